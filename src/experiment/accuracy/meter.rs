//! What a measurement costs besides time on the wall.

use std::time::{Duration, Instant};

use cpu_time::ProcessTime;

/// What something has cost.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Cost {
    /// Time on the wall, s.
    pub seconds: f64,
    /// Time of all threads together, s.
    pub cpu_seconds: f64,
    /// Most memory held by the whole program, bytes; none where the system does not tell.
    pub memory: Option<u64>,
}

impl Cost {
    /// The least time of two, and the most memory.
    #[must_use]
    pub fn least(self, other: Self) -> Self {
        Self {
            seconds: self.seconds.min(other.seconds),
            cpu_seconds: self.cpu_seconds.min(other.cpu_seconds),
            memory: self.memory.max(other.memory),
        }
    }
}

/// Does some work and tells what it has cost.
pub fn metered<T>(work: impl FnOnce() -> T) -> (T, Cost) {
    // Linux forgets the greatest memory so far; others do not tell it.
    let forgotten = std::fs::write("/proc/self/clear_refs", "5").is_ok();
    let (wall, cpu) = (Instant::now(), ProcessTime::try_now().ok());
    let done = work();
    let cpu_seconds = cpu.and_then(|t| t.try_elapsed().ok()).unwrap_or(Duration::ZERO).as_secs_f64();
    let memory = forgotten.then(most_memory).flatten();
    (done, Cost { seconds: wall.elapsed().as_secs_f64(), cpu_seconds, memory })
}

/// Greatest memory of this process, bytes.
fn most_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    Some(1024 * line.split_whitespace().next()?.parse::<u64>().ok()?)
}
