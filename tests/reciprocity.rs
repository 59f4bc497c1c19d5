//! Helmholtz: light goes from one cone of directions into another as it goes back.
//!
//! With the direction of incidence drawn uniformly from cone I, the mean of cos θᵢ times the power that leaves into
//! cone O is ∬ f cos θᵢ cos θₒ dωᵢ dωₒ / |I|: symmetric in I and O, for cones of any width. Each incidence is its own
//! batch, and Welch's test compares the two ways; a right program fails each comparison with probability 1e-3.
#![allow(missing_docs, clippy::print_stdout, reason = "p-values are shown with --nocapture")]

mod common;

use common::build::{Build, ball, cuboid, fibre, light};
use common::listen::histogram;
use common::stats::{moments, welch};
use glam::DVec3;
use gonio_embree::light::{Incidence, Light, Polarization};
use gonio_embree::optics::C64;
use gonio_embree::sample::description::{Body, Fill, Shape};
use gonio_embree::sample::generate::packing::Packing;
use gonio_embree::trace::Batch;
use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};

/// Half-angle of the cones, degrees.
const HALF: f64 = 25.0;
/// Trees of a direction.
const TREES: u32 = 128;
/// Directions of a cone: 10⁵ and 2·10⁶ trees each way.
const FEW: u32 = 768;
const MANY: u32 = 16_384;

/// The unit vector with this polar angle and azimuth, degrees.
fn towards((theta, phi): (f64, f64)) -> DVec3 {
    let ((s, c), (sin, cos)) = (theta.to_radians().sin_cos(), phi.to_radians().sin_cos());
    DVec3::new(s * cos, s * sin, c)
}

/// A direction of a cone.
fn draw(axis: DVec3, rng: &mut Xoshiro256PlusPlus) -> DVec3 {
    let c = 1.0 - rng.random::<f64>() * (1.0 - HALF.to_radians().cos());
    let (sin, cos) = (std::f64::consts::TAU * rng.random::<f64>()).sin_cos();
    let (u, v) = axis.any_orthonormal_pair();
    c * axis + (1.0 - c * c).sqrt() * (cos * u + sin * v)
}

/// cos θᵢ times the power from each of many directions of the cone around `from` into the cone around `into`, of
/// which both axes point away from the sample.
fn transfer(build: &Build, from: DVec3, into: DVec3, directions: u32, seed: u64) -> Vec<f64> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let incidences: Vec<Incidence> = (0..directions)
        .map(|_| {
            let d = draw(from, &mut rng);
            Incidence { theta_deg: d.z.acos().to_degrees(), phi_deg: d.y.atan2(d.x).to_degrees() }
        })
        .collect();
    let light = Light { incidences, ..light(&[550.0], &[], Polarization::Unpolarized) };
    let batches: Vec<Batch> = (0..directions).map(|incidence| Batch { seed, incidence, scramble: 0 }).collect();
    let bound = HALF.to_radians().cos();
    let rows = histogram(&build.sample(&light), &light, &batches, TREES, 1, |dir| (dir.dot(into) > bound).then_some(0));
    rows.iter().zip(&light.incidences).map(|(row, i)| row[0] * -i.propagation().z).collect()
}

/// The p-value that two samples have one mean.
fn compare(a: &[f64], b: &[f64]) -> f64 {
    let ((ma, va, _), (mb, vb, _)) = (moments(a), moments(b));
    let se = (va + vb).sqrt();
    println!("{ma:.6} and {mb:.6}, standard error {se:.6}");
    assert!(se < 0.1 * ma, "too noisy to tell");
    welch(a, b)
}

/// The sample seen from below.
fn flipped(build: &Build) -> Build {
    let mut d = build.0.clone();
    let flip = |p: DVec3| p.with_z(-p.z);
    for object in &mut d.objects {
        let Body::Solid(shape, _) = &mut object.body else { panic!("no films here") };
        match shape {
            Shape::Sphere { center, .. } => *center = flip(*center),
            Shape::Cylinder(f) => (f.from, f.to) = (flip(f.from), flip(f.to)),
            Shape::Cuboid { min, max } => (min.z, max.z) = (-max.z, -min.z),
            Shape::Slab { top, bottom } => (*top, *bottom) = (-*bottom, -*top),
            Shape::Mesh(_) | Shape::Relief(_) => panic!("no meshes here"),
        }
    }
    Build(d)
}

fn reflects(name: &str, build: &Build, one: (f64, f64), other: (f64, f64), directions: u32) {
    let (a, b) = (towards(one), towards(other));
    let p = compare(&transfer(build, a, b, directions, 1), &transfer(build, b, a, directions, 2));
    println!("{name}: p = {p:.4}");
    assert!(p > 1e-3, "{name}: p = {p:e}");
}

/// From above and from below: there the sample is turned upside down.
fn transmits(name: &str, build: &Build, above: (f64, f64), below: (f64, f64), directions: u32) {
    let (a, b) = (towards(above), towards(below));
    let mirror = DVec3::new(1.0, 1.0, -1.0);
    let down = transfer(build, a, b * mirror, directions, 3);
    let up = transfer(&flipped(build), b, a * mirror, directions, 4);
    let p = compare(&down, &up);
    println!("{name}: p = {p:.4}");
    assert!(p > 1e-3, "{name}: p = {p:e}");
}

fn spheres() -> Build {
    let size = DVec3::new(20.0, 20.0, 12.0);
    Build::within(1.0).packing(&Packing { count: 350, radius: 1.0, size, periodic: true, seed: 3 }, 1.5)
}

/// Nothing about it is symmetric, and it absorbs.
fn lopsided() -> Build {
    Build::within(1.0)
        .patch(12.0, 9.0)
        .put(cuboid([-5.0, -4.0, 0.0], [-1.0, 1.0, 2.0]), 1.5)
        .put(ball([3.0, 1.0, 5.0], 2.5), C64::new(1.4, 5e-3))
        .put(Shape::Cylinder(fibre([-5.0, 3.0, 2.0], [1.0, -3.0, 6.0], 1.0)), 1.7)
        .fill(ball([3.0, -3.0, 1.5], 1.2), Fill::Diffuse(0.7))
}

/// White balls on a white floor.
fn matt() -> Build {
    let floor = cuboid([-6.0, -6.0, -1.0], [6.0, 6.0, 0.0]);
    let white = || Fill::Diffuse(0.9);
    let balls = [([-3.0, -2.0, 2.0], 2.0), ([2.0, 2.0, 4.0], 2.5), ([3.0, -3.0, 1.0], 1.0)];
    let around = Build::within(1.0).patch(12.0, 12.0).fill(floor, white());
    balls.into_iter().fold(around, |build, (center, radius)| build.fill(ball(center, radius), white()))
}

fn all(directions: u32) {
    reflects("spheres", &spheres(), (20.0, 0.0), (60.0, 40.0), directions);
    reflects("spheres, far apart", &spheres(), (0.0, 0.0), (65.0, 200.0), directions);
    reflects("lopsided", &lopsided(), (30.0, 10.0), (65.0, 250.0), directions);
    reflects("matt", &matt(), (0.0, 0.0), (65.0, 100.0), directions);
    transmits("spheres", &spheres(), (10.0, 0.0), (60.0, 100.0), directions);
    transmits("lopsided", &lopsided(), (55.0, 30.0), (20.0, 60.0), directions);
}

#[test]
fn light_goes_as_it_comes() {
    all(FEW);
}

#[test]
#[ignore = "slow: cargo test --release --test reciprocity -- --ignored (minutes)"]
fn light_goes_as_it_comes_for_2e6_trees() {
    all(MANY);
}
