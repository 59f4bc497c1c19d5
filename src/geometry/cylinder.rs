//! Circular and flattened (elliptic) cylinders with plane ends.

use glam::DVec3;

use super::{Aabb, Plane, Ray};

/// A right cylinder with elliptic cross-section.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cylinder {
    /// Centre of the first end, µm.
    pub from: DVec3,
    /// Unit vector from the first end to the second.
    pub axis: DVec3,
    /// Length, µm; infinite for a cylinder without ends (then `from` is any point of the axis).
    pub length: f64,
    /// Unit vector across, along the first half-axis of the cross-section.
    pub u: DVec3,
    /// Half-axes of the cross-section, µm: along `u` and along `axis × u`.
    pub radii: [f64; 2],
}

/// See [`super::Sphere`]: misses within this of tangency, relative.
const TANGENT: f64 = 1e-14;

impl Cylinder {
    /// Number of the mantle among the faces.
    pub const MANTLE: u8 = 0;
    /// Number of the end at `from`.
    pub const FIRST_END: u8 = 1;
    /// Number of the other end.
    pub const SECOND_END: u8 = 2;

    /// Unit vector along the second half-axis.
    #[inline]
    pub fn v(&self) -> DVec3 {
        self.axis.cross(self.u)
    }

    /// Position or direction in the plane across, in units of the half-axes: there the mantle is the unit circle.
    #[inline]
    fn across(&self, w: DVec3) -> [f64; 2] {
        [w.dot(self.u) / self.radii[0], w.dot(self.v()) / self.radii[1]]
    }

    /// Where the line is inside the mantle, as distances (enter, leave), µm.
    #[inline]
    pub fn mantle_interval(&self, ray: &Ray) -> Option<(f64, f64)> {
        let [px, py] = self.across(ray.origin - self.from);
        let [dx, dy] = self.across(ray.dir);
        let a = dx * dx + dy * dy;
        let c = px * px + py * py - 1.0;
        if a == 0.0 {
            return (c < 0.0).then_some((f64::NEG_INFINITY, f64::INFINITY));
        }
        let b = -(px * dx + py * dy);
        let m = b / a;
        let (ex, ey) = (px + m * dx, py + m * dy);
        let discriminant = 1.0 - (ex * ex + ey * ey);
        if discriminant < TANGENT {
            return None;
        }
        let q = b + (a * discriminant).sqrt().copysign(b);
        let (t0, t1) = (c / q, q / a);
        Some(if t0 < t1 { (t0, t1) } else { (t1, t0) })
    }

    /// The same for a ray that starts on the mantle: one end of the interval is exactly 0.
    #[inline]
    pub fn mantle_interval_from_surface(&self, ray: &Ray) -> Option<(f64, f64)> {
        let [px, py] = self.across(ray.origin - self.from);
        let [dx, dy] = self.across(ray.dir);
        let a = dx * dx + dy * dy;
        if a == 0.0 {
            return None;
        }
        let t = -2.0 * (px * dx + py * dy) / a;
        Some(if t > 0.0 { (0.0, t) } else { (t, 0.0) })
    }

    /// The planes of the ends, with outward normals; `None` for an infinite cylinder.
    pub fn ends(&self) -> Option<[Plane; 2]> {
        self.length.is_finite().then(|| {
            let to = self.from + self.length * self.axis;
            [
                Plane { normal: -self.axis, offset: -self.axis.dot(self.from) },
                Plane { normal: self.axis, offset: self.axis.dot(to) },
            ]
        })
    }

    /// Outward normal of the mantle at `p`.
    #[inline]
    pub fn mantle_normal(&self, p: DVec3) -> DVec3 {
        let [x, y] = self.across(p - self.from);
        (x / self.radii[0] * self.u + y / self.radii[1] * self.v()).normalize()
    }

    /// Whether its cross-section is a circle.
    pub fn is_round(&self) -> bool {
        self.radii[0] == self.radii[1]
    }

    /// Curvature of the cross-section at `p` on the mantle, 1/µm: ab/(a² sin² + b² cos²)^{3/2}.
    pub fn curvature(&self, p: DVec3) -> f64 {
        let ([cos, sin], [a, b]) = (self.across(p - self.from), self.radii);
        a * b / (a * sin).hypot(b * cos).powi(3)
    }

    /// `p`, known to lie on the mantle up to rounding, moved onto it.
    #[inline]
    pub fn snap_to_mantle(&self, p: DVec3) -> DVec3 {
        let [x, y] = self.across(p - self.from);
        let excess = 1.0 / x.hypot(y) - 1.0;
        p + excess * (x * self.radii[0] * self.u + y * self.radii[1] * self.v())
    }

    /// Bounds; infinite along an infinite axis.
    pub fn bounds(&self) -> Aabb {
        let (a, b) = (self.radii[0] * self.u, self.radii[1] * self.v());
        let half = DVec3::from_array(std::array::from_fn(|i| a[i].hypot(b[i])));
        if self.length.is_finite() {
            return Aabb::around([self.from, self.from + self.length * self.axis]).expand(half);
        }
        let reach = DVec3::from_array(std::array::from_fn(|i| if self.axis[i] == 0.0 { 0.0 } else { f64::INFINITY }));
        Aabb::around([self.from]).expand(half + reach)
    }

    /// Signed distance-like measure across: negative inside the mantle.
    pub fn inside_mantle(&self, p: DVec3) -> bool {
        let [x, y] = self.across(p - self.from);
        x * x + y * y < 1.0
    }
}

impl Aabb {
    fn expand(self, half: DVec3) -> Self {
        Self { min: self.min - half, max: self.max + half }
    }
}
