//! Convex bodies, and a point that two of them have in common.
//!
//! The search is that of Gilbert, Johnson and Keerthi, IEEE J. Robotics and Automation 4, 193 (1988): it needs of
//! a body only the point farthest in a direction. Every answer is checked, so rounding can hide an overlap that is
//! hardly there, but not invent one.

use glam::DVec3;

use crate::geometry::{Aabb, Cuboid, Cylinder, Shape, Sphere};

/// A convex body.
#[derive(Clone, Copy, Debug)]
pub(super) enum Convex<'a> {
    Sphere(Sphere),
    Cylinder(Cylinder),
    Cuboid(Cuboid),
    Triangle([DVec3; 3]),
    /// What spans some points, moved and scaled about its centre.
    Hull {
        corners: &'a [DVec3],
        center: DVec3,
        offset: DVec3,
        scale: f64,
    },
}

impl<'a> Convex<'a> {
    /// Of a shape with bounds that is no triangle.
    pub fn of(shape: &Shape) -> Option<Self> {
        match *shape {
            Shape::Sphere(s) => Some(Self::Sphere(s)),
            Shape::Cylinder(c) => Some(Self::Cylinder(c)),
            Shape::Cuboid(b) => Some(Self::Cuboid(b)),
            Shape::Triangle(_) | Shape::Layer(_) => None,
        }
    }

    /// The same body `by` µm elsewhere.
    pub fn translated(self, by: DVec3) -> Self {
        match self {
            Self::Sphere(s) => Self::Sphere(Sphere { center: s.center + by, ..s }),
            Self::Cylinder(c) => Self::Cylinder(Cylinder { from: c.from + by, ..c }),
            Self::Cuboid(b) => Self::Cuboid(Cuboid { min: b.min + by, max: b.max + by }),
            Self::Triangle(t) => Self::Triangle(t.map(|p| p + by)),
            Self::Hull { corners, center, offset, scale } => Self::Hull { corners, center, offset: offset + by, scale },
        }
    }

    /// The points at least `depth` µm inside; `None` if there are none. Triangles and hulls stay.
    pub fn shrunk(self, depth: f64) -> Option<Self> {
        match self {
            Self::Sphere(s) => (s.radius > depth).then_some(Self::Sphere(Sphere { radius: s.radius - depth, ..s })),
            Self::Cylinder(c) => (c.radii[0].min(c.radii[1]).min(0.5 * c.length) > depth).then(|| {
                let (from, length) = (c.from + depth * c.axis, c.length - 2.0 * depth);
                Self::Cylinder(Cylinder { from, length, radii: c.radii.map(|r| r - depth), ..c })
            }),
            Self::Cuboid(b) => {
                let (min, max) = (b.min + depth, b.max - depth);
                min.cmplt(max).all().then_some(Self::Cuboid(Cuboid { min, max }))
            }
            Self::Triangle(_) | Self::Hull { .. } => Some(self),
        }
    }

    /// Whether `p` lies in the body or on its border. Triangles and hulls are asked for their own points.
    pub fn contains(&self, p: DVec3) -> bool {
        match self {
            Self::Sphere(s) => p.distance_squared(s.center) <= s.radius * s.radius,
            Self::Cylinder(c) => {
                let along = (p - c.from).dot(c.axis);
                c.inside_mantle(p) && (0.0..=c.length).contains(&along)
            }
            Self::Cuboid(b) => b.bounds().contains(p),
            Self::Triangle(_) | Self::Hull { .. } => true,
        }
    }

    /// A point well inside.
    pub fn center(&self) -> DVec3 {
        match self {
            Self::Sphere(s) => s.center,
            Self::Cylinder(c) => c.from + 0.5 * c.length * c.axis,
            Self::Cuboid(b) => b.bounds().center(),
            Self::Triangle([a, b, c]) => (*a + *b + *c) / 3.0,
            Self::Hull { center, offset, .. } => *center + *offset,
        }
    }

    /// The part of an endless cylinder that can meet a body around `bounds`.
    pub fn clipped(self, bounds: Aabb) -> Self {
        match self {
            Self::Cylinder(c) if !c.length.is_finite() => {
                let half = 0.5 * bounds.size().length() + c.radii[0].max(c.radii[1]);
                let middle = c.from + (bounds.center() - c.from).dot(c.axis) * c.axis;
                Self::Cylinder(Cylinder { from: middle - half * c.axis, length: 2.0 * half, ..c })
            }
            other => other,
        }
    }

    /// The point farthest along `d`.
    pub fn farthest(&self, d: DVec3) -> DVec3 {
        match self {
            Self::Sphere(s) => s.center + s.radius * d.normalize_or_zero(),
            Self::Cylinder(c) => {
                let (v, [a, b]) = (c.v(), c.radii);
                let (x, y) = (a * d.dot(c.u), b * d.dot(v));
                let rim = x.hypot(y);
                let across = if rim > 0.0 { (a * x * c.u + b * y * v) / rim } else { DVec3::ZERO };
                c.from + across + if d.dot(c.axis) > 0.0 { c.length } else { 0.0 } * c.axis
            }
            Self::Cuboid(b) => DVec3::select(d.cmpgt(DVec3::ZERO), b.max, b.min),
            Self::Triangle([a, b, c]) => {
                let further = |p: DVec3, q: DVec3| if q.dot(d) > p.dot(d) { q } else { p };
                further(further(*a, *b), *c)
            }
            Self::Hull { corners, center, offset, scale } => {
                let further = |p: DVec3, q: &DVec3| if q.dot(d) > p.dot(d) { *q } else { p };
                let corner = corners.iter().fold(corners[0], further);
                center.lerp(corner, *scale) + offset
            }
        }
    }
}

