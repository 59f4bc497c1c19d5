//! Rays that graze, or meet edges.

use std::sync::Arc;

use glam::DVec3;
use gonio_embree::geometry::{
    Aabb, All, Builder, Chord, Cylinder, Hit, Primitives, Query, Ray, Shape, Sphere, SurfaceId,
};
use gonio_embree::intersect::Scene;
use gonio_embree::intersect::choose::Backend;
use gonio_embree::light::Polarization;
use gonio_embree::optics::field::{State, Stokes};
use gonio_embree::plan::{Limits, Wanted};
use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};

use super::twin::{double, single};
use super::{Case, Tier};
use crate::common::build::{Build, light, mesh};
use crate::common::listen::{entries, listen};
use crate::common::{Mesh, direction};

const QUADRATIC: &str = "(−b ± √(b² − 4ac))/2a";

pub fn all(tier: Tier) -> Vec<Case> {
    let rays = if tier == Tier::Quick { 100_000 } else { 1_000_000 };
    let spheres = [("middle", 1.0), ("1e-6 r within the rim", 1e-6), ("1e-12 r within the rim", 1e-12)];
    let spheres = spheres.map(|(name, depth)| chord(name, depth));
    let parallel = [along_the_axis(DVec3::Z, 1.0 - 1e-9), along_the_axis(tilted(), 1.0 - 1e-9)];
    let beside = [along_the_axis(DVec3::Z, 1.0 + 1e-9), along_the_axis(tilted(), 1.0 + 1e-9)];
    [
        spheres.to_vec(),
        vec![grazing_exit()],
        parallel.to_vec(),
        beside.to_vec(),
        vec![rim(rays), edges(rays)],
        aimed(rays / 10).to_vec(),
    ]
    .concat()
}

const R: f64 = 10.0;
const FAR: f64 = 2000.0;

/// A sphere of 10 µm, 2 mm away, met at a distance b = r(1 − depth) from its centre: 2√((r − b)(r + b)). Of b² half a unit
/// in the last place is 1e-14, which the square root makes 1e-8 r at the rim.
fn chord(name: &str, depth: f64) -> Case {
    let b = R * (1.0 - depth);
    let (o, d) = (DVec3::new(b, 0.0, FAR), DVec3::NEG_Z);
    let ours = match (Sphere { center: DVec3::ZERO, radius: R }).chord(&Ray { origin: o, dir: d }) {
        Chord::Through(near, far) => far - near,
        Chord::None | Chord::Tangent => f64::INFINITY,
    };
    let single = single::careful_sphere(o.as_vec3(), d.as_vec3(), R as f32).map_or(f32::INFINITY, |[a, b]| b - a);
    let naive = double::sphere(o, d, R).map_or(f64::INFINITY, |[a, b]| b - a);
    let truth = 2.0 * ((R - b) * (R + b)).sqrt();
    Case::new(format!("sphere of 10 µm seen from 2 mm, {name}"), "chord, µm", truth, ours, 1e-8 * R)
        .single(single.into())
        .naive(QUADRATIC, naive)
}

/// Smallest distance at which rays with a fixed ε look for a face, µm.
const EPSILON: f64 = 1e-4;

/// A ray on a sphere around (1, 1, 2) mm that goes into it with d·n = −1e-6: its chord of 2r·1e-6 is 0.02 nm.
fn grazing_exit() -> Case {
    let (center, cos) = (DVec3::new(1000.0, 1000.0, 2000.0), 1e-6);
    let (n, across) = (DVec3::new(2.0, 3.0, 6.0) / 7.0, DVec3::new(6.0, 2.0, -3.0) / 7.0);
    let (o, d) = (center + R * n, -cos * n + (1.0 - cos * cos).sqrt() * across);
    let ours = (Sphere { center, radius: R }).other_root(&Ray { origin: o, dir: d }).unwrap_or(f64::INFINITY);
    let far = |roots: Option<[f64; 2]>, least: f64| roots.map(|r| r[1]).filter(|t| *t > least).unwrap_or(f64::INFINITY);
    let (o32, d32) = ((o.as_vec3() - center.as_vec3()), d.as_vec3());
    let single = single::careful_sphere(o32, d32, R as f32).map(|r| r.map(f64::from));
    Case::new("ray that leaves a sphere's surface inwards, d·n = −1e-6", "chord, µm", 2.0 * R * cos, ours, 1e-12)
        .single(far(single, 256.0 * f64::from(f32::EPSILON) * FAR))
        .naive("quadratic, t > ε = 0.1 nm", far(double::sphere(o - center, d, R), EPSILON))
}

