//! Only the effects a scene calls for: what is off changes nothing, or no more than its bound says.
#![allow(clippy::print_stdout, reason = "figures are shown with --nocapture")]

use crate::common::build::{Build, ball, cuboid, fibre, light, mesh_box};
use crate::common::listen::{Heard, entries, listen_to, listen_with, settings};
use glam::DVec3;
use gonio_embree::bsdf::Scattering;
use gonio_embree::dome::Estimate;
use gonio_embree::experiment::{Outcome, Settings, measure};
use gonio_embree::intersect::choose::Backend;
use gonio_embree::light::{Light, Polarization, SourceMode};
use gonio_embree::optics::C64;
use gonio_embree::optics::field::{Field, Jones, Mueller, Power, Stokes};
use gonio_embree::plan::{KernelChoice, Limits, Name, Options, Plan, State, Wanted};
use gonio_embree::sample::Sample;
use gonio_embree::sample::description::{Fill, Shape};
use gonio_embree::sample::generate::packing::Packing;
use gonio_embree::trace::{Effects, Job, with_kernel};
use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};

const NM: [f64; 3] = [450.0, 550.0, 650.0];

/// Some balls.
fn cluster(n: impl Into<C64> + Copy) -> Build {
    let balls = [([0.0, 0.0, 4.0], 4.0), ([7.0, 1.0, 3.0], 3.0), ([1.0, 8.0, 5.0], 4.0), ([6.0, 6.0, 11.0], 3.5)];
    balls.into_iter().fold(Build::within(1.0).open().patch(16.0, 16.0), |b, (c, r)| b.put(ball(c, r), n))
}

fn dispersive() -> Build {
    let mut build = cluster(1.5);
    let glass = build.cauchy(1.5, 6000.0);
    build.fill(ball([-7.0, 0.0, 4.0], 3.0), Fill::Medium(glass))
}

/// Exits: tree, direction, power per lane.
type Paths = Vec<(u32, DVec3, Vec<(u16, f64)>)>;

/// What each kernel has heard of the same trees, its fields as power per lane.
struct Hear<'a> {
    plan: &'a Plan,
    sample: &'a Sample,
    light: &'a Light,
}

impl Job for Hear<'_> {
    type Yield = Paths;

    fn run<F: Field, E: Effects>(self) -> Self::Yield {
        let Self { plan, sample, light } = self;
        paths(&listen_with::<F, E>(plan, sample, light, Backend::Auto, &entries(3, 400)))
    }
}

fn paths<F: Field>(heard: &Heard<F>) -> Paths {
    let powers = |fields: &[(u16, F)]| fields.iter().map(|(lane, f)| (*lane, f.power())).collect();
    heard.exits.iter().map(|e| (e.tree, e.dir, powers(&e.fields))).collect()
}

/// A kernel that leaves out what the sample has none of follows the same trees as the full one, exit by exit.
#[test]
fn reduced_kernels_follow_the_same_trees() {
    let metal = cluster(1.5).put(Shape::Slab { top: -1.0, bottom: -2.0 }, C64::new(1.0, 6.0));
    let ink = cluster(C64::new(1.5, 1e-4));
    let film = cluster(1.5).films(-1.0, &[(1.7, 0.2), (2.0, 0.1)]);
    for (name, build) in
        [("glass", cluster(1.5)), ("dispersive", dispersive()), ("metal", metal), ("ink", ink), ("film", film)]
    {
        let light = light(&NM, &[(30.0, 20.0)], Polarization::P);
        let sample = build.sample(&light);
        let all = Plan::new(&sample, &light, &Options { wanted: Wanted::ALL, ..Options::default() });
        let auto = Plan::new(&sample, &light, &Options::default());
        assert_ne!(auto.kernel, all.kernel, "{name}: nothing is left out");
        let full = with_kernel(all.kernel, Hear { plan: &all, sample: &sample, light: &light });
        for state in [State::Stokes, State::Jones, State::Mueller] {
            // Mueller matrices go by the power of unpolarized light.
            let (light, full) = match state {
                State::Mueller => {
                    let light = Light { polarization: Polarization::Unpolarized, ..light.clone() };
                    let full = with_kernel(all.kernel, Hear { plan: &all, sample: &sample, light: &light });
                    (light, full)
                }
                _ => (light.clone(), full.clone()),
            };
            let kernel = KernelChoice { state, ..auto.kernel };
            let reduced = with_kernel(kernel, Hear { plan: &auto, sample: &sample, light: &light });
            assert_eq!(reduced.len(), full.len(), "{name} {state:?}");
            for (a, b) in reduced.iter().zip(&full) {
                assert!(a.0 == b.0 && a.1 == b.1, "{name} {state:?}: {a:?} {b:?}");
                for (_, power) in &b.2 {
                    assert!(a.2.iter().any(|(_, p)| (p - power).abs() <= 1e-12), "{name} {state:?}: {a:?} {b:?}");
                }
            }
        }
    }
}

