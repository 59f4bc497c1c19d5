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

/// Rays that pass the centre at a distance whose square is this close to r², relative, count as misses: there
/// the two roots differ by less than their own error.
const TANGENT: f64 = 1e-14;

impl Sphere {
    /// Where the line of `ray` is inside, as distances (enter, leave), µm.
    ///
    /// Roots in the form of Haines, Günther and Akenine-Möller, *Precision Improvements for Ray/Sphere
    /// Intersection*, Ray Tracing Gems (2019), ch. 7: the discriminant from the perpendicular, the smaller root
    /// from the product of the roots.
    #[inline]
    pub fn interval(&self, ray: &Ray) -> Option<(f64, f64)> {
        let f = ray.origin - self.center;
        let b = -f.dot(ray.dir);
        let r2 = self.radius * self.radius;
        let discriminant = r2 - (f + b * ray.dir).length_squared();
        if discriminant < TANGENT * r2 {
            return None;
        }
        let c = f.length_squared() - r2;
        let q = b + discriminant.sqrt().copysign(b);
        let (t0, t1) = (c / q, q);
        Some(if t0 < t1 { (t0, t1) } else { (t1, t0) })
    }

    /// The other root for a ray that starts on the sphere, or `None` if it points outwards.
    #[inline]
    pub fn other_root(&self, ray: &Ray) -> Option<f64> {
        let t = -2.0 * (ray.origin - self.center).dot(ray.dir);
        (t > 0.0).then_some(t)
    }

    /// Outward normal at `p` on the sphere.
    #[inline]
    pub fn normal(&self, p: DVec3) -> DVec3 {
        (p - self.center) / self.radius
    }

    /// `p`, known to lie on the sphere up to rounding, moved onto it.
    #[inline]
    pub fn snap(&self, p: DVec3) -> DVec3 {
        let f = p - self.center;
        self.center + f * (self.radius / f.length())
    }

    /// Bounds.
    pub fn bounds(&self) -> Aabb {
        Aabb { min: self.center - self.radius, max: self.center + self.radius }
    }
}
