//! Jones matrices: what a ray carries per wavelength.

use super::{C64, Pair};

/// Electric field components of a ray in its own frame (x̂, ŷ = k̂ × x̂), power-normalised, one column per
/// mutually incoherent state of the light: column c holds the field that the c-th input state has become. With
/// two columns this is the Jones matrix of the path so far; unpolarized light is both inputs at half power.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jones<const COLUMNS: usize> {
    /// Component along x̂, per column.
    pub x: [C64; COLUMNS],
    /// Component along ŷ, per column.
    pub y: [C64; COLUMNS],
}

impl<const COLUMNS: usize> Jones<COLUMNS> {
    /// Power along x̂ and ŷ, summed over the columns.
    #[inline]
    pub fn powers(&self) -> [f64; 2] {
        let sum = |c: &[C64; COLUMNS]| c.iter().map(C64::norm_sqr).sum();
        [sum(&self.x), sum(&self.y)]
    }

    /// All power.
    #[inline]
    pub fn power(&self) -> f64 {
        let [x, y] = self.powers();
        x + y
    }

    /// The same field in the frame (p̂, ŝ) with p̂ = cos·x̂ + sin·ŷ.
    #[inline]
    #[must_use]
    pub fn rotated(&self, cos: f64, sin: f64) -> Self {
        Self {
            x: std::array::from_fn(|c| self.x[c] * cos + self.y[c] * sin),
            y: std::array::from_fn(|c| self.y[c] * cos - self.x[c] * sin),
        }
    }

    /// The field behind an interface whose plane of incidence is spanned by x̂: x̂ is p, ŷ is s.
    #[inline]
    #[must_use]
    pub fn times(&self, by: Pair<C64>) -> Self {
        Self { x: self.x.map(|e| e * by.p), y: self.y.map(|e| e * by.s) }
    }

    /// Linearly polarized light of unit power in the first column, along x̂ or along ŷ.
    pub fn linear(along_x: bool) -> Self {
        let mut out = Self { x: [C64::ZERO; COLUMNS], y: [C64::ZERO; COLUMNS] };
        (if along_x { &mut out.x } else { &mut out.y })[0] = C64::ONE;
        out
    }

    /// Unpolarized light of given power: the two columns carry half each (with one column: light of that power
    /// polarized at 45°).
    pub fn depolarized(power: f64) -> Self {
        let a = C64::new((0.5 * power).sqrt(), 0.0);
        let mut out = Self { x: [C64::ZERO; COLUMNS], y: [C64::ZERO; COLUMNS] };
        out.x[0] = a;
        out.y[COLUMNS - 1] = a;
        out
    }

    /// The field with its amplitude multiplied.
    #[inline]
    #[must_use]
    pub fn scaled(&self, by: f64) -> Self {
        Self { x: self.x.map(|e| e * by), y: self.y.map(|e| e * by) }
    }
}

