//! x
pub mod bsdf;
pub mod dome;
pub mod experiment;
pub mod geometry;
pub mod intersect;
pub mod light;
pub mod media;
pub mod optics;
pub mod plan;
pub mod sample;
pub mod text;
pub mod trace;
pub mod units;