/// Light that is never polarized needs no state.
#[test]
fn power_alone_is_exact_where_light_meets_one_interface() {
    let light = light(&NM, &[(50.0, 0.0)], Polarization::Unpolarized);
    let sample = Build::within(1.0).below(1.5).films(0.0, &[(2.0, 0.1)]).sample(&light);
    let plan = Plan::new(&sample, &light, &Options::default());
    assert_eq!((plan.kernel.state, plan.lanes.len()), (State::Power, 3));
    let [power, stokes] = [
        paths(&listen_to::<Power>(&plan, &sample, &light, Backend::Auto, &entries(3, 50))),
        paths(&listen_to::<Stokes>(&plan, &sample, &light, Backend::Auto, &entries(3, 50))),
    ];
    for (a, b) in power.iter().zip(&stokes) {
        assert!(a.1 == b.1 && a.2.iter().zip(&b.2).all(|(x, y)| (x.1 - y.1).abs() < 1e-15), "{a:?} {b:?}");
    }
}

fn run(build: &Build, light: &Light, trees: u64, options: Options) -> Outcome {
    let settings = Settings { options, ..settings(trees) };
    measure(&build.sample(light), light, &settings, |_| {}).unwrap()
}

fn wanting(wanted: Wanted) -> Options {
    Options { wanted, ..Options::default() }
}

/// Pairs of the reflected and the transmitted light of two runs, per wavelength.
fn pairs<'a>(a: &'a Scattering, b: &'a Scattering) -> impl Iterator<Item = (Estimate, Estimate)> + 'a {
    let (a, b) = (&a.ledger, &b.ledger);
    let both = [(&a.reflected, &b.reflected), (&a.transmitted, &b.transmitted)];
    both.into_iter().flat_map(|(a, b)| a.iter().copied().zip(b.iter().copied()))
}

#[test]
fn one_lane_stands_for_all_where_nothing_depends_on_the_wavelength() {
    let light = light(&NM, &[(30.0, 0.0)], Polarization::Unpolarized);
    let plan = |build: &Build| Plan::new(&build.sample(&light), &light, &Options::default());
    let glass = plan(&cluster(1.5));
    assert_eq!(glass.lanes.len(), 1);
    assert_eq!(glass.kernel, KernelChoice { state: State::Stokes, films: false, absorbs: false, parts: false });
    assert_eq!(plan(&cluster(C64::new(1.5, 1e-4))).lanes.len(), 3, "absorption goes with the wavelength");
    let parted = plan(&dispersive());
    assert!(parted.lanes.len() == 3 && parted.kernel.parts);
    // A metal whose index is constant reflects all wavelengths alike.
    let metal = plan(&cluster(1.5).put(Shape::Slab { top: -1.0, bottom: -30.0 }, C64::new(1.0, 6.0)));
    assert!(metal.lanes.len() == 1 && metal.kernel.absorbs);
}

