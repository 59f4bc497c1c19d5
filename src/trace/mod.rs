//! Follows ray trees through the sample.

mod films;
mod finder;
mod inside;
mod interact;
mod kernel;
mod media;
mod random;
mod record;
mod report;
mod schedule;
mod stream;
mod tracer;

pub use kernel::Kernel;
pub use random::{Batch, TreeKey, TreeNumbers};
#[cfg(test)]
pub(crate) use record::tests as testing;
pub use record::{Exit, Loss, Recorder};
pub use report::{Met, Stacks};
pub use schedule::{Detect, Unit, run};
pub use tracer::Tracer;
