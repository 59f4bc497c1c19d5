//! The same questions as float32 and textbooks answer them.
//!
//! Float32: all positions, directions, indices and phases are single precision, and so is every operation. Films are
//! collapsed interface by interface with Airy's formula (which does not overflow), spheres are met by the careful formula
//! that this program uses, triangles by Möller and Trumbore's. A ray goes on from a face 256 units in the last place of its
//! coordinate further (Wächter and Binder, Ray Tracing Gems, ch. 6): at 1 to 2 mm that is 31 nm, beyond 61 nm.

use std::f32::consts::TAU;

use num_complex::Complex;

type C32 = Complex<f32>;

/// A stack in float32.
pub struct Stack32 {
    pub first: f32,
    /// Of the angle of incidence.
    pub cos: f32,
    pub sin: f32,
    pub layers: Vec<(C32, f32)>,
    pub last: C32,
    pub wavelength: f32,
    pub p: bool,
}

/// Amplitudes r and t, and shares R and T.
pub struct Answer32 {
    pub r: C32,
    pub t: C32,
    pub reflected: f64,
    pub transmitted: f64,
}

impl Stack32 {
    fn kz(&self, n: C32) -> C32 {
        if n == C32::from(self.first) {
            return C32::from(self.first * self.cos);
        }
        let kx = self.first * self.sin;
        let root = (n * n - kx * kx).sqrt();
        if root.im < 0.0 { -root } else { root }
    }

    fn interface(&self, n1: C32, n2: C32) -> (C32, C32) {
        let (k1, k2) = (self.kz(n1), self.kz(n2));
        let (a, b) = if self.p { (n2 / n1 * k1, n1 / n2 * k2) } else { (k1, k2) };
        ((a - b) / (a + b), k1 * 2.0 / (a + b))
    }

    pub fn solve(&self) -> Answer32 {
        let before = |i: usize| if i == 0 { C32::from(self.first) } else { self.layers[i - 1].0 };
        let (mut r, mut t) = self.interface(before(self.layers.len()), self.last);
        for (i, &(n, d)) in self.layers.iter().enumerate().rev() {
            let (front, through) = self.interface(before(i), n);
            let phase = (C32::i() * self.kz(n) * (TAU * d / self.wavelength)).exp();
            let round_trip = r * phase * phase;
            let airy = (front * round_trip + 1.0).inv();
            (r, t) = ((front + round_trip) * airy, through * t * phase * airy);
        }
        let behind = self.kz(self.last);
        let flux = if self.p { (self.last * (behind / self.last).conj()).re } else { behind.re };
        let transmitted = t.norm_sqr() * flux / (self.first * self.cos);
        Answer32 { r, t, reflected: r.norm_sqr().into(), transmitted: transmitted.into() }
    }
}

/// Which faces a ray that goes down meets if it starts again `offset` of their height behind each.
pub fn seen(faces: &[f64], offset: impl Fn(f64) -> f64) -> Vec<usize> {
    let mut from = f64::INFINITY;
    let mut meets = |z: f64| {
        let met = z < from;
        from = if met { z - offset(z) } else { from };
        met
    };
    (0..faces.len()).filter(|&i| meets(faces[i])).collect()
}

/// 256 units in the last place of a coordinate in float32.
pub fn offset32(z: f64) -> f64 {
    let z = z as f32;
    256.0 * f64::from(z.next_up() - z)
}

/// Bodies in one precision.
macro_rules! precision {
    ($name:ident, $vector:ty, $real:ty) => {
        pub mod $name {
            type Vector = $vector;
            type Real = $real;

            /// Möller and Trumbore: whether the half-line meets a triangle.
            pub fn triangle(o: Vector, d: Vector, [a, b, c]: [Vector; 3]) -> bool {
                let (e, f, s) = (b - a, c - a, o - a);
                let (h, q) = (d.cross(f), s.cross(e));
                let det = e.dot(h);
                let (u, v) = (s.dot(h) / det, d.dot(q) / det);
                u >= 0.0 && v >= 0.0 && u + v <= 1.0 && f.dot(q) / det > 0.0
            }

            /// (−b ± √(b² − 4ac))/2a for a sphere around the origin.
            pub fn sphere(o: Vector, d: Vector, r: Real) -> Option<[Real; 2]> {
                let (a, b, c) = (d.dot(d), 2.0 * o.dot(d), o.dot(o) - r * r);
                let root = (b * b - 4.0 * a * c).sqrt();
                (!root.is_nan()).then(|| [(-b - root) / (2.0 * a), (-b + root) / (2.0 * a)])
            }

            /// The form of Haines, Günther and Akenine-Möller.
            pub fn careful_sphere(o: Vector, d: Vector, r: Real) -> Option<[Real; 2]> {
                let b = -o.dot(d);
                let root = (r * r - (o + b * d).length_squared()).sqrt();
                let q = b + root.copysign(b);
                (!root.is_nan()).then(|| [(o.length_squared() - r * r) / q, q])
            }

            /// Distances at which a line meets the mantle and the ends of a cylinder.
            pub fn cylinder(o: Vector, d: Vector, [from, to]: [Vector; 2], r: Real) -> Vec<Real> {
                let axis = (to - from).normalize();
                let (w, length) = (o - from, (to - from).length());
                let (along, high) = (d.dot(axis), w.dot(axis));
                let (dp, wp) = (d - along * axis, w - high * axis);
                let (a, b, c) = (dp.dot(dp), 2.0 * wp.dot(dp), wp.dot(wp) - r * r);
                let root = (b * b - 4.0 * a * c).sqrt();
                let mantle = [(-b - root) / (2.0 * a), (-b + root) / (2.0 * a)];
                let ends = [-high / along, (length - high) / along];
                let between = |t: &Real| (0.0..=length).contains(&(high + t * along));
                let within = |t: &Real| (wp + t * dp).length_squared() <= r * r;
                mantle.into_iter().filter(between).chain(ends.into_iter().filter(within)).collect()
            }
        }
    };
}

precision!(single, glam::Vec3, f32);
precision!(double, glam::DVec3, f64);
