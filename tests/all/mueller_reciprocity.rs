//! Helmholtz for polarized light: M of a way is Q Mᵀ Q of the way back, Q = diag(1, 1, −1, 1).
//!
//! Light that comes from u is told along (−θ̂, φ̂) of u, light that goes to u along (θ̂, φ̂): so a Jones matrix J of the way
//! there is D Jᵀ D of the way back, D = diag(1, −1), for fields in the same directions of space are exchanged. Sums over
//! cones are compared as in `reciprocity.rs`, element by element, with a false alarm of 1e-3 per sample.
#![allow(clippy::print_stdout, reason = "p-values are shown with --nocapture")]

use crate::common::matrices;

use crate::common::Mesh;
use crate::common::build::{Build, light, mesh};
use crate::common::cones::{self, FEW, MANY, TREES, incidence, lopsided, over, spheres, towards, turned_over};
use crate::common::listen::{entries, listen};
use crate::common::stats::{moments, welch};
use glam::{DMat3, DVec3};
use gonio_embree::intersect::Scene;
use gonio_embree::intersect::choose::Backend;
use gonio_embree::light::{Light, Polarization};
use gonio_embree::optics::C64;
use gonio_embree::optics::field::{Mueller, State};
use gonio_embree::plan::{Limits, Options, Plan, Wanted};
use gonio_embree::sample::description::Shape;
use gonio_embree::trace::{All, Detect, Exit, Kernel, Recorder, Unit, run};

const FALSE_ALARM: f64 = 1e-3;
const ALUMINIUM: C64 = C64::new(0.96, 6.69);
/// What the way back makes of a matrix.
fn reversed(m: &matrices::Mueller) -> matrices::Mueller {
    let sign = |i: usize| if i == 2 { -1.0 } else { 1.0 };
    let transposed = matrices::transposed(m);
    std::array::from_fn(|at| sign(at / 4) * sign(at % 4) * transposed[at])
}

/// The matrix of light that leaves along `dir`, told in (θ̂, φ̂).
fn in_polar_frame(field: Mueller, dir: DVec3, x: DVec3) -> matrices::Mueller {
    let phi = DVec3::new(-dir.y, dir.x, 0.0).normalize();
    let theta = phi.cross(dir);
    field.rotated(theta.dot(x), theta.dot(dir.cross(x))).rows()
}

fn box_of(size: [f64; 3], turn: DMat3, center: [f64; 3]) -> Shape {
    mesh(Mesh::cube().map(|p| turn * ((p - 0.5) * DVec3::from_array(size)) + DVec3::from_array(center)))
}

/// Matrices of all light from `from` that leaves exactly towards `to`.
fn exact(build: &Build, from: DVec3, to: DVec3) -> Vec<matrices::Mueller> {
    let light = Light { incidences: vec![incidence(from)], ..light(&[550.0], &[], Polarization::Mueller) };
    let sample = build.sample(&light);
    let limits = Limits { splits: Some(4), ..Limits::default() };
    let heard = listen::<Mueller>(&sample, &light, Backend::Auto, limits, Wanted::AUTO, &entries(3, 2000));
    let there = heard.exits.iter().filter(|e| e.dir.distance(to) < 1e-6);
    there.map(|e| in_polar_frame(e.fields[0].1, e.dir, e.frame)).collect()
}

