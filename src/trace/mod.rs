//! Follows ray trees through the sample.

mod films;
mod inside;
mod interact;
mod kernel;
mod random;
mod record;
mod schedule;
mod stream;

pub use kernel::{Kernel, Tracer, TreeKey};
pub use random::{Batch, TreeNumbers};
pub use record::{Exit, Loss, Recorder};
pub use schedule::{Detect, StackCounts, Unit, run};
