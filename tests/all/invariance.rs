//! A sample that is moved, turned, or scaled together with the wavelength scatters as before, tree by tree.
//!
//! Where the coordinates of both samples are exact in binary, all trees agree to 1e-9. Where they are rounded, paths
//! drift apart by the rounding, multiplied at every curved surface; trees are then compared as far as they are short.

use crate::common::Mesh;
use crate::common::build::{Build, ball, cuboid, fibre, light, mesh, mesh_box};
use crate::common::listen::{Entries, Heard, Leaving, entries, listen};
use glam::{DMat3, DVec2, DVec3};
use gonio_embree::intersect::choose::Backend;
use gonio_embree::light::{Light, Polarization};
use gonio_embree::optics::field::{State, Stokes};
use gonio_embree::plan::{Limits, Wanted};
use gonio_embree::sample::description::{Body, Description, Shape};
use gonio_embree::sample::generate::packing::Packing;

const NM: [f64; 2] = [500.0, 520.0];
const TREES: u32 = 3000;

/// Rounds to multiples of 2⁻²⁰: such coordinates stay exact when moved by 10 mm or scaled by a power of two.
fn exact(x: f64) -> f64 {
    (x * 1_048_576.0).round() / 1_048_576.0
}

/// A sample whose lengths are mapped: points by `point`, lengths by `scale`.
fn mapped(mut d: Description, point: impl Fn(DVec3) -> DVec3, scale: f64) -> Build {
    let turned = |v: DVec3| point(v) - point(DVec3::ZERO);
    for object in &mut d.objects {
        match &mut object.body {
            Body::Films { top, layers } => {
                *top = point(DVec3::Z * *top).z;
                layers.iter_mut().for_each(|(_, thickness)| *thickness *= scale);
            }
            Body::Solid(shape, _) => match shape {
                Shape::Sphere { center, radius } => (*center, *radius) = (point(*center), *radius * scale),
                Shape::Cuboid { min, max } => {
                    let (a, b) = (point(*min), point(*max));
                    (*min, *max) = (a.min(b), a.max(b));
                }
                Shape::Slab { top, bottom } => {
                    (*top, *bottom) = (point(DVec3::Z * *top).z, point(DVec3::Z * *bottom).z)
                }
                Shape::Relief(_) => unreachable!("no relief is among the samples"),
                Shape::Mesh(mesh) => mesh.vertices.iter_mut().for_each(|v| *v = point(*v)),
                Shape::Cylinder(f) => {
                    (f.from, f.to, f.radius) = (point(f.from), point(f.to), f.radius * scale);
                    f.lumen.iter_mut().for_each(|(radius, _)| *radius *= scale);
                    f.flatten.iter_mut().for_each(|(axis, _)| *axis = turned(*axis));
                }
            },
        }
    }
    if let Some(patch) = &mut d.patch {
        patch.center = point(patch.center.extend(0.0)).truncate();
        patch.size = turned(patch.size.extend(0.0)).truncate().abs();
    }
    Build(d)
}

/// Spheres; mesh, box and films; fibres. With every coordinate rounded by `round`.
fn samples(round: fn(f64) -> f64) -> Vec<(&'static str, Build)> {
    let size = DVec3::new(16.0, 16.0, 12.0);
    let packing = Packing { count: 200, radius: 0.75, size, periodic: true, seed: 2 };
    let patch = || Build::within(1.0).patch(16.0, 16.0);
    let rod = fibre([-5.1, -2.0, 1.3], [4.7, 3.3, 4.1], 1.25);
    let build = [
        ("spheres", Build::within(1.0).packing(&packing, 1.5)),
        (
            "mesh, box and films",
            patch()
                .films(9.0, &[(1.7, 0.109375), (1.35, 0.0703125)])
                .put(mesh(Mesh::ball(2).map(|p| 2.3 * p + DVec3::new(2.1, 1.7, 3.1))), 1.5)
                .put(cuboid([-7.3, -3.1, 0.0], [-1.2, 2.9, 0.37]), 2.0),
        ),
        (
            "meshes and films",
            patch()
                .films(9.0, &[(1.7, 0.109375), (1.35, 0.0703125)])
                .put(mesh(Mesh::ball(2).map(|p| 2.3 * p + DVec3::new(2.1, 1.7, 3.1))), 1.5)
                .put(mesh_box([-7.3, -3.1, 0.0], [-1.2, 2.9, 0.375]), 2.0),
        ),
        ("fibres", patch().hollow(rod.clone(), 1.53, 0.75, 1.0).put(ball([3.0, -5.0, 3.0], 2.0), 1.4)),
    ];
    let rounded =
        |(name, build): (_, Build)| (name, mapped(build.0, |p| DVec3::from_array(p.to_array().map(round)), 1.0));
    build.into_iter().map(rounded).collect()
}

