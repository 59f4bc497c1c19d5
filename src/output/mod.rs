//! Bytes for people and programs, one file per format. To add a format: a file with a pure function from
//! [`Measured`] to bytes or text; [`atomic`] puts them on the disk.

pub mod accuracy;
pub mod atomic;
pub mod compare;
pub mod export;
pub mod film;
pub mod materials;
mod measured;
pub mod netcdf;
pub mod overlay;
pub mod plan;
pub mod report;
pub mod scan;
pub mod summary;
pub mod sweep;
pub mod table;

pub use measured::{EffectUsed, Measured, Provenance, StackHits, UsedBackend, Validity, sha256_of_files};
