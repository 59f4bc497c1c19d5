//! Cases in which numbers go wrong first, for a test and for the table in `docs/hard-cases.md`.
//!
//! What is true comes from closed forms or from `tests/reference`, never from this program. Beside this program's answer
//! stand those of float32 and of textbooks (see [`twin`]), where they mean something.

mod bodies;
mod films;
mod interfaces;
mod scenes;
mod shifts;
mod twin;
mod unseen;

/// A quantity, and what is said of it.
#[derive(Clone, Debug)]
pub struct Case {
    pub name: String,
    /// With its unit.
    pub quantity: String,
    /// Whether errors are relative to the truth.
    pub relative: bool,
    pub truth: f64,
    pub ours: f64,
    /// In float32.
    pub single: Option<f64>,
    /// A textbook's formula in double precision: which, and what it gives. Infinite if it misses what is there.
    pub naive: Option<(&'static str, f64)>,
    /// Largest error allowed.
    pub bound: f64,
}

impl Case {
    /// With absolute errors of no more than `bound`.
    fn new(name: impl Into<String>, quantity: impl Into<String>, truth: f64, ours: f64, bound: f64) -> Self {
        let (name, quantity) = (name.into(), quantity.into());
        Self { name, quantity, relative: false, truth, ours, single: None, naive: None, bound }
    }

    fn relative(self) -> Self {
        Self { relative: true, ..self }
    }

    fn single(self, value: f64) -> Self {
        Self { single: Some(value), ..self }
    }

    fn naive(self, formula: &'static str, value: f64) -> Self {
        Self { naive: Some((formula, value)), ..self }
    }

    /// Error of a value.
    pub fn error(&self, value: f64) -> f64 {
        let off = (value - self.truth).abs();
        if self.relative { off / self.truth.abs() } else { off }
    }

    /// Whether this program's answer is as good as it must be.
    pub fn holds(&self) -> bool {
        self.error(self.ours) <= self.bound
    }
}

/// How long it may take.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tier {
    Quick,
    Slow,
}

/// All cases, group by group.
pub fn all(tier: Tier) -> Vec<(&'static str, Vec<Case>)> {
    vec![
        ("Films", films::all()),
        ("Interfaces", interfaces::all()),
        ("Bodies", bodies::all(tier)),
        ("Films in a scene of 2 mm", scenes::all()),
        ("Scenes that must scatter alike", shifts::all()),
        ("Scenes that cannot be seen", unseen::all()),
    ]
}

/// The largest; NaN if one is NaN.
fn worst(all: impl IntoIterator<Item = f64>) -> f64 {
    all.into_iter().fold(0.0, |a: f64, b| if a.is_nan() || b.is_nan() { f64::NAN } else { a.max(b.abs()) })
}
