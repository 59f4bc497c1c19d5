//! A layer at a block of wavelengths: what it does to fields, in coefficients.

use std::f64::consts::TAU;

use pulp::Simd;

use super::block::Normal;
use super::steps::COEFFICIENTS;
use crate::optics::elementary::{exp_m1_negative, exp_split, sin_cos};
use crate::optics::film::MOST_TURNS;
use crate::optics::lanes::{Complex, Lanes, Number as _};

/// A layer in which some lane does not travel.
pub(super) struct Slab<S: Simd> {
    pub n: Complex<S>,
    pub normal: Normal<S>,
    pub kz: Complex<S>,
    /// Real part of δ without whole turns, and its imaginary part.
    pub phase: Lanes<S>,
    pub decay: Lanes<S>,
    /// Thickness in wavelengths.
    pub length: Lanes<S>,
}

impl<S: Simd> Slab<S> {
    /// c, b and g; real ones where light travels.
    #[inline(always)]
    pub fn coefficients(&self) -> [Complex<S>; COEFFICIENTS] {
        let Self { n, kz, length, .. } = *self;
        let zero = length.number(0.0);
        let (sin, cos) = sin_cos(self.phase);
        // cosh and sinh of the decay, from e^−x − 1.
        let m = exp_m1_negative(-self.decay);
        let twice = (m + m.number(1.0)) * 2.0;
        let (rise, sinh) = ((m * m).over(twice), -(m * (m + m.number(2.0))).over(twice));
        let cosh = rise + m.number(1.0);
        let (c, s) = (Complex { re: cos * cosh, im: -(sin * sinh) }, Complex { re: sin * cosh, im: cos * sinh });
        let standing = kz.norm_sqr().eq(zero);
        let b = standing.choose_complex(Complex { re: zero, im: length * -TAU }, minus_i(s.over(kz)));
        let (square, g) = (n * n, minus_i(s * kz));
        let mut step = [c, b, g, b * square, g.over(square)];
        let travels = self.normal.travels;
        if travels.any() {
            let real = real_step(n.re, self.normal.squared.re.sqrt(), length);
            step[0] = travels.choose_complex(Complex::real(real[0]), step[0]);
            for i in 1..COEFFICIENTS {
                step[i] = travels.choose_complex(Complex { re: zero, im: -real[i] }, step[i]);
            }
        }
        step
    }

    /// e^{2iδ}, and the admittance and its inverse.
    #[inline(always)]
    pub fn waves(&self) -> [Complex<S>; COEFFICIENTS] {
        let (sin, cos) = sin_cos(self.phase);
        let (mantissa, twos) = exp_split(self.decay * 2.0);
        let size = mantissa * twos.max(twos.number(-1022.0)).power_of_two();
        let round_trip = Complex { re: (cos * cos - sin * sin) * size, im: sin * cos * 2.0 * size };
        let (square, inverse) = (self.n * self.n, self.kz.inverse());
        [round_trip, self.kz, inverse, self.kz.over(square), inverse * square]
    }
}

/// c, and ib, ig for s and p, of a layer in which light travels; `length` in wavelengths.
#[inline(always)]
pub(super) fn real_step<S: Simd>(n: Lanes<S>, kz: Lanes<S>, length: Lanes<S>) -> [Lanes<S>; COEFFICIENTS] {
    let (sin, cos) = sin_cos(reduced_phase(meaningful(kz * length)));
    let square = n * n;
    let (b, g) = (sin.over(kz), kz * sin);
    [cos, b, g, b * square, g.over(square)]
}

#[inline(always)]
fn minus_i<S: Simd>(z: Complex<S>) -> Complex<S> {
    Complex { re: z.im, im: -z.re }
}

/// Turns of which something can be said, else none.
#[inline(always)]
pub(super) fn meaningful<S: Simd>(turns: Lanes<S>) -> Lanes<S> {
    turns.number(MOST_TURNS).gt(turns).choose(turns, turns.number(0.0))
}

/// 2π·turns. Whole turns are dropped only where that helps: below some 100 rad sine and cosine are exact enough, and the
/// reduction would only add its own rounding.
#[inline(always)]
pub(super) fn reduced_phase<S: Simd>(turns: Lanes<S>) -> Lanes<S> {
    const MANY: f64 = 16.0;
    turns.gt(turns.number(MANY)).choose(turns - turns.round(), turns) * TAU
}
