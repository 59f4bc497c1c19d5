//! Bodies and their shapes, before repetition.

use std::sync::Arc;

use glam::DVec3;

use super::media_list::MediumId;
use super::mesh::Mesh;
use super::problem::Place;
use super::relief::Wrap;
use crate::geometry::{self, Aabb, Cuboid, Cylinder, Layer, Sphere};

/// What a solid does to light that meets it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Matter {
    /// Light enters.
    Medium(MediumId),
    /// Lambert reflection of this share; the rest is absorbed.
    Diffuse(f64),
    /// Mirror reflection of this share; the rest is absorbed.
    Mirror(f64),
}

/// A body.
#[derive(Clone, Debug, PartialEq)]
pub struct Solid {
    /// What people call it.
    pub name: Arc<str>,
    /// Where it is described.
    pub place: Place,
    /// What it does to light.
    pub matter: Matter,
    /// Where solids overlap the greater wins: (priority, nesting).
    pub precedence: (i32, u32),
    /// Whether it has an inside; only opaque meshes may have none.
    pub closed: bool,
    /// Whether it is one convex primitive whose inside no other surface enters.
    pub lonely: bool,
}

/// A shape before repetition, with its owner.
#[derive(Clone, Debug)]
pub(super) enum Base {
    Triangles(Mesh),
    /// One period of a body without sides: the mesh has walls where the next begins, which light does not meet.
    Relief(Mesh, Wrap),
    Shape(geometry::Shape),
}

impl Base {
    /// The layer, if it is one.
    pub(super) fn layer(&self) -> Option<Layer> {
        if let Self::Shape(geometry::Shape::Layer(layer)) = self { Some(*layer) } else { None }
    }

    /// The closed surface, if it is one of triangles.
    pub(super) fn mesh(&self) -> Option<&Mesh> {
        match self {
            Self::Triangles(mesh) | Self::Relief(mesh, _) => Some(mesh),
            Self::Shape(_) => None,
        }
    }

    /// Bounds, µm; `None` for layers.
    pub(super) fn bounds(&self) -> Option<Aabb> {
        match self {
            Self::Triangles(mesh) | Self::Relief(mesh, _) => Some(mesh.bounds()),
            Self::Shape(geometry::Shape::Sphere(s)) => Some(s.bounds()),
            Self::Shape(geometry::Shape::Cylinder(c)) => Some(c.bounds()),
            Self::Shape(geometry::Shape::Cuboid(b)) => Some(b.bounds()),
            Self::Shape(geometry::Shape::Layer(_) | geometry::Shape::Triangle(_)) => None,
        }
    }

    pub(super) fn translate(&mut self, by: DVec3) {
        *self = match std::mem::replace(self, Self::Triangles(Mesh::default())) {
            Self::Triangles(mesh) => Self::Triangles(mesh.map(|p| p + by)),
            Self::Relief(mesh, wrap) => Self::Relief(mesh.map(|p| p + by), wrap),
            Self::Shape(shape) => Self::Shape(translated(shape, by)),
        };
    }

    /// Planes x = const and y = const among the faces: (axis, coordinate).
    pub(super) fn walls(&self) -> Vec<(usize, f64)> {
        match self {
            Self::Triangles(mesh) => {
                let corners = mesh.triangles.iter().map(|&t| mesh.corners(t));
                corners
                    .flat_map(|[a, b, c]| (0..2).filter(move |&i| a[i] == b[i] && b[i] == c[i]).map(move |i| (i, a[i])))
                    .collect()
            }
            Self::Shape(geometry::Shape::Cuboid(b)) => (0..2).flat_map(|i| [(i, b.min[i]), (i, b.max[i])]).collect(),
            Self::Shape(geometry::Shape::Cylinder(c)) if c.length.is_finite() => {
                let to = c.from + c.length * c.axis;
                (0..2).filter(|&i| c.axis[i].abs() > 0.999).flat_map(|i| [(i, c.from[i]), (i, to[i])]).collect()
            }
            Self::Relief(..) | Self::Shape(_) => Vec::new(),
        }
    }
}

pub(super) fn translated(shape: geometry::Shape, by: DVec3) -> geometry::Shape {
    use geometry::Shape as Flat;
    match shape {
        Flat::Sphere(s) => Flat::Sphere(Sphere { center: s.center + by, ..s }),
        Flat::Cylinder(c) => Flat::Cylinder(Cylinder { from: c.from + by, ..c }),
        Flat::Cuboid(b) => Flat::Cuboid(Cuboid { min: b.min + by, max: b.max + by }),
        Flat::Layer(l) => Flat::Layer(Layer { bottom: l.bottom + by.z, top: l.top + by.z }),
        Flat::Triangle(t) => Flat::Triangle(t),
    }
}
