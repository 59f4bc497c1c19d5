//! Where geometrical optics has an answer: one sphere, one endless cylinder, solid or hollow.
//!
//! The power in bins of direction is compared with the exact integrals over the bins, by Hotelling's T² over
//! independent scrambles: a right program fails each test with probability 1e-3 (but seeds are fixed).
#![allow(clippy::print_stdout, reason = "p-values are shown with --nocapture")]

use crate::common::build::{Build, ball, fibre, light};
use crate::common::listen::{histogram, scrambles};
use crate::common::stats::hotelling;
use glam::DVec3;
use gonio_embree::light::Polarization;
use gonio_embree::optics::fresnel::{dielectric, other_leg};
use gonio_embree::sample::description::{Fibre, Shape};
use gonio_embree::trace::Batch;

const FALSE_ALARM: f64 = 1e-3;
/// More than four times as many as bins.
const BATCHES: u32 = 160;
/// Trees of a batch: 6.6·10⁵ and 10⁷ in all.
const FEW: u32 = 4096;
const MANY: u32 = 65_536;

/// A column of a table, by its name.
fn column(file: &str, name: &str) -> Vec<f64> {
    let text = std::fs::read_to_string(format!("tests/reference/{file}.csv")).unwrap();
    let mut lines = text.lines();
    let at = lines.next().unwrap().split(',').position(|c| c == name).unwrap();
    lines.map(|l| l.split(',').nth(at).unwrap().parse().unwrap()).collect()
}

/// Sums of `n` neighbours.
fn pooled(bins: &[f64], n: usize) -> Vec<f64> {
    bins.chunks_exact(n).map(|c| c.iter().sum()).collect()
}

/// How often a whole run must expect the power of a bin to change by one tree's for T² to be trusted there: a bin that
/// nearly always gets the same light, but from one tree in 10⁶ much more, has no honest standard error.
const EVENTS: f64 = 100.0;

/// Most of the power that may be guided along an endless cylinder until it has walked out sideways: light that entered at
/// the rim, where next to none enters or leaves.
const GUIDED: f64 = 1e-7;

/// Groups of neighbouring bins that expect enough events, by an independent pilot of `FEW` trees a batch: the group
/// of each bin.
fn groups(pilot: &[Vec<f64>], trees: u32) -> Vec<usize> {
    let (n, bins) = (pilot.len() as f64, pilot[0].len() - 1);
    let events = |bins: std::ops::Range<usize>| {
        let powers = pilot.iter().map(|row| row[bins.clone()].iter().sum::<f64>() * f64::from(FEW));
        let mean = powers.clone().sum::<f64>() / n;
        let variance = powers.map(|x| (x - mean).powi(2)).sum::<f64>() / (n - 1.0);
        variance * f64::from(trees / FEW * BATCHES)
    };
    let (mut first, mut group, mut out) = (0, 0, Vec::new());
    for bin in 0..bins {
        out.push(group);
        if events(first..bin + 1) >= EVENTS {
            (first, group) = (bin + 1, group + 1);
        }
    }
    // What is left over at the end goes to the last full group.
    out.iter().map(|&g| g.min(group - 1)).collect()
}

fn grouped(row: &[f64], groups: &[usize]) -> Vec<f64> {
    let mut out = vec![0.0; groups[groups.len() - 1] + 1];
    row.iter().zip(groups).for_each(|(x, &g)| out[g] += x);
    out
}

/// What is measured, and how.
struct Comparison<'a> {
    name: &'a str,
    seed: u64,
    /// Whether all light is in the bins: then they add up to 1, and the last says nothing new.
    complete: bool,
    truth: &'a [f64],
}

