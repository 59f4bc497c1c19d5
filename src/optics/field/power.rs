//! Power alone: for light whose polarization does not matter.

use super::super::{C64, Pair};
use super::stokes::Powers;
use super::{Dielectric, Field, Passage, Refracted};

/// The power of light that counts as unpolarized wherever it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Power(f64);

/// The mean share of s and p.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mean(f64);

impl Mean {
    #[inline]
    fn of(shares: Pair<f64>) -> Self {
        Self(0.5 * (shares.s + shares.p))
    }
}

impl Passage for Mean {
    fn new(a: Pair<C64>) -> Self {
        Self::of(a.map(|x| x.norm_sqr()))
    }

    #[inline]
    fn reflection(d: &Dielectric) -> Self {
        match d {
            Dielectric::Partial(d) => Self::of(d.r().map(|x| x * x)),
            Dielectric::Total(_) => Self(1.0),
        }
    }

    #[inline]
    fn transmission(d: &Refracted) -> Self {
        Self::of(d.t_powers().0)
    }

    #[inline]
    fn shares(&self) -> Pair<f64> {
        Pair { s: self.0, p: self.0 }
    }
}

impl Field for Power {
    const COMPONENTS: usize = 1;
    type Passage = Mean;

    fn incident(stokes: [f64; 4]) -> Self {
        Self(stokes[0])
    }

    fn depolarized(&self, share: f64) -> Self {
        Self(share * self.0)
    }

    #[inline]
    fn powers(&self) -> [f64; 2] {
        [0.5 * self.0; 2]
    }

    #[inline]
    fn power(&self) -> f64 {
        self.0
    }

    #[inline]
    fn rotated(&self, _: f64, _: f64) -> Self {
        *self
    }

    #[inline]
    fn times(&self, Mean(share): &Mean) -> Self {
        Self(self.0 * share)
    }

    #[inline]
    fn scaled(&self, power: f64) -> Self {
        Self(self.0 * power)
    }
}

/// [`Power`], and how much polarization could change it.
///
/// An interface that passes shares a of s and b of p makes diattenuation D = |a − b|/(a + b). Along any chain of them the
/// power differs from the product of the means by no more than (∏(1 + D) + ∏(1 − D))/2 − 1 of it, whatever lies between.
/// Light that comes polarized to the degree D is as if it came through one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    power: f64,
    /// ∏(1 + D) and ∏(1 − D).
    products: [f64; 2],
}

impl Range {
    /// Largest relative change that polarization can make.
    pub fn most(&self) -> f64 {
        0.5 * (self.products[0] + self.products[1]) - 1.0
    }
}

impl Field for Range {
    const COMPONENTS: usize = 1;
    type Passage = Powers;

    fn incident([power, q, u, v]: [f64; 4]) -> Self {
        let d = if power > 0.0 { ((q * q + u * u + v * v).sqrt() / power).min(1.0) } else { 0.0 };
        Self { power, products: [1.0 + d, 1.0 - d] }
    }

    fn depolarized(&self, share: f64) -> Self {
        // What was before is kept as a doubt of the power; the state is known again.
        Self { power: share * self.power, ..*self }
    }

    fn powers(&self) -> [f64; 2] {
        [0.5 * self.power; 2]
    }

    fn rotated(&self, _: f64, _: f64) -> Self {
        *self
    }

    fn times(&self, by: &Powers) -> Self {
        let Pair { s, p } = by.shares();
        let d = if s + p > 0.0 { (s - p).abs() / (s + p) } else { 0.0 };
        let [plus, minus] = self.products;
        Self { power: self.power * 0.5 * (s + p), products: [plus * (1.0 + d), minus * (1.0 - d)] }
    }

    fn scaled(&self, power: f64) -> Self {
        Self { power: self.power * power, ..*self }
    }
}