/// Two mirrors of metal, neither of which stands in the plane of incidence of the other: all elements are there. Each
/// matrix of the way there has its like on the way back.
#[test]
fn two_mirrors_exchange_source_and_detector() {
    let turn = |axis: [f64; 3], degrees: f64| {
        DMat3::from_axis_angle(DVec3::from_array(axis).normalize(), degrees.to_radians())
    };
    let [left, right] = [turn([0.2, 1.0, 0.0], 40.0), turn([0.3, -1.0, 0.1], 45.0)];
    let build = Build::within(1.0)
        .open()
        .patch(14.0, 14.0)
        .put(box_of([8.0, 14.0, 1.0], left, [-4.5, 0.0, 0.0]), ALUMINIUM)
        .put(box_of([8.0, 14.0, 1.0], right, [4.5, 0.0, 0.0]), ALUMINIUM);
    let mirrored = |d: DVec3, turn: DMat3| d - 2.0 * d.dot(turn * DVec3::Z) * (turn * DVec3::Z);
    for from in [(10.0, 20.0), (25.0, 130.0), (5.0, 250.0)].map(towards) {
        let to = mirrored(mirrored(-from, left), right);
        let (there, back) = (exact(&build, from, to), exact(&build, to, from));
        assert!(!there.is_empty() && !back.is_empty() && to.z > 0.0, "{from} {to}");
        let expected = reversed(&back[0]);
        assert!(there.iter().all(|m| matrices::distance(m, &expected) < 1e-12), "{:?}\n{expected:?}", there[0]);
        assert!(expected.iter().all(|x| x.abs() > 1e-4 * expected[0]), "an element that is not there shows nothing");
    }
}

/// A prism: light leaves it in another direction than it came.
#[test]
fn a_prism_exchanges_source_and_detector() {
    let n = 1.3;
    let [upper, lower] = [DVec3::new(0.2, 0.1, 1.0), DVec3::new(-0.2, 0.25, -1.0)].map(DVec3::normalize);
    // A box whose faces above and below have these normals.
    let on = |normal: DVec3, x: f64, y: f64, at: f64| (at - normal.x * x - normal.y * y) / normal.z;
    let wedge = Mesh::cube().map(|p| {
        let (x, y) = (10.0 * p.x - 5.0, 10.0 * p.y - 5.0);
        DVec3::new(x, y, if p.z > 0.5 { on(upper, x, y, 3.0) } else { on(lower, x, y, 3.0) })
    });
    let build = Build::within(1.0).open().patch(10.0, 10.0).put(mesh(wedge), n);
    let bent = |d: DVec3, normal: DVec3, ratio: f64| {
        let cos = -d.dot(normal);
        let behind = (1.0 - ratio * ratio * (1.0 - cos * cos)).sqrt();
        ratio * d + (ratio * cos - behind) * normal
    };
    for from in [(10.0, 20.0), (45.0, 130.0), (60.0, 250.0)].map(towards) {
        let to = bent(bent(-from, upper, 1.0 / n), -lower, n);
        assert!(to.z < 0.0, "{from} {to}");
        let (there, back) = (exact(&build, from, to), exact(&turned_over(&build), over(to), over(from)));
        assert!(!there.is_empty() && !back.is_empty(), "{from} {to}");
        let strongest = |all: &[matrices::Mueller]| *all.iter().max_by(|a, b| a[0].total_cmp(&b[0])).unwrap();
        let (there, back) = (strongest(&there), strongest(&back));
        assert!(matrices::distance(&there, &reversed(&back)) < 1e-12, "{there:?}\n{back:?}");
        assert!(there[2].abs() > 1e-3 && there[6].abs() > 1e-3, "{there:?}");
    }
}

/// Adds up the matrices of light that leaves into a cone.
struct Cone {
    axis: DVec3,
    sum: matrices::Mueller,
}

impl Recorder<Mueller> for Cone {
    fn exit(&mut self, exit: &Exit<'_, Mueller>) {
        if cones::holds(self.axis, exit.dir) {
            for (_, field) in exit.loads() {
                let m = in_polar_frame(field, exit.dir, exit.frame);
                self.sum.iter_mut().zip(m).for_each(|(sum, x)| *sum += x);
            }
        }
    }
}

impl Detect<Mueller> for Cone {
    type Part = matrices::Mueller;

    fn begin(&mut self, _: usize) {}

    fn finish(&mut self, trees: u64) -> matrices::Mueller {
        std::mem::take(&mut self.sum).map(|x| x / trees as f64)
    }
}

