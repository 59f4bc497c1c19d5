//! Films where they are found: on curved faces, near edges, as thick as slabs, along either probe.

use crate::common::build::{Build, ball, cuboid, fibre, light, mesh_box};
use crate::common::listen::{Heard, entries, listen, settings};
use crate::common::stats::student_two_sided;
use glam::DVec3;
use gonio_embree::bsdf::Scattering;
use gonio_embree::dome::Estimate;
use gonio_embree::experiment::{BATCHES, Settings, measure};
use gonio_embree::intersect::choose::Backend;
use gonio_embree::light::{Light, Polarization, SourceMode};
use gonio_embree::optics::field::{State, Stokes};
use gonio_embree::optics::film::{Amplitudes, Incidence, Layer, solve};
use gonio_embree::optics::{C64, Pair};
use gonio_embree::plan::{Edges, Limits, Options, Probe, Wanted};
use gonio_embree::sample::description::{Fibre, Shape};

/// Chance that one of the comparisons of a test fails by bad luck (but seeds are fixed).
const FALSE_ALARM: f64 = 1e-3;

fn run(build: &Build, light: &Light, settings: &Settings) -> Vec<Scattering> {
    measure(&build.sample(light), light, settings, |_| {}).unwrap().bsdf.incidences
}

/// Whether a measured value is `expected` but for its standard error, in one of `comparisons` comparisons.
fn agrees(measured: Estimate, expected: f64, comparisons: usize) -> bool {
    let difference = measured.value - expected;
    if difference.abs() < 1e-9 {
        return true;
    }
    student_two_sided(difference / measured.se, f64::from(BATCHES - 1)) > FALSE_ALARM / comparisons as f64
}

fn formula(around: f64, cos: f64, layers: &[(C64, f64)], last: C64, nm: f64) -> Pair<Amplitudes> {
    let layers: Vec<Layer> = layers.iter().map(|&(index, thickness)| Layer { index, thickness }).collect();
    solve(&Incidence::from_cos(around, cos), &layers, last, nm / 1e3)
}

fn unpolarized(both: &Pair<Amplitudes>) -> f64 {
    0.5 * (both.s.reflectance() + both.p.reflectance())
}

/// A film of n 1.5 grows until it is a slab: first it follows the formula, in the end it reflects without interference,
/// and in between the share of the trees that are coherent falls with the path.
#[test]
fn films_grow_into_slabs_without_a_jump() {
    let light = light(&[550.0], &[(0.0, 0.0)], Polarization::Unpolarized);
    let coherence = light.coherence();
    let thicknesses = [0.1, 1.0, 4.0, 4.9, 5.04, 5.05, 5.3, 6.0, 7.0, 8.0, 9.0, 9.9, 10.08, 10.09, 11.0, 20.0, 100.0];
    let single: f64 = 0.04;
    let incoherent = 2.0 * single / (1.0 + single);
    let mut degrees = Vec::new();
    for d in thicknesses {
        let degree = coherence.degree(2.0 * 1.5 * d);
        let film = unpolarized(&formula(1.0, 1.0, &[(1.5.into(), d)], 1.0.into(), 550.0));
        let expected = degree * film + (1.0 - degree) * incoherent;
        let build = Build::within(1.0).films(0.0, &[(1.5, d)]);
        let ledger = &run(&build, &light, &settings(20_000))[0].ledger;
        let measured = ledger.reflected[0];
        assert!(agrees(measured, expected, thicknesses.len()), "{d} µm: {measured:?} for {expected}");
        assert!((ledger.sum()[0] - 1.0).abs() < 1e-9);
        degrees.push(degree);
    }
    assert!(degrees[0] == 1.0 && degrees.iter().any(|d| *d > 0.0 && *d < 1.0) && degrees.ends_with(&[0.0]));
}

