//! All backends give the same answer, bit for bit, and no closed body leaks.

use std::sync::Arc;

use crate::common::{Mesh, direction, in_cube};
use glam::{DMat3, DVec3};
use gonio_embree::geometry::{
    Aabb, All, Builder, Cuboid, Cylinder, Hit, Kind, Layer, Nearest, Primitives, Query, Ray, Shape, Sphere,
};
use gonio_embree::intersect::choose::Backend;
use gonio_embree::intersect::{Coherence, Scene};
use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};
use rayon::prelude::*;

/// A geometry with the points where it is delicate.
struct Case {
    name: &'static str,
    primitives: Arc<Primitives>,
    /// Aims at edges, corners, rims, tangents, touching faces.
    aim: Aim,
}

type Aim = Box<dyn Fn(&mut Xoshiro256PlusPlus) -> DVec3 + Send + Sync>;

/// A case for which there is one backend more.
const PACKED: &str = "packed spheres";

/// A case whose body has no end, so that lines through it need not leave it.
const ENDLESS: &str = "endless cylinder";

fn build(
    name: &'static str,
    aim: impl Fn(&mut Xoshiro256PlusPlus) -> DVec3 + Send + Sync + 'static,
    fill: impl Fn(&mut Builder),
) -> Case {
    let mut builder = Builder::default();
    fill(&mut builder);
    Case { name, primitives: Arc::new(builder.finish()), aim: Box::new(aim) }
}

fn cylinder(from: DVec3, to: DVec3, radii: [f64; 2], across: DVec3) -> Cylinder {
    let axis = (to - from).normalize();
    let u = (across - across.dot(axis) * axis).normalize();
    Cylinder { from, axis, length: (to - from).length(), u, radii }
}

fn pick<T: Copy>(rng: &mut Xoshiro256PlusPlus, from: &[T]) -> T {
    from[rng.random_range(0..from.len())]
}

