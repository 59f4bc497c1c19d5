//! How wide the faces of the sample are compared with the wavelength: where they are narrow, light is diffracted,
//! and ray optics is in doubt.

use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::FxHashMap;

use crate::geometry::{Cylinder, Kind, PrimId, Primitives, Shape};

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
struct Patch<'a> {
    triangles: &'a [u32],
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
    let roots = roots(primitives, &corners);
    let mut sorted: Vec<u32> = (0..count as u32).collect();
    sorted.par_sort_by_key(|&i| roots[i as usize]);
    let parts: Vec<&[u32]> = sorted.chunk_by(|&a, &b| roots[a as usize] == roots[b as usize]).collect();
    let patches: Vec<Patch> = parts.into_par_iter().map(|part| patch(primitives, &corners, part)).collect();
    let mut patch_of = vec![0; count];
    for (number, patch) in patches.iter().enumerate() {
        patch.triangles.iter().for_each(|&i| patch_of[i as usize] = number as u32);
    }
    let mut curved = vec![f64::INFINITY; patches.len()];
    for (edge, pair) in creases(&corners, &patch_of) {
        let [a, b] = pair.map(|p| &patches[p as usize]);
        let tilt = a.normal.angle_between(b.normal);
        if tilt < SMOOTH {
            let ends = edge.map(|v| primitives.vertex(v));
            let apart = [a, b].map(|p| distance_to_line(p.centroid, ends)).iter().sum::<f64>();
            // Normals turn by `tilt` over the arc between the centroids.
            for width in pair.map(|p| p as usize) {
                curved[width] = curved[width].min(2.0 * apart / tilt);
            }
        }
    }
    let widths = patches.par_iter().zip(&curved);
    let widths =
        widths.map(|(p, &curved)| if curved.is_finite() { curved } else { flat_width(primitives, &corners, p) });
    let widths: Vec<f64> = widths.collect();
    patch_of.iter().map(|&p| widths[p as usize]).collect()
}

/// For each triangle, the first that is coplanar and hangs together with it.
fn roots(primitives: &Primitives, corners: &[[u32; 3]]) -> Vec<u32> {
    let surface = |i: u32| primitives.faces(PrimId(i))[0];
    let mut sorted: Vec<u32> = (0..corners.len() as u32).collect();
    let mut root = sorted.clone();
    sorted.par_sort_by_key(|&i| surface(i));
    fn find(root: &mut [u32], mut i: u32) -> u32 {
        while root[i as usize] != i {
            root[i as usize] = root[root[i as usize] as usize];
            i = root[i as usize];
        }
        i
    }
    for coplanar in sorted.chunk_by(|&a, &b| surface(a) == surface(b)).filter(|part| part.len() > 1) {
        // Triangles are joined through corners.
        let mut joints: FxHashMap<u32, u32> = FxHashMap::default();
        for &i in coplanar {
            for v in corners[i as usize] {
                let other = *joints.entry(v).or_insert(i);
                let (x, y) = (find(&mut root, i), find(&mut root, other));
                root[x.max(y) as usize] = x.min(y);
            }
        }
    }
    for i in 0..root.len() as u32 {
        root[i as usize] = find(&mut root, i);
    }
    root
}

fn patch<'a>(primitives: &Primitives, corners: &[[u32; 3]], triangles: &'a [u32]) -> Patch<'a> {
    let (mut area, mut centroid) = (0.0, DVec3::ZERO);
    for &i in triangles {
        let [a, b, c] = corners[i as usize].map(|v| primitives.vertex(v));
        let part = (b - a).cross(c - a).length();
        area += part;
        centroid += part * (a + b + c) / 3.0;
    }
    Patch { triangles, normal: primitives.normal(PrimId(triangles[0]), 0, DVec3::ZERO), centroid: centroid / area }
}

/// The edges of a triangle, each with its lower corner first.
fn edges([a, b, c]: [u32; 3]) -> [[u32; 2]; 3] {
    [(a, b), (b, c), (c, a)].map(|(p, q)| [p.min(q), p.max(q)])
}

/// Edges between two patches, with the patches.
fn creases(corners: &[[u32; 3]], patch_of: &[u32]) -> Vec<([u32; 2], [u32; 2])> {
    let of_triangle = |i: usize| edges(corners[i]).map(|edge| (edge, i as u32));
    let mut all: Vec<([u32; 2], u32)> = (0..corners.len()).into_par_iter().flat_map_iter(of_triangle).collect();
    all.par_sort_unstable();
    // More than two triangles at an edge are taken two by two.
    let pairs = all.chunk_by(|a, b| a.0 == b.0).flat_map(|at_edge| at_edge.chunks_exact(2));
    let pairs = pairs.map(|pair| (pair[0].0, [pair[0].1, pair[1].1].map(|i| patch_of[i as usize])));
    pairs.filter(|(_, [a, b])| a != b).collect()
}

fn distance_to_line(p: DVec3, [a, b]: [DVec3; 2]) -> f64 {
    (p - a).cross((b - a).normalize_or_zero()).length()
}

/// The narrowest gap through which a flat face passes: one of its outer edges lies along a wall of it.
fn flat_width(primitives: &Primitives, corners: &[[u32; 3]], patch: &Patch) -> f64 {
    let mut all: Vec<[u32; 2]> = patch.triangles.iter().flat_map(|&i| edges(corners[i as usize])).collect();
    all.sort_unstable();
    let outline = all.chunk_by(|a, b| a == b).filter(|same| same.len() == 1);
    let outline = outline.map(|same| same[0].map(|v| primitives.vertex(v)));
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
