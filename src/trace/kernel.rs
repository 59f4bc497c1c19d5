//! What the tracer reads: shared by all workers, changed by none.

use glam::{DVec2, DVec3};

use super::finder::World;
use super::inside::Solids;
use super::media::Media;
use super::stream::{Border, Flight};
use crate::geometry::{Crossing, Order, Query, Ray, SurfaceId};
use crate::intersect::Scene;
use crate::light::Light;
use crate::plan::{Limits, Name, Plan};
use crate::sample::Sample;
use crate::sample::tiling::Cell;

/// Sample, scene and plan, with what rays need of them close together.
pub struct Kernel<'a> {
    pub(super) scene: &'a Scene,
    pub(super) sample: &'a Sample,
    pub(super) plan: &'a Plan,
    pub(super) solids: Solids,
    pub(super) media: Media,
    /// Surfaces of more than one face: leaving a body there may enter another.
    shared: Vec<bool>,
    /// At how many interfaces of a tree both branches are followed.
    pub(super) splits: u32,
    /// How far sideways a ray may get: in periods, or, in an open sample, µm from the centre.
    far: DVec2,
    /// Whether lengths are reported at exits, from which the phase follows.
    pub(super) follow_phase: bool,
}

/// Why a ray is not followed any further.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stop {
    /// It has walked out at the side.
    Side,
    /// The copy of the surface it starts on is missing.
    NoCopy,
}

impl<'a> Kernel<'a> {
    /// For a sample, the scene of its primitives, and the plan for it.
    pub fn new(sample: &'a Sample, scene: &'a Scene, plan: &'a Plan, light: &Light) -> Self {
        let wavelengths: Vec<f64> = light.wavelengths.um().collect();
        let media = Media::new(plan, &wavelengths);
        let (solids, shared) = (Solids::new(sample), shared_surfaces(scene));
        let far = plan.limits.walk * furthest(&sample.cell);
        let splits = plan.limits.splits.unwrap_or(Limits::USUAL_SPLITS);
        Self { scene, sample, plan, solids, media, shared, splits, far, follow_phase: plan.has(Name::Phase) }
    }

    /// The plan.
    pub fn plan(&self) -> &'a Plan {
        self.plan
    }

    /// What searches for films are asked of.
    pub(super) fn world(&self) -> World<'_> {
        World {
            sample: self.sample,
            scene: self.scene,
            solids: &self.solids,
            media: &self.media,
            probe: self.plan.films.probe,
            coherence: self.plan.films.coherence,
        }
    }

    /// Number of lanes.
    pub fn lanes(&self) -> usize {
        self.plan.lanes.len()
    }

    /// Media whose lengths are followed.
    pub(super) fn followed(&self) -> usize {
        if self.follow_phase { self.sample.media.len() } else { 0 }
    }

    /// How far a ray can go before it leaves the heights of the sample or reaches a seam, µm.
    pub(super) fn border(&self, ray: &Ray) -> (f64, Border) {
        let cell = &self.sample.cell;
        if !cell.periodic {
            return (f64::INFINITY, Border::Out);
        }
        let (low, high) = cell.heights;
        // Nobody can foretell where a ray goes, so all three are computed.
        let forward = ray.dir.cmpgt(DVec3::ZERO);
        let ends = DVec3::select(forward, cell.seam().extend(high), (-cell.seam()).extend(low));
        let t = DVec3::select(ray.dir.cmpeq(DVec3::ZERO), DVec3::INFINITY, (ends - ray.origin) / ray.dir);
        let t = [t.x, t.y, t.z];
        let seam = t[0].min(t[1]);
        if t[2] <= seam {
            return (t[2], Border::Out);
        }
        let back = |axis: usize| if ray.dir[axis] > 0.0 { -1 } else { 1 };
        (seam, Border::Seam(if t[0] <= t[1] { [back(0), 0] } else { [0, back(1)] }))
    }

    /// Where a ray leaves a convex body with nothing in it, if it is in one and leaves it within the seams.
    #[inline]
    pub(super) fn leave_lonely(&self, query: &Query, flight: &Flight) -> Option<(Order, Crossing)> {
        let solid = flight.inside.winner()?;
        let primitives = self.scene.primitives();
        if !self.solids.is_lonely(solid) || query.last == SurfaceId::NONE || primitives.owner(flight.at) != solid {
            return None;
        }
        let (order, crossing) = primitives.other_side(query, flight.at)?;
        if crossing.enters || self.shared[order.surface.0 as usize] {
            return None;
        }
        let cell = &self.sample.cell;
        let within = !cell.periodic || query.ray.at(order.t).truncate().abs().cmple(cell.seam()).all();
        within.then_some((order, crossing))
    }

    /// Moves a ray by whole periods if it starts beyond a seam (a stack of films can carry it there).
    ///
    /// # Errors
    /// When it cannot or need not be followed.
    #[inline(always)]
    pub(super) fn settle(&self, query: &mut Query, flight: &mut Flight) -> Result<(), Stop> {
        if self.sample.cell.is_beyond(query.ray.origin) {
            self.move_to_copy(query, flight).ok_or(Stop::NoCopy)?;
        }
        if self.walked_out(flight.walk, query.ray.origin) { Err(Stop::Side) } else { Ok(()) }
    }

    #[cold]
    fn move_to_copy(&self, query: &mut Query, flight: &mut Flight) -> Option<()> {
        let primitives = self.scene.primitives();
        let face = primitives.faces(flight.at).iter().position(|&s| s == query.last)?;
        let shift = self.sample.cell.shift_home(query.ray.origin);
        flight.at = self.sample.copy(flight.at, shift)?;
        flight.walk = [flight.walk[0] - shift[0], flight.walk[1] - shift[1]];
        let origin = query.ray.origin + self.sample.cell.offset(shift);
        *query = primitives.query_leaving(Ray { origin, ..query.ray }, primitives.faces(flight.at)[face]);
        Some(())
    }

    /// Whether a ray has gone so far sideways that its light counts as guided out of the sample.
    #[inline]
    pub(super) fn walked_out(&self, walk: [i32; 2], origin: DVec3) -> bool {
        if self.sample.cell.periodic {
            return (0..2).any(|axis| f64::from(walk[axis].abs()) > self.far[axis]);
        }
        (0..2).any(|axis| origin[axis].abs() > self.far[axis])
    }
}

/// The longer of footprint and height, for light that only crosses a high sample is not guided: in periods, or, in an
/// open sample, µm.
fn furthest(cell: &Cell) -> DVec2 {
    let longer = cell.size.max(DVec2::splat(cell.heights.1 - cell.heights.0));
    if cell.periodic { longer / cell.size } else { longer }
}

/// Which surfaces belong to more than one face.
fn shared_surfaces(scene: &Scene) -> Vec<bool> {
    let primitives = scene.primitives();
    let mut faces = vec![0u8; primitives.surface_count() + 1];
    for id in primitives.ids() {
        for surface in primitives.faces(id) {
            let n = &mut faces[surface.0 as usize];
            *n = n.saturating_add(1);
        }
    }
    faces.into_iter().map(|n| n > 1).collect()
}
