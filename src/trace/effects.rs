//! Which effects a kernel simulates: decided when it is compiled, so that what is off costs nothing.

use crate::optics::field::{Field, Jones, Mueller, Power, Stokes};
use crate::plan::{KernelChoice, State};

/// A choice of effects.
pub trait Effects: Send + Sync + 'static {
    /// Whether faces are searched for films.
    const FILMS: bool;
    /// Whether anything absorbs.
    const ABSORBS: bool;
    /// Whether refraction may part the lanes of a ray.
    const PARTS: bool;
}

/// The choice, by its three answers.
pub struct Of<const FILMS: bool, const ABSORBS: bool, const PARTS: bool>;

/// All effects.
pub type All = Of<true, true, true>;

impl<const FILMS: bool, const ABSORBS: bool, const PARTS: bool> Effects for Of<FILMS, ABSORBS, PARTS> {
    const FILMS: bool = FILMS;
    const ABSORBS: bool = ABSORBS;
    const PARTS: bool = PARTS;
}

/// Work that can be done with any kernel.
pub trait Job {
    /// What it yields.
    type Yield;
    /// Does it with rays that carry `F` and are subject to `E`.
    fn run<F: Field, E: Effects>(self) -> Self::Yield;
}

/// Does a job with the kernel that a plan has chosen.
pub fn with_kernel<J: Job>(choice: KernelChoice, job: J) -> J::Yield {
    match choice.state {
        State::Power => with_effects::<Power, J>(choice, job),
        State::Stokes => with_effects::<Stokes, J>(choice, job),
        State::Mueller if choice.films => job.run::<Mueller, All>(),
        State::Mueller => job.run::<Mueller, Of<false, true, true>>(),
        State::Jones => job.run::<Jones, All>(),
    }
}

fn with_effects<F: Field, J: Job>(choice: KernelChoice, job: J) -> J::Yield {
    match (choice.films, choice.absorbs, choice.parts) {
        (false, false, false) => job.run::<F, Of<false, false, false>>(),
        (false, false, true) => job.run::<F, Of<false, false, true>>(),
        (false, true, false) => job.run::<F, Of<false, true, false>>(),
        (false, true, true) => job.run::<F, Of<false, true, true>>(),
        (true, false, false) => job.run::<F, Of<true, false, false>>(),
        (true, false, true) => job.run::<F, Of<true, false, true>>(),
        (true, true, false) => job.run::<F, Of<true, true, false>>(),
        (true, true, true) => job.run::<F, All>(),
    }
}
