//! What the plan saves: each sample with the effects it calls for and with all of them, on the same trees; and bundles of
//! wavelengths against a ray for each. Times are those of whole measurements, pilot included, the best of three that
//! alternate. `cargo bench --bench effects` prints the tables of the README.
#![allow(missing_docs, clippy::print_stdout)]

use glam::{DVec2, DVec3};
use gonio_embree::experiment::{Outcome, Settings, measure};
use gonio_embree::light::{Incidence, Light, Polarization, SourceMode, Wavelengths};
use gonio_embree::media::Dispersion;
use gonio_embree::optics::C64;
use gonio_embree::plan::{Options, Wanted};
use gonio_embree::sample::Sample;
use gonio_embree::sample::description::{Body, Description, Fill, Medium, Named, Object, Patch, Shape};
use gonio_embree::sample::generate::bricks::Bricks;
use gonio_embree::sample::generate::packing::{Packing, SpherePacking};
use gonio_embree::sample::problem::Place;

fn named(name: &str) -> Named {
    Named { name: name.into(), place: Place::default() }
}

fn medium(name: &str, dispersion: Dispersion) -> Medium {
    Medium { name: name.into(), dispersion, place: Place::default() }
}

fn constant(n: f64) -> Dispersion {
    Dispersion::Constant(C64::new(n, 0.0))
}

fn object(name: &str, body: Body, priority: i32) -> Object {
    Object { name: name.into(), body, priority, nesting: 0, place: Place::default() }
}

/// A film of 100 nm under which a glass goes on for ever.
fn flat_film() -> Description {
    Description {
        below: named("glass"),
        media: vec![medium("film", constant(2.0)), medium("glass", constant(1.5))],
        objects: vec![object("film", Body::Films { top: 0.0, layers: vec![(named("film"), 0.1)] }, 0)],
        ..Description::default()
    }
}

/// 1000 spheres in a periodic layer.
fn packing(spheres: &str, matrix: &str, media: Vec<Medium>) -> Description {
    let packing = Packing { count: 1000, radius: 2.0, size: DVec3::new(48.0, 48.0, 48.0), periodic: true, seed: 1 };
    let spheres = SpherePacking::equal(packing, Fill::Medium(named(spheres)));
    Description {
        above: named(matrix),
        below: named(matrix),
        patch: Some(Patch { size: DVec2::splat(48.0), center: DVec2::ZERO }),
        media,
        objects: spheres.objects(&Place::default()).unwrap(),
        ..Description::default()
    }
}

/// Flat bumps of aluminium on aluminium.
fn relief() -> Description {
    let bump = |i: i32| {
        let center = DVec3::new(f64::from(i % 3 - 1) * 8.0, f64::from(i / 3 - 1) * 8.0, -8.0);
        let sphere = Shape::Sphere { center, radius: 10.0 };
        object(&format!("bump {i}"), Body::Solid(sphere, Fill::Medium(named("Al"))), i + 1)
    };
    let base = Body::Solid(Shape::Slab { top: 0.0, bottom: -20.0 }, Fill::Medium(named("Al")));
    Description {
        patch: Some(Patch { size: DVec2::splat(24.0), center: DVec2::ZERO }),
        objects: std::iter::once(object("base", base, 0)).chain((0..9).map(bump)).collect(),
        ..Description::default()
    }
}

fn feather() -> Description {
    let bricks = Bricks::default();
    Description {
        patch: Some(Patch { size: bricks.patch().into(), center: DVec2::ZERO }),
        media: vec![medium("platelet", constant(2.0)), medium("core", constant(1.5))],
        objects: bricks.objects(&Place::default()),
        ..Description::default()
    }
}

fn light(wavelengths: usize) -> Light {
    let nm = (0..wavelengths).map(|i| 400.0 + 300.0 * i as f64 / (wavelengths - 1) as f64).collect();
    Light {
        wavelengths: Wavelengths::from_nm(nm).unwrap(),
        incidences: vec![Incidence { theta_deg: 30.0, phi_deg: 0.0 }],
        polarization: Polarization::Unpolarized,
        source: SourceMode::Band,
    }
}

/// The best of three runs of each of two ways, alternating.
fn compare(description: &Description, light: &Light, trees: u64, options: [Options; 2]) -> [Outcome; 2] {
    let sample = Sample::new(description, &light.wavelengths, light.coherence()).unwrap();
    let run = |options: Options| {
        let settings = Settings { trees, options, ..Settings::default() };
        measure(&sample, light, &settings, |_| {}).unwrap()
    };
    let mut best = options.map(run);
    for _ in 0..2 {
        for (best, options) in best.iter_mut().zip(options) {
            let again = run(options);
            if again.seconds < best.seconds {
                *best = again;
            }
        }
    }
    best
}

