//! Samples made by rule: each a `[[generate]]` kind of the sample file and a `generate` sub-command.
//!
//! To add one: a file with its parameters and the objects they make, and an arm in [`Generate`]; the command line needs
//! the names of its keys only, as it writes the same table.

pub mod bricks;
pub mod common;
pub mod export;
pub mod flakes;
pub mod insertion;
pub mod mosaic;
pub mod packing;
mod prism;
pub mod rough;
pub mod sizes;
pub mod web;

use glam::DVec2;

use super::description::{Object, Patch, Sides};
use super::problem::suggestion;
use super::reader::Table;
use crate::units::{show_length, significant};
use bricks::Bricks;
use common::Setting;
use flakes::Flakes;
use mosaic::Mosaic;
use packing::SpherePacking;
use rough::RoughSurface;
use web::Web;

/// A `[[generate]]` table.
#[derive(Clone, Debug)]
pub enum Generate {
    /// Interlocking bricks with cores.
    Bricks(Bricks),
    /// Spheres by random insertion.
    Packing(SpherePacking),
    /// Fibres of paper.
    Web(Web),
    /// Flakes of an effect pigment.
    Flakes(Flakes),
    /// Layers of unequal platelets.
    Mosaic(Mosaic),
    /// A random rough surface.
    Rough(RoughSurface),
}

const KINDS: [&str; 6] = ["bricks", "packing", "web", "flakes", "mosaic", "rough"];

impl Generate {
    /// Reads the table; `None` if something is wrong, which has been noted.
    pub fn read(t: &Table<'_>, setting: Setting) -> Option<Self> {
        let made = match t.text("kind").or_else(|| t.missing_if_absent("kind", "\"bricks\"")) {
            Some("bricks") => Bricks::read(t).map(Self::Bricks),
            Some("packing") => SpherePacking::read(t, setting).map(Self::Packing),
            Some("flakes") => Flakes::read(t, setting).map(Self::Flakes),
            Some("mosaic") => Mosaic::read(t, setting).map(Self::Mosaic),
            Some("rough") => RoughSurface::read(t).map(Self::Rough),
            Some("web") => Web::read(t, setting).map(Self::Web),
            unknown => {
                if let Some(other) = unknown {
                    let hint = suggestion(other, KINDS);
                    t.complain(format!("unknown kind `{other}`{hint}; known: {}", KINDS.join(", ")));
                }
                t.accept_all_keys();
                None
            }
        }?;
        made.check_patch(setting).map_err(|why| t.complain(why)).ok()?;
        Some(made)
    }

    /// Whether it fits into the footprint of the file, if it repeats with that.
    fn check_patch(&self, setting: Setting) -> Result<(), String> {
        let repeats = setting.periodic
            && match self {
                Self::Bricks(_) | Self::Mosaic(_) | Self::Rough(_) => true,
                Self::Packing(p) => p.common.periodic,
                Self::Web(w) => w.common.periodic,
                Self::Flakes(f) => f.common.periodic,
            };
        let Some((file, own)) = setting.patch.zip(self.patch()).filter(|_| repeats) else { return Ok(()) };
        if own.size.cmple(file.size * (1.0 + 1e-9)).all() {
            return Ok(());
        }
        let [own, file] = [own, file].map(|p| p.size.to_array().map(show_length).join(" x "));
        Err(format!(
            "what is made here repeats every {own}, and the sample every {file}: leave the patch's size out, or give both \
             the same"
        ))
    }

    /// The footprint that goes with it, if the sample file gives none.
    pub fn patch(&self) -> Option<Patch> {
        let size = match self {
            Self::Bricks(b) => DVec2::from_array(b.patch()),
            Self::Packing(p) => p.slab.size.truncate(),
            Self::Web(w) => w.size,
            Self::Flakes(f) => f.slab.size.truncate(),
            Self::Mosaic(m) => DVec2::from_array(m.patch()),
            Self::Rough(r) => r.rough.size,
        };
        Some(Patch { size, center: DVec2::ZERO })
    }

    /// What it is and on which patch, in a line.
    pub fn title(&self, sides: Sides) -> String {
        let what = match self {
            Self::Bricks(b) => b.title(),
            Self::Packing(p) => p.title(),
            Self::Web(w) => w.title(),
            Self::Flakes(f) => f.title(),
            Self::Mosaic(m) => m.title(),
            Self::Rough(r) => r.title(),
        };
        let [w, d] = self.patch().map_or([0.0; 2], |p| p.size.to_array()).map(|x| significant(x, 9));
        format!("{what}; {sides} patch {w} x {d} um")
    }

    /// What it makes; problems are noted at the table.
    pub fn objects(&self, t: &Table<'_>) -> Option<Vec<Object>> {
        match self {
            Self::Bricks(b) => Some(b.objects(t.place())),
            Self::Packing(p) => p.objects(t.place()).map_err(|e| t.complain(e.to_string())).ok(),
            Self::Flakes(f) => f.objects(t.place()).map_err(|e| t.complain(e.to_string())).ok(),
            Self::Mosaic(m) => Some(m.objects(t.place())),
            Self::Web(w) => w.objects(t.place()).map_err(|e| t.complain(e)).ok(),
            Self::Rough(r) => r.objects(t.place()).map_err(|e| t.complain(e)).ok(),
        }
    }
}