/// An axis that no coordinate holds exactly.
fn tilted() -> DVec3 {
    DVec3::new(1.0, 2.0, -2.0) / 3.0
}

/// A fibre of 2 mm and a ray parallel to its axis, at r·`share` from it.
fn along_the_axis(axis: DVec3, share: f64) -> Case {
    let from = DVec3::new(100.0, -200.0, 300.0);
    let across = axis.any_orthonormal_vector();
    let fibre = Cylinder { from, axis, length: FAR, u: across, radii: [R, R] };
    let (o, d) = (from - FAR * axis + share * R * across, axis);
    let hits = met(&scene(|b| b.add(Shape::Cylinder(fibre), 0)), o, d);
    let ours = hits.iter().map(|h| if h.crossing.enters { -h.order.t } else { h.order.t }).sum();
    let inside = |t: &[f64]| if t.is_empty() { 0.0 } else { t.iter().fold(0.0, |a: f64, b| a.max(*b)) - FAR };
    let ends = [from, from + FAR * axis];
    let in_single = single::cylinder(o.as_vec3(), d.as_vec3(), ends.map(DVec3::as_vec3), R as f32);
    let in_single: Vec<f64> = in_single.into_iter().map(f64::from).collect();
    let where_ = if share < 1.0 { "within" } else { "beside" };
    let how = if axis == DVec3::Z { "along z" } else { "tilted" };
    let truth = if share < 1.0 { FAR } else { 0.0 };
    Case::new(format!("ray parallel to a fibre, 1e-9 r {where_} it, {how}"), "length inside, µm", truth, ours, 1e-9)
        .single(inside(&in_single))
        .naive("quadratic", inside(&double::cylinder(o, d, ends, R)))
}

fn scene(fill: impl Fn(&mut Builder)) -> Scene {
    let mut builder = Builder::default();
    fill(&mut builder);
    let primitives: Arc<Primitives> = Arc::new(builder.finish());
    Scene::new(primitives, Aabb::INFINITE, Backend::Auto).unwrap()
}

fn met(scene: &Scene, o: DVec3, d: DVec3) -> Vec<Hit> {
    let query: Query = scene.primitives().query(Ray { origin: o, dir: d });
    debug_assert!(query.last == SurfaceId::NONE);
    scene.all(&query, &mut All::default()).to_vec()
}

/// Whether a line does not leave as often as it enters.
fn leaks(hits: &[Hit]) -> bool {
    hits.iter().map(|h| if h.crossing.enters { 1 } else { -1 }).sum::<i32>() != 0
}

/// How many of these lines leak: here, in float32, and by textbook formulas.
struct Leaks([u32; 3]);

impl Leaks {
    fn count(
        rays: u32,
        mut target: impl FnMut(&mut Xoshiro256PlusPlus) -> DVec3,
        odd: impl Fn(DVec3, DVec3) -> [bool; 3],
    ) -> Self {
        let (mut rng, mut out) = (Xoshiro256PlusPlus::seed_from_u64(11), [0; 3]);
        for _ in 0..rays {
            // Along an axis edge functions may be 0 exactly.
            let axis = DVec3::AXES[rng.random_range(0..3)];
            let d = if rng.random_range(0..4) == 0 { axis } else { direction(&mut rng) };
            let o = target(&mut rng) - 3.0 * FAR * d;
            out.iter_mut().zip(odd(o, d)).for_each(|(sum, odd)| *sum += u32::from(odd));
        }
        Self(out)
    }

    fn case(self, name: String, formula: &'static str) -> Case {
        let [ours, single, naive] = self.0.map(f64::from);
        Case::new(name, "rays that leak", 0.0, ours, 0.0).single(single).naive(formula, naive)
    }
}