fn cases() -> Vec<Case> {
    let turn = DMat3::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 0.7);
    let ball = Mesh::ball(3).map(move |p| turn * p * DVec3::new(1.0, 0.7, 0.4));
    let cube = Mesh::cube().map(|p| p - 0.5);
    let turned = cube.clone().map(move |p| turn * p);
    let (aim_ball, aim_cube, aim_turned) = (ball.clone(), cube.clone(), turned.clone());
    let tiny = 0.05;
    vec![
        build("mesh ball", move |r| aim_ball.edge_point(r), move |b| ball.add_to(b, 0)),
        build("mesh cube", move |r| aim_cube.edge_point(r), move |b| cube.add_to(b, 0)),
        build("turned mesh cube", move |r| aim_turned.edge_point(r), move |b| turned.add_to(b, 0)),
        build(
            "spheres",
            |r| {
                // Points of the silhouette as seen along z, and a point of contact.
                let (s, c) = (6.3 * r.random::<f64>()).sin_cos();
                pick(r, &[DVec3::new(0.5 * c, 0.5 * s, 0.0), DVec3::ZERO.with_x(0.5), DVec3::new(1.0, 0.5, 0.0)])
            },
            |b| {
                for (i, x) in [0.0, 1.0, -1.0].into_iter().enumerate() {
                    b.add(Shape::Sphere(Sphere { center: DVec3::ZERO.with_x(x), radius: 0.5 }), i as u32);
                }
                // A concentric core and a coincident twin.
                b.add(Shape::Sphere(Sphere { center: DVec3::ZERO, radius: 0.49 }), 3);
                b.add(Shape::Sphere(Sphere { center: DVec3::ZERO.with_x(1.0), radius: 0.5 }), 4);
            },
        ),
        build(
            "cylinders",
            |r| {
                let (s, c) = (6.3 * r.random::<f64>()).sin_cos();
                let rim = DVec3::new(-1.0, 0.4 * c, 0.4 * s);
                let inner_rim = DVec3::new(1.0, 0.2 * c, 0.2 * s);
                let generatrix = DVec3::new(2.0 * r.random::<f64>() - 1.0, 0.4, 0.0);
                pick(r, &[rim, inner_rim, generatrix, DVec3::new(0.3, 0.0, 1.4)])
            },
            move |b| {
                let (from, to) = (DVec3::NEG_X, DVec3::X);
                b.add(Shape::Cylinder(cylinder(from, to, [0.4, 0.4], DVec3::Y)), 0);
                b.add(Shape::Cylinder(cylinder(from, to, [0.2, 0.2], DVec3::Y)), 1);
                // Flattened, tilted, hollow, without ends.
                let up = DVec3::Z * 1.2;
                b.add(Shape::Cylinder(cylinder(turn * from + up, turn * to + up, [0.1, 0.3], DVec3::Z)), 2);
                b.add(Shape::Cylinder(cylinder(turn * from + up, turn * to + up, [0.05, 0.15], DVec3::Z)), 3);
            },
        ),
        build(
            ENDLESS,
            |r| DVec3::new(0.0, 2.0 * r.random::<f64>() - 1.0, -1.2),
            move |b| {
                let part = cylinder(DVec3::Z * -1.5, DVec3::new(0.0, 1.0, -1.5), [0.3, 0.1], DVec3::Z);
                b.add(Shape::Cylinder(Cylinder { length: f64::INFINITY, ..part }), 0);
            },
        ),
        build(
            "bricks",
            |r| {
                let on = |r: &mut Xoshiro256PlusPlus| pick(r, &[-1.0, 0.0, 0.5, 1.0]) + pick(r, &[0.0, 0.0, 0.25]);
                DVec3::new(on(r), on(r), pick(r, &[0.0, 0.2, 0.201, 0.401]))
            },
            |b| {
                // Touching bricks, a second layer shifted by half a brick, a third 1 nm above it.
                let mut add = |x: f64, z: f64, owner| {
                    let min = DVec3::new(x, -1.0, z);
                    b.add(Shape::Cuboid(Cuboid { min, max: min + DVec3::new(1.0, 2.0, 0.2) }), owner);
                };
                for (i, x) in [-1.0, 0.0].into_iter().enumerate() {
                    add(x, 0.0, i as u32);
                    add(x + 0.5, 0.2, 2 + i as u32);
                    add(x, 0.401, 4 + i as u32);
                }
            },
        ),
        build(
            "films of 50 nm in 2 mm",
            move |r| {
                let z = tiny * f64::from(r.random_range(0..40u32));
                DVec3::new(pick(r, &[-1000.0, 1000.0, 0.0]), 1000.0 * (2.0 * r.random::<f64>() - 1.0), z)
            },
            move |b| {
                for i in 0..20u32 {
                    let z = tiny * f64::from(2 * i);
                    let (min, max) = (DVec3::new(-1000.0, -1000.0, z), DVec3::new(1000.0, 1000.0, z + tiny));
                    b.add(Shape::Cuboid(Cuboid { min, max }), i);
                }
                Mesh::cube()
                    .map(|p| p * DVec3::new(2000.0, 2000.0, 0.05) + DVec3::new(-1000.0, -1000.0, -0.05))
                    .add_to(b, 20);
            },
        ),
        build(
            PACKED,
            |r| {
                // Touching points, and lines along the lattice, at its tangents too.
                let node = DVec3::from_array(std::array::from_fn(|_| f64::from(r.random_range(-3..4))));
                let half = pick(r, &[DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z, DVec3::splat(1.0)]) * 0.5;
                node + half
            },
            |b| {
                let mut rng = Xoshiro256PlusPlus::seed_from_u64(3);
                for i in 0..343 {
                    let node = DVec3::new(f64::from(i % 7), f64::from(i / 7 % 7), f64::from(i / 49)) - 3.0;
                    let radius = if i % 3 == 0 { 0.5 } else { 0.25 + 0.25 * rng.random::<f64>() };
                    b.add(Shape::Sphere(Sphere { center: node, radius }), i as u32);
                    if i % 50 == 0 {
                        // A coincident twin.
                        b.add(Shape::Sphere(Sphere { center: node, radius }), 1000 + i as u32);
                    }
                }
            },
        ),
        build("everything", in_cube, move |b| {
            Mesh::ball(2).map(|p| 0.3 * p + DVec3::new(0.5, 0.5, 0.5)).add_to(b, 0);
            b.add(Shape::Sphere(Sphere { center: DVec3::new(-0.5, 0.5, 0.2), radius: 0.4 }), 1);
            b.add(
                Shape::Cylinder(cylinder(
                    DVec3::new(-1.0, -0.5, 0.0),
                    DVec3::new(1.0, -0.4, 0.3),
                    [0.2, 0.1],
                    DVec3::Z,
                )),
                2,
            );
            b.add(Shape::Cuboid(Cuboid { min: DVec3::splat(-0.9), max: DVec3::new(0.1, -0.2, -0.5) }), 3);
            b.add(Shape::Layer(Layer { bottom: -0.5, top: -0.4 }), 4);
            b.add(Shape::Layer(Layer { bottom: -0.4, top: -0.3 }), 5);
            b.add(Shape::Layer(Layer { bottom: f64::NEG_INFINITY, top: -0.95 }), 6);
        }),
    ]
}

