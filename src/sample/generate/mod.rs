//! Samples made by rule: each a `[[generate]]` kind of the sample file and a `generate` sub-command.
//!
//! To add one: a file with its parameters and the objects they make, and an arm in [`Generate`].

pub mod bricks;
pub mod packing;
pub mod rough;

use glam::DVec2;

use super::description::{Object, Patch};
use super::problem::suggestion;
use super::reader::Table;
use bricks::Bricks;
use packing::SpherePacking;
use rough::RoughSurface;

/// A `[[generate]]` table.
#[derive(Clone, Debug)]
pub enum Generate {
    /// Interlocking bricks with cores.
    Bricks(Bricks),
    /// Spheres by random insertion.
    Packing(SpherePacking),
    /// A random rough surface.
    Rough(RoughSurface),
}

const KINDS: [&str; 3] = ["bricks", "packing", "rough"];

impl Generate {
    /// Reads the table; `None` if something is wrong, which has been noted.
    pub fn read(t: &Table<'_>) -> Option<Self> {
        match t.text("kind").or_else(|| t.missing_if_absent("kind", "\"bricks\"")) {
            Some("bricks") => return Bricks::read(t).map(Self::Bricks),
            Some("packing") => return SpherePacking::read(t).map(Self::Packing),
            Some("rough") => return RoughSurface::read(t).map(Self::Rough),
            Some(other) => {
                let hint = suggestion(other, KINDS);
                t.complain(format!("unknown kind `{other}`{hint}; known: {}", KINDS.join(", ")));
            }
            None => {}
        }
        t.accept_all_keys();
        None
    }

    /// The footprint that goes with it, if the sample file gives none.
    pub fn patch(&self) -> Option<Patch> {
        let size = match self {
            Self::Bricks(b) => DVec2::from_array(b.patch()),
            Self::Packing(p) => p.packing.size.truncate(),
            Self::Rough(r) => r.rough.size,
        };
        Some(Patch { size, center: DVec2::ZERO })
    }

    /// What it makes; problems are noted at the table.
    pub fn objects(&self, t: &Table<'_>) -> Option<Vec<Object>> {
        match self {
            Self::Bricks(b) => Some(b.objects(t.place())),
            Self::Packing(p) => p.objects(t.place()).map_err(|e| t.complain(e.to_string())).ok(),
            Self::Rough(r) => r.objects(t.place()).map_err(|e| t.complain(e)).ok(),
        }
    }
}
