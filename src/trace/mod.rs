//! Follows ray trees through the sample.

mod films;
mod inside;
mod interact;
mod kernel;
mod media;
mod random;
mod record;
mod schedule;
mod stream;
mod tracer;

pub use films::Stacks;
pub use kernel::Kernel;
pub use random::{Batch, TreeKey, TreeNumbers};
#[cfg(test)]
pub(crate) use record::tests as testing;
pub use record::{Exit, Loss, Recorder};
pub use schedule::{Detect, Unit, run};
pub use tracer::Tracer;