/// Dropping polarization moves the reflectance of a cluster of glass spheres by some percent, and the plan knows: the
/// bound of the pilot says so. A relief of metal that light meets once or twice needs none.
#[test]
fn polarization_is_kept_where_it_matters() {
    let packing = Packing { count: 60, radius: 1.0, size: DVec3::new(8.0, 8.0, 14.0), periodic: true, seed: 2 };
    let build = Build::within(1.0).packing(&packing, 1.5);
    let light = light(&[550.0], &[(0.0, 0.0)], Polarization::Unpolarized);
    let kept = run(&build, &light, 300_000, Options::default());
    assert_eq!(kept.plan.kernel.state, State::Stokes);
    let dropped = run(&build, &light, 300_000, wanting(Wanted::AUTO.with(Name::Polarization, false)));
    assert_eq!(dropped.plan.kernel.state, State::Power);
    let [a, b] = [&kept, &dropped].map(|o| o.bsdf.incidences[0].ledger.reflected[0]);
    let (change, se) = ((b.value / a.value - 1.0).abs(), a.se.hypot(b.se) / a.value);
    println!("reflectance {:.4}, without polarization {:.1} % ± {:.1} % off", a.value, 100.0 * change, 100.0 * se);
    assert!(change > 0.015 && change < 0.07 && 4.0 * se < change, "{change} {se}");

    let bumps = (0..4).fold(Build::within(1.0).patch(16.0, 16.0), |b, i| {
        b.put(ball([f64::from(i % 2) * 8.0 - 4.0, f64::from(i / 2) * 8.0 - 4.0, -7.0], 7.5), C64::new(1.0, 6.0))
            .priority(i + 1)
    });
    let relief = bumps.put(Shape::Slab { top: 0.0, bottom: -20.0 }, C64::new(1.0, 6.0)).priority(0);
    let outcome = run(&relief, &light, 300_000, Options::default());
    let polarization = &outcome.plan.effects[Name::Polarization as usize];
    println!("metal relief: {} ({})", polarization.reason, polarization.bound);
    assert!(outcome.plan.kernel.state == State::Power && polarization.bound < 0.002);
    let full = run(&relief, &light, 300_000, wanting(Wanted::ALL));
    for (a, b) in pairs(&outcome.bsdf.incidences[0], &full.bsdf.incidences[0]).filter(|(_, b)| b.value > 0.0) {
        assert!((a.value / b.value - 1.0).abs() < polarization.bound, "{a:?} {b:?} {}", polarization.bound);
    }
}

/// Weak effects are left out, and the bound holds; strong ones are kept without a pilot.
#[test]
fn weak_absorption_and_dispersion_are_left_out() {
    let light = light(&NM, &[(20.0, 0.0)], Polarization::Unpolarized);
    let mut weak = Build::within(1.0).open().patch(8.0, 8.0);
    let glass = weak.cauchy(1.5, 1.0);
    let weak = weak
        .fill(ball([0.0, 0.0, 20.0], 12.0), Fill::Medium(glass))
        .put(cuboid([-9.0, -9.0, -9.0], [9.0, 9.0, 0.0]), C64::new(1.4, 1e-9));
    let outcome = run(&weak, &light, 250_000, Options::default());
    for name in [Name::Dispersion, Name::Absorption] {
        let effect = &outcome.plan.effects[name as usize];
        println!("{}: {} ({})", effect.name, effect.reason, effect.bound);
        assert!(!effect.on && effect.bound > 0.0, "{effect:?}");
    }
    assert_eq!(outcome.plan.lanes.len(), 1);
    let full = run(&weak, &light, 250_000, wanting(Wanted::ALL.with(Name::Polarization, true)));
    let bound: f64 = outcome.plan.effects.iter().filter(|e| !e.on).map(|e| e.bound).sum();
    for (a, b) in pairs(&outcome.bsdf.incidences[0], &full.bsdf.incidences[0]) {
        assert!((a.value / b.value - 1.0).abs() < bound, "{a:?} {b:?} {bound}");
    }
    let strong = Plan::new(&dispersive().sample(&light), &light, &Options::default());
    let dispersion = &strong.effects[Name::Dispersion as usize];
    assert!(dispersion.on && !dispersion.open);
}

/// Spheres in a liquid of nearly their index, 20 wavelengths.
fn christiansen() -> (Build, Light) {
    let packing = Packing { count: 60, radius: 1.0, size: DVec3::new(8.0, 8.0, 14.0), periodic: true, seed: 5 };
    let mut build = Build::within(1.0).patch(8.0, 8.0);
    let (glass, liquid) = (build.cauchy(1.51, 4200.0), build.cauchy(1.4902, 10_200.0));
    (build.0.above, build.0.below) = (liquid.clone(), liquid);
    let centers = packing.centers().unwrap();
    let build = centers.into_iter().fold(build, |b, c| b.fill(ball(c, packing.radius), Fill::Medium(glass.clone())));
    let nm: Vec<f64> = (0..20).map(|i| 400.0 + 16.0 * f64::from(i)).collect();
    (build, light(&nm, &[(15.0, 0.0)], Polarization::Unpolarized))
}

