//! What the tracer tells, and to whom: it does not know who listens.

use glam::DVec3;

use crate::optics::jones::Jones;

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
#[derive(Debug)]
pub struct Exit<'a, const C: usize> {
    /// Number of its tree in the chunk.
    pub tree: u32,
    /// Direction, sample frame.
    pub dir: DVec3,
    /// x̂ of the frame of the fields.
    pub frame: DVec3,
    /// Where it last met the sample, µm; copies of a periodic sample count as one long sample.
    pub position: DVec3,
    /// Where its tree first met the sample, µm.
    pub anchor: DVec3,
    /// Geometric length per medium since the anchor, µm; empty if phase is not followed.
    pub lengths: &'a [f64],
    /// The lanes it carries.
    pub lanes: &'a [u16],
    /// Their fields.
    pub fields: &'a [Jones<C>],
}

/// Listens to the tracer.
pub trait Recorder<const C: usize> {
    /// A ray left upwards or downwards.
    fn exit(&mut self, exit: &Exit<'_, C>);
    /// Power of a lane left sideways.
    fn side(&mut self, lane: u16, power: f64);
    /// Power of a lane was absorbed.
    fn absorb(&mut self, lane: u16, power: f64);
    /// Power of a lane was lost.
    fn lose(&mut self, why: Loss, lane: u16, power: f64);
    /// Segments were traced.
    fn segments(&mut self, count: usize);
}
