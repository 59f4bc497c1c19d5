//! Many measurements: what a job file asks for, and how it is cut into shards.

mod file;
pub mod plan;
pub mod shard;

pub use file::{Job, read};
