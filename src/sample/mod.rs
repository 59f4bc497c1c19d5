//! sample
pub mod generate;
