//! What double precision and the memory can hold: beyond it there is a message instead of a wrong result or an abort.

use super::problem::Problem;
use super::reader::LARGEST;
use super::solid::{Base, Solid};
use super::tiling::Cell;
use crate::geometry::{Aabb, COINCIDENT, Shape};

/// Largest number of primitives, repetitions included: some ten gigabytes.
pub(super) const MOST_PRIMITIVES: usize = 20_000_000;

/// Whether a number of primitives is more than can be held, and what to do then.
///
/// # Errors
/// The message.
pub(super) fn check_count(count: f64) -> Result<(), String> {
    if count <= MOST_PRIMITIVES as f64 {
        return Ok(());
    }
    Err(format!(
        "about {count:.1e} primitives with their repetitions: at most {MOST_PRIMITIVES} are taken; enlarge the patch, \
         use fewer bodies or coarser meshes"
    ))
}

/// Thinnest extent that is told from nothing, µm, in a sample that reaches so far from the origin, µm.
///
/// Coordinates are rounded to 2⁻⁵³ of their size; with 2⁻⁴⁰ a thickness is still good to a ten-thousandth. And faces
/// closer than [`COINCIDENT`] are one.
fn smallest(reach: f64) -> f64 {
    (100.0 * COINCIDENT).max(reach * 2.0_f64.powi(-40))
}

/// Bodies too thin or too large, in the user's coordinates.
pub(super) fn sizes(shapes: &[(Base, u32)], solids: &[Solid]) -> Vec<Problem> {
    let reaches: Vec<f64> = shapes.iter().map(|(base, _)| reach(base)).collect();
    let smallest = smallest(reaches.iter().copied().filter(|r| *r <= 2.0 * LARGEST).fold(0.0, f64::max));
    let wrong = |((base, owner), reach): (&(Base, u32), &f64)| {
        let solid = &solids[*owner as usize];
        let thin = thickness(base);
        let message = if reach.is_nan() || *reach > 2.0 * LARGEST {
            format!("reaches {reach:.3e} µm from the origin: at most 20 m is taken; is the unit right?")
        } else if solid.closed && (thin.is_nan() || thin < smallest) {
            format!(
                "is only {thin:.3e} µm thick: expected at least {smallest:.1e} µm in a sample of this extent; \
                 is the unit right?"
            )
        } else {
            return None;
        };
        Some(solid.place.problem(format!("`{}` {message}", solid.name)))
    };
    shapes.iter().zip(&reaches).filter_map(wrong).collect()
}

/// Whether the footprint is wide enough for its repetitions to be told apart.
///
/// # Errors
/// The message.
pub(super) fn check_patch(cell: &Cell) -> Result<(), String> {
    let center = cell.center.abs().max_element();
    let smallest = smallest(cell.size.max_element().max(center));
    if cell.size.min_element() >= smallest {
        return Ok(());
    }
    let [x, y] = cell.size.to_array();
    Err(format!("the patch is {x:.3e} x {y:.3e} µm: expected at least {smallest:.1e} µm across; is the unit right?"))
}

/// Primitives that a sample becomes, repetitions included; of large meshes those outside the zone count as well.
pub(super) fn primitives(shapes: &[(Base, u32)], cell: &Cell, zone: Aabb) -> f64 {
    shapes.iter().map(|(base, _)| cell.copies(base.bounds(), zone)).sum()
}

/// Largest coordinate, µm; endless extents do not count, what is no number does.
fn reach(base: &Base) -> f64 {
    let ends = |ends: &[f64]| ends.iter().filter(|x| !x.is_infinite()).fold(0.0, farther);
    match base {
        // A mesh has no endless extents: what is infinite there is an overflow.
        Base::Triangles(mesh) | Base::Relief(mesh, _) => {
            mesh.vertices.iter().flat_map(|v| v.to_array()).fold(0.0, |far, x| farther(far, &x))
        }
        Base::Shape(Shape::Layer(l)) => ends(&[l.bottom, l.top]),
        Base::Shape(_) => base.bounds().map_or(0.0, |b| ends(&[b.min, b.max].map(|p| p.to_array()).concat())),
    }
}

/// The larger size of both, or no number if one is none.
fn farther(far: f64, x: &f64) -> f64 {
    if x.abs() <= far || far.is_nan() { far } else { x.abs() }
}

/// Smallest extent, µm.
fn thickness(base: &Base) -> f64 {
    match base {
        Base::Triangles(mesh) | Base::Relief(mesh, _) => mesh.bounds().size().min_element(),
        Base::Shape(Shape::Sphere(s)) => 2.0 * s.radius,
        Base::Shape(Shape::Cylinder(c)) => c.length.min(2.0 * c.radii[0].min(c.radii[1])),
        Base::Shape(Shape::Cuboid(b)) => b.bounds().size().min_element(),
        Base::Shape(Shape::Layer(l)) => l.top - l.bottom,
        Base::Shape(Shape::Triangle(_)) => f64::INFINITY,
    }
}
