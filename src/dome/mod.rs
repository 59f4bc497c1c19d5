//! The detector: a geodesic dome around the sample.
//!
//! Power that leaves is added up per facet of the finest level, sparsely. After each batch (an independent
//! scramble of the entry points) the sums go up the tree of facets with their squares, so that every facet of
//! every level has a mean and a standard error. Only then are facets merged that do not differ: the result does
//! not depend on the order of events, and parts measured elsewhere merge by addition.

mod apertures;
mod detector;
mod frame;
mod geodesic;
pub mod klems;
mod leaves;
mod patch;
mod precision;
mod statistics;
mod tally;

pub use apertures::Apertures;
pub use detector::{Apart, Detector};
pub use frame::{theta as theta_direction, turn};
pub use geodesic::{FINEST_LEVEL, Facet, Locator, count};
pub use leaves::{Leaf, RESOLVED, Rule, critical};
pub use patch::Patch;
pub use precision::{FAINT, Noise, Precision, RESOLUTION};
pub use statistics::{BATCHES, Estimate, Measurement, Round};
pub use tally::{Entry, Shape, Tally};
