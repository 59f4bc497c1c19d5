//! Work that is kept while it goes on, and goes on from where it was.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use gonio_embree::experiment::sealed::{Key, Kind, seal, unseal};
use gonio_embree::output::atomic;
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::{Failure, tell};

/// A file in which unfinished work is kept.
#[derive(Clone, Debug)]
pub struct Checkpoint {
    path: PathBuf,
    key: Key,
    every: Duration,
    last: Instant,
    failed: bool,
}

impl Checkpoint {
    /// Beside the file `output`, of work that depends on what `key` tells; written after each such time, if one is given.
    pub fn beside(output: &Path, key: Key, every: Option<Duration>) -> Self {
        let digits: String = key[..4].iter().map(|byte| format!("{byte:02x}")).collect();
        let mut name = output.file_name().unwrap_or_default().to_os_string();
        name.push(format!(".{digits}.checkpoint"));
        let every = every.unwrap_or(Duration::MAX);
        Self { path: output.with_file_name(name), key, every, last: Instant::now(), failed: false }
    }

    /// What was kept, if there is something that can be believed.
    pub fn read<T: DeserializeOwned>(&self) -> Option<T> {
        let bytes = match fs::read(&self.path) {
            Err(e) if e.kind() == ErrorKind::NotFound => return None,
            read => read.map_err(|e| e.to_string()),
        };
        let read = bytes.and_then(|bytes| unseal(Kind::Checkpoint, &self.key, &bytes).map_err(|e| e.to_string()));
        read.map_err(|e| tell(&format!("warning: {}: {e}; beginning anew", self.path.display()))).ok()
    }

    /// Keeps `work` if that was not done for long. That it cannot be is no reason to end, but told once.
    pub fn keep_now_and_then(&mut self, work: &impl Serialize) {
        if self.last.elapsed() < self.every {
            return;
        }
        let kept = self.write(work);
        self.last = Instant::now();
        if let (Err(e), false) = (kept, self.failed) {
            self.failed = true;
            tell(&format!("warning: {e}; going on without"));
        }
    }

    /// Keeps `work`, which ends here for now.
    ///
    /// # Errors
    /// Always: that it was stopped, or that it could not be kept.
    pub fn stop<T>(&self, work: &impl Serialize) -> Result<T, Failure> {
        self.write(work).map_err(Failure::Cannot)?;
        let path = self.path.display();
        Err(Failure::Stopped(format!("stopped; {path} is kept, and the same command goes on from there")))
    }

    fn write(&self, work: &impl Serialize) -> Result<(), String> {
        atomic::write(&self.path, &seal(Kind::Checkpoint, &self.key, work))
            .map_err(|e| format!("{}: cannot be written: {e}", self.path.display()))
    }

    /// The work is done and its result written.
    pub fn remove(&self) {
        if let Err(e) = atomic::remove(&self.path) {
            tell(&format!("warning: {}: cannot be removed: {e}", self.path.display()));
        }
    }
}
