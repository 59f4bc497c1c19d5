//! From where the light comes: angles as people type them, or those of a Klems matrix.

use std::fmt;
use std::str::FromStr;

use gonio_embree::dome::klems::{self, Basis};

use super::numbers::Values;

/// Directions of the source.
#[derive(Clone, Debug, PartialEq)]
pub enum Incident {
    /// Polar angles, each with every azimuth.
    Angles(Values),
    /// One direction for each patch.
    Klems(&'static str, Basis),
}

const KLEMS: [(&str, Basis); 3] =
    [("klems-full", klems::FULL), ("klems-half", klems::HALF), ("klems-quarter", klems::QUARTER)];

impl FromStr for Incident {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if let Some((name, basis)) = KLEMS.into_iter().find(|k| k.0 == text) {
            return Ok(Self::Klems(name, basis));
        }
        text.parse().map(Self::Angles).map_err(|e| {
            let known = KLEMS.map(|k| k.0).join(", ");
            if text.starts_with("klems") { format!("there are {known}") } else { e }
        })
    }
}

impl fmt::Display for Incident {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Angles(values) => values.fmt(f),
            Self::Klems(name, _) => f.write_str(name),
        }
    }
}
