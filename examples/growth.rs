//! How time and memory grow with the sample and with what is asked of it: measures the figures of `docs/performance.md`, and
//! writes it.
//!
//! ```text
//! cargo run --release --example growth
//! ```
#![allow(missing_docs, clippy::print_stdout)]

use std::fmt::Write as _;
use std::fs;
use std::path::Path;
use std::time::Instant;

use glam::{DVec2, DVec3};
use gonio_embree::experiment::{Settings, measure};
use gonio_embree::light::{Incidence, Light, Polarization, SourceMode, Wavelengths};
use gonio_embree::plot::{Curve, Panel, panels};
use gonio_embree::sample::description::{Fill, Named, Patch};
use gonio_embree::sample::generate::packing::{Packing, SpherePacking};
use gonio_embree::sample::problem::Place;
use gonio_embree::sample::{Description, Sample};
use gonio_embree::units::significant;

/// One measurement.
struct Point {
    /// What grows.
    size: f64,
    /// Sample and accelerator, s.
    build: f64,
    /// Planning and tracing, s, per unit of work.
    trace: f64,
    /// Greatest memory, MiB, above that of the program before.
    memory: f64,
}

/// What grows, and how.
struct Series {
    name: &'static str,
    axis: &'static str,
    /// What the time is of.
    unit: &'static str,
    points: Vec<Point>,
}

fn light(nm: usize, incidences: usize, source: SourceMode) -> Light {
    let step = if nm > 1 { 300.0 / (nm - 1) as f64 } else { 0.0 };
    let theta = |i: usize| 80.0 * i as f64 / incidences.max(2) as f64;
    Light {
        wavelengths: Wavelengths::from_nm((0..nm).map(|i| 400.0 + step * i as f64).collect()).unwrap(),
        incidences: (0..incidences).map(|i| Incidence { theta_deg: theta(i), phi_deg: 0.0 }).collect(),
        polarization: Polarization::Unpolarized,
        source,
    }
}

/// `count` spheres, 30 % of a layer of ten diameters, of a glass that disperses if `disperses`.
fn spheres(count: usize, disperses: bool) -> Description {
    let glass = if disperses { "{ cauchy_nm = [1.5, 5000] }" } else { "1.5" };
    let text = format!(
        "[media]\nglass = {glass}\n[[object]]\nshape = \"sphere\"\ncenter = [0,0,0]\nradius = 1\nmedium = \"glass\"\n"
    );
    let mut description = Description::from_text(&text).unwrap().0;
    let height = 20.0;
    let edge = (count as f64 * 4.0 / 3.0 * std::f64::consts::PI / 0.3 / height).sqrt();
    let packing = Packing { count, radius: 1.0, size: DVec3::new(edge, edge, height), periodic: true, seed: 1 };
    let glass = Fill::Medium(Named { name: "glass".into(), place: Place::default() });
    description.objects = SpherePacking::equal(packing, glass).objects(&Place::default()).unwrap();
    description.patch = Some(Patch { size: DVec2::splat(edge), center: DVec2::ZERO });
    description
}

/// A stack of `count` films, high and low by turns.
fn films(count: usize) -> Description {
    let pair = "{ medium = \"high\", thickness = \"60 nm\" }, { medium = \"low\", thickness = \"90 nm\" }";
    let layers = if count == 1 {
        "layers = [{ medium = \"high\", thickness = \"60 nm\" }]".to_string()
    } else {
        format!("layers = [{pair}]\nrepeat = {}", count / 2)
    };
    let text = format!("[media]\nhigh = 2.0\nlow = 1.5\n[[object]]\nshape = \"films\"\ntop = 0\n{layers}\n");
    Description::from_text(&text).unwrap().0
}

/// Bytes of this program: now, or the most since it was last asked to forget.
fn memory(key: &str) -> f64 {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|l| l.strip_prefix(key));
    line.and_then(|l| l.split_whitespace().next()?.parse().ok()).unwrap_or(f64::NAN) / 1024.0
}

/// More primitives than these take minutes: once is enough.
const LARGE: f64 = 2e6;

/// The best of three, or of one if large: work of `units` units.
fn point(size: f64, description: &Description, light: &Light, settings: &Settings, units: f64) -> Point {
    let mut best = Point { size, build: f64::INFINITY, trace: f64::INFINITY, memory: 0.0 };
    for _ in 0..if size > LARGE { 1 } else { 3 } {
        let _ = fs::write("/proc/self/clear_refs", "5");
        let before = memory("VmRSS:");
        let start = Instant::now();
        let sample = Sample::new(description, &light.wavelengths, light.coherence()).unwrap();
        let read = start.elapsed().as_secs_f64();
        let outcome = measure(&sample, light, settings, |_| {}).unwrap();
        best.build = best.build.min(read + outcome.seconds - outcome.tracing_seconds);
        best.trace = best.trace.min(outcome.tracing_seconds / units);
        best.memory = best.memory.max(memory("VmHWM:") - before);
    }
    println!("{size:>10} {:>9.4} s {:>10.3e} s {:>8.1} MiB", best.build, best.trace, best.memory);
    best
}