/// Entry points on a grid that is exact under a quarter turn.
fn exact_entries(n: u32) -> Entries {
    let round = |x: f64| ((x * 16_777_216.0).floor() + 0.5) / 16_777_216.0;
    entries(5, n).into_iter().map(|([x, y], key)| ([round(x), round(y)], key)).collect()
}

/// How deep trees are followed.
const DEEP: u32 = 10_000;

fn run(build: &Build, light: &Light, depth: u32, entries: &Entries) -> Heard<Stokes> {
    let limits = Limits { depth, ..Limits::default() };
    listen(&build.sample(light), light, Backend::Auto, limits, Wanted::AUTO, entries)
}

fn of_tree<F>(heard: &Heard<F>, tree: u32) -> &[Leaving<F>] {
    let first = heard.exits.partition_point(|e| e.tree < tree);
    let last = heard.exits.partition_point(|e| e.tree <= tree);
    &heard.exits[first..last]
}

/// Distance of two rays in direction or power.
fn apart(a: &Leaving<Stokes>, b: &Leaving<Stokes>, turn: impl Fn(DVec3) -> DVec3) -> f64 {
    let lanes = |l: &Leaving<Stokes>| l.fields.iter().map(|f| f.0).collect::<Vec<_>>();
    if lanes(a) != lanes(b) {
        return f64::INFINITY;
    }
    let powers = a.fields.iter().zip(&b.fields).map(|(f, g)| (f.1.power() - g.1.power()).abs());
    powers.fold(turn(a.dir).distance(b.dir), f64::max)
}

/// Distance of two trees: how far the nearest ray of the other is at most. The order of rays does not count;
/// infinite if there are more in one.
fn difference(a: &[Leaving<Stokes>], b: &[Leaving<Stokes>], turn: &impl Fn(DVec3) -> DVec3) -> f64 {
    if a.len() != b.len() {
        return f64::INFINITY;
    }
    let to_b = a.iter().map(|x| b.iter().map(|y| apart(x, y, turn)).fold(f64::INFINITY, f64::min));
    let to_a = b.iter().map(|y| a.iter().map(|x| apart(x, y, turn)).fold(f64::INFINITY, f64::min));
    to_b.chain(to_a).fold(0.0, f64::max)
}

/// Differences of more than 1e-9 between trees.
fn differences(a: &Heard<Stokes>, b: &Heard<Stokes>, trees: usize, turn: impl Fn(DVec3) -> DVec3) -> Vec<f64> {
    assert!(a.exits.len() > trees / 2, "most trees must end in an exit");
    let each = (0..trees as u32).map(|t| difference(of_tree(a, t), of_tree(b, t), &turn));
    each.filter(|&d| d > 1e-9).collect()
}

fn assert_none(name: &str, differences: &[f64]) {
    assert!(differences.is_empty(), "{name}: {} trees differ: {differences:?}", differences.len());
}

fn oblique(phi: f64) -> Light {
    light(&NM, &[(30.0, phi)], Polarization::P)
}

const FAR: DVec3 = DVec3::new(10_000.0, -10_000.0, 10_000.0);

fn moved(build: &Build) -> Build {
    mapped(build.0.clone(), |p| p + FAR, 1.0)
}

/// 10 mm away along all axes, all trees to their ends.
#[test]
fn a_moved_sample_is_the_same() {
    let (light, entries) = (oblique(0.0), entries(5, TREES));
    for (name, build) in samples(exact) {
        let (a, b) = (run(&build, &light, DEEP, &entries), run(&moved(&build), &light, DEEP, &entries));
        assert_none(name, &differences(&a, &b, entries.len(), |d| d));
    }
}