/// A ray from somewhere around, through a random or a delicate point.
fn ray(case: &Case, aimed: bool, rng: &mut Xoshiro256PlusPlus) -> Ray {
    let size = extent(&case.primitives);
    let target = if aimed { (case.aim)(rng) } else { in_cube(rng) * size };
    let dir = match rng.random_range(0..8) {
        // Negated, so that some zeros are negative.
        0 => pick(rng, &DVec3::AXES) * pick(rng, &[1.0, -1.0]),
        1 => (pick(rng, &DVec3::AXES) + 1e-9 * direction(rng)).normalize(),
        _ => direction(rng),
    };
    Ray { origin: target - rng.random::<f64>() * 3.0 * size.max_element() * dir, dir }
}

fn extent(primitives: &Primitives) -> DVec3 {
    let all = (0..primitives.bounded_count() as u32)
        .map(|i| primitives.bounds(gonio_embree::geometry::PrimId(i)))
        .fold(Aabb::EMPTY, Aabb::union);
    let e = all.max.max(-all.min);
    if e.is_finite() { e } else { DVec3::splat(2.0) }
}

/// Every body must be entered and left in turn, and be left as often as it was entered by a line from far away (layers have no
/// outside to the sides).
fn check_parity(name: &str, ray: &Ray, primitives: &Primitives, hits: &[Hit]) {
    let mut inside = std::collections::BTreeMap::new();
    for hit in hits {
        if primitives.locate(hit.crossing.prim).0 == Kind::Layer {
            continue;
        }
        let owner = primitives.owner(hit.crossing.prim);
        let depth: &mut i32 = inside.entry(owner).or_default();
        *depth += if hit.crossing.enters { 1 } else { -1 };
    }
    for (owner, depth) in inside {
        assert!(depth == 0, "{name}: body {owner} leaks {depth} along {ray:?}: {hits:?}");
    }
}

/// Half of the rays are aimed at what is difficult.
fn run(rays_per_case: usize) {
    cases().into_par_iter().for_each(|case| {
        let domain = Aabb { min: DVec3::splat(-20.0), max: DVec3::splat(20.0) };
        let domain = if case.name == ENDLESS { domain } else { Aabb::INFINITE };
        let is_packed = Backend::Auto.fit(&case.primitives, domain) == Backend::Grid;
        assert_eq!(is_packed, case.name == PACKED);
        let backends = is_packed.then_some(Backend::Grid).into_iter().chain(Backend::available());
        let scenes: Vec<Scene> = backends.map(|b| Scene::new(case.primitives.clone(), domain, b).unwrap()).collect();
        let (brute, others) = scenes.split_last().unwrap();
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(7);
        let mut met = 0;
        for chunk in 0..rays_per_case.div_ceil(CHUNK) {
            let aimed = chunk % 2 == 1;
            let queries: Vec<Query> = (0..CHUNK).map(|_| query(&case, aimed, &mut rng)).collect();
            met += compare(&case, brute, others, &queries);
        }
        assert!(met > rays_per_case / 20, "{}: only {met} rays met anything", case.name);
    });
}

