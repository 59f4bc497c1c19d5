//! A closed surface sorted into columns: which points are inside of it, and which of its triangles are near.

use std::ops::RangeInclusive;

use glam::{DVec2, DVec3};

use super::super::mesh::Mesh;
use crate::geometry::Aabb;

/// Triangles of a mesh by the cells of a grid they cover, seen from above, aslant: so that no upright or level face
/// of usual samples is seen edge-on.
pub(super) struct Columns<'a> {
    mesh: &'a Mesh,
    low: DVec2,
    cell: DVec2,
    count: [usize; 2],
    cells: Vec<Vec<u32>>,
}

/// The view from above: x and y move by this per height.
const SLANT: DVec2 = DVec2::new(0.137_035_999, 0.292_893_219);

fn seen(p: DVec3) -> DVec2 {
    p.truncate() + p.z * SLANT
}

impl<'a> Columns<'a> {
    /// Of a mesh that is closed and wound outwards.
    pub fn new(mesh: &'a Mesh) -> Self {
        let corners = mesh.triangles.iter().flatten().map(|&i| seen(mesh.vertices[i as usize]));
        let (low, high) = corners.fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(a, b), p| (a.min(p), b.max(p)));
        let mut side = (mesh.triangles.len() as f64).sqrt().ceil() as usize;
        loop {
            let cell = (high - low).max(DVec2::splat(f64::MIN_POSITIVE)) / side as f64;
            let mut out = Self { mesh, low, cell, count: [side; 2], cells: Vec::new() };
            if side == 1 || out.places() <= 16 * mesh.triangles.len() {
                out.fill();
                return out;
            }
            side /= 2;
        }
    }

    /// How often triangles would stand in cells.
    fn places(&self) -> usize {
        let covered = |t: &[u32; 3]| {
            let [x, y] = self.covered(self.mesh.corners(*t).map(seen));
            x.count() * y.count()
        };
        self.mesh.triangles.iter().map(covered).sum()
    }

    fn fill(&mut self) {
        self.cells = vec![Vec::new(); self.count[0] * self.count[1]];
        for (i, t) in self.mesh.triangles.iter().enumerate() {
            let [xs, ys] = self.covered(self.mesh.corners(*t).map(seen));
            for y in ys {
                for x in xs.clone() {
                    self.cells[y * self.count[0] + x].push(i as u32);
                }
            }
        }
    }

    /// Cells under some points.
    fn covered<const N: usize>(&self, points: [DVec2; N]) -> [RangeInclusive<usize>; 2] {
        let index = |p: DVec2, i: usize| (((p[i] - self.low[i]) / self.cell[i]) as usize).min(self.count[i] - 1);
        let range = |i: usize| {
            let (low, high) =
                points.iter().fold((usize::MAX, 0), |(a, b), &p| (a.min(index(p, i)), b.max(index(p, i))));
            low..=high
        };
        [range(0), range(1)]
    }

    /// Triangles that may reach into `bounds`, each once.
    pub fn near(&self, bounds: Aabb) -> Vec<[DVec3; 3]> {
        let corners: [DVec2; 8] = std::array::from_fn(|i| {
            let pick = |bit: usize| if i >> bit & 1 == 0 { bounds.min[bit] } else { bounds.max[bit] };
            seen(DVec3::new(pick(0), pick(1), pick(2)))
        });
        let [xs, ys] = self.covered(corners);
        let mut found: Vec<u32> =
            ys.flat_map(|y| xs.clone().flat_map(move |x| &self.cells[y * self.count[0] + x])).copied().collect();
        found.sort_unstable();
        found.dedup();
        let corners = found.into_iter().map(|i| self.mesh.corners(self.mesh.triangles[i as usize]));
        corners.filter(|c| Aabb::around(*c).overlaps(bounds)).collect()
    }

    /// Whether `p` lies inside, at least `depth` µm away from the surface.
    pub fn contains(&self, p: DVec3, depth: f64) -> bool {
        if !self.mesh_bounds_hold(p) || self.winding(p) <= 0 {
            return false;
        }
        let around = Aabb { min: p - depth, max: p + depth };
        self.near(around).into_iter().all(|t| distance_squared(p, t) >= depth * depth)
    }

    fn mesh_bounds_hold(&self, p: DVec3) -> bool {
        let q = seen(p);
        q.cmpge(self.low).all()
            && (q - self.low).cmple(self.cell * DVec2::new(self.count[0] as f64, self.count[1] as f64)).all()
    }

    /// How often the surface winds around `p`: its crossings with the line of sight above `p`, by direction.
    fn winding(&self, p: DVec3) -> i32 {
        let q = seen(p);
        let [x, y] = self.covered([q]).map(|r| *r.start());
        let triangles = self.cells[y * self.count[0] + x].iter();
        triangles.map(|&i| crossing(self.mesh.corners(self.mesh.triangles[i as usize]), p, q)).sum()
    }
}

/// Whether the line of sight meets the triangle above `p`: 1 from inside, −1 from outside, 0 if it does not.
fn crossing(corners: [DVec3; 3], p: DVec3, q: DVec2) -> i32 {
    let [a, b, c] = corners.map(seen);
    let inside = left_of(a, b, q) ^ left_of(b, c, q) ^ left_of(c, a, q);
    let area = (b - a).perp_dot(c - a);
    if !inside || area == 0.0 {
        return 0;
    }
    let weight = |r: DVec2, s: DVec2| (r - q).perp_dot(s - q) / area;
    let height = weight(b, c) * corners[0].z + weight(c, a) * corners[1].z + weight(a, b) * corners[2].z;
    if height <= p.z { 0 } else { area.signum() as i32 }
}

/// Whether the edge crosses the half-line from `q` along x. Both triangles at an edge get one answer.
fn left_of(a: DVec2, b: DVec2, q: DVec2) -> bool {
    let (low, high) = if (a.y, a.x) < (b.y, b.x) { (a, b) } else { (b, a) };
    low.y <= q.y && q.y < high.y && (high - low).perp_dot(q - low) > 0.0
}

/// Squared distance of a point from a triangle (Ericson, *Real-Time Collision Detection*, 2005, section 5.1.5).
fn distance_squared(p: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let n = (b - a).cross(c - a);
    let beside = |from: DVec3, to: DVec3| (to - from).cross(p - from).dot(n) < 0.0;
    if n.length_squared() > 0.0 && !beside(a, b) && !beside(b, c) && !beside(c, a) {
        return (p - a).dot(n).powi(2) / n.length_squared();
    }
    let to_edge = |from: DVec3, to: DVec3| {
        let (edge, w) = (to - from, p - from);
        let at = (w.dot(edge) / edge.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        (w - at * edge).length_squared()
    };
    to_edge(a, b).min(to_edge(b, c)).min(to_edge(c, a))
}
