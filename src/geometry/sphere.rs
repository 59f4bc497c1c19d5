//! Spheres.

use glam::DVec3;

use super::{Aabb, Ray};

/// A sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Centre, µm.
    pub center: DVec3,
    /// Radius, µm.
    pub radius: f64,
}

/// How a line meets a sphere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Chord {
    /// Not at all.
    None,
    /// So close to a tangent that the two roots differ by less than their own error: counts as a miss, except
    /// for a ray that starts on the sphere.
    Tangent,
    /// It enters and leaves at these distances, µm.
    Through(f64, f64),
}

/// A line counts as a tangent if it passes the centre at a distance whose square is this close to r², relative.
const TANGENT: f64 = 1e-14;

impl Sphere {
    /// Where the line of `ray` is inside.
    ///
    /// Roots in the form of Haines, Günther and Akenine-Möller, *Precision Improvements for Ray/Sphere
    /// Intersection*, Ray Tracing Gems (2019), ch. 7: the discriminant from the perpendicular, the smaller root
    /// from the product of the roots.
    #[inline]
    pub fn chord(&self, ray: &Ray) -> Chord {
        let f = ray.origin - self.center;
        let b = -f.dot(ray.dir);
        let r2 = self.radius * self.radius;
        let discriminant = r2 - (f + b * ray.dir).length_squared();
        if discriminant < TANGENT * r2 {
            return if discriminant < -TANGENT * r2 { Chord::None } else { Chord::Tangent };
        }
        let c = f.length_squared() - r2;
        let q = b + discriminant.sqrt().copysign(b);
        let (t0, t1) = (c / q, q);
        Chord::Through(t0.min(t1), t0.max(t1))
    }

    /// The other root for a ray that starts on the sphere, or `None` if it points outwards.
    #[inline]
    pub fn other_root(&self, ray: &Ray) -> Option<f64> {
        let t = -2.0 * (ray.origin - self.center).dot(ray.dir);
        (t > 0.0).then_some(t)
    }

    /// The point on the sphere next to `p`, which is off by rounding only, and the outward normal there.
    #[inline]
    pub fn settle(&self, p: DVec3) -> (DVec3, DVec3) {
        let per_radius = 1.0 / self.radius;
        let f = (p - self.center) * per_radius;
        // One step of Newton's method for 1/√x at x ≈ 1.
        let normal = f * (1.5 - 0.5 * f.length_squared());
        (self.center + self.radius * normal, normal)
    }

    /// Outward normal at `p` on the sphere.
    #[inline]
    pub fn normal(&self, p: DVec3) -> DVec3 {
        (p - self.center) / self.radius
    }

    /// Bounds.
    pub fn bounds(&self) -> Aabb {
        Aabb { min: self.center - self.radius, max: self.center + self.radius }
    }
}
