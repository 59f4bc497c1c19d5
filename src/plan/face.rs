//! Faces of primitives, and which of them are parallel.

use std::ops::Deref;

use glam::{DVec2, DVec3};

use crate::geometry::{Aabb, Cuboid, Cylinder, Layer, PrimId, Primitives, Shape, Sphere, SurfaceId};

/// Cosine of the largest angle between the faces of a film: 1e-3 rad.
pub const PARALLEL: f64 = 1.0 - 0.5e-6;
/// The same angle, radians.
pub const TILT: f64 = 1e-3;

/// A face; its form is looked up when it is asked for, for a sample has millions.
#[derive(Clone, Copy)]
pub struct Face<'p> {
    primitives: &'p Primitives,
    /// Its primitive.
    pub prim: PrimId,
    /// Its number there.
    pub number: u8,
    surface: SurfaceId,
}

enum Form {
    Planar {
        normal: DVec3,
        outline: Outline,
    },
    /// z = height, everywhere.
    Level(f64),
    Sphere(Sphere),
    Mantle(Cylinder),
}

impl Form {
    /// How far one can go on a curved face until its normal has turned by the allowed tilt, µm.
    fn flat_spot(&self) -> f64 {
        match self {
            Self::Sphere(s) => TILT * s.radius,
            Self::Mantle(c) => TILT * c.radii[0].max(c.radii[1]).powi(2) / c.radii[0].min(c.radii[1]),
            _ => 0.0,
        }
    }
}

/// The corners of a convex face.
#[derive(Clone, Copy)]
enum Outline {
    Triangle([DVec3; 3]),
    Rectangle([DVec3; 4]),
}

impl Deref for Outline {
    type Target = [DVec3];

    fn deref(&self) -> &[DVec3] {
        match self {
            Self::Triangle(corners) => corners,
            Self::Rectangle(corners) => corners,
        }
    }
}

/// The faces of a primitive.
pub fn faces(primitives: &Primitives, prim: PrimId) -> impl Iterator<Item = Face<'_>> {
    let surfaces = primitives.faces(prim).iter().enumerate().filter(|(_, surface)| **surface != SurfaceId::NONE);
    surfaces.map(move |(number, &surface)| Face { primitives, prim, number: number as u8, surface })
}

/// The rectangle around an elliptic end.
fn end(c: &Cylinder, number: u8) -> Outline {
    let center = if number == Cylinder::FIRST_END { c.from } else { c.from + c.length * c.axis };
    let (a, b) = (c.radii[0] * c.u, c.radii[1] * c.v());
    Outline::Rectangle([center - a - b, center + a - b, center + a + b, center - a + b])
}

fn rectangle(b: &Cuboid, number: u8) -> Outline {
    let axis = usize::from(number / 2);
    let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
    let corner = |p: DVec3, q: DVec3| {
        let mut c = b.corner(number);
        (c[i], c[j]) = (p[i], q[j]);
        c
    };
    Outline::Rectangle([corner(b.min, b.min), corner(b.max, b.min), corner(b.max, b.max), corner(b.min, b.max)])
}

