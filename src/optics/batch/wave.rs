//! A wave, and how it goes through a layer.

use pulp::Simd;

use super::steps::{COEFFICIENTS, Kind, Step};
use crate::optics::lanes::{Complex, Lanes, Number as _};

/// Fields stay within 2^±100, but for what a few layers can change; stacks of others are solved one by one.
const RESCALING: i32 = 200;
const UP: f64 = power_of_two(RESCALING);
const DOWN: f64 = power_of_two(-RESCALING);
const TINY: f64 = power_of_two(-RESCALING / 2);
const HUGE: f64 = power_of_two(RESCALING / 2);
pub(super) const STEPS_PER_RESCALING: usize = 4;

const fn power_of_two(exponent: i32) -> f64 {
    f64::from_bits(((1023 + exponent) as u64) << 52)
}

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
        match step.kind {
            Kind::Real => self.cross_real(step.real(p)),
            Kind::Complex => self.cross_complex(step.complex(0, p)),
            Kind::Waves => self.cross_as_waves(step.complex(0, p)),
            Kind::Mixed => {
                let mut other = *self;
                self.cross_complex(step.complex(0, p));
                other.cross_as_waves(step.complex(2 * COEFFICIENTS, p));
                let much = step.much();
                self.u = much.choose_complex(other.u, self.u);
                self.v = much.choose_complex(other.v, self.v);
            }
        }
    }

    /// b and g stand for −ib and −ig.
    #[inline(always)]
    fn cross_real(&mut self, [c, b, g]: [Lanes<S>; 3]) {
        let Self { u, v, .. } = *self;
        self.u = Complex { re: u.re * c + v.im * b, im: u.im * c - v.re * b };
        self.v = Complex { re: v.re * c + u.im * g, im: v.im * c - u.re * g };
    }

    /// The wave that grows on the way stays, the other one is multiplied by e^{2iδ}; see [`crate::optics::film`].
    #[inline(always)]
    fn cross_as_waves(&mut self, [round_trip, q, inverse]: [Complex<S>; 3]) {
        let Self { u, v, .. } = *self;
        let w = v * inverse;
        let half = u.re.number(0.5);
        let (growing, decaying) = ((u + w).times(half), (u - w).times(half) * round_trip);
        self.u = growing + decaying;
        self.v = (growing - decaying) * q;
    }

    #[inline(always)]
    fn cross_complex(&mut self, [c, b, g]: [Complex<S>; 3]) {
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
        let (tiny, huge) = (size.number(TINY).gt(size), size.gt(size.number(HUGE)));
        let one = size.number(1.0);
        if !tiny.or(huge).any() {
            return one;
        }
        let factor = tiny.choose(size.number(UP), huge.choose(size.number(DOWN), one));
        let shift = size.number(f64::from(RESCALING));
        self.u = self.u.times(factor);
        self.v = self.v.times(factor);
        self.exponent = self.exponent - tiny.choose(shift, huge.choose(-shift, size.number(0.0)));
        factor
    }
}
