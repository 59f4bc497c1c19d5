//! Jones matrices: fields with their phase.

use super::super::{C64, Pair};
use super::{Dielectric, Field, Passage, Refracted};

/// A Jones matrix: column c is the field that the c-th of two orthogonal inputs has become, which make up the incident
/// light and never interfere: unpolarized light is any two at half power.
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

impl Amplitudes {
    /// For s and for p.
    pub fn pair(&self) -> Pair<C64> {
        self.0
    }
}

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
    const COMPONENTS: usize = 1;
    type Passage = Amplitudes;

    /// The two orthogonal states into which the light falls apart: that along the polarized part of its Stokes vector, and
    /// the opposite one.
    fn incident([i, q, u, v]: [f64; 4]) -> Self {
        let polarized = (q * q + u * u + v * v).sqrt();
        let [strong, weak] = [0.5 * (i + polarized), 0.5 * (i - polarized).max(0.0)];
        // The state of the strong part: |Eₓ|² = (1 + q)/2, 2 Eₓ E_y* = u + iv.
        let [q, u, v] = if polarized > 0.0 { [q, u, v].map(|x| x / polarized) } else { [1.0, 0.0, 0.0] };
        let (x, y) = if q > -0.5 {
            let x = (0.5 * (1.0 + q)).sqrt();
            (C64::from(x), C64::new(u, -v) / (2.0 * x))
        } else {
            let y = (0.5 * (1.0 - q)).sqrt();
            (C64::new(u, v) / (2.0 * y), C64::from(y))
        };
        let [a, b] = [strong, weak].map(f64::sqrt);
        Self { x: [x * a, -y.conj() * b], y: [y * a, x.conj() * b] }
    }

    /// Incoherently: which is what a matt surface does, and a Jones matrix can only say of two inputs.
    fn depolarized(&self, share: f64) -> Self {
        Self::incident([share * self.power(), 0.0, 0.0, 0.0])
    }

    #[inline]
    fn powers(&self) -> [f64; 2] {
        let sum = |c: &[C64; 2]| c[0].norm_sqr() + c[1].norm_sqr();
        [sum(&self.x), sum(&self.y)]
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
