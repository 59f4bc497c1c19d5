//! Mueller matrices: what becomes of light of any polarization.

use super::Field;
use super::stokes::{Powers, Stokes};

/// A Mueller matrix by columns: what four kinds of light of unit power have become that are unpolarized, and (added to
/// that) linear along x̂, linear at 45°, and right-handed. Ways are chosen by the power of unpolarized light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mueller([Stokes; 4]);

impl Mueller {
    /// From its elements by rows.
    pub fn from_rows(rows: &[f64; 16]) -> Self {
        Self([0, 1, 2, 3].map(|c| Stokes::from_components(std::array::from_fn(|row| rows[4 * row + c]))))
    }

    /// Its elements by rows.
    pub fn rows(&self) -> [f64; 16] {
        let mut rows = [0.0; 16];
        self.add_to(&mut rows);
        rows
    }

    /// The Stokes vector that light of this one becomes.
    pub fn applied_to(&self, stokes: [f64; 4]) -> [f64; 4] {
        let column = |c: usize| self.0[c].components().map(|x| x * stokes[c]);
        let columns = [0, 1, 2, 3].map(column);
        std::array::from_fn(|row| columns.iter().map(|c| c[row]).sum())
    }
}

impl Field for Mueller {
    /// By rows.
    const COMPONENTS: usize = 16;
    type Passage = Powers;

    /// All states at once, with the power of this one.
    fn incident([power, ..]: [f64; 4]) -> Self {
        let unit = |c: usize| Stokes::from_components(std::array::from_fn(|row| if row == c { power } else { 0.0 }));
        Self([0, 1, 2, 3].map(unit))
    }

    fn depolarized(&self, share: f64) -> Self {
        Self(self.0.map(|column| column.depolarized(share)))
    }

    #[inline]
    fn powers(&self) -> [f64; 2] {
        self.0[0].powers()
    }

    #[inline]
    fn power(&self) -> f64 {
        self.0[0].i
    }

    #[inline]
    fn add_to(&self, out: &mut [f64]) {
        for (c, column) in self.0.iter().enumerate() {
            for (row, x) in column.components().into_iter().enumerate() {
                out[4 * row + c] += x;
            }
        }
    }

    #[inline]
    fn rotated(&self, cos: f64, sin: f64) -> Self {
        Self(self.0.map(|column| column.rotated(cos, sin)))
    }

    #[inline]
    fn times(&self, by: &Powers) -> Self {
        Self(self.0.map(|column| column.times(by)))
    }

    #[inline]
    fn scaled(&self, power: f64) -> Self {
        Self(self.0.map(|column| column.scaled(power)))
    }
}
