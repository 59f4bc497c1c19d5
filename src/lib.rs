//! x
pub mod geometry;
pub mod intersect;
pub mod optics;
pub mod sample;
