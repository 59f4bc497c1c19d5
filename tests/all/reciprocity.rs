//! Helmholtz: light goes from one cone of directions into another as it goes back. Welch's test compares the two ways; a
//! right program fails each comparison with probability 1e-3.
#![allow(clippy::print_stdout, reason = "p-values are shown with --nocapture")]

use crate::common::build::{Build, ball, cuboid};
use crate::common::cones::{self, FEW, MANY, TREES, lopsided, over, spheres, towards, turned_over};
use crate::common::listen::histogram;
use crate::common::stats::{moments, welch};
use glam::DVec3;
use gonio_embree::light::Polarization;
use gonio_embree::sample::description::Fill;

/// cos θᵢ times the power from each of many directions of the cone around `from` into the cone around `into`, of
/// which both axes point away from the sample.
fn transfer(build: &Build, from: DVec3, into: DVec3, directions: u32, seed: u64) -> Vec<f64> {
    let light = cones::light_from(from, directions, seed, Polarization::Unpolarized);
    let batches = cones::batches(seed, directions);
    let bin = |dir| cones::holds(into, dir).then_some(0);
    let rows = histogram(&build.sample(&light), &light, &batches, TREES, 1, bin);
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

fn reflects(name: &str, build: &Build, one: (f64, f64), other: (f64, f64), directions: u32) {
    let (a, b) = (towards(one), towards(other));
    let p = compare(&transfer(build, a, b, directions, 1), &transfer(build, b, a, directions, 2));
    println!("{name}: p = {p:.4}");
    assert!(p > 1e-3, "{name}: p = {p:e}");
}

/// From above and from below: there the sample is turned over.
fn transmits(name: &str, build: &Build, above: (f64, f64), below: (f64, f64), directions: u32) {
    let (a, b) = (towards(above), towards(below));
    let down = transfer(build, a, over(b), directions, 3);
    let up = transfer(&turned_over(build), b, over(a), directions, 4);
    let p = compare(&down, &up);
    println!("{name}: p = {p:.4}");
    assert!(p > 1e-3, "{name}: p = {p:e}");
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
#[ignore = "slow: cargo test --release reciprocity:: -- --ignored (minutes)"]
fn light_goes_as_it_comes_for_2e6_trees() {
    all(MANY);
}
