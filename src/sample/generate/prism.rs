//! Regular prisms, and whether two of them are apart.

use std::f64::consts::TAU;

use glam::{DMat3, DVec3};

use super::super::mesh::Mesh;

/// A right prism over a regular polygon.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Form {
    /// Corners of the polygon.
    pub sides: usize,
    /// Radius of the circle through them, µm.
    pub radius: f64,
    /// Half of its height, µm.
    pub half: f64,
}

impl Form {
    /// Radius of the ball around it, µm.
    pub fn reach(&self) -> f64 {
        self.radius.hypot(self.half)
    }

    /// Its volume, µm³.
    pub fn volume(&self) -> f64 {
        self.sides as f64 * self.radius.powi(2) * (TAU / self.sides as f64).sin() * self.half
    }

    /// The same with a skin `thickness` µm thick on all faces.
    pub fn within(self, thickness: f64) -> Self {
        let corner = thickness / (0.5 * TAU / self.sides as f64).cos();
        Self { radius: self.radius + corner, half: self.half + thickness, ..self }
    }

    /// Corners of the lower polygon, then of the upper one.
    fn corners(&self) -> Vec<DVec3> {
        let at = |i: usize| TAU * i as f64 / self.sides as f64;
        let ring =
            |z: f64| (0..self.sides).map(move |i| DVec3::new(self.radius * at(i).cos(), self.radius * at(i).sin(), z));
        ring(-self.half).chain(ring(self.half)).collect()
    }

    /// As a mesh about the origin, turned.
    pub fn mesh(&self, turn: DMat3) -> Mesh {
        let n = self.sides as u32;
        let ends = (1..n - 1).flat_map(|i| [[0, i + 1, i], [n, n + i, n + i + 1]]);
        let sides = (0..n).flat_map(|i| {
            let j = (i + 1) % n;
            [[i, j, n + j], [i, n + j, n + i]]
        });
        Mesh {
            vertices: self.corners().into_iter().map(|p| turn * p).collect(),
            triangles: ends.chain(sides).collect(),
        }
    }
}

/// A prism turned about its centre, with what a comparison needs.
#[derive(Clone, Debug)]
pub(super) struct Turned {
    pub form: Form,
    pub turn: DMat3,
    corners: Vec<DVec3>,
    normals: Vec<DVec3>,
    edges: Vec<DVec3>,
}

impl Turned {
    pub fn new(form: Form, turn: DMat3) -> Self {
        let corners: Vec<DVec3> = form.corners().into_iter().map(|p| turn * p).collect();
        let edges: Vec<DVec3> = (0..form.sides).map(|i| corners[(i + 1) % form.sides] - corners[i]).collect();
        // Of an even number of sides the second half is that of the first.
        let different = if form.sides.is_multiple_of(2) { form.sides / 2 } else { form.sides };
        let edges: Vec<DVec3> = edges[..different].to_vec();
        let normals = edges.iter().map(|e| e.cross(turn.z_axis)).chain([turn.z_axis]).collect();
        Self { form, turn, corners, normals, edges: edges.into_iter().chain([turn.z_axis]).collect() }
    }

    /// Half of its extent along z, µm.
    pub fn half_height(&self) -> f64 {
        self.corners.iter().map(|p| p.z.abs()).fold(0.0, f64::max)
    }

    /// Whether a plane lies between this one and `other`, whose centre is `by` from its own (they may touch): the theorem
    /// of separating axes, exact for convex bodies of flat faces.
    pub fn is_apart(&self, other: &Self, by: DVec3) -> bool {
        let reach = self.form.reach() + other.form.reach();
        if by.length_squared() >= reach * reach {
            return true;
        }
        let parts = |axis: DVec3| {
            let ([a, b], [c, d], way) = (self.extent(axis), other.extent(axis), by.dot(axis));
            b <= way + c || way + d <= a
        };
        let mut normals = self.normals.iter().chain(&other.normals).copied();
        let mut crosses = self.edges.iter().flat_map(|e| other.edges.iter().map(|f| e.cross(*f)));
        normals.any(parts) || crosses.any(|axis| axis.length_squared() > 1e-20 && parts(axis))
    }

    /// Smallest and largest coordinate along an axis, times its length.
    fn extent(&self, axis: DVec3) -> [f64; 2] {
        let along = self.corners.iter().map(|p| p.dot(axis));
        along.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(x), high.max(x)])
    }
}
