//! The sample: from what the user wrote ([`Description`]) to what the tracer needs ([`Sample`]).

pub mod description;
mod file;
mod fill;
mod flat;
pub mod generate;
mod groups;
mod limits;
mod lonely;
mod media_list;
pub mod mesh;
pub mod obj;
mod overlap;
mod parts;
pub mod problem;
pub(crate) mod reader;
pub mod relief;
mod repeats;
mod solid;
pub mod tiling;

pub use description::Description;
pub use file::Replacement;
pub use flat::Sample;
pub use groups::Groups;
pub use media_list::{MediumId, MediumTable};
pub use solid::{Matter, Solid};
