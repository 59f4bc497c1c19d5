//! x
pub mod bsdf;
pub mod dome;
pub mod experiment;
pub mod geometry;
pub mod intersect;
pub mod light;
pub mod media;
pub mod optics;
pub mod output;
pub mod plan;
pub mod plot;
pub mod sample;
pub mod trace;
pub mod units;
