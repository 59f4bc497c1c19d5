//! Stokes vectors: all that intensities need.

use num_complex::Complex;

use super::super::{C64, Pair};
use super::{Dielectric, Field, Jones, Number, Parts, Passage, Refracted, Shares, State};

/// A Stokes vector: I = |Eₓ|² + |E_y|², Q = |Eₓ|² − |E_y|², U + iV = 2 Eₓ E_y*.
///
/// The same paths as with [`Jones`], with half the numbers: whatever is not summed as fields needs no more.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stokes<T = f64> {
    /// Power.
    pub i: T,
    /// Power along x̂ minus power along ŷ.
    pub q: T,
    /// Power at 45° minus power at −45°.
    pub u: T,
    /// Handedness.
    pub v: T,
}

impl<T: Copy> Stokes<T> {
    /// (I, Q, U, V).
    #[inline]
    pub fn components(&self) -> [T; 4] {
        [self.i, self.q, self.u, self.v]
    }

    /// From (I, Q, U, V).
    #[inline]
    pub fn from_components([i, q, u, v]: [T; 4]) -> Self {
        Self { i, q, u, v }
    }
}

/// Shares of the power of s and p light, and what becomes of their correlation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Powers<T = f64> {
    shares: Pair<T>,
    cross: Complex<T>,
}

impl Powers {
    /// 2 p s* over 2: what multiplies U + iV.
    #[inline]
    pub fn cross(&self) -> C64 {
        self.cross
    }
}

impl Passage for Powers {
    fn new(a: Pair<C64>) -> Self {
        Self { shares: a.map(|x| x.norm_sqr()), cross: a.p * a.s.conj() }
    }

    #[inline]
    fn reflection(d: &Dielectric) -> Self {
        match d {
            Dielectric::Partial(d) => {
                let r = d.r();
                Self { shares: r.map(|x| x * x), cross: C64::new(r.p * r.s, 0.0) }
            }
            Dielectric::Total(r) => Self { shares: Pair { s: 1.0, p: 1.0 }, cross: r.p * r.s.conj() },
        }
    }

    #[inline]
    fn transmission(d: &Refracted) -> Self {
        let (shares, cross) = d.t_powers();
        Self { shares, cross: C64::new(cross, 0.0) }
    }
}

impl<T: Number> Parts<T> for Powers<T> {
    const PARTS: usize = 4;

    #[inline(always)]
    fn from_parts(parts: &[T]) -> Self {
        Self { shares: Pair { s: parts[0], p: parts[1] }, cross: Complex { re: parts[2], im: parts[3] } }
    }

    #[inline(always)]
    fn write(&self, to: &mut [T]) {
        let Self { shares, cross } = self;
        (to[0], to[1], to[2], to[3]) = (shares.s, shares.p, cross.re, cross.im);
    }
}

impl<T: Number> Shares<T> for Powers<T> {
    #[inline(always)]
    fn shares(&self) -> Pair<T> {
        self.shares
    }
}

impl<T: Number> Parts<T> for Stokes<T> {
    const PARTS: usize = 4;

    #[inline(always)]
    fn from_parts(parts: &[T]) -> Self {
        Self { i: parts[0], q: parts[1], u: parts[2], v: parts[3] }
    }

    #[inline(always)]
    fn write(&self, to: &mut [T]) {
        (to[0], to[1], to[2], to[3]) = (self.i, self.q, self.u, self.v);
    }
}

impl<T: Number> State<T> for Stokes<T> {
    type Passage = Powers<T>;

    #[inline(always)]
    fn powers(&self) -> [T; 2] {
        [(self.i + self.q) * 0.5, (self.i - self.q) * 0.5]
    }

    #[inline(always)]
    fn power(&self) -> T {
        self.i
    }

    #[inline(always)]
    fn rotated(&self, cos: f64, sin: f64) -> Self {
        // Twice the angle.
        let (c, s) = ((cos - sin) * (cos + sin), 2.0 * cos * sin);
        Self { q: self.q * c + self.u * s, u: self.u * c - self.q * s, ..*self }
    }

    #[inline(always)]
    fn times(&self, Powers { shares, cross }: &Powers<T>) -> Self {
        let [x, y] = self.powers();
        let (x, y) = (x * shares.p, y * shares.s);
        Self { i: x + y, q: x - y, u: self.u * cross.re - self.v * cross.im, v: self.v * cross.re + self.u * cross.im }
    }

    #[inline(always)]
    fn scaled(&self, power: T) -> Self {
        Self { i: self.i * power, q: self.q * power, u: self.u * power, v: self.v * power }
    }
}

impl Field for Stokes {
    type Of<T: Number> = Stokes<T>;
    const COMPONENTS: usize = 1;

    fn incident(stokes: [f64; 4]) -> Self {
        Self::from_components(stokes)
    }

    fn depolarized(&self, share: f64) -> Self {
        Self::from_components([share * self.i, 0.0, 0.0, 0.0])
    }
}

impl From<Jones> for Stokes {
    fn from(j: Jones) -> Self {
        let [x, y] = j.powers();
        let cross: C64 = (0..2).map(|c| j.x[c] * j.y[c].conj() * 2.0).sum();
        Self { i: x + y, q: x - y, u: cross.re, v: cross.im }
    }
}
