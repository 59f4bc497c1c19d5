//! What a ray carries per wavelength, in its own frame (x̂, ŷ = k̂ × x̂) and normalised to power: a Jones matrix,
//! or, where phase does not matter, a Stokes vector; and what an interface does to each.

use super::fresnel::{Dielectric, Refracted};
use super::{C64, Pair};

/// The state of light on a ray at one wavelength.
pub trait Field: Copy + Send + Sync + std::fmt::Debug + 'static {
    /// Linearly polarized light of unit power, along x̂ or along ŷ.
    fn linear(along_x: bool) -> Self;

    /// Unpolarized light of given power.
    fn unpolarized(power: f64) -> Self;

    /// Power along x̂ and along ŷ.
    fn powers(&self) -> [f64; 2];

    /// All power.
    fn power(&self) -> f64;

    /// The same light in the frame whose x̂ is cos·x̂ + sin·ŷ.
    #[must_use]
    fn rotated(&self, cos: f64, sin: f64) -> Self;

    /// What reflection, or transmission, at an interface does to this kind of state.
    type Passage: Passage;

    /// The light behind an interface whose plane of incidence is spanned by x̂: x̂ is p, ŷ is s.
    #[must_use]
    fn times(&self, by: &Self::Passage) -> Self;

    /// The light with its power multiplied.
    #[must_use]
    fn scaled(&self, power: f64) -> Self;
}

/// One of the two beams of an interface.
pub trait Passage: Copy + Send + Sync + std::fmt::Debug + 'static {
    /// From power-normalised amplitude coefficients.
    fn new(amplitudes: Pair<C64>) -> Self;

    /// Reflection at an interface between transparent media.
    fn reflection(d: &Dielectric) -> Self;

    /// Transmission through one.
    fn transmission(d: &Refracted) -> Self;

    /// Shares of the power that s and p light have in this beam.
    fn shares(&self) -> Pair<f64>;
}

/// A Jones matrix: column c is the field that the c-th of two orthogonal inputs has become. Unpolarized light is
/// both inputs at half power; they never interfere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jones {
    /// Component along x̂, per column.
    pub x: [C64; 2],
    /// Component along ŷ, per column.
    pub y: [C64; 2],
}

/// Amplitude coefficients.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Amplitudes(Pair<C64>);

impl Passage for Amplitudes {
    fn new(amplitudes: Pair<C64>) -> Self {
        Self(amplitudes)
    }

    fn reflection(d: &Dielectric) -> Self {
        Self(d.r())
    }

    fn transmission(d: &Refracted) -> Self {
        Self(d.t().map(C64::from))
    }

    #[inline]
    fn shares(&self) -> Pair<f64> {
        self.0.map(|a| a.norm_sqr())
    }
}

impl Field for Jones {
    type Passage = Amplitudes;

    fn linear(along_x: bool) -> Self {
        let (one, zero) = ([C64::ONE, C64::ZERO], [C64::ZERO; 2]);
        if along_x { Self { x: one, y: zero } } else { Self { x: zero, y: one } }
    }

    fn unpolarized(power: f64) -> Self {
        let a = C64::new((0.5 * power).sqrt(), 0.0);
        Self { x: [a, C64::ZERO], y: [C64::ZERO, a] }
    }

    #[inline]
    fn powers(&self) -> [f64; 2] {
        let sum = |c: &[C64; 2]| c[0].norm_sqr() + c[1].norm_sqr();
        [sum(&self.x), sum(&self.y)]
    }

    #[inline]
    fn power(&self) -> f64 {
        let [x, y] = self.powers();
        x + y
    }

    #[inline]
    fn rotated(&self, cos: f64, sin: f64) -> Self {
        let at = |c: usize| (self.x[c] * cos + self.y[c] * sin, self.y[c] * cos - self.x[c] * sin);
        let ((x0, y0), (x1, y1)) = (at(0), at(1));
        Self { x: [x0, x1], y: [y0, y1] }
    }

    #[inline]
    fn times(&self, Amplitudes(by): &Amplitudes) -> Self {
        Self { x: self.x.map(|e| e * by.p), y: self.y.map(|e| e * by.s) }
    }

    #[inline]
    fn scaled(&self, power: f64) -> Self {
        let a = power.sqrt();
        Self { x: self.x.map(|e| e * a), y: self.y.map(|e| e * a) }
    }
}

