//! Watertight triangles.

use glam::{DVec2, DVec3, Vec3Swizzles};

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
    /// The coordinates of `v`, this one last.
    #[inline(always)]
    fn last(self, v: DVec3) -> DVec3 {
        match self {
            Self::X => v.yzx(),
            Self::Y => v.zxy(),
            Self::Z => v,
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
        let DVec3 { x, y, z } = axis.last(ray.dir);
        let inverse = 1.0 / z;
        Self { axis, by: DVec3::new(x * inverse, y * inverse, inverse) }
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
#[inline(always)]
pub(super) fn meet(shear: &Shear, ray: &Ray, corners: [DVec3; 3]) -> Option<Met> {
    let [a, b, c] = [corners[0] - ray.origin, corners[1] - ray.origin, corners[2] - ray.origin];
    // One branch that is mostly foretold, not one for each corner.
    match shear.axis {
        Axis::X => meet_along(shear.by, [a.yzx(), b.yzx(), c.yzx()]),
        Axis::Y => meet_along(shear.by, [a.zxy(), b.zxy(), c.zxy()]),
        Axis::Z => meet_along(shear.by, [a, b, c]),
    }
}

/// The same for corners seen from the origin of the ray, with the axis along which it goes last.
#[inline(always)]
fn meet_along(by: DVec3, corners: [DVec3; 3]) -> Option<Met> {
    let [a, b, c] = [across(by, corners[0]), across(by, corners[1]), across(by, corners[2])];
    let [ab, bc, ca] = [Edge::new(a, b), Edge::new(b, c), Edge::new(c, a)];
    let turn = ab.turns_left();
    // Nobody can foretell which of the edges it passes on the other side.
    if (turn ^ bc.turns_left()) | (turn ^ ca.turns_left()) {
        return None;
    }
    let [ta, tb, tc] = [corners[0].z * by.z, corners[1].z * by.z, corners[2].z * by.z];
    let weights = DVec3::new(bc.area(), ca.area(), ab.area()).abs();
    let t = weights.dot(DVec3::new(ta, tb, tc)) / weights.element_sum();
    // The projected axes keep their handedness, so who looks along +z sees every turn reversed.
    let enters = turn != (by.z > 0.0);
    Some(Met { range: (ta.min(tb).min(tc), ta.max(tb).max(tc)), t, enters })
}

/// The place of a corner in the plane across the ray.
#[inline(always)]
fn across(by: DVec3, p: DVec3) -> DVec2 {
    DVec2::new(p.x - by.x * p.z, p.y - by.y * p.z)
}

/// A projected edge, with the two products of its edge function.
struct Edge {
    ends: [DVec2; 2],
    products: [f64; 2],
}

impl Edge {
    #[inline(always)]
    fn new(p: DVec2, q: DVec2) -> Self {
        Self { ends: [p, q], products: [p.x * q.y, p.y * q.x] }
    }

    /// Twice the area that it spans with the origin.
    #[inline(always)]
    fn area(&self) -> f64 {
        self.products[0] - self.products[1]
    }

    /// Whether the origin, moved by (ε, ε²), lies to its left. Exact.
    #[inline(always)]
    fn turns_left(&self) -> bool {
        let [m, n] = self.products;
        // Rounding is monotonic: unequal products have the order of the exact ones.
        if m != n { m > n } else { orient_equal_products(self.ends[0], self.ends[1]) }
    }
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
        let orient = |p, q| Edge::new(p, q).turns_left();
        assert!(!orient(p, q));
        assert!(orient(q, p));
        for (p, q) in [((1.0, 2.0), (-2.0, -4.0)), ((0.0, 0.0), (3.0, 1.0)), ((1.0, 0.0), (-1.0, 0.0))] {
            let (p, q) = (DVec2::from(p), DVec2::from(q));
            assert_ne!(orient(p, q), orient(q, p), "{p} {q}");
        }
    }
}
