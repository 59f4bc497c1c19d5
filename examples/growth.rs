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
use std::process::Command;
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

/// One measurement, made by a process of its own: what others have given back would be used again, and hide what it needs.
#[derive(Clone, Copy)]
struct Point {
    /// What grows.
    size: f64,
    /// Sample and accelerator, s.
    build: f64,
    /// Planning and tracing, s, per unit of work.
    trace: f64,
    /// Greatest memory, MiB, beyond that of the process with the description of the sample.
    memory: f64,
}

/// What grows, and how.
struct Series {
    name: &'static str,
    axis: &'static str,
    sizes: &'static [usize],
    measure: fn(usize) -> Point,
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

/// MiB of this process: now, or the most so far.
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
    let before = memory("VmRSS:");
    for run in 0..if size > LARGE { 1 } else { 3 } {
        let start = Instant::now();
        let sample = Sample::new(description, &light.wavelengths, light.coherence()).unwrap();
        let read = start.elapsed().as_secs_f64();
        let outcome = measure(&sample, light, settings, |_| {}).unwrap();
        best.build = best.build.min(read + outcome.seconds - outcome.tracing_seconds);
        best.trace = best.trace.min(outcome.tracing_seconds / units);
        if run == 0 {
            // What this one gives back the next need not be given again.
            best.memory = memory("VmHWM:") - before;
        }
    }
    best
}

fn settings(trees: u64) -> Settings {
    Settings { trees, ..Settings::default() }
}

fn band(nm: usize, incidences: usize) -> Light {
    light(nm, incidences, SourceMode::Band)
}

const ALL: [Series; 5] = [
    Series {
        name: "Spheres",
        axis: "spheres",
        sizes: &[1000, 10_000, 100_000, 1_000_000, 10_000_000],
        measure: |n| point(n as f64, &spheres(n, false), &band(1, 1), &settings(50_000), 50_000.0),
    },
    Series {
        name: "Films",
        axis: "layers",
        sizes: &[1, 10, 100, 1000, 10_000],
        measure: |n| point(n as f64, &films(n), &light(16, 1, SourceMode::Line), &settings(50_000), 50_000.0),
    },
    Series {
        name: "Wavelengths of a packing that disperses",
        axis: "wavelengths",
        sizes: &[1, 4, 16, 64, 256, 400],
        measure: |n| point(n as f64, &spheres(3000, true), &band(n, 1), &settings(4000), 4000.0),
    },
    Series {
        name: "Facets of the dome",
        axis: "facets",
        sizes: &[2, 3, 4, 5, 6, 7],
        measure: |n| {
            let settings = Settings { dome_level: n as u8, ..settings(50_000) };
            point(20.0 * 4f64.powi(n as i32), &spheres(3000, false), &band(16, 1), &settings, 50_000.0)
        },
    },
    Series {
        name: "Incidences",
        axis: "incidences",
        sizes: &[1, 5, 20, 100, 500],
        measure: |n| point(n as f64, &spheres(3000, false), &band(1, n), &settings(2000), 2000.0 * n as f64),
    },
];

/// Measures a point of a series in another process.
fn apart(series: usize, size: usize) -> std::io::Result<Point> {
    let out = Command::new(std::env::current_exe()?).args([series, size].map(|n| n.to_string())).output()?;
    let text = String::from_utf8_lossy(&out.stdout);
    let numbers: Vec<f64> = text.split_whitespace().filter_map(|x| x.parse().ok()).collect();
    let &[size, build, trace, memory] = &numbers[..] else {
        return Err(std::io::Error::other(String::from_utf8_lossy(&out.stderr).into_owned()));
    };
    println!("{size:>10} {build:>9.4} s {trace:>10.3e} s {memory:>8.1} MiB");
    Ok(Point { size, build, trace, memory })
}

type Of = fn(&Point) -> f64;

/// A slope; none where too little was measured.
fn told(slope: f64) -> String {
    if slope.is_finite() { format!("{slope:.2}") } else { "–".into() }
}

/// How a quantity grows from the last size but one to the last: the power of the size.
fn slope(points: &[Point], of: Of) -> f64 {
    let [.., a, b] = points else { return f64::NAN };
    (of(b) / of(a)).ln() / (b.size / a.size).ln()
}

fn plot(series: &Series, points: &[Point]) -> String {
    let x: Vec<f64> = points.iter().map(|p| p.size.log10()).collect();
    let panel = |title: &str, y_name: &str, curves: Vec<(&str, Of)>| Panel {
        title: title.into(),
        x_name: format!("log10 of the number of {}", series.axis),
        y_name: y_name.into(),
        is_log: true,
        y_range: Some(range(curves.iter().flat_map(|(_, of)| points.iter().map(of)))),
        curves: curves.into_iter().map(|(name, of)| Curve::exact(name, x.clone(), points.iter().map(of))).collect(),
    };
    let time: Vec<(&str, Of)> =
        vec![("sample, accelerator, plan", |p| p.build), ("a million trees traced", |p| 1e6 * p.trace)];
    panels(series.name, &[panel("time", "s", time), panel("memory", "MiB", vec![("", |p| p.memory)])])
}

fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = values.fold((f64::INFINITY, 0.0f64), |(l, h), x| (l.min(x), h.max(x)));
    (0.5 * low.max(1e-6), 2.0 * high)
}

const HEAD: &str = "# How time and memory grow

This page and the files beside it are made by `cargo run --release --example growth` (two threads, the best of three; of 10⁷
spheres once; 6 minutes). *Build* is the sample, the accelerator and the plan with its pilots, once per measurement, but not the
places of randomly inserted spheres; *tree* is the time of a tree of rays. Memory is what the measurement holds at most, without
the program itself and the description of the sample. The slope is the power with which the last step grows: 1 is linear, 0 does
not depend on it. How near tracing is to what the accelerator alone can do is printed by `cargo bench --bench limit`.
";

fn main() -> std::io::Result<()> {
    let asked: Vec<usize> = std::env::args().skip(1).filter_map(|n| n.parse().ok()).collect();
    if let [series, size] = asked[..] {
        let Point { size, build, trace, memory } = (ALL[series].measure)(size);
        println!("{size} {build} {trace} {memory}");
        return Ok(());
    }
    let out = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/performance");
    fs::create_dir_all(&out)?;
    let mut page = String::from(HEAD);
    for (number, series) in ALL.iter().enumerate() {
        println!("{}", series.name);
        let points = series.sizes.iter().map(|&size| apart(number, size)).collect::<Result<Vec<Point>, _>>()?;
        let file = series.name.split(' ').next().unwrap_or_default().to_lowercase();
        fs::write(out.join(format!("{file}.svg")), plot(series, &points))?;
        let _ = write!(
            page,
            "\n## {}\n\n![{0}](performance/{file}.svg)\n\n| {} | build / s | tree / µs | memory / MiB |\n|--:|--:|--:|--:|\n",
            series.name, series.axis
        );
        for p in &points {
            let [build, trace, memory] = [p.build, 1e6 * p.trace, p.memory].map(|x| significant(x, 3));
            let _ = writeln!(page, "| {} | {build} | {trace} | {memory} |", p.size);
        }
        let of: [Of; 3] = [|p| p.build, |p| p.trace, |p| p.memory];
        let [build, trace, memory] = of.map(|of| told(slope(&points, of)));
        let _ = writeln!(page, "| *slope* | {build} | {trace} | {memory} |");
    }
    fs::write(out.with_extension("md"), page)
}
