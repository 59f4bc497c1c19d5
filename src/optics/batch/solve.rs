//! Amplitudes of a stack, a block of wavelengths at a time.

use std::f64::consts::TAU;

use pulp::Simd;

use super::block::Block;
use super::steps::Steps;
use super::wave::{STEPS_PER_RESCALING, Wave};
use super::{Question, Sides};
use crate::optics::elementary::{exp_split, sin_cos};
use crate::optics::film::Amplitudes;
use crate::optics::lanes::{Complex, Lanes, Number as _, WIDEST};
use crate::optics::{C64, Pair};

/// To solve a stack.
pub(super) struct Work<'a> {
    pub q: &'a Question<'a>,
    pub sides: Sides,
    pub steps: &'a mut Steps,
    pub out: &'a mut Vec<Pair<Amplitudes>>,
}

impl pulp::WithSimd for Work<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) {
        let count = self.q.wavelengths.len();
        for number in 0..count.div_ceil(S::F64_LANES) {
            let mut block = Block::new(s, self.q, number);
            block.prepare(self.q, self.steps);
            let ends = [block.solve(self.steps, false, self.sides), block.solve(self.steps, true, self.sides)];
            let rows = [ends[0].rows(), ends[1].rows()];
            for lane in 0..S::F64_LANES.min(count - number * S::F64_LANES) {
                let [s, p] = [0, 1].map(|i| amplitudes(&rows[i], lane));
                self.out.push(Pair { s, p });
            }
        }
    }
}

fn amplitudes(rows: &[[f64; WIDEST]; 9], lane: usize) -> Amplitudes {
    let z = |i: usize| C64::new(rows[i][lane], rows[i + 1][lane]);
    Amplitudes { r: z(0), t: z(2), r_back: z(4), t_back: z(6), flux_ratio: rows[8][lane] }
}

impl<S: Simd> Block<S> {
    /// Both directions, for one polarization.
    #[inline(always)]
    fn solve(&self, steps: &Steps, p: bool, sides: Sides) -> Solved<S> {
        let first = Complex::real(self.n0);
        let [q0, qn] = self.admittances(p);
        let zero = Complex::real(self.n0.number(0.0));
        let front = self.sweep(steps, Wave::outgoing(qn), p, true);
        let denominator = q0 * front.u + front.v;
        // Without the factor kz0, so that both directions have it.
        let common = self.left_out(front.exponent).over(denominator);
        let common = if p { common.over(first * self.last) } else { common };
        let common = common + common;
        let flux = if p { self.kzn.conj() * self.last * self.last } else { self.kzn };
        let flux = if p { flux.re.over(self.last.norm_sqr()) } else { flux.re };
        let mut out = Solved {
            r: (q0 * front.u - front.v).over(denominator),
            t: common.times(self.kz0),
            r_back: zero,
            t_back: zero,
            flux_ratio: flux.max(zero.re).over(self.kz0),
        };
        if sides == Sides::Both {
            let back = self.sweep(steps, Wave::outgoing(q0), p, false);
            out.r_back = (qn * back.u - back.v).over(qn * back.u + back.v);
            out.t_back = common * self.kzn;
        }
        out
    }

    /// Carries fields through all layers: from the back to the front, or the other way.
    #[inline(always)]
    fn sweep(&self, steps: &Steps, mut wave: Wave<S>, p: bool, backwards: bool) -> Wave<S> {
        let count = steps.len();
        for i in 0..count {
            wave.cross(&steps.at(self.s, if backwards { count - 1 - i } else { i }), p);
            if i % STEPS_PER_RESCALING == STEPS_PER_RESCALING - 1 {
                wave.rescale();
            }
        }
        wave.rescale();
        wave
    }

    /// e^{iδ} of the complex steps and the powers of two that were split off.
    #[inline(always)]
    fn left_out(&self, exponent: Lanes<S>) -> Complex<S> {
        let (mantissa, twos) = exp_split(self.decay);
        let (sin, cos) = sin_cos(self.turns * TAU);
        let total = twos - exponent;
        let half = (total * 0.5).round();
        Complex { re: cos, im: sin }
            .times(mantissa)
            .times(limited_power_of_two(half))
            .times(limited_power_of_two(total - half))
    }
}

/// 2^k, or the nearest that there is.
#[inline(always)]
fn limited_power_of_two<S: Simd>(k: Lanes<S>) -> Lanes<S> {
    k.max(k.number(-1022.0)).min(k.number(1023.0)).power_of_two()
}

/// [`Amplitudes`] in lanes.
struct Solved<S: Simd> {
    r: Complex<S>,
    t: Complex<S>,
    r_back: Complex<S>,
    t_back: Complex<S>,
    flux_ratio: Lanes<S>,
}

impl<S: Simd> Solved<S> {
    #[inline(always)]
    fn rows(&self) -> [[f64; WIDEST]; 9] {
        let Self { r, t, r_back, t_back, flux_ratio } = self;
        let all = [r.re, r.im, t.re, t.im, r_back.re, r_back.im, t_back.re, t_back.im, *flux_ratio];
        let mut rows = [[0.0; WIDEST]; 9];
        for (row, x) in rows.iter_mut().zip(all) {
            x.store(row, 0);
        }
        rows
    }
}
