//! Mueller matrices: what becomes of light of any polarization.

use super::stokes::{Powers, Stokes};
use super::{Field, Number, Parts, State};

/// A Mueller matrix by columns: what four kinds of light of unit power have become that are unpolarized, and (added to
/// that) linear along x̂, linear at 45°, and right-handed. Ways are chosen by the power of unpolarized light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mueller<T = f64>([Stokes<T>; 4]);

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

impl<T: Number> Parts<T> for Mueller<T> {
    const PARTS: usize = 16;

    #[inline(always)]
    fn from_parts(parts: &[T]) -> Self {
        Self([
            Stokes::from_parts(&parts[..4]),
            Stokes::from_parts(&parts[4..8]),
            Stokes::from_parts(&parts[8..12]),
            Stokes::from_parts(&parts[12..]),
        ])
    }

    #[inline(always)]
    fn write(&self, to: &mut [T]) {
        for (column, stokes) in self.0.iter().enumerate() {
            stokes.write(&mut to[4 * column..4 * column + 4]);
        }
    }
}

impl<T: Number> State<T> for Mueller<T> {
    type Passage = Powers<T>;

    #[inline(always)]
    fn powers(&self) -> [T; 2] {
        self.0[0].powers()
    }

    #[inline(always)]
    fn power(&self) -> T {
        self.0[0].i
    }

    #[inline(always)]
    fn rotated(&self, cos: f64, sin: f64) -> Self {
        let Self([a, b, c, d]) = self;
        Self([a.rotated(cos, sin), b.rotated(cos, sin), c.rotated(cos, sin), d.rotated(cos, sin)])
    }

    #[inline(always)]
    fn times(&self, by: &Powers<T>) -> Self {
        let Self([a, b, c, d]) = self;
        Self([a.times(by), b.times(by), c.times(by), d.times(by)])
    }

    #[inline(always)]
    fn scaled(&self, power: T) -> Self {
        let Self([a, b, c, d]) = self;
        Self([a.scaled(power), b.scaled(power), c.scaled(power), d.scaled(power)])
    }
}

impl Field for Mueller {
    type Of<T: Number> = Mueller<T>;
    /// By rows.
    const COMPONENTS: usize = 16;

    /// All states at once, with the power of this one.
    fn incident([power, ..]: [f64; 4]) -> Self {
        let unit = |c: usize| Stokes::from_components(std::array::from_fn(|row| if row == c { power } else { 0.0 }));
        Self([0, 1, 2, 3].map(unit))
    }

    fn depolarized(&self, share: f64) -> Self {
        Self(self.0.map(|column| column.depolarized(share)))
    }

    #[inline]
    fn add_to(&self, out: &mut [f64]) {
        for (c, column) in self.0.iter().enumerate() {
            for (row, x) in column.components().into_iter().enumerate() {
                out[4 * row + c] += x;
            }
        }
    }
}
