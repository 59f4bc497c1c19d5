//! Many measurements: on this machine, or in shards on several.

mod board;
mod forecast;
pub mod merge;
pub mod plan;
mod prepared;
pub mod run;
pub mod shard;
pub mod slurm;
pub mod status;
mod sweep;