impl Face<'_> {
    fn form(&self) -> Form {
        let Self { primitives, prim, number, surface } = *self;
        let planar = |outline| {
            let normal = primitives.plane(surface).map_or(DVec3::Z, |p| p.normal);
            Form::Planar { normal, outline }
        };
        match primitives.shape(prim) {
            Shape::Triangle(t) => planar(Outline::Triangle(primitives.corners(t))),
            Shape::Sphere(s) => Form::Sphere(s),
            Shape::Cylinder(c) if number == Cylinder::MANTLE => Form::Mantle(c),
            Shape::Cylinder(c) => planar(end(&c, number)),
            Shape::Cuboid(b) => planar(rectangle(&b, number)),
            Shape::Layer(l) => Form::Level(if number == Layer::TOP { l.top } else { l.bottom }),
        }
    }

    /// Bounds of everything that could be parallel to it: what lies within `reach` along the normal on either
    /// side, or, for a strongly curved face, what could share its centre.
    pub fn seen(&self, reach: f64, wavelength: f64) -> Aabb {
        let form = self.form();
        match &form {
            Form::Planar { normal, outline } => {
                let (b, along) = (Aabb::around(outline.iter().copied()), (reach * *normal).abs());
                Aabb { min: b.min - along, max: b.max + along }
            }
            Form::Level(z) => {
                Aabb { min: DVec3::NEG_INFINITY.with_z(z - reach), max: DVec3::INFINITY.with_z(z + reach) }
            }
            Form::Sphere(s) if form.flat_spot() < wavelength => Aabb::around([s.center]),
            Form::Sphere(s) => s.bounds().inflate(reach),
            Form::Mantle(c) if form.flat_spot() < wavelength && c.length.is_finite() => {
                Aabb::around([c.from, c.from + c.length * c.axis])
            }
            Form::Mantle(c) => c.bounds().inflate(reach),
        }
    }

    pub fn may_face_a_level(&self, wavelength: f64) -> bool {
        let form = self.form();
        matches!(&form, Form::Planar { normal, .. } if normal.z.abs() >= PARALLEL) || form.flat_spot() >= wavelength
    }

    /// The normal of a plane face.
    pub fn normal(&self) -> Option<DVec3> {
        self.primitives.plane(self.surface).map(|plane| plane.normal)
    }

    /// Whether light that meets this face may meet the other as the next of a stack.
    pub fn parallel_to(&self, other: &Self, reach: f64, wavelength: f64) -> bool {
        if self.surface == other.surface {
            return false;
        }
        let forms = (self.form(), other.form());
        match (&forms.0, &forms.1) {
            (Form::Planar { normal, outline }, Form::Planar { normal: n, outline: o }) => {
                normal.dot(*n).abs() >= PARALLEL
                    && gap(*normal, outline, o) <= reach
                    && outlines_overlap(*normal, outline, o)
            }
            (Form::Planar { normal, outline }, Form::Level(z)) | (Form::Level(z), Form::Planar { normal, outline }) => {
                normal.z.abs() >= PARALLEL && outline.iter().any(|p| (p.z - z).abs() <= reach)
            }
            (Form::Level(a), Form::Level(b)) => (a - b).abs() <= reach,
            (Form::Sphere(a), Form::Sphere(b)) => {
                let concentric = a.center.distance(b.center) <= TILT * a.radius.min(b.radius);
                concentric && (a.radius - b.radius).abs() <= reach
            }
            (Form::Mantle(a), Form::Mantle(b)) => coaxial(a, b, reach),
            (form, other_form) => {
                self.prim != other.prim
                    && form.flat_spot().max(other_form.flat_spot()) >= wavelength
                    && self.is_near(other, reach)
            }
        }
    }

    /// The radius of a curved face (the first of a flattened one), µm.
    pub fn radius(&self) -> Option<f64> {
        match self.form() {
            Form::Sphere(s) => Some(s.radius),
            Form::Mantle(c) => Some(c.radii[0]),
            _ => None,
        }
    }

    fn is_near(&self, other: &Self, reach: f64) -> bool {
        self.seen(reach, 0.0).overlaps(other.seen(0.0, 0.0))
    }
}

/// Smallest distance of two nearly parallel faces along the normal of the first, µm.
fn gap(normal: DVec3, a: &[DVec3], b: &[DVec3]) -> f64 {
    let range = |points: &[DVec3]| {
        let heights = points.iter().map(|p| normal.dot(*p));
        heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), h| (low.min(h), high.max(h)))
    };
    let (a, b) = (range(a), range(b));
    (a.0 - b.1).max(b.0 - a.1).max(0.0)
}

/// Whether two convex outlines overlap when seen along `normal`: by separating axes. Touching does not count.
fn outlines_overlap<'a>(normal: DVec3, a: &'a [DVec3], b: &'a [DVec3]) -> bool {
    let (u, v) = normal.any_orthonormal_pair();
    let flat = |p: DVec3| DVec2::new(p.dot(u), p.dot(v));
    let separates = |axis: DVec2| {
        let range = |points: &[DVec3]| {
            let along = points.iter().map(|&p| flat(p).dot(axis));
            along.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
        };
        let (x, y) = (range(a), range(b));
        let slack = 1e-12 * (x.1 - x.0 + y.1 - y.0);
        x.1 <= y.0 + slack || y.1 <= x.0 + slack
    };
    let axes = |p: &'a [DVec3]| (0..p.len()).map(move |i| flat(p[(i + 1) % p.len()] - p[i]).perp());
    !axes(a).chain(axes(b)).any(separates)
}

/// Whether two mantles are shells of one another.
fn coaxial(a: &Cylinder, b: &Cylinder, reach: f64) -> bool {
    let between = b.from - a.from;
    let off_axis = (between - between.dot(a.axis) * a.axis).length();
    let smallest = a.radii.iter().chain(&b.radii).copied().fold(f64::INFINITY, f64::min);
    let across = |c: &Cylinder, along: DVec3| {
        // Half the width of the mantle along a direction.
        (c.radii[0] * c.u.dot(along)).hypot(c.radii[1] * c.v().dot(along))
    };
    let near = [a.u, a.v()].into_iter().any(|d| (across(a, d) - across(b, d)).abs() <= reach);
    a.axis.dot(b.axis).abs() >= PARALLEL && off_axis <= TILT * smallest && near
}
