//! What a shard has left.

use serde::{Deserialize, Serialize};

use crate::experiment::State;

/// The content of the file of a shard, or of its checkpoint, whose last piece may not be finished.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Shard<S = State> {
    /// How it came about.
    pub made: Made,
    /// What is traced, of each slice of the shard.
    pub pieces: Vec<S>,
}

/// Where and by whom a shard was traced.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Made {
    /// Its number, and how many there are.
    pub shard: usize,
    /// How many there are.
    pub of: usize,
    /// Who intersected, with the version of the library.
    pub backend: String,
    /// The machine.
    pub host: String,
    /// Its processor.
    pub processor: String,
    /// The job of a queue, and how often that has begun anew.
    pub job: String,
    /// Begun and ended, seconds since 1970.
    pub seconds: [u64; 2],
}
