//! Follows ray trees through the sample.

mod beams;
mod effects;
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

pub use effects::{All, Effects, Job, Of, with_kernel};
pub use kernel::Kernel;
pub use random::{Batch, TreeKey, TreeNumbers};
#[cfg(test)]
pub(crate) use record::tests as testing;
pub use record::{Exit, Loss, Recorder};
pub use report::{Met, Stacks};
pub use schedule::{Detect, Unit, run};
pub use tracer::Tracer;