/// Rays at the edge between the mantle and an end of a tilted fibre of 2 mm.
fn rim(rays: u32) -> Case {
    let (from, axis) = (DVec3::new(100.0, -200.0, 300.0), tilted());
    let u = axis.any_orthonormal_vector();
    let fibre = Cylinder { from, axis, length: FAR, u, radii: [R, R] };
    let (scene, ends) = (scene(|b| b.add(Shape::Cylinder(fibre), 0)), [from, from + FAR * axis]);
    let on_rim = |rng: &mut Xoshiro256PlusPlus| {
        let (sin, cos) = (std::f64::consts::TAU * rng.random::<f64>()).sin_cos();
        ends[rng.random_range(0..2)] + R * (cos * u + sin * fibre.v())
    };
    let odd = |o: DVec3, d: DVec3| {
        let in_single = single::cylinder(o.as_vec3(), d.as_vec3(), ends.map(DVec3::as_vec3), R as f32);
        let in_double = double::cylinder(o, d, ends, R);
        [leaks(&met(&scene, o, d)), in_single.len() % 2 == 1, in_double.len() % 2 == 1]
    };
    Leaks::count(rays, on_rim, odd).case(format!("{rays} rays at the rims of a fibre"), "quadratic")
}

/// Rays at the corners and edges of a closed mesh of 2 mm.
fn edges(rays: u32) -> Case {
    let ball = Mesh::ball(2).map(|p| p * DVec3::new(1000.0, 700.0, 400.0));
    let scene = scene(|b| ball.add_to(b, 0));
    let corners: Vec<[DVec3; 3]> = ball.triangles.iter().map(|t| t.map(|i| ball.vertices[i as usize])).collect();
    let corners32: Vec<_> = corners.iter().map(|c| c.map(|p| p.as_vec3())).collect();
    let odd = |o: DVec3, d: DVec3| {
        let (o32, d32) = (o.as_vec3(), d.as_vec3());
        let in_single = corners32.iter().filter(|c| single::triangle(o32, d32, **c)).count();
        let in_double = corners.iter().filter(|c| double::triangle(o, d, **c)).count();
        [leaks(&met(&scene, o, d)), in_single % 2 == 1, in_double % 2 == 1]
    };
    let name = format!("{rays} rays at corners and edges of a closed mesh");
    Leaks::count(rays, |rng| ball.edge_point(rng), odd).case(name, "Möller–Trumbore")
}

/// Trees that begin at corners and edges of a body, within rounding. There a ray may leave by one face a rounding before it
/// enters by another, or start behind the neighbour of the face it was reflected at: its media contradict one another, and
/// it ends. All of that is told as lost, so nothing leaks. By chance few rays come so near to an edge:
/// among triangles of 1 µm in a scene of 2 mm, where coordinates are known to 5e-13 µm, some one in 10¹¹.
fn aimed(trees: u32) -> [Case; 2] {
    let ball = Mesh::ball(2).map(|p| DVec3::new(3.0, 2.0, 1.5) * p);
    let light = light(&[550.0], &[(30.0, 17.0)], Polarization::Unpolarized);
    let sample = Build::within(1.0).open().patch(20.0, 20.0).put(mesh(ball.clone()), 1.5).sample(&light);
    let (dir, top) = (light.incidences[0].propagation(), sample.cell.heights.1);
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(12);
    let starts = entries(1, trees).into_iter().map(|(_, key)| {
        let p = ball.edge_point(&mut rng);
        let o = p - (p.z - top) / dir.z * dir;
        (((o / sample.cell.size.extend(1.0)).truncate() + 0.5).to_array(), key)
    });
    let (limits, effects) = (Limits::default(), Wanted::AUTO);
    let heard = listen::<Stokes>(&sample, &light, Backend::Auto, limits, effects, &starts.collect());
    let left: f64 = heard.exits.iter().flat_map(|e| &e.fields).map(|f| f.1.power()).sum();
    let missing = left + heard.side + heard.absorbed + heard.lost - f64::from(trees);
    let case = |quantity, value: f64, bound| {
        let name = format!("{trees} trees that begin at corners and edges of a closed mesh");
        Case::new(name, quantity, 0.0, value / f64::from(trees), bound)
    };
    [case("power not accounted for", missing, 1e-12), case("power told as lost", heard.lost, 0.06)]
}
