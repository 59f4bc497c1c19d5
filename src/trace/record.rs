//! What the tracer tells, and to whom: it does not know who listens.

use glam::DVec3;

use super::stream::{Slot, Stream};
use crate::geometry::Query;
use crate::optics::field::Field;

/// Where power went that left nobody: each kind is its own entry of the energy ledger.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Loss {
    /// The record of media contradicted itself.
    Medium,
    /// More interfaces were met than the plan allows.
    Depth,
    /// Numbers failed: more faces coincide than can be told apart, or a copy of the sample is missing.
    Numeric,
}

impl Loss {
    /// All kinds.
    pub const ALL: [Self; 3] = [Self::Medium, Self::Depth, Self::Numeric];
}

/// A ray that leaves the sample.
pub struct Exit<'a, F> {
    /// Number of its tree in the chunk.
    pub tree: u32,
    /// Direction, sample frame.
    pub dir: DVec3,
    /// x̂ of the frame of the fields.
    pub frame: DVec3,
    /// Its last place in the sample, µm; copies of a periodic sample count as one long sample.
    pub position: DVec3,
    /// Where its tree entered, µm.
    pub anchor: DVec3,
    pub(super) slot: Slot,
    pub(super) stream: &'a Stream<F>,
}

impl<F: Field> Exit<'_, F> {
    /// Its lanes with their fields.
    #[inline]
    pub fn loads(&self) -> impl Iterator<Item = (u16, F)> + use<'_, F> {
        self.stream.loads(self.slot)
    }

    /// Geometric length per medium from the anchor to the last place, µm; empty if phase is not followed.
    pub fn lengths(&self) -> &[f64] {
        self.stream.lengths(self.slot)
    }
}

/// Listens to the tracer; what it does not care for passes it by.
pub trait Recorder<F> {
    /// A ray left upwards or downwards.
    fn exit(&mut self, exit: &Exit<'_, F>);
    /// Power of a lane left sideways.
    fn side(&mut self, _lane: u16, _power: f64) {}
    /// Power of a lane was absorbed by a body of this group.
    fn absorb(&mut self, _group: u16, _lane: u16, _power: f64) {}
    /// Power of a lane was lost.
    fn lose(&mut self, _why: Loss, _lane: u16, _power: f64) {}
    /// Power of a lane met, for the first time on its way, a face so narrow that ray optics is in doubt, outside
    /// of films.
    fn doubt(&mut self, _lane: u16, _power: f64) {}
    /// Power of a lane met, for the first time on its way, a stack of films so near to its edge that light in it would get
    /// there.
    fn edge(&mut self, _lane: u16, _power: f64) {}
    /// The nearest interfaces of these rays are searched for.
    fn search(&mut self, _queries: &[Query], _which: &[usize]) {}
    /// Segments were traced.
    fn segments(&mut self, _count: usize) {}
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use crate::geometry::{PrimId, Primitives, Ray};
    use crate::trace::inside::Inside;
    use crate::trace::stream::Border;
    use crate::trace::stream::Flight;

    /// Lets `recorder` hear of a ray of one lane.
    pub fn exit<F: Field>(recorder: &mut impl Recorder<F>, tree: u32, dir: DVec3, field: F) {
        let mut stream = Stream::new(1, 0);
        let (frame, at, medium, inside) = (DVec3::X, PrimId(0), crate::sample::MediumId(0), Inside::NOTHING);
        let (branch, events, walk, border) = (1, 0, [0, 0], Border::Out);
        let query = Primitives::default().query(Ray { origin: DVec3::ZERO, dir });
        let slot = stream.insert(
            query,
            Flight {
                frame,
                at,
                medium,
                inside,
                tree,
                branch,
                events,
                walk,
                border,
                spread: 0.0,
                doubtful: false,
                edge: false,
            },
        );
        stream.put(slot, 0, field);
        let (position, anchor) = (DVec3::ZERO, DVec3::ZERO);
        recorder.exit(&Exit { tree, dir, frame, position, anchor, slot, stream: &stream });
    }
}
