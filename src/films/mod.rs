//! Plane-parallel film stacks by themselves, without a sample around them.
//!
//! ```text
//! text ─parse─► FilmStack (media by name) ─resolve─► Stack ─at λ─► Films ─► optics::film ─► Sweep
//! file ─cases─► Case ────────────────────────────────────────────► Films ─► optics::film ─► Amplitudes
//! ```

pub mod cases;
mod media;
mod parse;
mod sweep;
mod tokens;

pub use media::{Stack, check_name};
pub use parse::parse;
pub use sweep::{Shares, Spectrum, Sweep, sweep};

use std::fmt;

use crate::optics::film::{self, Amplitudes, Incidence, Layer};
use crate::optics::{C64, Pair};

/// Most layers of a stack, repetitions included.
pub const MOST_LAYERS: usize = 1_000_000;

/// A medium as written.
#[derive(Clone, Debug, PartialEq)]
pub enum Medium {
    /// By its index.
    Index(C64),
    /// By its name.
    Named(String),
}

/// A medium and where it is written.
#[derive(Clone, Debug, PartialEq)]
pub struct Written {
    /// The medium.
    pub medium: Medium,
    /// Where.
    pub span: Span,
}

/// A stack as written, repetitions unrolled.
#[derive(Clone, Debug, PartialEq)]
pub struct FilmStack {
    /// The medium the light comes from.
    pub first: Written,
    /// Layers from the side of the light: medium and thickness in nm.
    pub layers: Vec<(Written, f64)>,
    /// The medium behind.
    pub last: Written,
}

/// A stack at one wavelength.
#[derive(Clone, Debug, PartialEq)]
pub struct Films {
    /// Index of the first medium, which is transparent.
    pub first: f64,
    /// Layers from the side of the light, thickness in nm.
    pub layers: Vec<Layer>,
    /// Index of the last medium.
    pub last: C64,
    /// Vacuum wavelength, nm.
    pub wavelength_nm: f64,
}

impl Films {
    /// What the stack does to light from a direction.
    pub fn solve(&self, incidence: &Incidence) -> Pair<Amplitudes> {
        film::solve(incidence, &self.layers, self.last, self.wavelength_nm)
    }
}

/// Characters of a text, counted from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Span {
    /// The first.
    pub start: usize,
    /// How many, at least one.
    pub len: usize,
}

/// What is wrong with a stack, and where.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StackError {
    /// The characters it is about.
    pub span: Span,
    /// What was found, what was expected, and how to mend it.
    pub message: String,
}

impl StackError {
    /// The message with the text it is about and carets under the place.
    pub fn show(&self, text: &str) -> impl fmt::Display {
        /// Characters shown before and after the place.
        const AROUND: usize = 60;
        let from = self.span.start.saturating_sub(AROUND);
        let len = self.span.len.clamp(1, AROUND);
        let line = text.chars().map(|c| if c.is_whitespace() || c.is_control() { ' ' } else { c });
        let line: String = line.skip(from).take(self.span.start - from + len + AROUND).collect();
        let carets = " ".repeat(self.span.start - from) + &"^".repeat(len);
        format!("stack, column {}: {}\n  {}\n  {carets}", self.span.start + 1, self.message, line.trim_end())
    }
}
