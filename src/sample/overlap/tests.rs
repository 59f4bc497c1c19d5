use std::time::Instant;

use glam::{DMat3, DVec2, DVec3};
use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};

use super::super::generate::packing::Packing;
use super::super::media_list::MediumId;
use super::super::mesh::Mesh;
use super::super::solid::Matter;
use super::*;
use crate::geometry::{Cuboid, Cylinder, Shape, Sphere};

/// By how much bodies overlap that overlap, µm.
const OVERLAP: f64 = 1e-3;

fn solid(name: &str) -> Solid {
    Solid {
        name: name.into(),
        place: Place::default(),
        matter: Matter::Medium(MediumId(0)),
        precedence: (0, 0),
        closed: true,
        lonely: false,
    }
}

fn open_cell() -> Cell {
    Cell::new(DVec2::splat(100.0), DVec3::ZERO, false, (-50.0, 50.0), 1.0)
}

fn overlaps(bases: Vec<Base>, cell: &Cell) -> Vec<Problem> {
    let solids: Vec<Solid> = (0..bases.len()).map(|i| solid(&format!("body {i}"))).collect();
    let shapes: Vec<(Base, u32)> = bases.into_iter().zip(0..).collect();
    problems(&shapes, &solids, cell)
}

/// Millions of pairs would take minutes and gigabytes, to be told as a number.
#[test]
fn of_many_bodies_in_one_place_some_are_enough() {
    let count = 1500;
    let ball = Base::Shape(Shape::Sphere(Sphere { center: DVec3::ZERO, radius: 1.0 }));
    let shapes: Vec<(Base, u32)> = (0..count).map(|i| (ball.clone(), i)).collect();
    let solids = vec![solid("ball"); count as usize];
    let found = Scene::new(&shapes, &solids, &open_cell()).overlapping_bodies().len();
    assert!((ENOUGH..=AT_ONCE * ENOUGH).contains(&found), "{found}");
}

/// Random bodies of a size of about 1.
struct Bodies(Xoshiro256PlusPlus);

impl Bodies {
    fn number(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.0.random::<f64>()
    }

    fn vector(&mut self) -> DVec3 {
        DVec3::from_array(std::array::from_fn(|_| self.number(-1.0, 1.0)))
    }

    fn direction(&mut self) -> DVec3 {
        self.vector().normalize()
    }

    fn turn(&mut self) -> DMat3 {
        DMat3::from_axis_angle(self.direction(), self.number(0.0, 6.0))
    }

    fn body(&mut self, kind: usize) -> Base {
        let center = 10.0 * self.vector();
        let size = DVec3::splat(1.5) + self.vector();
        match kind {
            0 => Base::Shape(Shape::Sphere(Sphere { center, radius: size.x })),
            1 => {
                let turn = self.turn();
                let ratio = if self.0.random() { 1.0 } else { self.number(0.3, 1.0) };
                let radii = [ratio * size.x, size.x];
                let (axis, u) = (turn.x_axis, turn.y_axis);
                Base::Shape(Shape::Cylinder(Cylinder { from: center, axis, length: 3.0 * size.y, u, radii }))
            }
            2 => Base::Shape(Shape::Cuboid(Cuboid { min: center - size, max: center + size })),
            _ => {
                let turn = self.turn();
                Base::Triangles(Mesh::cuboid(-size, size).map(|p| center + turn * p))
            }
        }
    }
}

/// The point of a body farthest along `d`.
fn farthest(base: &Base, d: DVec3) -> DVec3 {
    match base {
        Base::Triangles(mesh) | Base::Relief(mesh, _) => {
            mesh.vertices.iter().copied().max_by(|p, q| p.dot(d).total_cmp(&q.dot(d))).unwrap()
        }
        Base::Shape(shape) => Convex::of(shape).unwrap().farthest(d),
    }
}

fn moved(mut base: Base, by: DVec3) -> Base {
    base.translate(by);
    base
}

#[test]
fn touching_bodies_do_not_overlap_and_overlapping_ones_do() {
    let mut bodies = Bodies(Xoshiro256PlusPlus::seed_from_u64(4));
    let mut missed = [[0; 4]; 4];
    for case in 0..4000 {
        let (i, j) = (case % 4, case / 4 % 4);
        let (a, b, d) = (bodies.body(i), bodies.body(j), bodies.direction());
        let b = moved(b.clone(), farthest(&a, d) - farthest(&b, -d));
        let touching = overlaps(vec![a.clone(), b.clone()], &open_cell());
        assert!(touching.is_empty(), "case {case}: {touching:?}");
        let apart = overlaps(vec![a.clone(), moved(b.clone(), OVERLAP * d)], &open_cell());
        assert!(apart.is_empty(), "case {case}: {apart:?}");
        if overlaps(vec![a, moved(b, -OVERLAP * d)], &open_cell()).is_empty() {
            missed[i][j] += 1;
        }
    }
    assert_eq!(missed, [[0; 4]; 4]);
}