/// The difference of reflected or transmitted light, of all wavelengths, that is largest for its standard error (as if the
/// trees were others); both as shares of the light.
fn difference([a, b]: &[Outcome; 2]) -> (f64, f64) {
    let (a, b) = (&a.bsdf.incidences[0].ledger, &b.bsdf.incidences[0].ledger);
    let pairs = [(&a.reflected, &b.reflected), (&a.transmitted, &b.transmitted)];
    let all = pairs.into_iter().flat_map(|(a, b)| a.iter().zip(b)).filter(|(_, b)| b.value > 1e-6);
    let relative = all.map(|(a, b)| ((a.value - b.value).abs() / b.value, a.se.hypot(b.se) / b.value));
    relative.fold((0.0, 0.0), |worst, x| if x.0 * worst.1 >= worst.0 * x.1 { x } else { worst })
}

fn main() {
    let n_bk7 = vec![medium("water", constant(1.33))];
    let plain = vec![medium("glass", constant(1.5)), medium("matrix", constant(1.33))];
    let samples = [
        ("film on glass", flat_film(), 400_000),
        ("1000 glass spheres", packing("glass", "matrix", plain), 40_000),
        ("the same of N-BK7", packing("N-BK7", "water", n_bk7), 20_000),
        ("bumps of aluminium", relief(), 200_000),
        ("feather", feather(), 100_000),
    ];
    println!("| sample, 16 λ, 30° | simulated | carried | time, all / auto | difference | its SE | bound |");
    println!("|---|---|---|--:|--:|--:|--:|");
    for (name, description, trees) in samples {
        let options = [Wanted::AUTO, Wanted::ALL].map(|wanted| Options { wanted, ..Options::default() });
        let outcomes = compare(&description, &light(16), trees, options);
        let (found, se) = difference(&outcomes);
        let plan = &outcomes[0].plan;
        let on: Vec<String> = plan.effects.iter().filter(|e| e.on).map(|e| e.name.to_string()).collect();
        let bound: f64 = plan.effects.iter().filter(|e| !e.on).map(|e| e.bound).sum();
        println!(
            "| {name} | {} | {:?}, {} λ | {:.1} | {found:.1e} | {se:.1e} | {bound:.1e} |",
            on.join(", "),
            plan.kernel.state,
            plan.lanes.len(),
            outcomes[1].seconds / outcomes[0].seconds,
        );
    }
    one_lane();
    bundles();
}

/// One lane for all wavelengths against a measurement of each by itself, which is the paper's way.
fn one_lane() {
    let media = vec![medium("glass", constant(1.5)), medium("matrix", constant(1.33))];
    let description = packing("glass", "matrix", media);
    let seconds = |light: &Light| {
        let sample = Sample::new(&description, &light.wavelengths, light.coherence()).unwrap();
        let settings = Settings { trees: 40_000, ..Settings::default() };
        (0..3).map(|_| measure(&sample, light, &settings, |_| {}).unwrap().seconds).fold(f64::INFINITY, f64::min)
    };
    let all = light(16);
    let each = |&nm: &f64| seconds(&Light { wavelengths: Wavelengths::from_nm(vec![nm]).unwrap(), ..all.clone() });
    let one_by_one: f64 = all.wavelengths.nm().iter().map(each).sum();
    println!(
        "\n1000 glass spheres, 16 λ: a ray for each wavelength takes {:.1} times as long as auto",
        one_by_one / seconds(&all)
    );
}

/// Spheres in a liquid that matches them at 550 nm: at each wavelength more or less light goes straight on.
fn bundles() {
    let cauchy = |a: f64, b: f64| Dispersion::Cauchy { a, b };
    let media = vec![medium("glass", cauchy(1.51, 4200.0)), medium("liquid", cauchy(1.4902, 10_200.0))];
    let options = [Options::default().limits.spread, 0.0].map(|spread| {
        let mut options = Options::default();
        options.limits.spread = spread;
        options
    });
    let outcomes = compare(&packing("glass", "liquid", media), &light(20), 20_000, options);
    let (found, se) = difference(&outcomes);
    let [bundled, single] = [&outcomes[0], &outcomes[1]];
    println!(
        "\nChristiansen filter, 20 λ: bundles take {:.2} of the time of a ray per wavelength, {:.2} of its segments; \
         difference {found:.1e} ± {se:.1e}",
        bundled.seconds / single.seconds,
        bundled.bsdf.incidences[0].segments as f64 / single.bsdf.incidences[0].segments as f64,
    );
}
