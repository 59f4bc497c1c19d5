//! Jones matrices: fields with their phase.

use num_complex::Complex;

use super::super::{C64, Pair};
use super::{Dielectric, Field, Number, Parts, Passage, Refracted, Shares, State};

/// A Jones matrix: column c is the field that the c-th of two orthogonal inputs has become, which make up the incident
/// light and never interfere: unpolarized light is any two at half power.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jones<T = f64> {
    /// Component along x̂, per column.
    pub x: [Complex<T>; 2],
    /// Component along ŷ, per column.
    pub y: [Complex<T>; 2],
}

/// Amplitude coefficients.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Amplitudes<T = f64>(Pair<Complex<T>>);

#[inline(always)]
fn norm_sqr<T: Number>(z: Complex<T>) -> T {
    z.re * z.re + z.im * z.im
}

#[inline(always)]
fn product<T: Number>(a: Complex<T>, b: Complex<T>) -> Complex<T> {
    Complex { re: a.re * b.re - a.im * b.im, im: a.re * b.im + a.im * b.re }
}

/// cos·a + sin·b.
#[inline(always)]
fn turned<T: Number>(a: Complex<T>, b: Complex<T>, cos: f64, sin: f64) -> Complex<T> {
    Complex { re: a.re * cos + b.re * sin, im: a.im * cos + b.im * sin }
}

#[inline(always)]
fn scaled<T: Number>(z: Complex<T>, by: T) -> Complex<T> {
    Complex { re: z.re * by, im: z.im * by }
}

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
}

impl<T: Number> Parts<T> for Amplitudes<T> {
    const PARTS: usize = 4;

    #[inline(always)]
    fn from_parts(parts: &[T]) -> Self {
        let s = Complex { re: parts[0], im: parts[1] };
        Self(Pair { s, p: Complex { re: parts[2], im: parts[3] } })
    }

    #[inline(always)]
    fn write(&self, to: &mut [T]) {
        let Self(Pair { s, p }) = self;
        (to[0], to[1], to[2], to[3]) = (s.re, s.im, p.re, p.im);
    }
}

impl<T: Number> Shares<T> for Amplitudes<T> {
    #[inline(always)]
    fn shares(&self) -> Pair<T> {
        Pair { s: norm_sqr(self.0.s), p: norm_sqr(self.0.p) }
    }
}

impl<T: Number> Parts<T> for Jones<T> {
    const PARTS: usize = 8;

    #[inline(always)]
    fn from_parts(parts: &[T]) -> Self {
        let x = [Complex { re: parts[0], im: parts[1] }, Complex { re: parts[2], im: parts[3] }];
        Self { x, y: [Complex { re: parts[4], im: parts[5] }, Complex { re: parts[6], im: parts[7] }] }
    }

    #[inline(always)]
    fn write(&self, to: &mut [T]) {
        let Self { x, y } = self;
        (to[0], to[1], to[2], to[3]) = (x[0].re, x[0].im, x[1].re, x[1].im);
        (to[4], to[5], to[6], to[7]) = (y[0].re, y[0].im, y[1].re, y[1].im);
    }
}

impl<T: Number> State<T> for Jones<T> {
    type Passage = Amplitudes<T>;

    #[inline(always)]
    fn powers(&self) -> [T; 2] {
        let Self { x, y } = self;
        [norm_sqr(x[0]) + norm_sqr(x[1]), norm_sqr(y[0]) + norm_sqr(y[1])]
    }

    #[inline(always)]
    fn rotated(&self, cos: f64, sin: f64) -> Self {
        let Self { x, y } = *self;
        Self {
            x: [turned(x[0], y[0], cos, sin), turned(x[1], y[1], cos, sin)],
            y: [turned(y[0], x[0], cos, -sin), turned(y[1], x[1], cos, -sin)],
        }
    }

    #[inline(always)]
    fn times(&self, Amplitudes(by): &Amplitudes<T>) -> Self {
        let Self { x, y } = *self;
        Self { x: [product(x[0], by.p), product(x[1], by.p)], y: [product(y[0], by.s), product(y[1], by.s)] }
    }

    #[inline(always)]
    fn scaled(&self, power: T) -> Self {
        let (a, Self { x, y }) = (power.sqrt(), *self);
        Self { x: [scaled(x[0], a), scaled(x[1], a)], y: [scaled(y[0], a), scaled(y[1], a)] }
    }
}

impl Field for Jones {
    type Of<T: Number> = Jones<T>;
    const COMPONENTS: usize = 1;

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
}