/// Bundles of wavelengths scatter as each wavelength by itself does: all facets of a coarse dome within 4 standard errors
/// but for 1 in 1000, with fewer segments.
#[test]
fn bundles_scatter_like_single_wavelengths() {
    let (build, light) = christiansen();
    let with_spread = |spread: f64| Options { limits: Limits { spread, ..Limits::default() }, ..Options::default() };
    let run = |spread: f64| {
        let settings = Settings { options: with_spread(spread), dome_level: 2, ..settings(40_000) };
        measure(&build.sample(&light), &light, &settings, |_| {}).unwrap().bsdf.incidences.remove(0)
    };
    let (bundled, single) = (run(Limits::default().spread), run(0.0));
    let share = bundled.segments as f64 / single.segments as f64;
    println!("bundles trace {share:.2} of the segments");
    assert!(share < 0.9, "{share}");
    assert!(bundled.ledger.lost().iter().all(|&x| x < 1e-9), "nothing is caught in a sphere");
    let (mut compared, mut far) = (0, 0);
    for (a, b) in bundled.facets.iter().flat_map(|f| single.facets.iter().map(move |g| (f, g))) {
        if a.facet == b.facet && a.trees.min(b.trees) > 100 {
            for (x, y) in a.value.iter().zip(&b.value) {
                compared += 1;
                far += u32::from((x.value - y.value).abs() > 4.0 * x.se.hypot(y.se));
            }
        }
    }
    println!("{compared} values compared, {far} differ by more than 4 standard errors");
    assert!(compared > 200 && f64::from(far) <= 1e-3 * f64::from(compared) + 1.0);
    for (a, b) in pairs(&bundled, &single) {
        assert!((a.value - b.value).abs() <= 4.0 * a.se.hypot(b.se) + 1e-12, "{a:?} {b:?}");
    }
}

/// Light that grazes into a sphere at the middle of a bundle would be totally reflected inside for ever at wavelengths of a
/// lower index.
#[test]
fn no_wavelength_of_a_bundle_is_caught_in_a_sphere() {
    let mut build = Build::within(1.0).open().patch(2.4, 2.4);
    let glass = build.cauchy(1.5, 3000.0);
    let build = build.fill(ball([0.0; 3], 1.2), Fill::Medium(glass));
    let light = light(&NM, &[(0.0, 0.0)], Polarization::Unpolarized);
    let options = Options {
        limits: Limits { depth: 1000, spread: Limits::spread_for(2), ..Limits::default() },
        ..Options::default()
    };
    let lost = run(&build, &light, 200_000, options).bsdf.largest_loss();
    assert!(lost < 1e-9, "{lost}");
}

/// Draws samples, lights and all.
struct Draw(Xoshiro256PlusPlus);