/// Rays asked together.
const CHUNK: usize = 1024;

/// A fresh query, or one that goes on from a surface.
fn query(case: &Case, aimed: bool, rng: &mut Xoshiro256PlusPlus) -> Query {
    let mut q = case.primitives.query(ray(case, aimed, rng));
    // Outside its domain a scene answers nothing certain; an endless cylinder goes on there.
    let size = extent(&case.primitives).max_element();
    q.limit = if rng.random_range(0..4) == 0 { size * rng.random::<f64>() * 3.0 } else { 8.0 * size };
    q
}

/// Asks all backends; then, for those that hit, goes on from the surface met into a new direction, or straight on.
fn compare(case: &Case, brute: &Scene, others: &[Scene], queries: &[Query]) -> usize {
    let mut leaving = Vec::new();
    for (nearest, q) in agreed(case, brute, others, queries).iter().zip(queries) {
        let Some(order) = nearest.order() else { continue };
        let c = nearest.crossings()[0];
        let p = case.primitives.snap(c, order.surface, q.ray.at(order.t));
        let n = case.primitives.normal(c.prim, c.face, p);
        assert!((n.length() - 1.0).abs() < 1e-12);
        assert!(n.dot(q.ray.dir) <= 1e-7 || !c.enters, "{}: normal points inwards", case.name);
        let reflected = q.ray.dir - 2.0 * q.ray.dir.dot(n) * n;
        let ray = Ray { origin: p, dir: if leaving.len() % 2 == 0 { reflected.normalize() } else { q.ray.dir } };
        leaving.push(case.primitives.query_leaving(ray, order.surface).within(q.limit));
    }
    agreed(case, brute, others, &leaving);
    check_all(case, brute, others, &queries[..queries.len().min(256)], case.name != ENDLESS);
    check_all(case, brute, others, &leaving[..leaving.len().min(256)], false);
    leaving.len()
}

/// The nearest interfaces, the same from all backends.
fn agreed(case: &Case, brute: &Scene, others: &[Scene], queries: &[Query]) -> Vec<Nearest> {
    let nothing = vec![Nearest::none(0.0); queries.len()];
    let (mut expected, mut got) = (nothing.clone(), nothing);
    let which: Vec<usize> = (0..queries.len()).collect();
    brute.nearest(queries, &which, Coherence::Scattered, &mut expected);
    for scene in others {
        for coherence in [Coherence::Scattered, Coherence::Coherent] {
            scene.nearest(queries, &which, coherence, &mut got);
            for ((e, g), q) in expected.iter().zip(&got).zip(queries) {
                assert_eq!((e.order(), e.crossings()), (g.order(), g.crossings()), "{}: {q:?}", case.name);
            }
        }
    }
    expected
}

/// All crossings agree, their order is total, and bodies are entered and left in pairs.
fn check_all(case: &Case, brute: &Scene, others: &[Scene], queries: &[Query], whole_lines: bool) {
    let (mut a, mut b) = (All::default(), All::default());
    for q in queries {
        let back = 16.0 * extent(&case.primitives).max_element();
        let far = case.primitives.query(Ray { origin: q.ray.origin - back * q.ray.dir, dir: q.ray.dir });
        let q = if whole_lines { &far } else { q };
        let expected = brute.all(q, &mut a);
        if whole_lines {
            check_parity(case.name, &q.ray, &case.primitives, expected);
        }
        for scene in others {
            assert_eq!(expected, scene.all(q, &mut b), "{}: {q:?}", case.name);
        }
    }
}

#[test]
fn backends_agree_and_nothing_leaks() {
    run(1 << 18);
}

#[test]
#[ignore = "slow: cargo test --release backends:: -- --ignored (half an hour)"]
fn backends_agree_and_nothing_leaks_for_1e8_rays() {
    run(12_500_000);
}
