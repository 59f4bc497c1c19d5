//! How wide the faces of the sample are compared with the wavelength: where they are narrow, light is diffracted,
//! and ray optics is in doubt.

use std::collections::HashMap;

use glam::DVec3;

use crate::geometry::{Cylinder, Kind, PrimId, Primitives, Shape, SurfaceId};

/// Faces narrower than this many wavelengths count as small (diffraction spreads light by λ/width, some 10°).
pub const SMALL: f64 = 5.0;

/// Neighbouring triangles that are tilted against each other by less than this (rad) are parts of a curved face.
const SMOOTH: f64 = 0.5;

/// The width of the narrowest face, and which faces are small: a bit per face, per primitive.
#[derive(Clone, Debug, Default)]
pub struct Features {
    bits: Vec<u8>,
    any: bool,
    smallest: f64,
}

impl Features {
    /// Finds all faces narrower than [`SMALL`] times `wavelength` (µm). Curved faces are as wide as the
    /// diameter of their curvature, flat ones as the narrowest gap they pass through.
    pub fn new(primitives: &Primitives, wavelength: f64) -> Self {
        let mut features = Self { bits: vec![0; primitives.len()], any: false, smallest: f64::INFINITY };
        let triangles = triangle_widths(primitives);
        let first = primitives.first(Kind::Triangle).0;
        for id in primitives.ids() {
            for face in 0..primitives.faces(id).len() as u8 {
                let width = match primitives.shape(id) {
                    Shape::Triangle(_) => triangles[(id.0 - first) as usize],
                    shape => face_width(&shape, face),
                };
                features.note(id, face, width, SMALL * wavelength);
            }
        }
        features
    }

    fn note(&mut self, prim: PrimId, face: u8, width: f64, enough: f64) {
        self.smallest = self.smallest.min(width);
        if width < enough {
            self.bits[prim.0 as usize] |= 1 << face;
            self.any = true;
        }
    }

    /// Whether a face is small.
    #[inline]
    pub fn is_small(&self, prim: PrimId, face: u8) -> bool {
        self.bits[prim.0 as usize] >> face & 1 == 1
    }

    /// Whether any face is small.
    #[inline]
    pub fn any(&self) -> bool {
        self.any
    }

    /// Width of the narrowest face, µm; infinite if all are endless.
    pub fn smallest(&self) -> f64 {
        self.smallest
    }
}

fn face_width(shape: &Shape, face: u8) -> f64 {
    match shape {
        Shape::Sphere(s) => 2.0 * s.radius,
        Shape::Cylinder(c) => {
            let across = 2.0 * c.radii[0].min(c.radii[1]);
            if face == Cylinder::MANTLE { across.min(c.length) } else { across }
        }
        Shape::Cuboid(b) => {
            let edges = (b.max - b.min).to_array();
            let across = usize::from(face / 2);
            edges[(across + 1) % 3].min(edges[(across + 2) % 3])
        }
        Shape::Layer(_) | Shape::Triangle(_) => f64::INFINITY,
    }
}

/// Coplanar triangles that hang together.
#[derive(Clone, Debug, Default)]
struct Patch {
    triangles: Vec<usize>,
    normal: DVec3,
    centroid: DVec3,
}

/// Width of the face each triangle belongs to.
fn triangle_widths(primitives: &Primitives) -> Vec<f64> {
    let count = primitives.count(Kind::Triangle);
    let corners: Vec<[u32; 3]> = primitives
        .ids()
        .take(count)
        .map(|id| if let Shape::Triangle(t) = primitives.shape(id) { t.corners } else { [0; 3] })
        .collect();
    let surface = |i: usize| primitives.faces(PrimId(i as u32))[0];
    let (patches, patch_of) = patches(primitives, &corners, surface);
    let mut curved = vec![f64::INFINITY; patches.len()];
    for (edge, [a, b]) in creases(&corners, &patch_of) {
        let tilt = patches[a].normal.angle_between(patches[b].normal);
        if tilt < SMOOTH {
            let ends = edge.map(|v| primitives.vertex(v));
            let apart = [a, b].map(|p| distance_to_line(patches[p].centroid, ends)).iter().sum::<f64>();
            // Normals turn by `tilt` over the arc between the centroids.
            for p in [a, b] {
                curved[p] = curved[p].min(2.0 * apart / tilt);
            }
        }
    }
    let widths: Vec<f64> = patches
        .iter()
        .zip(&curved)
        .map(|(p, &curved)| if curved.is_finite() { curved } else { flat_width(primitives, &corners, p) })
        .collect();
    patch_of.iter().map(|&p| widths[p]).collect()
}

fn patches(
    primitives: &Primitives,
    corners: &[[u32; 3]],
    surface: impl Fn(usize) -> SurfaceId,
) -> (Vec<Patch>, Vec<usize>) {
    // Triangles are joined through (surface, corner).
    let mut joints: HashMap<(SurfaceId, u32), usize> = HashMap::new();
    let mut root: Vec<usize> = (0..corners.len()).collect();
    fn find(root: &mut [usize], mut i: usize) -> usize {
        while root[i] != i {
            root[i] = root[root[i]];
            i = root[i];
        }
        i
    }
    for (i, t) in corners.iter().enumerate() {
        for &v in t {
            let other = *joints.entry((surface(i), v)).or_insert(i);
            let (x, y) = (find(&mut root, i), find(&mut root, other));
            root[x.max(y)] = x.min(y);
        }
    }
    let mut patches: Vec<Patch> = Vec::new();
    let mut patch_of = vec![0; corners.len()];
    for i in 0..corners.len() {
        let r = find(&mut root, i);
        if r == i {
            patch_of[i] = patches.len();
            let normal = primitives.normal(PrimId(i as u32), 0, DVec3::ZERO);
            patches.push(Patch { triangles: Vec::new(), normal, centroid: DVec3::ZERO });
        }
        patch_of[i] = patch_of[r];
        patches[patch_of[i]].triangles.push(i);
    }
    for patch in &mut patches {
        let mut area = 0.0;
        for &i in &patch.triangles {
            let [a, b, c] = corners[i].map(|v| primitives.vertex(v));
            let part = (b - a).cross(c - a).length();
            area += part;
            patch.centroid += part * (a + b + c) / 3.0;
        }
        patch.centroid /= area;
    }
    (patches, patch_of)
}

