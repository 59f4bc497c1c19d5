//! Axis-aligned boxes.

use glam::DVec3;

use super::{Aabb, Ray};

/// A solid box. Faces are numbered −x, +x, −y, +y, −z, +z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cuboid {
    /// Smallest coordinates, µm.
    pub min: DVec3,
    /// Largest coordinates, µm.
    pub max: DVec3,
}

impl Cuboid {
    /// Where the line is inside: (enter, leave) as (distance in µm, face), by intersecting three intervals.
    /// Distances are computed as [`super::Plane::distance`] computes them for these planes.
    #[inline]
    pub fn interval(&self, ray: &Ray) -> Option<[(f64, u8); 2]> {
        let mut enter = (f64::NEG_INFINITY, 0);
        let mut leave = (f64::INFINITY, 0);
        for i in 0..3 {
            let (o, d) = (ray.origin[i], ray.dir[i]);
            if d == 0.0 {
                if o <= self.min[i] || o >= self.max[i] {
                    return None;
                }
                continue;
            }
            let low = ((self.min[i] - o) / d, 2 * i as u8);
            let high = ((self.max[i] - o) / d, 2 * i as u8 + 1);
            let (near, far) = if d > 0.0 { (low, high) } else { (high, low) };
            if near.0 > enter.0 {
                enter = near;
            }
            if far.0 < leave.0 {
                leave = far;
            }
        }
        (enter.0 < leave.0).then_some([enter, leave])
    }

    /// Outward normal of a face.
    pub fn normal(face: u8) -> DVec3 {
        let mut n = DVec3::ZERO;
        n[usize::from(face / 2)] = if face.is_multiple_of(2) { -1.0 } else { 1.0 };
        n
    }

    /// A corner of a face (enough to fix its plane).
    pub fn corner(&self, face: u8) -> DVec3 {
        if face.is_multiple_of(2) { self.min } else { self.max }
    }

    /// Bounds.
    pub fn bounds(&self) -> Aabb {
        Aabb { min: self.min, max: self.max }
    }
}