fn all() -> Vec<Series> {
    let settings = |trees: u64| Settings { trees, ..Settings::default() };
    let band = |nm, incidences| light(nm, incidences, SourceMode::Band);
    let tree = |trees: u64, incidences: usize| (trees * incidences as u64) as f64;
    let grow = |name, axis, unit, sizes: &[usize], of: &dyn Fn(usize) -> Point| {
        println!("{name}");
        Series { name, axis, unit, points: sizes.iter().map(|&n| of(n)).collect() }
    };
    let packing = spheres(3000, false);
    let dispersing = spheres(3000, true);
    vec![
        grow("Spheres", "spheres", "tree", &[1000, 10_000, 100_000, 1_000_000, 10_000_000], &|n| {
            point(n as f64, &spheres(n, false), &band(1, 1), &settings(50_000), tree(50_000, 1))
        }),
        grow("Films", "layers", "tree", &[1, 10, 100, 1000, 10_000], &|n| {
            let line = light(16, 1, SourceMode::Line);
            point(n as f64, &films(n), &line, &settings(50_000), tree(50_000, 1))
        }),
        grow("Wavelengths of a packing that disperses", "wavelengths", "tree", &[1, 4, 16, 64, 256, 400], &|n| {
            point(n as f64, &dispersing, &band(n, 1), &settings(4000), tree(4000, 1))
        }),
        grow("Facets of the dome", "level", "tree", &[2, 3, 4, 5, 6, 7], &|n| {
            let settings = Settings { dome_level: n as u8, ..settings(50_000) };
            let facets = 20.0 * 4f64.powi(n as i32);
            point(facets, &packing, &band(16, 1), &settings, tree(50_000, 1))
        }),
        grow("Incidences", "incidences", "tree", &[1, 5, 20, 100, 500], &|n| {
            point(n as f64, &packing, &band(1, n), &settings(2000), tree(2000, n))
        }),
    ]
}

type Of = fn(&Point) -> f64;

/// A slope; none where too little was measured, such as memory that was there before.
fn told(slope: f64) -> String {
    if slope.is_finite() { format!("{slope:.2}") } else { "–".into() }
}

/// How a quantity grows from the last size but one to the last: the power of the size.
fn slope(series: &Series, of: Of) -> f64 {
    let [.., a, b] = &series.points[..] else { return f64::NAN };
    (of(b) / of(a)).ln() / (b.size / a.size).ln()
}

fn plot(series: &Series) -> String {
    let x: Vec<f64> = series.points.iter().map(|p| p.size.log10()).collect();
    let panel = |title: &str, y_name: &str, curves: Vec<(&str, Of)>| Panel {
        title: title.into(),
        x_name: format!("log10 of the number of {}", series.axis),
        y_name: y_name.into(),
        is_log: true,
        y_range: Some(range(curves.iter().flat_map(|(_, of)| series.points.iter().map(of)))),
        curves: curves
            .into_iter()
            .map(|(name, of)| Curve::exact(name, x.clone(), series.points.iter().map(of)))
            .collect(),
    };
    let time: Vec<(&str, Of)> =
        vec![("sample, accelerator, plan", |p| p.build), ("a million trees traced", |p| 1e6 * p.trace)];
    panels(series.name, &[panel("time", "s", time), panel("memory", "MiB", vec![("", |p| p.memory.max(0.1))])])
}

fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = values.fold((f64::INFINITY, 0.0f64), |(l, h), x| (l.min(x), h.max(x)));
    (0.5 * low.max(1e-6), 2.0 * high)
}

const HEAD: &str = "# How time and memory grow

This page and the files beside it are made by `cargo run --release --example growth` (two threads, the best of three; of 10⁷
spheres once; 6 minutes). *Build* is the sample, the accelerator and the plan with its pilots, once per measurement, but not the
places of randomly inserted spheres; *tree* is the time of a tree of rays. The slope is the power with which the last step grows:
1 is linear, 0 does not depend on it. Memory is what the measurement holds at most beyond what the program held before; what a
larger one before it has given back is used again and does not show, so that only the spheres, which come first, tell how memory
grows. How near tracing is to what the accelerator alone can do is printed by `cargo bench --bench limit`.
";

fn main() -> std::io::Result<()> {
    let out = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/performance");
    fs::create_dir_all(&out)?;
    let mut page = String::from(HEAD);
    for series in all() {
        let file = series.name.split(' ').next().unwrap_or_default().to_lowercase();
        fs::write(out.join(format!("{file}.svg")), plot(&series))?;
        let _ = write!(
            page,
            "\n## {}\n\n![{0}](performance/{file}.svg)\n\n| {} | build / s | {} / µs | memory / MiB |\n|--:|--:|--:|--:|\n",
            series.name, series.axis, series.unit
        );
        for p in &series.points {
            let [build, trace, memory] = [p.build, 1e6 * p.trace, p.memory].map(|x| significant(x, 3));
            let _ = writeln!(page, "| {} | {build} | {trace} | {memory} |", p.size);
        }
        let [build, trace, memory] =
            [slope(&series, |p| p.build), slope(&series, |p| p.trace), slope(&series, |p| p.memory)].map(told);
        let _ = writeln!(page, "| *slope* | {build} | {trace} | {memory} |");
    }
    fs::write(out.with_extension("md"), page)
}
