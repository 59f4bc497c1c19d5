//! What each layer absorbs, a block of wavelengths at a time: the difference of the fluxes through its faces.

use pulp::Simd;

use super::Question;
use super::block::Block;
use super::steps::{Kind, Steps};
use super::wave::{STEPS_PER_RESCALING, Wave};
use crate::optics::Pair;
use crate::optics::lanes::{Lanes, Number as _};

/// To find what the layers of a stack absorb; there is one at least.
pub(super) struct Losses<'a> {
    pub q: &'a Question<'a>,
    pub steps: &'a mut Steps,
    /// For each wavelength the share of each layer; zeros.
    pub out: &'a mut [Pair<f64>],
}

impl pulp::WithSimd for Losses<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) {
        let layers = self.q.films.len();
        self.steps.losses.resize(layers * ROWS * S::F64_LANES, 0.0);
        for (number, out) in self.out.chunks_mut(layers * S::F64_LANES).enumerate() {
            let mut block = Block::new(s, self.q, number);
            block.prepare(self.q, self.steps);
            let units = [block.lose(self.steps, false), block.lose(self.steps, true)];
            block.share(self.q, self.steps, units, out);
        }
    }
}

/// Rows of a layer: what it takes, and what one unit of power behind it is, in units of the power in front; for s, then
/// for p.
const ROWS: usize = 4;

impl<S: Simd> Block<S> {
    /// Fills in the rows of one polarization, from the back; returns what one unit in front of the stack is of the incident
    /// power, |q₀ U + V|²/4 q₀.
    #[inline(always)]
    fn lose(&self, steps: &mut Steps, p: bool) -> Lanes<S> {
        let [q0, qn] = self.admittances(p);
        let mut wave = Wave::outgoing(qn);
        let one = self.n0.number(1.0);
        for i in (0..steps.len()).rev() {
            let factor = if i % STEPS_PER_RESCALING == 0 { wave.rescale() } else { one };
            let step = steps.at(self.s, i);
            let (before, behind) = (wave.flux(), step.behind());
            wave.cross(&step, p);
            let lost = wave.flux() - before * behind;
            let row = i * ROWS + if p { 2 } else { 0 };
            lost.store(&mut steps.losses, row);
            (behind * factor * factor).store(&mut steps.losses, row + 1);
        }
        let factor = wave.rescale();
        let size = (q0 * wave.u + wave.v).norm_sqr();
        (q0.re * 4.0).over(size) * factor * factor
    }

    /// Writes the shares, from the front.
    #[inline(always)]
    fn share(&self, q: &Question<'_>, steps: &Steps, mut units: [Lanes<S>; 2], out: &mut [Pair<f64>]) {
        let zero = self.n0.number(0.0);
        for (i, film) in q.films.iter().enumerate() {
            let rows = &steps.losses[i * ROWS * S::F64_LANES..];
            if !matches!(steps.at(self.s, i).kind, Kind::Real) {
                let absorbs = Lanes::load(self.s, &q.media[film.medium].im, self.number).gt(zero);
                let s = absorbs.choose(zero.max(Lanes::load(self.s, rows, 0) * units[0]), zero).to_array();
                let p = absorbs.choose(zero.max(Lanes::load(self.s, rows, 2) * units[1]), zero).to_array();
                let out = out[i..].iter_mut().step_by(q.films.len());
                out.zip(s).zip(p).for_each(|((out, s), p)| *out = Pair { s, p });
            }
            units = [units[0] * Lanes::load(self.s, rows, 1), units[1] * Lanes::load(self.s, rows, 3)];
        }
    }
}
