//! Embree's own geometry in single precision, one ray at a time: the limit that benches hold the whole simulation against.

use glam::DVec3;

use super::sys;
use crate::geometry::{Primitives, Shape};

/// Scenes of bodies as Embree knows them: spheres, triangles (of boxes, too), cones (for cylinders, without their ends).
pub struct Bare {
    scenes: Vec<sys::RTCScene>,
}

/// Kinds of geometry, as the shim numbers them, and the numbers per vertex and per face.
const KINDS: [(usize, usize); 3] = [(4, 1), (3, 3), (4, 1)];

impl Bare {
    /// The bodies of `primitives`; endless layers are left out.
    pub fn new(primitives: &Primitives) -> Self {
        let mut lists: [(Vec<f32>, Vec<u32>); 3] = Default::default();
        let mut put = |kind: usize, points: &[DVec3], radius: Option<f64>, faces: &[u32]| {
            let (vertices, indices) = &mut lists[kind];
            let first = (vertices.len() / KINDS[kind].0) as u32;
            for point in points {
                vertices.extend(point.as_vec3().to_array());
                vertices.extend(radius.map(|r| r as f32));
            }
            indices.extend(faces.iter().map(|i| first + i));
        };
        for id in primitives.ids() {
            match primitives.shape(id) {
                Shape::Sphere(sphere) => put(0, &[sphere.center], Some(sphere.radius), &[]),
                Shape::Triangle(triangle) => put(1, &primitives.corners(triangle), None, &[0, 1, 2]),
                Shape::Cuboid(_) => {
                    let b = primitives.bounds(id);
                    let side = |i: usize, k: usize| if i >> k & 1 == 0 { b.min[k] } else { b.max[k] };
                    let corner = |i: usize| DVec3::from_array(std::array::from_fn(|k| side(i, k)));
                    put(1, &std::array::from_fn::<_, 8, _>(corner), None, &BOX);
                }
                Shape::Cylinder(c) if c.length.is_finite() => {
                    put(2, &[c.from, c.from + c.length * c.axis], Some(c.radii[0]), &[0]);
                }
                Shape::Cylinder(_) | Shape::Layer(_) => {}
            }
        }
        let scenes = lists.iter().enumerate().filter(|(_, (vertices, _))| !vertices.is_empty());
        let make = |(kind, (vertices, faces)): (usize, &(Vec<f32>, Vec<u32>))| {
            let (per_vertex, per_face) = KINDS[kind];
            let (points, count) = (vertices.len() / per_vertex, faces.len() / per_face);
            // SAFETY: the lists have so many vertices and faces as is said, and are copied.
            unsafe { sys::gonio_bare_new(kind as i32, vertices.as_ptr(), points, faces.as_ptr(), count) }
        };
        Self { scenes: scenes.map(make).collect() }
    }

    /// Shoots rays (origin, nearest, direction, farthest) and tells how many have hit something.
    pub fn shoot(&self, rays: &[[f32; 8]]) -> usize {
        let of = |scene: &sys::RTCScene| {
            // SAFETY: the scene is committed, and there are so many rays of 8 numbers.
            unsafe { sys::gonio_bare_shoot(*scene, rays.as_ptr().cast(), rays.len()) }
        };
        self.scenes.iter().map(of).sum()
    }
}

impl Drop for Bare {
    fn drop(&mut self) {
        // SAFETY: each was made by gonio_bare_new and is freed once.
        self.scenes.iter().for_each(|scene| unsafe { sys::gonio_bare_free(*scene) });
    }
}

/// Two triangles per side; bit k of the number of a corner is its side along axis k.
const BOX: [u32; 36] =
    [0, 1, 3, 0, 3, 2, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4, 2, 3, 7, 2, 7, 6, 0, 2, 6, 0, 6, 4, 1, 3, 7, 1, 7, 5];