/// Edges between two patches, with the patches.
fn creases(corners: &[[u32; 3]], patch_of: &[usize]) -> Vec<([u32; 2], [usize; 2])> {
    let mut first: HashMap<[u32; 2], usize> = HashMap::new();
    let mut out = Vec::new();
    for (&[a, b, c], &patch) in corners.iter().zip(patch_of) {
        for (p, q) in [(a, b), (b, c), (c, a)] {
            let edge = [p.min(q), p.max(q)];
            match first.remove(&edge) {
                Some(other) if other != patch => out.push((edge, [other, patch])),
                Some(_) => {}
                None => {
                    first.insert(edge, patch);
                }
            }
        }
    }
    out
}

fn distance_to_line(p: DVec3, [a, b]: [DVec3; 2]) -> f64 {
    (p - a).cross((b - a).normalize_or_zero()).length()
}

/// The narrowest gap through which a flat face passes: one of its outer edges lies along a wall of it.
fn flat_width(primitives: &Primitives, corners: &[[u32; 3]], patch: &Patch) -> f64 {
    let mut outline: HashMap<[u32; 2], bool> = HashMap::new();
    for &[a, b, c] in patch.triangles.iter().map(|&i| &corners[i]) {
        for (p, q) in [(a, b), (b, c), (c, a)] {
            outline.entry([p.min(q), p.max(q)]).and_modify(|outer| *outer = false).or_insert(true);
        }
    }
    let outline = outline.into_iter().filter(|(_, outer)| *outer).map(|(edge, _)| edge.map(|v| primitives.vertex(v)));
    let outline: Vec<[DVec3; 2]> = outline.collect();
    let extent = |edge: &[DVec3; 2]| {
        let across = patch.normal.cross(edge[1] - edge[0]).normalize_or_zero();
        let heights = outline.iter().flatten().map(|p| p.dot(across));
        let (low, high) = heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
        high - low
    };
    outline.iter().map(extent).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Builder, Cuboid, Sphere, Triangle};
    use crate::sample::mesh::Mesh;

    fn of_mesh(mesh: &Mesh, wavelength: f64) -> Features {
        let mut builder = Builder::default();
        mesh.vertices.iter().for_each(|&v| {
            builder.vertex(v);
        });
        mesh.triangles.iter().for_each(|&corners| builder.add(Shape::Triangle(Triangle { corners }), 0));
        Features::new(&builder.finish(), wavelength)
    }

    #[test]
    fn a_mesh_box_and_a_box_have_the_same_widths() {
        let (min, max) = (DVec3::ZERO, DVec3::new(1.5, 2.0, 0.172));
        let mesh = of_mesh(&Mesh::cuboid(min, max), 0.1);
        let mut builder = Builder::default();
        builder.add(Shape::Cuboid(Cuboid { min, max }), 0);
        let cuboid = Features::new(&builder.finish(), 0.1);
        assert!((mesh.smallest() - 0.172).abs() < 1e-12 && (cuboid.smallest() - 0.172).abs() < 1e-12);
        // Walls are small, the top and the bottom are not.
        assert_eq!(cuboid.bits, [0b00_1111]);
        assert_eq!(mesh.bits.iter().filter(|&&b| b == 1).count(), 8);
    }

    #[test]
    fn a_triangle_is_as_wide_as_its_least_height() {
        let vertices = vec![DVec3::ZERO, DVec3::new(3.0, 0.0, 0.0), DVec3::new(0.0, 4.0, 0.0)];
        for triangle in [[0, 1, 2], [1, 2, 0], [2, 1, 0]] {
            let width = of_mesh(&Mesh { vertices: vertices.clone(), triangles: vec![triangle] }, 1.0).smallest();
            assert!((width - 2.4).abs() < 1e-12, "{width}");
        }
    }

    /// A tube of `n` flat strips, without ends.
    fn tube(n: u32, radius: f64, length: f64) -> Mesh {
        let at = |k: u32, z: f64| {
            let (s, c) = (f64::from(k % n) * std::f64::consts::TAU / f64::from(n)).sin_cos();
            DVec3::new(radius * c, radius * s, z)
        };
        let vertices = (0..n).map(|k| at(k, 0.0)).chain((0..n).map(|k| at(k, length))).collect();
        let strip = |k: u32| {
            let next = (k + 1) % n;
            [[k, next, n + next], [k, n + next, n + k]]
        };
        Mesh { vertices, triangles: (0..n).flat_map(strip).collect() }
    }

    #[test]
    fn curved_meshes_are_as_wide_as_their_curvature() {
        let width = of_mesh(&tube(40, 3.0, 50.0), 1.0).smallest();
        assert!((width / 6.0 - 1.0).abs() < 0.01, "{width}");
        let mut builder = Builder::default();
        builder.add(Shape::Sphere(Sphere { center: DVec3::ZERO, radius: 3.0 }), 0);
        assert_eq!(Features::new(&builder.finish(), 1.0).smallest(), 6.0);
    }
}