/// The paper's probe, along the refracted rays, finds the stacks that ours finds, where there are such rays.
#[test]
fn both_probes_see_the_same() {
    let layers = [(1.53, 0.05), (1.0, 0.15)].repeat(12);
    let heights = |i: usize| -layers[..i].iter().map(|l| l.1).sum::<f64>();
    let boxes = |put: fn(DVec3, DVec3) -> Shape| {
        (0..layers.len()).fold(Build::within(1.0).patch(4.0, 3.0), |b, i| {
            let [bottom, top] = [heights(i + 1), heights(i)];
            b.put(put(DVec3::new(-2.0, -1.5, bottom), DVec3::new(2.0, 1.5, top)), layers[i].0)
        })
    };
    let films = Build::within(1.0).films(0.0, &layers).below(1.5);
    let directions = [(0.0, 0.0), (30.0, 20.0), (60.0, 100.0), (85.0, 200.0)];
    for (name, build) in [("films", films), ("boxes", boxes(cuboid)), ("meshes", boxes(mesh_box))] {
        let light =
            Light { source: SourceMode::Line, ..light(&[450.0, 600.0], &directions, Polarization::Unpolarized) };
        let with = |probe| {
            let options = Options { probe, ..Options::default() };
            run(&build, &light, &Settings { options, ..settings(640) })
        };
        for (a, b) in with(Probe::Normal).iter().zip(with(Probe::Refracted)) {
            for ((entry, x), (_, y)) in a.ledger.entries().into_iter().zip(b.ledger.entries()) {
                for (x, y) in x.iter().zip(y) {
                    assert!((x.value - y.value).abs() < 1e-12, "{name}, {entry}, {:?}: {x:?} {y:?}", a.incidence);
                }
            }
        }
    }
}

/// Beyond the critical angle of a layer there is no refracted ray, and the paper's probe ends there.
#[test]
fn only_the_normal_probe_sees_through_gaps() {
    let build = Build::within(1.5).films(0.0, &[(1.0, 0.05)]);
    let light = light(&[550.0], &[(60.0, 0.0)], Polarization::Unpolarized);
    let transmitted = |probe| {
        let options = Options { probe, ..Options::default() };
        run(&build, &light, &Settings { options, ..settings(64) })[0].ledger.transmitted[0].value
    };
    assert!(transmitted(Probe::Normal) > 0.3);
    assert_eq!(transmitted(Probe::Refracted), 0.0);
}

/// 50 nm of air in 2 mm of glass, at 60°: what single precision would jump over.
#[test]
fn light_tunnels_through_a_gap_in_a_thick_sample() {
    let light = light(&[450.0, 550.0, 650.0], &[(60.0, 30.0)], Polarization::P);
    let halves = |put: fn(DVec3, DVec3) -> Shape| {
        let (low, high) = (DVec3::new(-500.0, -500.0, -1000.0), DVec3::new(500.0, 500.0, 1000.0));
        Build::within(1.5)
            .patch(1000.0, 1000.0)
            .put(put(low.with_z(0.025), high), 1.5)
            .put(put(low, high.with_z(-0.025)), 1.5)
            .put(put(low.with_z(-0.025), high.with_z(0.025)), 1.0)
    };
    for (name, build) in [("boxes", halves(cuboid)), ("meshes", halves(mesh_box))] {
        let ledger = &run(&build, &light, &settings(2000))[0].ledger;
        for (i, nm) in [450.0, 550.0, 650.0].into_iter().enumerate() {
            let exact = formula(1.5, 60f64.to_radians().cos(), &[(1.0.into(), 0.05)], 1.5.into(), nm).p;
            let (r, t) = (ledger.specular[i], ledger.undeflected[i]);
            assert!((t.value - exact.transmittance()).abs() < 1e-9, "{name}, {nm} nm: {t:?} for {exact:?}");
            assert!((r.value - exact.reflectance()).abs() < 1e-9, "{name}, {nm} nm: {r:?} for {exact:?}");
        }
    }
}

/// A black body (nothing comes back from within) in shells, from the outside in.
struct Shells<'a> {
    layers: &'a [(f64, f64)],
    core: C64,
}

impl Shells<'_> {
    /// The body and its shells: `put` makes one of a given radius.
    fn build(&self, radius: f64, put: impl Fn(f64) -> Shape) -> Build {
        let mut build = Build::within(1.0).open().patch(2.2 * radius, 2.2 * radius);
        let mut r = radius;
        for (i, &(n, d)) in self.layers.iter().enumerate() {
            build = build.put(put(r), n).priority(i as i32);
            r -= d;
        }
        build.put(put(r), self.core).priority(self.layers.len() as i32)
    }

    /// Every tree that meets the body sends back what the film formula says of the local angle of incidence.
    fn check(&self, name: &str, build: &Build) {
        let nm = [400.0, 550.0, 700.0];
        let light = Light { source: SourceMode::Line, ..light(&nm, &[(20.0, 40.0)], Polarization::Unpolarized) };
        let heard: Heard<Stokes> =
            listen(&build.sample(&light), &light, Backend::Auto, Limits::default(), Wanted::AUTO, &entries(3, 3000));
        let incident = light.incidences[0].propagation();
        let layers: Vec<(C64, f64)> = self.layers.iter().map(|&(n, d)| (n.into(), d)).collect();
        let met: Vec<_> = heard.exits.iter().filter(|e| e.dir != incident).collect();
        assert!(met.len() > 1000, "{name}: {}", met.len());
        for exit in met {
            let cos = (exit.dir - incident).normalize().dot(exit.dir);
            for (lane, field) in &exit.fields {
                let expected = unpolarized(&formula(1.0, cos, &layers, self.core, nm[usize::from(*lane)]));
                // The cosine from two directions: its rounding, 1e-16 / cos.
                let allowed = 1e-9 + 1e-14 / cos;
                assert!((field.power() - expected).abs() < allowed, "{name}, cos {cos}: {field:?} for {expected}");
            }
        }
        assert_eq!(heard.lost, 0.0);
    }
}