#[test]
fn boxes_and_meshes_may_share_faces_and_parts_of_faces() {
    let mut bodies = Bodies(Xoshiro256PlusPlus::seed_from_u64(5));
    for case in 0..500 {
        let turn = if case % 2 == 0 { bodies.turn() } else { DMat3::IDENTITY };
        let (size, other) = (DVec3::splat(1.5) + bodies.vector(), DVec3::splat(1.5) + bodies.vector());
        let aside = if case % 3 == 0 { DVec3::ZERO } else { 0.4 * bodies.vector() };
        let place = 10.0 * bodies.vector();
        for (gap, expected) in [(0.0, 0), (OVERLAP, 0), (-OVERLAP, 1)] {
            let min = aside.with_x(size.x + gap);
            let first = Mesh::cuboid(DVec3::ZERO, size).map(|p| place + turn * p);
            let second = Mesh::cuboid(min, min + other).map(|p| place + turn * p);
            let found = overlaps(vec![Base::Triangles(first), Base::Triangles(second)], &open_cell());
            assert_eq!(found.len(), expected, "case {case}, gap {gap}: {found:?}");
        }
    }
}

#[test]
fn what_lies_within_or_is_there_twice_overlaps() {
    let mut bodies = Bodies(Xoshiro256PlusPlus::seed_from_u64(6));
    for case in 0..400 {
        let (kind, a) = (case % 4, bodies.body(case % 4));
        assert_eq!(overlaps(vec![a.clone(), a.clone()], &open_cell()).len(), 1, "kind {kind} twice");
        let center = a.bounds().unwrap().center();
        let seed = Sphere { center, radius: 0.01 };
        assert_eq!(overlaps(vec![a.clone(), Base::Shape(Shape::Sphere(seed))], &open_cell()).len(), 1);
        let grain = Mesh::cuboid(center - 0.01, center + 0.01);
        assert_eq!(overlaps(vec![Base::Triangles(grain), a], &open_cell()).len(), 1, "kind {kind}");
    }
}

#[test]
fn layers_are_compared_by_height() {
    let layer = |bottom, top| Base::Shape(Shape::Layer(Layer { bottom, top }));
    let mut bodies = Bodies(Xoshiro256PlusPlus::seed_from_u64(7));
    for case in 0..200 {
        let body = bodies.body(case % 4);
        let top = body.bounds().unwrap().max.z;
        for (z, expected) in [(top, 0), (top + OVERLAP, 0), (top - OVERLAP, 1)] {
            assert_eq!(overlaps(vec![layer(z, z + 1.0), body.clone()], &open_cell()).len(), expected);
            let two = vec![layer(top, top + 1.0), layer(2.0 * top - z - 1.0, 2.0 * top - z)];
            assert_eq!(overlaps(two, &open_cell()).len(), expected);
        }
    }
}

#[test]
fn bodies_meet_their_own_repetitions() {
    let cell = |size| Cell::new(DVec2::new(size, 7.0), DVec3::ZERO, true, (-2.0, 2.0), 1.0);
    let mut bodies = Bodies(Xoshiro256PlusPlus::seed_from_u64(8));
    for case in 0..40 {
        let center = 30.0 * bodies.vector().with_z(0.0);
        let ball = Base::Shape(Shape::Sphere(Sphere { center, radius: 2.0 }));
        let cube = Base::Triangles(Mesh::cuboid(center - 2.0, center + 2.0));
        let body = if case % 2 == 0 { ball } else { cube };
        for (size, expected) in [(4.0, 0), (4.0 + OVERLAP, 0), (4.0 - OVERLAP, 1)] {
            let found = overlaps(vec![body.clone()], &cell(size));
            assert_eq!(found.len(), expected, "case {case}, period {size}: {found:?}");
        }
    }
    let fibre = |axis: DVec3, z| {
        let (u, radii) = (DVec3::Z, [1.0; 2]);
        Base::Shape(Shape::Cylinder(Cylinder { from: z * DVec3::Z, axis, length: f64::INFINITY, u, radii }))
    };
    for (z, expected) in [(2.0, 0), (2.0 - OVERLAP, 1)] {
        for across in [DVec3::X, DVec3::Y] {
            let found = overlaps(vec![fibre(DVec3::X, 0.0), fibre(across, z)], &cell(5.0));
            assert_eq!(found.len(), expected, "{found:?}");
        }
    }
}

#[test]
fn large_samples_take_no_time() {
    let packing = Packing { count: 14_000, radius: 1.0, size: DVec3::new(100.0, 100.0, 20.0), periodic: true, seed: 1 };
    let sphere = |center| Base::Shape(Shape::Sphere(Sphere { center, radius: 1.0 }));
    let spheres: Vec<Base> = packing.centers().unwrap().into_iter().map(sphere).collect();
    let boxes =
        (0..20).flat_map(|x| (0..20).flat_map(move |y| (0..20).map(move |z| DVec3::from([x, y, z].map(f64::from)))));
    let boxes: Vec<Base> = boxes.map(|p| Base::Triangles(Mesh::cuboid(p, p + 1.0))).collect();
    let turn = DMat3::from_rotation_x(0.3) * DMat3::from_rotation_z(0.7);
    let turned: Vec<Base> = boxes
        .iter()
        .cloned()
        .map(|b| match b {
            Base::Triangles(mesh) => Base::Triangles(mesh.map(|p| turn * p)),
            shape => shape,
        })
        .collect();
    let tile = |size| Cell::new(DVec2::splat(size), DVec3::ZERO, true, (0.0, 20.0), 1.0);
    for (what, bases, cell) in
        [("spheres", spheres, tile(100.0)), ("boxes", boxes, tile(20.0)), ("turned", turned, open_cell())]
    {
        let start = Instant::now();
        let found = overlaps(bases, &cell);
        println!("{what}: {:?}", start.elapsed());
        assert!(found.is_empty(), "{what}: {found:?}");
        assert!(start.elapsed().as_secs_f64() < 5.0, "{what} took {:?}", start.elapsed());
    }
}