/// A point at least `depth` µm inside both bodies, if one is found.
pub(super) fn common_point(a: &Convex<'_>, b: &Convex<'_>, depth: f64) -> Option<DVec3> {
    if let (Convex::Sphere(s), Convex::Sphere(t)) = (a, b)
        && s.center.distance(t.center) >= s.radius + t.radius - 2.0 * depth
    {
        return None;
    }
    // Near the origin nothing is lost to rounding.
    let origin = a.center();
    let [near_a, near_b] = [a, b].map(|body| body.translated(-origin));
    // The search ends on the border of what it searches; so it is told to go a little deeper.
    let p = search(&near_a.shrunk(1.5 * depth)?, &near_b.shrunk(1.5 * depth)?)?;
    let deep = |body: Convex<'_>| body.shrunk(depth).is_some_and(|inner| inner.contains(p));
    (deep(near_a) && deep(near_b)).then_some(p + origin)
}

/// Steps after which bodies count as apart: curved ones that hardly touch need about 30.
const MOST_STEPS: usize = 64;

/// A point of both bodies, or `None` if a plane parts them (or hardly any point is in both).
fn search(a: &Convex<'_>, b: &Convex<'_>) -> Option<DVec3> {
    let mut corners = Simplex::default();
    let mut toward = b.center() - a.center();
    if toward == DVec3::ZERO {
        return Some(a.center());
    }
    for _ in 0..MOST_STEPS {
        let on_a = a.farthest(toward);
        let difference = on_a - b.farthest(-toward);
        if difference.dot(toward) <= 0.0 {
            return None;
        }
        corners.add(Corner { difference, on_a });
        let nearest = corners.reduce();
        if nearest.length_squared() <= 1e-30 * corners.extent_squared() {
            return Some(corners.point_on_a());
        }
        toward = -nearest;
    }
    None
}

/// A point of the difference of two bodies, and the point of the first it comes from.
#[derive(Clone, Copy, Debug, Default)]
struct Corner {
    difference: DVec3,
    on_a: DVec3,
}

/// Up to four corners with the weights of the point nearest to the origin.
#[derive(Clone, Debug, Default)]
struct Simplex {
    corners: [Corner; 4],
    weights: [f64; 4],
    len: usize,
}

impl Simplex {
    fn add(&mut self, corner: Corner) {
        // Four corners are left only when they enclose the origin, which ends the search.
        let at = self.len.min(3);
        self.corners[at] = corner;
        self.len = at + 1;
    }

    /// Leaves only the corners of the face that is nearest to the origin; the nearest point.
    fn reduce(&mut self) -> DVec3 {
        let mut best: Option<(f64, DVec3, usize, [f64; 4])> = None;
        for mask in 1..1_usize << self.len {
            let Some(weights) = self.weights_of(mask) else { continue };
            let point = (0..self.len).map(|i| weights[i] * self.corners[i].difference).sum::<DVec3>();
            let distance = if mask.count_ones() == 4 { 0.0 } else { point.length_squared() };
            if best.is_none_or(|(least, ..)| distance < least) {
                best = Some((distance, if distance == 0.0 { DVec3::ZERO } else { point }, mask, weights));
            }
        }
        // A single corner always has a weight.
        let (_, point, mask, weights) = best.unwrap_or((0.0, DVec3::ZERO, 1, [1.0, 0.0, 0.0, 0.0]));
        let kept: Vec<usize> = (0..self.len).filter(|i| mask >> i & 1 == 1).collect();
        for (to, &from) in kept.iter().enumerate() {
            self.corners[to] = self.corners[from];
            self.weights[to] = weights[from];
        }
        self.len = kept.len();
        point
    }

    /// Weights of the point nearest to the origin on the plane (line, point, space) of some corners; `None` if it
    /// lies outside of them.
    fn weights_of(&self, mask: usize) -> Option<[f64; 4]> {
        let chosen: Vec<usize> = (0..self.len).filter(|i| mask >> i & 1 == 1).collect();
        let base = self.corners[chosen[0]].difference;
        let edge = |k: usize| self.corners[chosen[k]].difference - base;
        let along: [f64; 3] = match chosen.len() {
            1 => [0.0; 3],
            2 => [-base.dot(edge(1)) / edge(1).length_squared(), 0.0, 0.0],
            3 => {
                let n = edge(1).cross(edge(2));
                let per = 1.0 / n.length_squared();
                [-base.cross(edge(2)).dot(n) * per, base.cross(edge(1)).dot(n) * per, 0.0]
            }
            _ => {
                let per = -1.0 / edge(1).dot(edge(2).cross(edge(3)));
                let with = |p: DVec3, q: DVec3, r: DVec3| p.dot(q.cross(r)) * per;
                [with(base, edge(2), edge(3)), with(edge(1), base, edge(3)), with(edge(1), edge(2), base)]
            }
        };
        let first = 1.0 - along.iter().sum::<f64>();
        let mut weights = [0.0; 4];
        for (k, &i) in chosen.iter().enumerate() {
            weights[i] = if k == 0 { first } else { along[k - 1] };
        }
        // False as well for corners that span no plane.
        weights.iter().all(|w| *w >= 0.0).then_some(weights)
    }

    fn extent_squared(&self) -> f64 {
        self.corners[..self.len].iter().map(|c| c.difference.length_squared()).fold(0.0, f64::max)
    }

    fn point_on_a(&self) -> DVec3 {
        (0..self.len).map(|i| self.weights[i] * self.corners[i].on_a).sum()
    }
}