impl Comparison<'_> {
    /// Compares batches of so many trees, made by `measure`, with the truth.
    fn run(&self, trees: u32, measure: impl Fn(&[Batch], u32) -> Vec<Vec<f64>>) {
        let groups = groups(&measure(&scrambles(self.seed + 1000, BATCHES / 2), FEW), trees);
        let count = groups[groups.len() - 1] + 1 - usize::from(self.complete);
        let reduced = |row: &Vec<f64>| {
            let (elsewhere, bins) = row.split_last().unwrap();
            let sum = bins.iter().sum::<f64>() + elsewhere;
            assert!(!self.complete || (sum - 1.0).abs() < 1e-9, "{}: {:e}", self.name, sum - 1.0);
            assert!(*elsewhere <= GUIDED, "{}: {elsewhere:e}", self.name);
            grouped(bins, &groups)[..count].to_vec()
        };
        let rows: Vec<Vec<f64>> = measure(&scrambles(self.seed, BATCHES), trees).iter().map(reduced).collect();
        let p = hotelling(&rows, &grouped(self.truth, &groups)[..count]);
        println!("{}: p = {p:.4}, {count} bins", self.name);
        assert!(p > FALSE_ALARM, "{}: p = {p:e}, groups {groups:?}", self.name);
    }
}

/// Bins of the scattering angle, 5° each.
const SPHERE_BINS: usize = 36;

/// What the table leaves out: orders 21 to 400 of a sphere, 2e-5 of the power, per bin for s and for p. Midpoint rule
/// in √(1 − b²) from 0 to 1/2, for all of it comes from near the rim.
fn high_orders() -> [Vec<f64>; 2] {
    const STEPS: usize = 10_000;
    let mut out = [vec![0.0; SPHERE_BINS], vec![0.0; SPHERE_BINS]];
    for step in 0..STEPS {
        let cos = 0.5 * (step as f64 + 0.5) / STEPS as f64;
        let sin = other_leg(cos);
        let share = cos / STEPS as f64;
        let r = dielectric(1.0, 1.5, cos, sin).r().map(|r| r.norm_sqr());
        let (i, refracted) = (sin.atan2(cos), (sin / 1.5).asin());
        for order in 21..=400 {
            let turned = 2.0 * i + f64::from(order - 1) * std::f64::consts::PI - 2.0 * f64::from(order) * refracted;
            let bin = angle_bin(turned.cos(), turned.sin().abs(), SPHERE_BINS);
            for (out, r) in out.iter_mut().zip([r.s, r.p]) {
                out[bin] += share * (1.0 - r).powi(2) * r.powi(order - 1);
            }
        }
    }
    out
}

/// Bin of an angle of 0..180° by its cosine and sine, whatever their scale.
fn angle_bin(cos: f64, sin: f64, bins: usize) -> usize {
    ((sin.atan2(cos) / std::f64::consts::PI * bins as f64) as usize).min(bins - 1)
}

/// A sphere under a patch that just holds its shadow, π/4 of the patch.
fn sphere(theta: f64) -> Build {
    let radius = 50.0;
    let (sin, cos) = theta.to_radians().sin_cos();
    let center = [-radius * sin / cos, 0.0, 0.0];
    Build::within(1.0).open().patch(2.0 * radius / cos, 2.0 * radius).put(ball(center, radius), 1.5)
}

/// Light that has met nothing goes on exactly in its direction.
fn hit(dir: DVec3, incident: DVec3) -> bool {
    dir != incident
}

fn unpolarized_sphere(trees: u32) {
    let light = light(&[550.0], &[(0.0, 0.0)], Polarization::Unpolarized);
    let incident = light.incidences[0].propagation();
    let [s, p] = high_orders();
    let table = column("sphere_n1.5_bins5deg", "E_unpol_total");
    let truth: Vec<f64> =
        (0..SPHERE_BINS).map(|i| (table[i] + 0.5 * (s[i] + p[i])) * std::f64::consts::FRAC_PI_4).collect();
    // Orders beyond 400 hold some 1e-8.
    assert!((truth.iter().sum::<f64>() - std::f64::consts::FRAC_PI_4).abs() < 1e-7, "orders up to 400 hold all power");
    let sample = sphere(0.0).sample(&light);
    let comparison = Comparison { name: "sphere, unpolarized", seed: 11, complete: false, truth: &truth };
    comparison.run(trees, |batches, trees| {
        histogram(&sample, &light, batches, trees, SPHERE_BINS, |dir| {
            hit(dir, incident).then(|| angle_bin(dir.dot(incident), dir.cross(incident).length(), SPHERE_BINS))
        })
    });
}

