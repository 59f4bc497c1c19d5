//! How films are found and what is done at their edges.

use crate::light::Coherence;
use crate::text::words;

/// Along what stacks are searched.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Probe {
    /// The normal of the first interface: finds every layer, whatever the light.
    #[default]
    Normal,
    /// The refracted ray, as the paper does: it ends where refraction is total.
    Refracted,
}

words!(Probe { Normal = "normal", Refracted = "refracted" });

/// What is done where a layer ends so near that light which goes to and fro in the stack would get there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Edges {
    /// The stack under the point counts, as if it had no end.
    #[default]
    Column,
    /// There is no stack: light is followed from interface to interface, without interference.
    Reject,
}

words!(Edges { Column = "column", Reject = "reject" });

/// What the plan says about films.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilmRules {
    /// Along what stacks are searched.
    pub probe: Probe,
    /// What is done at edges.
    pub edges: Edges,
    /// How thick stacks may be.
    pub coherence: Coherence,
    /// Whether stacks on curved faces are worth a table over the angle: there are few different ones.
    pub tables: bool,
}
