//! gen
pub mod packing;