/// An endless fibre along x.
fn endless(radius: f64) -> Shape {
    Shape::from(Fibre { caps: false, ..fibre([0.0; 3], [1.0, 0.0, 0.0], radius) })
}

#[test]
fn shells_are_films_at_the_local_angle() {
    let black = C64::new(1.5, 0.8);
    let one = Shells { layers: &[(1.45, 0.1)], core: black };
    one.check("sphere in a shell of 100 nm", &one.build(20.0, |r| ball([0.0; 3], r)));
    one.check("fibre in a shell of 100 nm", &one.build(20.0, endless));
    // So many that they are tabulated.
    let layers = [(2.0, 0.074), (1.5, 0.098)].repeat(5);
    let many = Shells { layers: &layers, core: black };
    many.check("sphere in ten shells", &many.build(60.0, |r| ball([0.0; 3], r)));
    many.check("fibre in ten shells", &many.build(60.0, endless));
}

/// A shell that is thick beside its radius is a body: rays go through it, and none is a film.
#[test]
fn thick_shells_are_no_films() {
    let build = Build::within(1.0).open().patch(5.0, 5.0).put(ball([0.0; 3], 2.0), 1.5).put(ball([0.0; 3], 1.8), 1.3);
    let light = light(&[550.0], &[(0.0, 0.0)], Polarization::Unpolarized);
    let outcome = measure(&build.priority(1).sample(&light), &light, &settings(1000), |_| {}).unwrap();
    assert_eq!(outcome.stacks.iter().count(), 0);
}

/// Light within X (1 + 2M) of the edge of a film, along the plane of incidence, is told of; `reject` leaves the film away
/// there and nowhere else.
#[test]
fn films_end_at_their_edges() {
    const D: f64 = 0.2;
    // The film ends at x = 5; the patch reaches from 0 to 6.
    let film = Build::within(1.0).open().put(cuboid([-5.0, -50.0, -D], [5.0, 50.0, 0.0]), 1.5);
    let mut build = film.patch(6.0, 4.0);
    build.0.patch.as_mut().unwrap().center.x = 3.0;
    let cos = 45f64.to_radians().cos();
    let (q1, q2) = (cos, (1.5f64 * 1.5 - 0.5).sqrt());
    let r = (q1 - q2) / (q1 + q2);
    let aside = D * cos / q2;
    let zone = aside * (1.0 + 2.0 * 0.01f64.ln() / (r * r).ln());
    // Light that goes towards the end of the film, and along it.
    for (phi, share) in [(180.0, zone / 6.0), (90.0, 0.0)] {
        let light = light(&[550.0], &[(45.0, phi)], Polarization::S);
        let with = |edges| {
            let options = Options { edges, ..Options::default() };
            run(&build, &light, &Settings { options, ..settings(32_000) }).remove(0).ledger
        };
        let (column, reject) = (with(Edges::Column), with(Edges::Reject));
        for ledger in [&column, &reject] {
            assert!(agrees(ledger.edge[0], share, 6), "{phi}°: {:?} for {share}", ledger.edge[0]);
        }
        let film = formula(1.0, cos, &[(1.5.into(), D)], 1.0.into(), 550.0).s.reflectance();
        let interfaces = 2.0 * r * r / (1.0 + r * r);
        let expected = (5.0 / 6.0 - share) * film + share * interfaces;
        assert!(agrees(column.specular[0], 5.0 / 6.0 * film, 6), "{phi}°: {:?}", column.specular[0]);
        // Of the light that is followed through the zone some leaves through the end of the film.
        let ends = share * 0.2;
        let rejected = reject.specular[0].value;
        assert!((rejected - expected).abs() < ends + 5.0 * reject.specular[0].se, "{phi}°: {rejected} for {expected}");
        assert!(share == 0.0 || (rejected - column.specular[0].value).abs() > 20.0 * reject.specular[0].se);
    }
}
