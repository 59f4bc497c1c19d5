//! The sample as the tracer needs it: solids by number, media by number, primitives in one flat list, moved to
//! the origin and repeated as far as rays can see.

use std::sync::Arc;

use super::description::Description;
use super::groups::Groups;
use super::limits;
use super::media_list::{MediaList, MediumId, MediumTable};
use super::parts::Parts;
use super::problem::Problems;
use super::solid::{Matter, Solid};
use super::tiling::{Cell, Tiling};
use crate::geometry::{Aabb, PrimId, Primitives};
use crate::light::{Coherence, Wavelengths};

/// A checked sample.
#[derive(Clone, Debug)]
pub struct Sample {
    /// Media, each with a different table.
    pub media: Vec<MediumTable>,
    /// Solids, by owner number of the primitives.
    pub solids: Vec<Solid>,
    /// Solids that are told apart in the ledger.
    pub groups: Groups,
    /// Medium above everything.
    pub above: MediumId,
    /// Medium below everything.
    pub below: MediumId,
    /// Footprint of the beam and what lies beside it.
    pub cell: Cell,
    /// The geometry; the footprint's centre is at x = y = 0.
    pub primitives: Arc<Primitives>,
    /// Which primitives repeat which.
    pub tiling: Tiling,
    /// Bounds of all points a ray can reach, µm.
    pub domain: Aabb,
}

impl Sample {
    /// Checks and flattens a description for the wavelengths of the light, whose coherence says how far stacks of films
    /// can reach.
    ///
    /// # Errors
    /// Everything that is wrong.
    pub fn new(description: &Description, wavelengths: &Wavelengths, coherence: Coherence) -> Result<Self, Problems> {
        let mut problems = Problems::default();
        let mut media = MediaList::new(description, wavelengths);
        let above = media.resolve_above(&description.above, &mut problems);
        let below = media.resolve(&description.below, &mut problems);
        let mut parts = Parts::default();
        for object in &description.objects {
            parts.add(object, description, &mut media, &mut problems);
        }
        parts.add_half_space(description, above, below, &mut problems);
        limits::sizes(&parts.shapes, &parts.solids).into_iter().for_each(|p| problems.push(p));
        let cell = parts.cell(description, coherence, &mut problems);
        problems.or(())?;
        // What is missing has been reported.
        let (Some(above), Some(below), Some(mut cell)) = (above, below, cell) else { return Err(Problems::default()) };
        let (primitives, tiling) = parts.flatten(description, &mut cell)?;
        let domain = cell.domain(&primitives);
        let (media, solids, primitives) = (media.tables, parts.solids, Arc::new(primitives));
        let groups = Groups::new(&solids, &media);
        Ok(Self { media, solids, groups, above, below, cell, primitives, tiling, domain })
    }

    /// Whether light ends in, or at, some body.
    pub fn has_opaque(&self) -> bool {
        let opaque = |s: &Solid| match s.matter {
            Matter::Medium(id) => self.media[usize::from(id.0)].is_opaque(),
            Matter::Diffuse(_) | Matter::Mirror(_) => false,
        };
        self.has_opaque_surface() || self.solids.iter().any(opaque) || self.media[usize::from(self.below.0)].is_opaque()
    }

    /// Whether some body reflects by a rule of its own instead of by its medium.
    pub fn has_opaque_surface(&self) -> bool {
        self.solids.iter().any(|s| !matches!(s.matter, Matter::Medium(_)))
    }

    /// The repetition of a primitive that is `shift` periods away, if it is near enough to be there. Along an axis on which
    /// it has no end it is its own copy.
    pub fn copy(&self, prim: PrimId, shift: [i32; 2]) -> Option<PrimId> {
        let size = self.primitives.bounds(prim).size();
        let shift = [0, 1].map(|i| if size[i].is_finite() { shift[i] } else { 0 });
        if shift == [0, 0] { Some(prim) } else { self.tiling.neighbour(prim, shift) }
    }
}