/// Decimal coordinates lose 1e-12 µm when they are moved by 10 mm. A plane face keeps such an error of position as it
/// is; each sphere of radius r makes it an error of direction, divided by r·cos of the angle of incidence, and the way
/// to the next makes that an error of position. So after four interfaces among small spheres some of it shows.
#[test]
fn a_moved_decimal_sample_is_nearly_the_same() {
    let (light, entries) = (oblique(0.0), entries(5, TREES));
    for (name, build) in samples(|x| x) {
        let (a, b) = (run(&build, &light, 4, &entries), run(&moved(&build), &light, 4, &entries));
        let differences = differences(&a, &b, entries.len(), |d| d);
        let curved = matches!(name, "spheres" | "fibres");
        assert!(differences.len() <= if curved { entries.len() / 100 } else { 0 }, "{name}: {differences:?}");
        assert!(differences.iter().all(|&d| d < 1e-6), "{name}: {differences:?}");
    }
}

/// 1024 times as large, wavelengths too: exact, all trees to their ends.
#[test]
fn only_the_ratio_to_the_wavelength_counts() {
    let entries = entries(5, TREES);
    for (name, build) in samples(exact) {
        scaled(name, &build, 1024.0, DEEP, &entries);
    }
}

/// 1000 times as large. Coordinates are rounded in their last digit: among spheres eight interfaces are compared.
#[test]
fn millimetres_of_micrometre_samples_are_the_same() {
    let entries = entries(5, TREES);
    for (name, build) in samples(|x| x) {
        scaled(name, &build, 1000.0, if name == "spheres" { 8 } else { DEEP }, &entries);
    }
}

fn scaled(name: &str, build: &Build, by: f64, depth: u32, entries: &Entries) {
    let small = oblique(0.0);
    let large = light(&NM.map(|nm| nm * by), &[(30.0, 0.0)], Polarization::P);
    let a = run(build, &small, depth, entries);
    let b = run(&mapped(build.0.clone(), |p| p * by, by), &large, depth, entries);
    assert_none(name, &differences(&a, &b, entries.len(), |d| d));
}

/// Turned by right angles together with the light and the entry points: exact, all trees to their ends.
#[test]
fn a_sample_turned_by_right_angles_is_the_same() {
    let quarter = |v: DVec3| DVec3::new(-v.y, v.x, v.z);
    for (name, build) in samples(|x| x) {
        let (mut turned, mut entries) = (build, exact_entries(TREES));
        for phi in [0.0, 90.0, 180.0, 270.0] {
            let next = mapped(turned.0.clone(), quarter, 1.0);
            let next_entries: Entries = entries.iter().map(|&([x, y], key)| ([1.0 - y, x], key)).collect();
            let a = run(&turned, &oblique(phi), DEEP, &entries);
            let b = run(&next, &oblique(phi + 90.0), DEEP, &next_entries);
            assert_none(name, &differences(&a, &b, entries.len(), quarter));
            (turned, entries) = (next, next_entries);
        }
    }
}

/// Turned by any angle, without repetition; boxes cannot be turned. Entry points in the circle that fits the patch.
#[test]
fn a_sample_turned_by_any_angle_is_the_same() {
    let middle = DVec2::splat(0.5);
    let mut entries = entries(5, TREES);
    entries.retain(|(at, _)| DVec2::from_array(*at).distance(middle) < 0.5);
    for (name, build) in samples(|x| x).into_iter().filter(|s| s.0 != "mesh, box and films") {
        for angle in [37.0, 200.0] {
            let turn = DMat3::from_rotation_z(f64::to_radians(angle));
            let patch = build.0.patch;
            let turned = Build(Description { patch, ..mapped(build.0.clone(), |p| turn * p, 1.0).0 });
            let to = |at: [f64; 2]| (turn * (DVec2::from_array(at) - middle).extend(0.0)).truncate() + middle;
            let turned_entries: Entries = entries.iter().map(|&(at, key)| (to(at).to_array(), key)).collect();
            let a = run(&build.clone().open(), &oblique(0.0), DEEP, &entries);
            let b = run(&turned.open(), &oblique(angle), DEEP, &turned_entries);
            assert_none(name, &differences(&a, &b, entries.len(), |d| turn * d));
        }
    }
}