impl Draw {
    fn unit(&mut self) -> f64 {
        self.0.random()
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    fn pick(&mut self, n: usize) -> usize {
        self.0.random_range(0..n)
    }

    fn fill(&mut self, build: &mut Build) -> Fill {
        match self.pick(8) {
            0 => Fill::Mirror(self.unit()),
            1 => Fill::Diffuse(self.unit()),
            2 => Fill::Medium(build.medium(C64::new(self.between(0.2, 3.0), self.between(1.0, 8.0)))),
            3 => {
                let k = 10f64.powf(self.between(-9.0, -2.0));
                Fill::Medium(build.medium(C64::new(self.between(1.2, 2.0), k)))
            }
            4 | 5 => {
                let b = 10f64.powf(self.between(0.0, 4.3));
                Fill::Medium(build.cauchy(self.between(1.3, 1.8), b))
            }
            _ => Fill::Medium(build.medium(self.between(1.2, 2.2))),
        }
    }

    fn sample(&mut self) -> Build {
        let mut build = Build::within(1.0).patch(10.0, 10.0);
        for i in 0..1 + self.pick(5) {
            let at = |d: &mut Self| DVec3::new(d.between(-4.0, 4.0), d.between(-4.0, 4.0), d.between(1.0, 8.0));
            let (a, b, r) = (at(self), at(self), self.between(0.5, 2.5));
            let shape = match self.pick(5) {
                0 => Shape::from(fibre(a, b, r)),
                1 => cuboid(a.min(b), a.max(b) + 0.1),
                2 => mesh_box(a.min(b), a.max(b) + 0.1),
                _ => ball(a, r),
            };
            let fill = self.fill(&mut build);
            build = build.fill(shape, fill).priority(i as i32);
        }
        if self.unit() < 0.4 {
            build =
                build.films(0.0, &[(self.between(1.3, 2.5), self.between(0.05, 0.5)), (1.5, self.between(0.05, 2.0))]);
        }
        build
    }

    fn light(&mut self) -> Light {
        let count = 1 + self.pick(4);
        let nm: Vec<f64> = (0..count).map(|i| 400.0 + 80.0 * i as f64).collect();
        let polarization = match self.pick(4) {
            0 => Polarization::S,
            1 => Polarization::Stokes([1.0, 0.2, -0.5, 0.4]),
            _ => Polarization::Unpolarized,
        };
        let source = if self.unit() < 0.2 { SourceMode::Gaussian(20.0) } else { SourceMode::Band };
        let from = (self.between(0.0, 80.0), self.between(0.0, 360.0));
        Light { source, ..light(&nm, &[from], polarization) }
    }
}

/// What the plan leaves out of `count` random samples changes nothing beyond its bound, and 5 standard errors: right
/// programs fail one of the 1600 comparisons of 200 samples with probability 1e-3.
fn random_samples(seed: u64, count: usize, trees: u64) {
    let mut draw = Draw(Xoshiro256PlusPlus::seed_from_u64(seed));
    let mut left_out = [0; Name::COUNT];
    for i in 0..count {
        let (build, light) = (draw.sample(), draw.light());
        let auto = run(&build, &light, trees, Options::default());
        let full = run(&build, &light, trees, wanting(Wanted::ALL));
        let off = || auto.plan.effects.iter().filter(|e| !e.on);
        off().for_each(|e| left_out[e.name as usize] += 1);
        let bound: f64 = off().map(|e| e.bound).sum();
        for (a, b) in pairs(&auto.bsdf.incidences[0], &full.bsdf.incidences[0]) {
            // Without a difference of paths the same trees give the same numbers but for rounding.
            let allowed = bound * b.value + if bound > 0.0 { 5.0 * a.se.hypot(b.se) } else { 1e-9 };
            let difference = (a.value - b.value).abs();
            assert!(difference <= allowed, "sample {i}: {a:?} {b:?}, allowed {allowed:e}\n{:#?}", auto.plan.effects);
        }
    }
    let names: Vec<String> = Name::ALL.iter().zip(left_out).map(|(n, count)| format!("{n} {count}")).collect();
    println!("left out of {count} samples: {}", names.join(", "));
}

#[test]
fn what_is_left_out_of_random_samples_stays_within_its_bound() {
    random_samples(11, 12, 8000);
}

#[test]
#[ignore = "slow: cargo test --release effects:: -- --ignored"]
fn what_is_left_out_of_200_random_samples_stays_within_its_bound() {
    random_samples(12, 200, 100_000);
}

/// Mueller matrices and Stokes vectors of one light are the same numbers.
#[test]
fn a_matrix_holds_what_a_vector_does() {
    let light = light(&[550.0], &[(40.0, 10.0)], Polarization::Unpolarized);
    let sample = cluster(1.5).sample(&light);
    let plan = Plan::new(&sample, &light, &Options::default());
    let mueller: Heard<Mueller> = listen_to(&plan, &sample, &light, Backend::Auto, &entries(5, 300));
    let stokes: Heard<Stokes> = listen_to(&plan, &sample, &light, Backend::Auto, &entries(5, 300));
    let jones: Heard<Jones> = listen_to(&plan, &sample, &light, Backend::Auto, &entries(5, 300));
    for ((m, s), j) in mueller.exits.iter().zip(&stokes.exits).zip(&jones.exits) {
        let [m, s, j] = [
            m.fields[0].1.applied_to([1.0, 0.0, 0.0, 0.0]),
            s.fields[0].1.components(),
            Stokes::from(j.fields[0].1).components(),
        ];
        for i in 0..4 {
            assert!((m[i] - s[i]).abs() < 1e-12 && (j[i] - s[i]).abs() < 1e-12, "{m:?} {s:?} {j:?}");
        }
    }
}
