//! The single-precision copy of a scene that accelerators work on: moved to the origin, scaled by a power of two
//! to about `SPAN`, every box grown by `PAD`.
//!
//! Error budget, in units of the span S: rounding the origin and direction of a ray moves it by at most
//! 2⁻²⁴·S each (origins farther than `NEAR` spans are first moved along the ray, in double precision); the
//! slab tests of the accelerators add a few 2⁻²⁴·S. The pad is 2⁻²⁰·S, several times the sum. Rays
//! reach as much farther than asked: obvhs never looks nearer than 1e-4.

use std::ops::Range;

use glam::DVec3;

use crate::geometry::{Aabb, Kind, PrimId, Primitives, Ray};

/// Diagonal of a scene in proxy units: between half of this and this.
const SPAN: f64 = 1024.0;
/// Growth of every box, in proxy units.
const PAD: f64 = SPAN / (1 << 20) as f64;
/// Rays start within this many spans of the centre.
const NEAR: f64 = 2.0;

/// The map from micrometres to proxy units.
#[derive(Clone, Copy, Debug)]
pub struct Proxy {
    center: DVec3,
    scale: f64,
    domain: Aabb,
}

/// A ray in proxy units.
#[derive(Clone, Copy, Debug)]
pub struct ProxyRay {
    /// Start.
    pub origin: [f32; 3],
    /// Direction, unit length.
    pub dir: [f32; 3],
    /// Distance by which the start was moved along the ray, µm.
    pub skipped: f64,
}

impl Proxy {
    /// The map for a scene within `domain`, or around all primitives if `domain` is infinite.
    pub fn new(primitives: &Primitives, domain: Aabb) -> Self {
        let ids = (0..primitives.bounded_count() as u32).map(PrimId);
        let bounds = ids.fold(Aabb::EMPTY, |b, p| b.union(primitives.bounds(p).intersection(domain)));
        let diagonal = if bounds.is_empty() { 1.0 } else { bounds.size().length().max(f64::MIN_POSITIVE) };
        let scale = (SPAN / diagonal).log2().floor().exp2();
        Self { center: if bounds.is_empty() { DVec3::ZERO } else { bounds.center() }, scale, domain }
    }

    /// Lower and upper corner of a primitive's box.
    pub fn bounds(&self, primitives: &Primitives, prim: PrimId) -> [[f32; 3]; 2] {
        self.around(primitives.bounds(prim))
    }

    /// Lower and upper corner of a box.
    pub fn around(&self, b: Aabb) -> [[f32; 3]; 2] {
        let b = b.intersection(self.domain);
        let b = Aabb { min: b.min - self.center, max: b.max - self.center };
        let low = (b.min * self.scale - PAD).to_array().map(|x| (x as f32).next_down());
        let high = (b.max * self.scale + PAD).to_array().map(|x| (x as f32).next_up());
        [low, high]
    }

    /// A ray, started close to the scene.
    #[inline]
    pub fn ray(&self, ray: &Ray) -> ProxyRay {
        let mut from = ray.origin - self.center;
        let mut skipped = 0.0;
        let reach = NEAR * SPAN / self.scale;
        if from.length_squared() > reach * reach {
            skipped = (-from.dot(ray.dir) - reach).max(0.0);
            from += skipped * ray.dir;
        }
        ProxyRay {
            origin: (from * self.scale).to_array().map(|x| x as f32),
            // + 0.0 turns -0.0 into 0.0: obvhs takes the sign from one and the order of slabs from the other.
            dir: ray.dir.to_array().map(|x| x as f32 + 0.0),
            skipped,
        }
    }

    /// A distance along `ray` in proxy units, rounded up by as much as boxes are grown.
    #[inline]
    pub fn reach(&self, t: f64, ray: &ProxyRay) -> f32 {
        self.reach_after(t, ray.skipped)
    }

    /// The same, for a ray whose start was moved by `skipped` µm.
    #[inline]
    pub fn reach_after(&self, t: f64, skipped: f64) -> f32 {
        ((t - skipped) * self.scale + PAD) as f32 * 1.000_001
    }
}

/// Triangles in an accelerator: some that follow one another have one box, where the boxes of each are nearly as large. The
/// two halves of a rectangle, as most meshes have them, are found at once.
#[derive(Default)]
pub struct Patches {
    /// The first triangle of each patch; at the end, the number of all.
    first: Vec<u32>,
}

impl Patches {
    /// Joins triangles while rays pay less for it, by the usual guess that a box is met in proportion to its surface
    /// (Goldsmith and Salmon, *Automatic Creation of Object Hierarchies for Ray Tracing*, IEEE CG&A 7(5), 1987), and if a call
    /// costs as much as a triangle.
    pub fn new(primitives: &Primitives) -> Self {
        let price = |b: Aabb, triangles: u32| surface(b) * f64::from(1 + triangles);
        let mut first = Vec::new();
        let mut patch = Aabb::EMPTY;
        for id in ids(primitives, Kind::Triangle) {
            let own = primitives.bounds(id);
            let joined = patch.union(own);
            let size = first.last().map_or(0, |start| id.0 - start);
            if size > 0 && price(joined, size + 1) <= price(patch, size) + price(own, 1) {
                patch = joined;
            } else {
                first.push(id.0);
                patch = own;
            }
        }
        first.push(primitives.count(Kind::Triangle) as u32);
        Self { first }
    }

    /// How many.
    pub fn count(&self) -> usize {
        self.first.len().saturating_sub(1)
    }

    /// The triangles of one.
    #[inline]
    pub fn triangles(&self, patch: usize) -> Range<usize> {
        self.first[patch] as usize..self.first[patch + 1] as usize
    }

    /// The box around one.
    pub fn bounds(&self, primitives: &Primitives, patch: usize) -> Aabb {
        self.triangles(patch).fold(Aabb::EMPTY, |b, i| b.union(primitives.bounds(PrimId(i as u32))))
    }
}

/// Half the surface of a box.
fn surface(b: Aabb) -> f64 {
    let DVec3 { x, y, z } = b.size();
    x * y + y * z + z * x
}

/// Ids of the primitives of a kind.
pub fn ids(primitives: &Primitives, kind: Kind) -> impl Iterator<Item = PrimId> {
    let first = primitives.first(kind).0;
    (first..first + primitives.count(kind) as u32).map(PrimId)
}
