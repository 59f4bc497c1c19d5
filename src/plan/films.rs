//! How films are found and what is done at their edges.

use std::fmt;
use std::str::FromStr;

use crate::light::Coherence;

/// Along what stacks are searched.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Probe {
    /// The normal of the first interface: finds every layer, whatever the light.
    #[default]
    Normal,
    /// The refracted ray, as the paper does: it ends where refraction is total.
    Refracted,
}

/// What is done where a layer ends so near that light which goes to and fro in the stack would get there.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Edges {
    /// The stack under the point counts, as if it had no end.
    #[default]
    Column,
    /// There is no stack: light is followed from interface to interface, without interference.
    Reject,
}

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

impl fmt::Display for Probe {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Normal => "normal",
            Self::Refracted => "refracted",
        })
    }
}

impl FromStr for Probe {
    type Err = String;

    fn from_str(s: &str) -> Result<Self, String> {
        match s {
            "normal" => Ok(Self::Normal),
            "refracted" => Ok(Self::Refracted),
            _ => Err(format!("`{s}`: expected normal or refracted")),
        }
    }
}

impl fmt::Display for Edges {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Column => "column",
            Self::Reject => "reject",
        })
    }
}

impl FromStr for Edges {
    type Err = String;

    fn from_str(s: &str) -> Result<Self, String> {
        match s {
            "column" => Ok(Self::Column),
            "reject" => Ok(Self::Reject),
            _ => Err(format!("`{s}`: expected column or reject")),
        }
    }
}
