//! The whole simulation: 14,000 packed spheres and the feather, per backend, on one and on two threads.
//! `cargo bench --bench end_to_end`
#![allow(missing_docs, clippy::print_stdout)]

use glam::DVec2;
use gonio_embree::experiment::{Settings, measure};
use gonio_embree::intersect::choose::Backend;
use gonio_embree::light::{Incidence, Light, Polarization, SourceMode, Wavelengths};
use gonio_embree::media::Dispersion;
use gonio_embree::optics::C64;
use gonio_embree::plan::{Limits, Options};
use gonio_embree::sample::Sample;
use gonio_embree::sample::description::{Description, Fill, Medium, Named, Patch};
use gonio_embree::sample::generate::bricks::Bricks;
use gonio_embree::sample::generate::packing::{Packing, SpherePacking};
use gonio_embree::sample::problem::Place;

fn named(name: &str) -> Named {
    Named { name: name.into(), place: Place::default() }
}

fn medium(name: &str, n: f64) -> Medium {
    Medium { name: name.into(), dispersion: Dispersion::Constant(C64::new(n, 0.0)), place: Place::default() }
}

/// 14,000 spheres of index 1.5 in a periodic layer of 100 × 100 × 20 µm of `matrix`, which fills all around, too.
fn spheres(matrix: f64) -> Description {
    let size = glam::DVec3::new(100.0, 100.0, 20.0);
    let packing = Packing { count: 14_000, radius: 1.0077, size, periodic: true, seed: 1 };
    let fill = Fill::Medium(named("glass"));
    let spheres = SpherePacking::equal(packing, fill);
    Description {
        above: named("matrix"),
        below: named("matrix"),
        patch: Some(Patch { size: DVec2::splat(100.0), center: DVec2::ZERO }),
        media: vec![medium("glass", 1.5), medium("matrix", matrix)],
        objects: spheres.objects(&Place::default()).unwrap(),
        ..Description::default()
    }
}

fn feather() -> Description {
    let bricks = Bricks::default();
    Description {
        patch: Some(Patch { size: bricks.patch().into(), center: DVec2::ZERO }),
        media: vec![medium("platelet", 2.0), medium("core", 1.5)],
        objects: bricks.objects(&Place::default()),
        ..Description::default()
    }
}

struct Case {
    name: &'static str,
    description: Description,
    wavelengths: usize,
    trees: u64,
    limits: Limits,
}

fn main() {
    let path = Limits { depth: 64, splits: Some(0), ..Limits::default() };
    let cases = [
        Case {
            name: "14,000 spheres n 1.5 in 1.33, depth 64, 1 λ",
            description: spheres(1.33),
            wavelengths: 1,
            trees: 400_000,
            limits: path,
        },
        Case {
            name: "14,000 spheres n 1.5 in 1.52, depth 64, 1 λ",
            description: spheres(1.52),
            wavelengths: 1,
            trees: 400_000,
            limits: path,
        },
        Case {
            name: "feather, 16 λ",
            description: feather(),
            wavelengths: 16,
            trees: 200_000,
            limits: Limits::default(),
        },
    ];
    println!(
        "{:46} {:8} {:>7} {:>10} {:>10} {:>10} {:>9}",
        "", "backend", "threads", "Mpaths/s", "Mseg/s", "seg/path", "vs 1 thr"
    );
    for case in cases {
        let grid = case.name.contains("spheres").then_some(Backend::Grid);
        for backend in Backend::available().into_iter().filter(|b| *b != Backend::Brute).chain(grid) {
            let mut alone = 0.0;
            for threads in [1, 2] {
                let (paths, segments) = rate(&case, backend, threads);
                if threads == 1 {
                    alone = paths;
                }
                println!(
                    "{:46} {:8} {threads:7} {:10.3} {:10.3} {:10.2} {:9.2}",
                    case.name,
                    backend.name(),
                    paths / 1e6,
                    segments / 1e6,
                    segments / paths,
                    paths / alone
                );
            }
        }
    }
}

/// Trees and segments per second: the best of three runs, set-up excluded.
fn rate(case: &Case, backend: Backend, threads: usize) -> (f64, f64) {
    let nm = (0..case.wavelengths).map(|i| 400.0 + 20.0 * i as f64).collect();
    let light = Light {
        wavelengths: Wavelengths::from_nm(nm).unwrap(),
        incidences: vec![Incidence { theta_deg: 0.0, phi_deg: 0.0 }],
        polarization: Polarization::Unpolarized,
        source: SourceMode::Band,
    };
    let sample = Sample::new(&case.description, &light.wavelengths, light.coherence()).unwrap();
    let settings = Settings {
        trees: case.trees,
        seed: 1,
        threads,
        backend,
        dome_level: 6,
        options: Options { limits: case.limits, ..Options::default() },
        ..Settings::default()
    };
    let runs = (0..3).map(|_| {
        let outcome = measure(&sample, &light, &settings, |_| {}).unwrap();
        let s = &outcome.bsdf.incidences[0];
        (s.trees as f64 / outcome.tracing_seconds, s.segments as f64 / outcome.tracing_seconds)
    });
    runs.fold((0.0, 0.0), |best: (f64, f64), r| if r.0 > best.0 { r } else { best })
}
