//! Watertight triangles.

use glam::{DVec2, DVec3};

use super::Ray;

/// A triangle of a mesh; counter-clockwise seen from outside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Triangle {
    /// Indices of its corners.
    pub corners: [u32; 3],
}

/// The map that turns a ray into the line through the origin along z: used for every corner a ray looks at, so
/// that two triangles see the same projected corner, bit for bit (Woop, Benthin and Wald, JCGT 2(1), 2013, §3).
#[derive(Clone, Copy, Debug)]
pub struct Shear {
    axis: Axis,
    by: DVec3,
}

/// The axis along which a ray goes furthest.
#[derive(Clone, Copy, Debug)]
enum Axis {
    X,
    Y,
    Z,
}

impl Axis {
    /// The coordinates of `v`, this one last. A branch that is nearly always foretold, where an index would go through memory.
    #[inline(always)]
    fn last(self, v: DVec3) -> [f64; 3] {
        match self {
            Self::X => [v.y, v.z, v.x],
            Self::Y => [v.z, v.x, v.y],
            Self::Z => [v.x, v.y, v.z],
        }
    }
}

impl Shear {
    /// Where there are no triangles.
    pub(super) const UNUSED: Self = Self { axis: Axis::Z, by: DVec3::ZERO };

    /// The map of `ray`.
    #[inline]
    pub fn new(ray: &Ray) -> Self {
        let a = ray.dir.abs();
        let axis = if a.x > a.y && a.x > a.z {
            Axis::X
        } else if a.y > a.z {
            Axis::Y
        } else {
            Axis::Z
        };
        let [x, y, z] = axis.last(ray.dir);
        let inverse = 1.0 / z;
        Self { axis, by: DVec3::new(x * inverse, y * inverse, inverse) }
    }

    /// Position across and distance along the ray of a corner.
    #[inline]
    fn project(&self, ray: &Ray, corner: DVec3) -> (DVec2, f64) {
        let p = corner - ray.origin;
        let [x, y, z] = self.axis.last(p);
        (DVec2::new(x - self.by.x * z, y - self.by.y * z), z * self.by.z)
    }
}

/// A triangle met by a line.
pub(super) struct Met {
    /// Bounds of the distance: those of the three corners, µm.
    pub range: (f64, f64),
    /// Distance by interpolation between the corners, µm.
    pub t: f64,
    /// Whether the ray meets the side from which the corners turn counter-clockwise.
    pub enters: bool,
}

/// Whether the line of the ray passes through the triangle.
///
/// The signs of the edge functions are exact for the projected corners, and an exact zero is decided as if the
/// line were moved by (ε, ε²): so the lines through a shared edge or corner of a closed mesh meet as many
/// triangles on the way in as on the way out, always.
#[inline]
pub(super) fn meet(shear: &Shear, ray: &Ray, corners: [DVec3; 3]) -> Option<Met> {
    let [(a, ta), (b, tb), (c, tc)] = corners.map(|p| shear.project(ray, p));
    let turn = orient(a, b);
    if orient(b, c) != turn || orient(c, a) != turn {
        return None;
    }
    let weights = DVec3::new(b.perp_dot(c), c.perp_dot(a), a.perp_dot(b)).abs();
    let t = weights.dot(DVec3::new(ta, tb, tc)) / weights.element_sum();
    // The projected axes keep their handedness, so who looks along +z sees every turn reversed.
    let enters = turn != (shear.by.z > 0.0);
    Some(Met { range: (ta.min(tb).min(tc), ta.max(tb).max(tc)), t, enters })
}

/// Whether the origin, moved by (ε, ε²), lies to the left of p → q. Exact.
#[inline]
fn orient(p: DVec2, q: DVec2) -> bool {
    let (m, n) = (p.x * q.y, p.y * q.x);
    // Rounding is monotonic: unequal products have the order of the exact ones.
    if m != n { m > n } else { orient_equal_products(p, q) }
}

#[cold]
fn orient_equal_products(p: DVec2, q: DVec2) -> bool {
    let m = p.x * q.y;
    let rest = p.x.mul_add(q.y, -m) - p.y.mul_add(q.x, -m);
    if rest != 0.0 {
        rest > 0.0
    } else if p.y != q.y {
        q.y < p.y
    } else {
        q.x > p.x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orientation_is_exact_and_antisymmetric() {
        let p = DVec2::new(1.0 + f64::EPSILON, 1.0);
        let q = DVec2::new(1.0, 1.0 - f64::EPSILON);
        // Exact determinant: (1+e)(1-e) - 1 = -e² < 0, while both products round to 1.
        assert!(!orient(p, q));
        assert!(orient(q, p));
        for (p, q) in [((1.0, 2.0), (-2.0, -4.0)), ((0.0, 0.0), (3.0, 1.0)), ((1.0, 0.0), (-1.0, 0.0))] {
            let (p, q) = (DVec2::from(p), DVec2::from(q));
            assert_ne!(orient(p, q), orient(q, p), "{p} {q}");
        }
    }
}
