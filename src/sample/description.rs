//! What the user wrote, as it was written: shapes, media by name, and where each stood.

use std::path::PathBuf;
use std::sync::Arc;

use glam::{DVec2, DVec3};

use super::mesh::Mesh;
use super::problem::{Place, Problem};
use super::relief::Relief;
use crate::media::Dispersion;
use crate::text::words;

/// A sample before it is checked and flattened.
#[derive(Clone, Debug)]
pub struct Description {
    /// File it came from.
    pub place: Place,
    /// All files it came from.
    pub files: Vec<PathBuf>,
    /// Name of the medium above.
    pub above: Named,
    /// Name of the medium below.
    pub below: Named,
    /// Footprint of the beam; around everything if not given.
    pub patch: Option<Patch>,
    /// What happens at the sides.
    pub sides: Sides,
    /// Media the file defines.
    pub media: Vec<Medium>,
    /// The bodies.
    pub objects: Vec<Object>,
}

/// A name in a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Named {
    /// The name.
    pub name: Arc<str>,
    /// Where it stands.
    pub place: Place,
}

/// A medium with a name.
#[derive(Clone, Debug, PartialEq)]
pub struct Medium {
    /// Its name.
    pub name: String,
    /// Its index.
    pub dispersion: Dispersion,
    /// Where it is defined.
    pub place: Place,
}

/// The rectangle through which light comes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch {
    /// Edge lengths, µm.
    pub size: DVec2,
    /// Centre, µm.
    pub center: DVec2,
}

/// What lies beside the patch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sides {
    /// The patch again, for ever.
    #[default]
    Periodic,
    /// Nothing: the sample stands alone.
    Open,
}

words!(Sides { Periodic = "periodic", Open = "open" });

/// A body, or a stack of films.
#[derive(Clone, Debug)]
pub struct Object {
    /// What people call it.
    pub name: Arc<str>,
    /// Its form and what it is made of.
    pub body: Body,
    /// Higher wins where solids overlap.
    pub priority: i32,
    /// Order among equal priorities: a core wins over the shell it lies in.
    pub nesting: u32,
    /// Where it is described.
    pub place: Place,
}

/// A body, or a stack of films.
#[derive(Clone, Debug)]
pub enum Body {
    /// One body.
    Solid(Shape, Fill),
    /// Plane-parallel, infinite films.
    Films {
        /// Height of the first interface, µm.
        top: f64,
        /// Medium and thickness in µm, from the top down.
        layers: Vec<(Named, f64)>,
    },
}

/// What a body is made of.
#[derive(Clone, Debug, PartialEq)]
pub enum Fill {
    /// A medium light can enter.
    Medium(Named),
    /// An opaque surface that reflects by Lambert's law.
    Diffuse(f64),
    /// An opaque surface that reflects this share like a mirror.
    Mirror(f64),
}

/// The form of a body.
#[derive(Clone, Debug)]
pub enum Shape {
    /// A ball.
    Sphere {
        /// Centre, µm.
        center: DVec3,
        /// Radius, µm.
        radius: f64,
    },
    /// A rod or fibre.
    Cylinder(Box<Fibre>),
    /// A box.
    Cuboid {
        /// Smallest coordinates, µm.
        min: DVec3,
        /// Largest coordinates, µm.
        max: DVec3,
    },
    /// A closed (or, if opaque, open) surface of triangles.
    Mesh(Mesh),
    /// A body under measured heights.
    Relief(Box<Relief>),
    /// An infinite plane-parallel body.
    Slab {
        /// Upper face, µm.
        top: f64,
        /// Lower face, µm.
        bottom: f64,
    },
}

/// A cylinder as people describe it.
#[derive(Clone, Debug, PartialEq)]
pub struct Fibre {
    /// Centre of the first end, µm.
    pub from: DVec3,
    /// Centre of the second end, µm.
    pub to: DVec3,
    /// Radius before flattening, µm.
    pub radius: f64,
    /// Radius of the lumen, µm, and what fills it.
    pub lumen: Option<(f64, Named)>,
    /// Direction of flattening and the ratio of thickness to width.
    pub flatten: Option<(DVec3, f64)>,
    /// Whether it ends at its ends, or goes on for ever.
    pub caps: bool,
}

impl From<Fibre> for Shape {
    fn from(fibre: Fibre) -> Self {
        Self::Cylinder(Box::new(fibre))
    }
}

impl Description {
    /// The footprint that is given or, where reliefs repeat, that of the first of them.
    pub fn footprint(&self) -> Option<Patch> {
        let first = self.reliefs().next().filter(|_| self.sides == Sides::Periodic);
        self.patch.or_else(|| first.map(|(_, r)| Patch { size: r.field.period(), center: r.center }))
    }

    /// All bodies with measured heights.
    pub(super) fn reliefs(&self) -> impl Iterator<Item = (&Object, &Relief)> {
        self.objects.iter().filter_map(|object| match &object.body {
            Body::Solid(Shape::Relief(relief), _) => Some((object, &**relief)),
            _ => None,
        })
    }

    /// What is no error, but may not be what was meant.
    pub fn remarks(&self) -> Vec<Problem> {
        let reliefs = self.reliefs().filter(|_| self.sides == Sides::Periodic);
        let seams = reliefs.filter_map(|(object, relief)| Some((object, relief.field.seams()?)));
        seams.map(|(object, seam)| object.place.problem(format!("`{}`: {seam}", object.name))).collect()
    }
}

impl Default for Description {
    /// Nothing in air, which repeats for ever.
    fn default() -> Self {
        let air = Named { name: "air".into(), place: Place::default() };
        Self {
            place: Place::default(),
            files: Vec::new(),
            above: air.clone(),
            below: air,
            patch: None,
            sides: Sides::default(),
            media: Vec::new(),
            objects: Vec::new(),
        }
    }
}
