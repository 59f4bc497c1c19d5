//! The sample: from what the user wrote ([`Description`]) to what the tracer needs ([`Sample`]).

pub mod description;
mod flat;
pub mod generate;
mod limits;
mod lonely;
pub mod mesh;
pub mod obj;
mod overlap;
pub mod problem;
mod reader;
pub mod tiling;

pub use description::Description;
pub use flat::{Matter, MediumId, MediumTable, Sample, Solid};