/// A Stokes vector: I = |Eₓ|² + |E_y|², Q = |Eₓ|² − |E_y|², U + iV = 2 Eₓ E_y*.
///
/// The same paths as with [`Jones`], with half the numbers: whatever is not summed as fields needs no more.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stokes {
    /// Power.
    pub i: f64,
    /// Power along x̂ minus power along ŷ.
    pub q: f64,
    /// Power at 45° minus power at −45°.
    pub u: f64,
    /// Handedness.
    pub v: f64,
}

/// Shares of the power of s and p light, and what becomes of their correlation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Powers {
    shares: Pair<f64>,
    cross: C64,
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

    #[inline]
    fn shares(&self) -> Pair<f64> {
        self.shares
    }
}

impl Field for Stokes {
    type Passage = Powers;

    fn linear(along_x: bool) -> Self {
        Self { i: 1.0, q: if along_x { 1.0 } else { -1.0 }, u: 0.0, v: 0.0 }
    }

    fn unpolarized(power: f64) -> Self {
        Self { i: power, q: 0.0, u: 0.0, v: 0.0 }
    }

    #[inline]
    fn powers(&self) -> [f64; 2] {
        [0.5 * (self.i + self.q), 0.5 * (self.i - self.q)]
    }

    #[inline]
    fn power(&self) -> f64 {
        self.i
    }

    #[inline]
    fn rotated(&self, cos: f64, sin: f64) -> Self {
        // Twice the angle.
        let (c, s) = ((cos - sin) * (cos + sin), 2.0 * cos * sin);
        Self { q: self.q * c + self.u * s, u: self.u * c - self.q * s, ..*self }
    }

    #[inline]
    fn times(&self, Powers { shares, cross }: &Powers) -> Self {
        let [x, y] = self.powers();
        let (x, y) = (x * shares.p, y * shares.s);
        Self { i: x + y, q: x - y, u: self.u * cross.re - self.v * cross.im, v: self.v * cross.re + self.u * cross.im }
    }

    #[inline]
    fn scaled(&self, power: f64) -> Self {
        Self { i: self.i * power, q: self.q * power, u: self.u * power, v: self.v * power }
    }
}

impl From<Jones> for Stokes {
    fn from(j: Jones) -> Self {
        let [x, y] = j.powers();
        let cross: C64 = (0..2).map(|c| j.x[c] * j.y[c].conj() * 2.0).sum();
        Self { i: x + y, q: x - y, u: cross.re, v: cross.im }
    }
}

#[cfg(test)]
mod tests {
    use rand::rngs::Xoshiro256PlusPlus;
    use rand::{RngExt, SeedableRng};

    use super::super::fresnel::dielectric;
    use super::*;

    #[test]
    fn interfaces_act_alike_on_both() {
        for (n1, n2) in [(1.0, 1.5), (1.5, 1.0)] {
            for i in 1..50 {
                let cos: f64 = f64::from(i) / 50.0;
                let d = dielectric(n1, n2, cos, ((1.0 - cos) * (1.0 + cos)).sqrt());
                let same = |a: Powers, b: Amplitudes| {
                    let b = Powers::new(b.0);
                    assert!((a.shares.s - b.shares.s).abs() < 1e-15 && (a.shares.p - b.shares.p).abs() < 1e-15);
                    assert!((a.cross - b.cross).norm() < 1e-15);
                };
                same(Powers::reflection(&d), Amplitudes::reflection(&d));
                if let Dielectric::Partial(t) = d {
                    same(Powers::transmission(&t), Amplitudes::transmission(&t));
                }
            }
        }
    }

    #[test]
    fn stokes_follows_jones() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(4);
        let mut number = || 2.0 * rng.random::<f64>() - 1.0;
        for start in [Jones::unpolarized(1.0), Jones::linear(true), Jones::linear(false)] {
            let (mut jones, mut stokes) = (start, Stokes::from(start));
            for _ in 0..20 {
                let angle: f64 = 3.0 * number();
                let by = Pair { s: C64::new(number(), number()), p: C64::new(number(), number()) };
                jones = jones.rotated(angle.cos(), angle.sin()).times(&Amplitudes::new(by));
                stokes = stokes.rotated(angle.cos(), angle.sin()).times(&Powers::new(by));
                let scale = 1.0 / jones.power();
                (jones, stokes) = (jones.scaled(scale), stokes.scaled(scale));
                let same = Stokes::from(jones);
                for (a, b) in [(same.i, stokes.i), (same.q, stokes.q), (same.u, stokes.u), (same.v, stokes.v)] {
                    assert!((a - b).abs() < 1e-12, "{same:?} {stokes:?}");
                }
                assert!((jones.powers()[0] - stokes.powers()[0]).abs() < 1e-12);
            }
        }
    }
}
