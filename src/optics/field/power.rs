//! Power alone: for light whose polarization does not matter.

use super::super::{C64, Pair};
use super::stokes::Powers;
use super::{Dielectric, Field, Number, Parts, Passage, Refracted, Shares, State};

/// The power of light that counts as unpolarized wherever it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Power<T = f64>(T);

/// The mean share of s and p.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mean<T = f64>(T);

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
}

impl<T: Number> Parts<T> for Mean<T> {
    const PARTS: usize = 1;

    #[inline(always)]
    fn from_parts(parts: &[T]) -> Self {
        Self(parts[0])
    }

    #[inline(always)]
    fn write(&self, to: &mut [T]) {
        to[0] = self.0;
    }
}

impl<T: Number> Shares<T> for Mean<T> {
    #[inline(always)]
    fn shares(&self) -> Pair<T> {
        Pair { s: self.0, p: self.0 }
    }
}

impl<T: Number> Parts<T> for Power<T> {
    const PARTS: usize = 1;

    #[inline(always)]
    fn from_parts(parts: &[T]) -> Self {
        Self(parts[0])
    }

    #[inline(always)]
    fn write(&self, to: &mut [T]) {
        to[0] = self.0;
    }
}

impl<T: Number> State<T> for Power<T> {
    type Passage = Mean<T>;

    #[inline(always)]
    fn powers(&self) -> [T; 2] {
        [self.0 * 0.5; 2]
    }

    #[inline(always)]
    fn power(&self) -> T {
        self.0
    }

    #[inline(always)]
    fn rotated(&self, _: f64, _: f64) -> Self {
        *self
    }

    #[inline(always)]
    fn times(&self, Mean(share): &Mean<T>) -> Self {
        Self(self.0 * *share)
    }

    #[inline(always)]
    fn scaled(&self, power: T) -> Self {
        Self(self.0 * power)
    }
}

impl Field for Power {
    type Of<T: Number> = Power<T>;
    const COMPONENTS: usize = 1;

    fn incident(stokes: [f64; 4]) -> Self {
        Self(stokes[0])
    }

    fn depolarized(&self, share: f64) -> Self {
        Self(share * self.0)
    }
}

/// [`Power`], and how much polarization could change it.
///
/// An interface that passes shares a of s and b of p makes diattenuation D = |a − b|/(a + b). Along any chain of them the
/// power differs from the product of the means by no more than (∏(1 + D) + ∏(1 − D))/2 − 1 of it, whatever lies between.
/// Light that comes polarized to the degree D is as if it came through one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range<T = f64> {
    power: T,
    /// ∏(1 + D) and ∏(1 − D).
    products: [T; 2],
}

impl Range {
    /// Largest relative change that polarization can make.
    pub fn most(&self) -> f64 {
        0.5 * (self.products[0] + self.products[1]) - 1.0
    }
}

impl<T: Number> Parts<T> for Range<T> {
    const PARTS: usize = 3;

    #[inline(always)]
    fn from_parts(parts: &[T]) -> Self {
        Self { power: parts[0], products: [parts[1], parts[2]] }
    }

    #[inline(always)]
    fn write(&self, to: &mut [T]) {
        (to[0], to[1], to[2]) = (self.power, self.products[0], self.products[1]);
    }
}

impl<T: Number> State<T> for Range<T> {
    type Passage = Powers<T>;

    #[inline(always)]
    fn powers(&self) -> [T; 2] {
        [self.power * 0.5; 2]
    }

    #[inline(always)]
    fn rotated(&self, _: f64, _: f64) -> Self {
        *self
    }

    #[inline(always)]
    fn times(&self, by: &Powers<T>) -> Self {
        let Pair { s, p } = by.shares();
        let d = (s - p).abs().share_of(s + p);
        let [plus, minus] = self.products;
        Self { power: self.power * (s + p) * 0.5, products: [plus + plus * d, minus - minus * d] }
    }

    #[inline(always)]
    fn scaled(&self, power: T) -> Self {
        Self { power: self.power * power, ..*self }
    }
}

impl Field for Range {
    type Of<T: Number> = Range<T>;
    const COMPONENTS: usize = 1;

    fn incident([power, q, u, v]: [f64; 4]) -> Self {
        let d = if power > 0.0 { ((q * q + u * u + v * v).sqrt() / power).min(1.0) } else { 0.0 };
        Self { power, products: [1.0 + d, 1.0 - d] }
    }

    fn depolarized(&self, share: f64) -> Self {
        // What was before is kept as a doubt of the power; the state is known again.
        Self { power: share * self.power, ..*self }
    }
}
