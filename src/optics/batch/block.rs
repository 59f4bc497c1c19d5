//! A block of wavelengths: what is known of the media around a stack, and the steps through its layers.

use std::f64::consts::TAU;

use pulp::Simd;

use super::slab::{Slab, meaningful, real_step, reduced_phase};
use super::steps::{COEFFICIENTS, Kind, Steps, store};
use super::{Question, Spectrum};
use crate::optics::film::{Incidence, MUCH};
use crate::optics::lanes::{Complex, Lanes, Mask, Number as _, WIDEST};

/// One block of wavelengths: what is known of them outside the stack.
pub(super) struct Block<S: Simd> {
    pub s: S,
    pub number: usize,
    /// Index and normal wave number of the first medium.
    pub n0: Lanes<S>,
    pub kz0: Lanes<S>,
    /// k_z² = (n − a)(n + a) + b: a form without cancellation.
    a: Lanes<S>,
    b: Lanes<S>,
    wavelength: Lanes<S>,
    /// Index and normal wave number of the last medium.
    pub last: Complex<S>,
    pub kzn: Complex<S>,
    /// Sum of the decays and of the turns that waves leave out.
    pub decay: Lanes<S>,
    pub turns: Lanes<S>,
}

/// Normal wave number in a layer.
pub(super) struct Normal<S: Simd> {
    pub squared: Complex<S>,
    /// Where it is real and not 0.
    pub travels: Mask<S>,
}

impl<S: Simd> Block<S> {
    /// Block `number` of the wavelengths; the last ones are repeated where there are no more.
    #[inline(always)]
    pub fn new(s: S, q: &Question<'_>, number: usize) -> Self {
        let mut rows = [[0.0; WIDEST]; 5];
        for lane in 0..S::F64_LANES {
            let w = (number * S::F64_LANES + lane).min(q.wavelengths.len() - 1);
            let Incidence { index, kz, kx, grazing } = q.incidences[w];
            let (a, b) = if grazing { (index, kz * kz) } else { (kx, 0.0) };
            [index, kz, a, b, q.wavelengths[w]].into_iter().zip(&mut rows).for_each(|(x, row)| row[lane] = x);
        }
        let zero = Lanes::splat(s, 0.0);
        let mut block = Self {
            s,
            number,
            n0: Lanes::load(s, &rows[0], 0),
            kz0: Lanes::load(s, &rows[1], 0),
            a: Lanes::load(s, &rows[2], 0),
            b: Lanes::load(s, &rows[3], 0),
            wavelength: Lanes::load(s, &rows[4], 0),
            last: Complex::load(s, &q.last().re, &q.last().im, number),
            kzn: Complex::real(zero),
            decay: zero,
            turns: zero,
        };
        block.kzn = block.root(&block.normal(block.last));
        block
    }

    #[inline(always)]
    fn normal(&self, n: Complex<S>) -> Normal<S> {
        let zero = n.re.number(0.0);
        let (low, high) = (n.re - self.a, n.re + self.a);
        let re = low * high - n.im * n.im + self.b;
        let lossless = n.im.eq(zero);
        let same = lossless.and(n.re.eq(self.n0));
        let re = same.choose(self.kz0 * self.kz0, re);
        Normal { squared: Complex { re, im: (low + high) * n.im }, travels: lossless.and(re.gt(zero)) }
    }

    /// The wave number that decays, or travels, away.
    #[inline(always)]
    fn root(&self, normal: &Normal<S>) -> Complex<S> {
        let travelling = Complex::real(normal.squared.re.sqrt());
        if normal.travels.all() {
            return travelling;
        }
        normal.travels.choose_complex(travelling, normal.squared.outgoing_root())
    }

    /// V/U of waves in the first medium and in the last.
    #[inline(always)]
    pub fn admittances(&self, p: bool) -> [Complex<S>; 2] {
        let (q0, qn) = (Complex::real(self.kz0), self.kzn);
        let first = Complex::real(self.n0);
        if p { [q0.over(first * first), qn.over(self.last * self.last)] } else { [q0, qn] }
    }

    /// Fills in the steps through all layers.
    #[inline(always)]
    pub fn prepare(&mut self, q: &Question<'_>, steps: &mut Steps) {
        steps.clear();
        let mut end = 0;
        for film in q.films {
            let Spectrum { re, im, .. } = &q.media[film.medium];
            let n = Complex::load(self.s, re, im, self.number);
            let normal = self.normal(n);
            let length = n.re.number(film.thickness).over(self.wavelength);
            let start = end;
            if normal.travels.all() {
                end = steps.claim(Kind::Real, start, S::F64_LANES);
                let step = real_step(n.re, normal.squared.re.sqrt(), length);
                for (i, x) in step.iter().enumerate() {
                    x.store(&mut steps.rows[start..end], i);
                }
            } else {
                end = self.prepare_complex(n, normal, length, start, steps);
            }
        }
    }

    /// The step through a layer in which some lane does not travel; returns where its rows end.
    #[inline(always)]
    fn prepare_complex(
        &mut self,
        n: Complex<S>,
        normal: Normal<S>,
        length: Lanes<S>,
        start: usize,
        steps: &mut Steps,
    ) -> usize {
        let kz = self.root(&normal);
        let (decay, turns) = (kz.im * length * TAU, meaningful(kz.re * length));
        let layer = Slab { n, normal, kz, phase: reduced_phase(turns), decay, length };
        let much = decay.gt(decay.number(MUCH));
        let (any, all) = (much.any(), much.all());
        let kind = if all {
            Kind::Waves
        } else if any {
            Kind::Mixed
        } else {
            Kind::Complex
        };
        let end = steps.claim(kind, start, S::F64_LANES);
        let mut rows = &mut steps.rows[start..end];
        if !all {
            store(&layer.coefficients(), rows);
            rows = &mut rows[2 * COEFFICIENTS * S::F64_LANES..];
        }
        if any {
            store(&layer.waves(), rows);
            let zero = decay.number(0.0);
            let sum = self.turns + much.choose(turns - turns.round(), zero);
            self.turns = sum - sum.round();
            self.decay = self.decay + much.choose(decay, zero);
        }
        if any && !all {
            much.choose(decay, decay.number(0.0)).store(rows, 2 * COEFFICIENTS);
        }
        end
    }
}