/// Polarized light scatters differently along its field and across: the azimuths nearer to the field and those
/// nearer to its normal are counted apart, in bins of 10°.
fn polarized_sphere(trees: u32) {
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, TAU};
    let theta = 40.0;
    let light = light(&[550.0], &[(theta, 0.0)], Polarization::P);
    let incidence = light.incidences[0];
    let (incident, e) = (incidence.propagation(), incidence.p_direction());
    let half = SPHERE_BINS / 2;
    let [s, p] = high_orders();
    let both = |name, high: Vec<f64>| {
        let table = column("sphere_n1.5_bins5deg", name);
        pooled(&table.iter().zip(&high).map(|(a, b)| a + b).collect::<Vec<_>>(), 2)
    };
    let (s, p) = (both("E_s_total", s), both("E_p_total", p));
    // ∫ (s sin² φ + p cos² φ) dφ/2π over the azimuths with |cos φ| above, or below, |sin φ|.
    let share = |s: f64, p: f64| FRAC_PI_4 * (p * (FRAC_PI_2 + 1.0) + s * (FRAC_PI_2 - 1.0)) / TAU;
    let along = s.iter().zip(&p).map(|(&s, &p)| share(s, p));
    let truth: Vec<f64> = along.chain(s.iter().zip(&p).map(|(&s, &p)| share(p, s))).collect();
    let sample = sphere(theta).sample(&light);
    let comparison = Comparison { name: "sphere, polarized, 40°", seed: 12, complete: false, truth: &truth };
    comparison.run(trees, |batches, trees| {
        histogram(&sample, &light, batches, trees, 2 * half, |dir| {
            let bin = angle_bin(dir.dot(incident), dir.cross(incident).length(), half);
            let across = dir.dot(e).abs() < dir.dot(incidence.s_direction()).abs();
            hit(dir, incident).then_some(if across { half + bin } else { bin })
        })
    });
}

/// Bins of the azimuth, 9° each.
const CYLINDER_BINS: usize = 20;

/// A cylinder along x under a patch as wide as it is.
fn cylinder(file: &str, oblique: f64, hollow: bool, trees: u32) {
    let radius = 20.0;
    let endless = Fibre { caps: false, ..fibre([0.0; 3], [1.0, 0.0, 0.0], radius) };
    let around = Build::within(1.0).open().patch(10.0 * radius, 2.0 * radius);
    let build =
        if hollow { around.hollow(endless, 1.53, 0.5 * radius, 1.0) } else { around.put(Shape::from(endless), 1.53) };
    for (polarization, name) in [(Polarization::P, "E_par"), (Polarization::S, "E_perp")] {
        let light = light(&[550.0], &[(oblique, 0.0)], polarization);
        let along = light.incidences[0].propagation().x;
        let sample = build.sample(&light);
        let truth = pooled(&column(file, name), 180 / CYLINDER_BINS);
        let name = format!("{file}, {name}");
        Comparison { name: &name, seed: 13, complete: true, truth: &truth }.run(trees, |batches, trees| {
            histogram(&sample, &light, batches, trees, CYLINDER_BINS, |dir| {
                assert!((dir.x - along).abs() < 1e-9, "rays stay on the cone");
                Some(angle_bin(-dir.z, dir.y.abs(), CYLINDER_BINS))
            })
        });
    }
}

fn all(trees: u32) {
    unpolarized_sphere(trees);
    polarized_sphere(trees);
    cylinder("cyl_solid_n1.53_normal", 0.0, false, trees);
    cylinder("cyl_solid_n1.53_oblique60", 60.0, false, trees);
    cylinder("cyl_hollow_n1.53_r0.5_normal", 0.0, true, trees);
    cylinder("cyl_hollow_n1.53_r0.5_oblique60", 60.0, true, trees);
}

#[test]
fn spheres_and_cylinders_scatter_as_they_should() {
    all(FEW);
}

#[test]
#[ignore = "slow: cargo test --release closed_forms:: -- --ignored (minutes)"]
fn spheres_and_cylinders_scatter_as_they_should_for_1e7_trees() {
    all(MANY);
}
