//! Infinite plane-parallel bodies: films, slabs, the half-space below.

/// All points between two heights. Face 0 is the bottom, face 1 the top.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Layer {
    /// Height of the lower face, µm; −∞ for a half-space.
    pub bottom: f64,
    /// Height of the upper face, µm.
    pub top: f64,
}

impl Layer {
    /// Number of the lower face.
    pub const BOTTOM: u8 = 0;
    /// Number of the upper face.
    pub const TOP: u8 = 1;
}