/// cos θᵢ times the matrix from each of many directions of the cone around `from` into the cone around `into`, of which
/// both axes point away from the sample.
fn transfer(build: &Build, from: DVec3, into: DVec3, directions: u32, seed: u64) -> Vec<matrices::Mueller> {
    let light = cones::light_from(from, directions, seed, Polarization::Mueller);
    let sample = build.sample(&light);
    let scene = Scene::new(sample.primitives.clone(), sample.domain, Backend::Auto).unwrap();
    let plan = Plan::new(&sample, &light, &Options::default());
    let kernel = Kernel::new(&sample, &scene, &plan, &light);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
    let units: Vec<Unit> = cones::batches(seed, directions).into_iter().flat_map(|b| Unit::cut(b, TREES)).collect();
    let make = || Cone { axis: into, sum: [0.0; 16] };
    let mut rows = Vec::new();
    run::<Mueller, All, _>(&kernel, &light, &units, &pool, make, |_, part, _| {
        let cos = -light.incidences[rows.len()].propagation().z;
        rows.push(part.map(|x| cos * x));
        true
    });
    rows
}

/// Compares the way there with the way back. Returns how many elements are seen that change their sign.
fn compare(name: &str, there: &[matrices::Mueller], back: &[matrices::Mueller]) -> usize {
    let back: Vec<matrices::Mueller> = back.iter().map(reversed).collect();
    let column = |rows: &[matrices::Mueller], at: usize| rows.iter().map(|m| m[at]).collect::<Vec<f64>>();
    let (mut seen, mut least) = (0, 1.0f64);
    for at in 0..16 {
        let (a, b) = (column(there, at), column(&back, at));
        let ((ma, va, _), (mb, vb, _)) = (moments(&a), moments(&b));
        let se = (va + vb).sqrt();
        println!("{name}, {at:2}: {ma:9.6} and {mb:9.6}, standard error {se:.6}");
        assert!(at > 0 || se < 0.1 * ma, "too noisy to tell");
        // With the wrong sign the difference would be this.
        seen += usize::from((at / 4 == 2) != (at % 4 == 2) && (ma + mb).abs() > 5.0 * se);
        // What is nothing but rounding has no statistics.
        least = least.min(if se > 1e-12 { welch(&a, &b) } else { f64::from((ma - mb).abs() < 1e-12) });
    }
    println!("{name}: least p = {least:.4}, {seen} of 6 signs seen");
    assert!(least > FALSE_ALARM / 16.0, "{name}: p = {least:e}");
    seen
}

fn reflects(name: &str, build: &Build, one: (f64, f64), other: (f64, f64), directions: u32) -> usize {
    let (a, b) = (towards(one), towards(other));
    compare(name, &transfer(build, a, b, directions, 1), &transfer(build, b, a, directions, 2))
}

/// From above and from below: there the sample is turned over.
fn transmits(name: &str, build: &Build, above: (f64, f64), below: (f64, f64), directions: u32) -> usize {
    let (a, b) = (towards(above), towards(below));
    let down = transfer(build, a, over(b), directions, 3);
    let up = transfer(&turned_over(build), b, over(a), directions, 4);
    compare(name, &down, &up)
}

fn all(directions: u32) {
    let seen = reflects("spheres", &spheres(), (20.0, 0.0), (60.0, 40.0), directions)
        + reflects("lopsided", &lopsided(), (30.0, 10.0), (65.0, 250.0), directions)
        + reflects("lopsided, near", &lopsided(), (40.0, 100.0), (40.0, 160.0), directions)
        + transmits("spheres", &spheres(), (10.0, 0.0), (60.0, 100.0), directions)
        + transmits("lopsided", &lopsided(), (55.0, 30.0), (20.0, 60.0), directions);
    assert!(seen >= 6, "too noisy to tell: {seen} signs seen");
}

#[test]
fn polarized_light_goes_as_it_comes() {
    all(FEW);
}

#[test]
#[ignore = "slow: cargo test --release mueller_reciprocity:: -- --ignored (minutes)"]
fn polarized_light_goes_as_it_comes_for_2e6_trees() {
    all(MANY);
}
