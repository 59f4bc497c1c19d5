//! The film solver: time per wavelength and polarization, both sides at once, how it grows, and what it takes to know
//! what each layer absorbs.
//! `cargo bench --bench film`, or with ` -- --csv` for scripts (`benches/peers`).
#![allow(missing_docs, clippy::print_stdout)]

use std::hint::black_box;
use std::time::Instant;

use gonio_embree::optics::C64;
use gonio_embree::optics::batch::{Film, Question, Sides, Solver, Spectrum};
use gonio_embree::optics::film::{Incidence, Layer, solve};

/// High and low layers in turn; `k` absorbs in the high ones.
fn stack(layers: usize, k: f64) -> Vec<Layer> {
    (0..layers)
        .map(|i| match i % 2 {
            0 => Layer { index: C64::new(2.0, k), thickness: 0.074 },
            _ => Layer { index: C64::new(1.5, 0.0), thickness: 0.098 },
        })
        .collect()
}

const WAVELENGTHS: usize = 20;

/// Nanoseconds per wavelength (s and p): the best of five runs.
struct Times {
    /// Both sides, one by one and in lanes.
    one_by_one: f64,
    lanes: f64,
    /// What each layer absorbs, in lanes.
    losses: f64,
}

fn time(layers: &[Layer], incidence: &Incidence, last: C64) -> Times {
    let wavelengths: Vec<f64> = (0..WAVELENGTHS).map(|i| 0.4 + 0.016 * i as f64).collect();
    // Each layer is a medium of its own, as in a sample of many media.
    let indices = layers.iter().map(|l| l.index).chain([last]);
    let media: Vec<Spectrum> = indices.map(|n| [n; WAVELENGTHS].into_iter().collect()).collect();
    let film = |(medium, l): (usize, &Layer)| Film { medium, thickness: l.thickness };
    let films: Vec<Film> = layers.iter().enumerate().map(film).collect();
    let question = Question {
        incidences: &[*incidence; WAVELENGTHS],
        media: &media,
        films: &films,
        last: layers.len(),
        wavelengths: &wavelengths,
    };
    let (mut solver, mut out, mut shares) = (Solver::default(), Vec::new(), Vec::new());
    Times {
        one_by_one: best(layers.len(), || {
            for &w in &wavelengths {
                black_box(solve(incidence, black_box(layers), last, w));
            }
        }),
        lanes: best(layers.len(), || {
            solver.solve(black_box(&question), Sides::Both, &mut out);
            black_box(&out);
        }),
        losses: best(layers.len(), || {
            solver.absorptances(black_box(&question), &mut shares);
            black_box(&shares);
        }),
    }
}

fn best(layers: usize, mut solve_all: impl FnMut()) -> f64 {
    let repeats = (1_000_000 / layers.max(1) / WAVELENGTHS).max(1);
    let mut run = || {
        let start = Instant::now();
        for _ in 0..repeats {
            solve_all();
        }
        start.elapsed().as_secs_f64() * 1e9 / (repeats * WAVELENGTHS) as f64
    };
    (0..5).map(|_| run()).fold(f64::INFINITY, f64::min)
}

fn main() {
    if std::env::args().any(|a| a == "--csv") { csv() } else { table() }
}

/// For scripts: of one polarization, both sides, many wavelengths at once.
fn csv() {
    println!("name,layers,wavelengths,ns_per_lambda_and_polarization");
    let incidence = Incidence::from_cos(1.0, 30f64.to_radians().cos());
    for (name, k) in [("lossless", 0.0), ("absorbing", 0.01)] {
        for layers in [1, 14, 100, 1000] {
            let Times { lanes, .. } = time(&stack(layers, k), &incidence, C64::new(1.0, 0.0));
            println!("{name},{layers},{WAVELENGTHS},{:.3}", lanes / 2.0);
        }
    }
}

fn table() {
    let (air, glass) = (C64::new(1.0, 0.0), C64::new(1.5, 0.0));
    let at = |deg: f64| Incidence::from_cos(1.0, deg.to_radians().cos());
    let Times { one_by_one, lanes: base, .. } = time(&stack(14, 0.0), &at(30.0), air);
    println!(
        "14 layers, lossless, 30°: {base:.0} ns per wavelength (s and p, both sides); 20 wavelengths {:.1} µs; one by one {:.2} times as long",
        base * 0.02,
        one_by_one / base
    );
    println!("{:34} {:>12} {:>8} {:>12} {:>12}", "", "ns per λ", "ratio", "one by one", "what layers");
    println!("{:69} {:>12}", "", "absorb");
    let dense = Incidence::from_cos(1.5, 60f64.to_radians().cos());
    for (name, layers, incidence, last) in [
        ("no layer", stack(0, 0.0), at(30.0), glass),
        ("1 layer", stack(1, 0.0), at(30.0), glass),
        ("14 layers, normal incidence", stack(14, 0.0), at(0.0), air),
        ("14 layers, absorbing", stack(14, 0.01), at(30.0), air),
        ("14 layers, half of them metal", stack(14, 4.0), at(30.0), air),
        ("14 layers, evanescent behind", stack(14, 0.0), dense, air),
        ("140 layers", stack(140, 0.0), at(30.0), air),
        ("1400 layers", stack(1400, 0.0), at(30.0), air),
        ("10,000 layers", stack(10_000, 0.0), at(30.0), air),
    ] {
        let Times { one_by_one, lanes, losses } = time(&layers, &incidence, last);
        println!("{name:34} {lanes:12.0} {:8.2} {one_by_one:12.0} {losses:12.0}", lanes / base);
    }
}
