//! Shared by the integration tests.
#![allow(dead_code, missing_docs, reason = "the tests and each example use their parts")]

use glam::DVec3;
use gonio_embree::geometry::{Builder, Shape, Triangle};
use rand::RngExt;
use rand::rngs::Xoshiro256PlusPlus;

pub mod build;
pub mod collapse;
pub mod cones;
pub mod errors;
pub mod hard;
pub mod listen;
pub mod matrices;
pub mod oracle;
pub mod reference;
pub mod stats;
pub mod synthetic;

/// A uniformly distributed direction.
pub fn direction(rng: &mut Xoshiro256PlusPlus) -> DVec3 {
    let z = 2.0 * rng.random::<f64>() - 1.0;
    let (s, c) = (std::f64::consts::TAU * rng.random::<f64>()).sin_cos();
    let r = (1.0 - z * z).sqrt();
    DVec3::new(r * c, r * s, z)
}

/// A uniformly distributed point of the box [-1, 1]³.
pub fn in_cube(rng: &mut Xoshiro256PlusPlus) -> DVec3 {
    DVec3::from_array(std::array::from_fn(|_| 2.0 * rng.random::<f64>() - 1.0))
}

/// A closed surface of triangles.
#[derive(Clone)]
pub struct Mesh {
    pub vertices: Vec<DVec3>,
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// An octahedron refined `level` times and blown up to the unit sphere.
    pub fn ball(level: u32) -> Self {
        let mut mesh = Self {
            vertices: vec![DVec3::X, DVec3::Y, -DVec3::X, -DVec3::Y, DVec3::Z, -DVec3::Z],
            triangles: (0..4).flat_map(|i| [[i, (i + 1) % 4, 4], [(i + 1) % 4, i, 5]]).collect(),
        };
        for _ in 0..level {
            mesh.refine();
        }
        mesh
    }

    fn refine(&mut self) {
        let mut middles = std::collections::HashMap::new();
        let mut out = Vec::new();
        for [a, b, c] in std::mem::take(&mut self.triangles) {
            let mut middle = |p: u32, q: u32| {
                *middles.entry((p.min(q), p.max(q))).or_insert_with(|| {
                    let m = self.vertices[p as usize] + self.vertices[q as usize];
                    self.vertices.push(m.normalize());
                    self.vertices.len() as u32 - 1
                })
            };
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            out.extend([[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
        }
        self.triangles = out;
    }

    /// The unit cube, two triangles a face.
    pub fn cube() -> Self {
        let vertices = (0..8).map(|i| DVec3::new((i & 1) as f64, (i >> 1 & 1) as f64, (i >> 2) as f64)).collect();
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        Self { vertices, triangles }
    }

    /// Every point mapped by `f`.
    pub fn map(mut self, f: impl Fn(DVec3) -> DVec3) -> Self {
        self.vertices.iter_mut().for_each(|v| *v = f(*v));
        self
    }

    /// Adds the triangles as solid `owner`.
    pub fn add_to(&self, builder: &mut Builder, owner: u32) {
        let ids: Vec<u32> = self.vertices.iter().map(|&v| builder.vertex(v)).collect();
        for t in &self.triangles {
            builder.add(Shape::Triangle(Triangle { corners: t.map(|i| ids[i as usize]) }), owner);
        }
    }

    /// Twice the middle of a random edge's ends mixed by a random weight, or a corner.
    pub fn edge_point(&self, rng: &mut Xoshiro256PlusPlus) -> DVec3 {
        let t = self.triangles[rng.random_range(0..self.triangles.len())];
        let [a, b] = [t[0], t[1]].map(|i| self.vertices[i as usize]);
        match rng.random_range(0..3) {
            0 => a,
            1 => 0.5 * (a + b),
            _ => a.lerp(b, rng.random()),
        }
    }
}
