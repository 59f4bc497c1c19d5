//! A wave, and how it goes through a layer.

use pulp::Simd;

use super::steps::{COEFFICIENTS, Kind, Step};
use crate::optics::lanes::{Complex, Lanes};

/// Fields stay within 2^±100, but for what a few layers can change; stacks of others are solved one by one.
const RESCALING: i32 = 200;
pub(super) const STEPS_PER_RESCALING: usize = 4;

/// Fields of a wave that left the stack, with the exponent of the power of two left out of them.
#[derive(Clone, Copy)]
pub(super) struct Wave<S: Simd> {
    pub u: Complex<S>,
    pub v: Complex<S>,
    pub exponent: Lanes<S>,
}

impl<S: Simd> Wave<S> {
    /// Of an admittance.
    #[inline(always)]
    pub fn outgoing(admittance: Complex<S>) -> Self {
        let one = admittance.re.number(1.0);
        Self { u: Complex::real(one), v: admittance, exponent: one.number(0.0) }
    }

    /// Goes through a layer.
    #[inline(always)]
    pub fn cross(&mut self, step: &Step<'_, S>, p: bool) {
        let first = if p { 3 } else { 1 };
        let (row, z) = (|i: usize| step.row(i), |at: usize, i: usize| step.complex(at, i));
        match step.kind {
            Kind::Real => self.cross_real(row(0), row(first), row(first + 1)),
            Kind::Complex => self.cross_complex(z(0, 0), z(0, first), z(0, first + 1)),
            Kind::Waves => self.cross_as_waves(z(0, 0), z(0, first), z(0, first + 1)),
            Kind::Mixed => {
                let second = 2 * COEFFICIENTS;
                let mut other = *self;
                self.cross_complex(z(0, 0), z(0, first), z(0, first + 1));
                other.cross_as_waves(z(second, 0), z(second, first), z(second, first + 1));
                let much = step.much();
                self.u = much.choose_complex(other.u, self.u);
                self.v = much.choose_complex(other.v, self.v);
            }
        }
    }

    /// b and g stand for −ib and −ig.
    #[inline(always)]
    fn cross_real(&mut self, c: Lanes<S>, b: Lanes<S>, g: Lanes<S>) {
        let Self { u, v, .. } = *self;
        self.u = Complex { re: u.re * c + v.im * b, im: u.im * c - v.re * b };
        self.v = Complex { re: v.re * c + u.im * g, im: v.im * c - u.re * g };
    }

    /// The wave that grows on the way stays, the other one is multiplied by e^{2iδ}; see [`crate::optics::film`].
    #[inline(always)]
    fn cross_as_waves(&mut self, round_trip: Complex<S>, q: Complex<S>, inverse: Complex<S>) {
        let Self { u, v, .. } = *self;
        let w = v * inverse;
        let half = u.re.number(0.5);
        let (growing, decaying) = ((u + w).times(half), (u - w).times(half) * round_trip);
        self.u = growing + decaying;
        self.v = (growing - decaying) * q;
    }

    #[inline(always)]
    fn cross_complex(&mut self, c: Complex<S>, b: Complex<S>, g: Complex<S>) {
        let Self { u, v, .. } = *self;
        self.u = u * c + v * b;
        self.v = v * c + u * g;
    }

    /// Power that flows through the interface, in the units of these fields.
    #[inline(always)]
    pub fn flux(&self) -> Lanes<S> {
        self.u.re * self.v.re + self.u.im * self.v.im
    }

    /// Keeps the fields within range by exact powers of two, which are returned.
    #[inline(always)]
    pub fn rescale(&mut self) -> Lanes<S> {
        let size = self.u.re.abs().max(self.u.im.abs()).max(self.v.re.abs().max(self.v.im.abs()));
        let [low, high] = [-RESCALING, RESCALING].map(|e| size.number(2f64.powi(e / 2)));
        let (tiny, huge) = (low.gt(size), size.gt(high));
        if !tiny.or(huge).any() {
            return size.number(1.0);
        }
        let pick = |of: fn(i32) -> f64| {
            let [up, none, down] = [RESCALING, 0, -RESCALING].map(|e| size.number(of(e)));
            tiny.choose(up, huge.choose(down, none))
        };
        let factor = pick(|e| 2f64.powi(e));
        self.u = self.u.times(factor);
        self.v = self.v.times(factor);
        self.exponent = self.exponent - pick(f64::from);
        factor
    }
}
