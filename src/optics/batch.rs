//! Film stacks at many wavelengths at once: the sweep of [`super::film`] in [`super::lanes`].
//!
//! What depends on a layer only (its wave number, its phase) is computed once for both polarizations and both
//! directions. Layers in which all lanes travel keep real coefficients; where some are absorbed or evanescent all
//! take complex ones, which for the others are the same numbers beside zeros.

use std::f64::consts::TAU;

use pulp::Simd;

use super::elementary::{exp_m1_negative, exp_split, sin_cos};
use super::film::{self, Amplitudes, Incidence, Layer, MOST_TURNS, MUCH, bare};
use super::lanes::{Complex, Lanes, Mask, WIDEST};
use super::{C64, Pair};

/// Complex numbers over wavelength, as the solver reads them: parts apart, padded with copies of the last.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Spectrum {
    len: usize,
    re: Vec<f64>,
    im: Vec<f64>,
}

impl Spectrum {
    /// How many.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// The number of a wavelength.
    #[inline]
    pub fn at(&self, i: usize) -> C64 {
        C64::new(self.re[i], self.im[i])
    }
}

impl FromIterator<C64> for Spectrum {
    fn from_iter<T: IntoIterator<Item = C64>>(numbers: T) -> Self {
        let mut all: Vec<C64> = numbers.into_iter().collect();
        let len = all.len();
        if let Some(&last) = all.last() {
            all.resize(len.next_multiple_of(WIDEST), last);
        }
        Self { len, re: all.iter().map(|z| z.re).collect(), im: all.iter().map(|z| z.im).collect() }
    }
}

/// A layer whose index depends on the wavelength.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Film {
    /// Number of its medium in [`Question::media`].
    pub medium: usize,
    /// Thickness, in the unit of the wavelengths.
    pub thickness: f64,
}

/// A stack at many wavelengths.
#[derive(Clone, Copy, Debug)]
pub struct Question<'a> {
    /// Direction of the light in the first medium, at each wavelength.
    pub incidences: &'a [Incidence],
    /// Complex index of every medium.
    pub media: &'a [Spectrum],
    /// Layers, from the side of the light.
    pub films: &'a [Film],
    /// Number of the last medium.
    pub last: usize,
    /// Vacuum wavelengths.
    pub wavelengths: &'a [f64],
}

impl Question<'_> {
    fn last(&self) -> &Spectrum {
        &self.media[self.last]
    }
}

/// From which sides a stack is lit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sides {
    /// From the first medium: the amplitudes from the last one remain 0.
    Front,
    /// From both.
    Both,
}

/// Solves stacks; keeps its memory from one to the next.
#[derive(Debug)]
pub struct Solver {
    arch: pulp::Arch,
    steps: Steps,
}

impl Default for Solver {
    fn default() -> Self {
        Self { arch: pulp::Arch::new(), steps: Steps::default() }
    }
}

impl Solver {
    /// What [`film::absorptances`] gives: for each wavelength the share of each layer.
    pub fn absorptances(&mut self, q: &Question<'_>, out: &mut Vec<Pair<f64>>) {
        out.clear();
        out.resize(q.wavelengths.len() * q.films.len(), Pair { s: 0.0, p: 0.0 });
        if !q.films.is_empty() {
            self.arch.dispatch(Losses { q, steps: &mut self.steps, out });
        }
    }

    /// What [`film::solve`] gives, for each wavelength.
    pub fn solve(&mut self, q: &Question<'_>, sides: Sides, out: &mut Vec<Pair<Amplitudes>>) {
        out.clear();
        if q.films.is_empty() {
            out.extend(q.incidences.iter().enumerate().map(|(w, incidence)| bare(incidence, q.last().at(w))));
            return;
        }
        self.arch.dispatch(Work { q, sides, steps: &mut self.steps, out });
        // Lanes do not look after numbers whose squares leave the range.
        for (w, both) in out.iter_mut().enumerate() {
            if !both.s.is_finite() || !both.p.is_finite() || !(1e-6..1e6).contains(&q.incidences[w].index) {
                *both = one_by_one(q, w);
            }
        }
    }
}

#[cold]
fn one_by_one(q: &Question<'_>, w: usize) -> Pair<Amplitudes> {
    let layers: Vec<Layer> =
        q.films.iter().map(|f| Layer { index: q.media[f.medium].at(w), thickness: f.thickness }).collect();
    film::solve(&q.incidences[w], &layers, q.last().at(w), q.wavelengths[w])
}

struct Work<'a> {
    q: &'a Question<'a>,
    sides: Sides,
    steps: &'a mut Steps,
    out: &'a mut Vec<Pair<Amplitudes>>,
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
            let rows = ends.map(|e| e.rows());
            for lane in 0..S::F64_LANES.min(count - number * S::F64_LANES) {
                let [s, p] = [0, 1].map(|i| amplitudes(&rows[i], lane));
                self.out.push(Pair { s, p });
            }
        }
    }
}

struct Losses<'a> {
    q: &'a Question<'a>,
    steps: &'a mut Steps,
    out: &'a mut [Pair<f64>],
}

impl pulp::WithSimd for Losses<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) {
        let (count, layers) = (self.q.wavelengths.len(), self.q.films.len());
        for number in 0..count.div_ceil(S::F64_LANES) {
            let mut block = Block::new(s, self.q, number);
            block.prepare(self.q, self.steps);
            for p in [false, true] {
                block.losses(self.steps, p, |layer, shares| {
                    let medium = &self.q.media[self.q.films[layer].medium];
                    let used = S::F64_LANES.min(count - number * S::F64_LANES);
                    for (lane, share) in shares.into_iter().enumerate().take(used) {
                        let w = number * S::F64_LANES + lane;
                        let out = &mut self.out[w * layers + layer];
                        let share = if medium.im[w] > 0.0 { share.max(0.0) } else { 0.0 };
                        if p { out.p = share } else { out.s = share }
                    }
                });
            }
        }
    }
}

fn amplitudes(rows: &[[f64; WIDEST]; 9], lane: usize) -> Amplitudes {
    let z = |i: usize| C64::new(rows[i][lane], rows[i + 1][lane]);
    Amplitudes { r: z(0), t: z(2), r_back: z(4), t_back: z(6), flux_ratio: rows[8][lane] }
}

/// What layers do to fields: rows of lanes, layer by layer.
#[derive(Debug, Default)]
struct Steps {
    layers: Vec<(Kind, usize)>,
    rows: Vec<f64>,
}

/// How lanes go through a layer.
#[derive(Clone, Copy, Debug)]
enum Kind {
    /// Light travels in all: U' = c U + b V, V' = c V + g U with rows c, and ib and ig for s, then for p.
    Real,
    /// The same with complex coefficients: all real parts, then all imaginary ones.
    Complex,
    /// As two waves: rows e^{2iδ}, and the admittance and its inverse for s, then for p; real parts, then imaginary ones;
    /// then Im δ.
    Waves,
    /// Some lanes as `Complex`, some as `Waves`: the rows of both; Im δ is 0 where waves do not count.
    Mixed,
}

/// Complex coefficients of a layer.
const COEFFICIENTS: usize = 5;

impl Kind {
    /// Number of its rows.
    fn rows(self) -> usize {
        match self {
            Self::Real => COEFFICIENTS,
            Self::Complex => 2 * COEFFICIENTS,
            Self::Waves => 2 * COEFFICIENTS + 1,
            Self::Mixed => 4 * COEFFICIENTS + 1,
        }
    }
}

/// One block of wavelengths: what is known of them outside the stack.
struct Block<S: Simd> {
    s: S,
    number: usize,
    /// Index and normal wave number of the first medium.
    n0: Lanes<S>,
    kz0: Lanes<S>,
    /// k_z² = (n − a)(n + a) + b: a form without cancellation.
    a: Lanes<S>,
    b: Lanes<S>,
    wavelength: Lanes<S>,
    /// Index and normal wave number of the last medium.
    last: Complex<S>,
    kzn: Complex<S>,
    /// Sum of the decays and of the turns that waves leave out.
    decay: Lanes<S>,
    turns: Lanes<S>,
}

/// A layer in which some lane does not travel.
struct Layered<S: Simd> {
    n: Complex<S>,
    normal: Normal<S>,
    kz: Complex<S>,
    /// Real part of δ without whole turns, and its imaginary part.
    phase: Lanes<S>,
    decay: Lanes<S>,
    length: Lanes<S>,
}

/// Normal wave number in a layer.
struct Normal<S: Simd> {
    squared: Complex<S>,
    /// Where it is real and not 0.
    travels: Mask<S>,
}

impl<S: Simd> Block<S> {
    #[inline(always)]
    fn new(s: S, q: &Question<'_>, number: usize) -> Self {
        let mut rows = [[0.0; WIDEST]; 5];
        for lane in 0..S::F64_LANES {
            let w = (number * S::F64_LANES + lane).min(q.wavelengths.len() - 1);
            let Incidence { index, kz, kx, grazing } = q.incidences[w];
            let (a, b) = if grazing { (index, kz * kz) } else { (kx, 0.0) };
            [index, kz, a, b, q.wavelengths[w]].into_iter().zip(&mut rows).for_each(|(x, row)| row[lane] = x);
        }
        let [n0, kz0, a, b, wavelength] = rows.map(|row| Lanes::load(s, &row, 0));
        let zero = n0.number(0.0);
        let mut block = Self {
            s,
            number,
            n0,
            kz0,
            a,
            b,
            wavelength,
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

    /// Fills in the steps through all layers.
    #[inline(always)]
    fn prepare(&mut self, q: &Question<'_>, steps: &mut Steps) {
        steps.layers.clear();
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
                step.iter().enumerate().for_each(|(i, x)| x.store(&mut steps.rows[start..end], i));
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
        let layer = Layered { n, normal, kz, phase: reduced_phase(turns), decay, length };
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
            let decay = much.choose(decay, zero);
            self.decay = self.decay + decay;
            decay.store(rows, 2 * COEFFICIENTS);
        }
        end
    }

    /// Both directions, for one polarization.
    #[inline(always)]
    fn solve(&self, steps: &Steps, p: bool, sides: Sides) -> Solved<S> {
        let first = Complex::real(self.n0);
        let admittance = |n: Complex<S>, kz: Complex<S>| if p { kz.over(n * n) } else { kz };
        let (q0, qn) = (admittance(first, Complex::real(self.kz0)), admittance(self.last, self.kzn));
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

    /// e^{iδ} of the complex steps and the powers of two that were split off.
    #[inline(always)]
    fn left_out(&self, exponent: Lanes<S>) -> Complex<S> {
        let (mantissa, twos) = exp_split(self.decay);
        let (sin, cos) = sin_cos(self.turns * TAU);
        let limit = |k: Lanes<S>| k.max(k.number(-1022.0)).min(k.number(1023.0)).power_of_two();
        let total = twos - exponent;
        let half = (total * 0.5).round();
        Complex { re: cos, im: sin }.times(mantissa).times(limit(half)).times(limit(total - half))
    }

    /// Calls `tell` with the share of the incident power that each layer absorbs, lane by lane, from the last layer on: the
    /// difference of the fluxes through its faces.
    #[inline(always)]
    fn losses(&self, steps: &Steps, p: bool, mut tell: impl FnMut(usize, [f64; WIDEST])) {
        let admittance = |n: Complex<S>, kz: Complex<S>| if p { kz.over(n * n) } else { kz };
        let q0 = admittance(Complex::real(self.n0), Complex::real(self.kz0));
        let mut wave = Wave::outgoing(admittance(self.last, self.kzn));
        let mut decay = self.n0.number(0.0);
        let mut met = Vec::with_capacity(steps.layers.len());
        for (i, &(kind, start)) in steps.layers.iter().enumerate().rev() {
            let rows = &steps.rows[start..start + kind.rows() * S::F64_LANES];
            let before = wave.flux();
            let kept = self.cross(&mut wave, kind, rows, p);
            let lost = wave.flux() - kept.map_or(before, |(kept, _)| before * kept);
            decay = kept.map_or(decay, |(_, more)| decay + more);
            // In units of 2^scale.
            let scale = (wave.exponent + decay * std::f64::consts::LOG2_E) * 2.0;
            met.push((i, lost.to_array(), scale.to_array()));
            wave.rescale();
        }
        let incident = (q0 * wave.u + wave.v).norm_sqr().over(q0.re * 4.0).to_array();
        let end = ((wave.exponent + decay * std::f64::consts::LOG2_E) * 2.0).to_array();
        for (layer, lost, scale) in met {
            tell(layer, std::array::from_fn(|l| lost[l] * (scale[l] - end[l]).exp2() / incident[l]));
        }
    }

    /// Carries fields through all layers: from the back to the front, or the other way.
    #[inline(always)]
    fn sweep(&self, steps: &Steps, mut wave: Wave<S>, p: bool, backwards: bool) -> Wave<S> {
        let count = steps.layers.len();
        for i in 0..count {
            let (kind, start) = steps.layers[if backwards { count - 1 - i } else { i }];
            let rows = &steps.rows[start..start + kind.rows() * S::F64_LANES];
            self.cross(&mut wave, kind, rows, p);
            if i % STEPS_PER_RESCALING == STEPS_PER_RESCALING - 1 {
                wave.rescale();
            }
        }
        wave.rescale();
        wave
    }
}

impl<S: Simd> Block<S> {
    /// Carries fields through one layer. Where waves are followed apart, they lack e^{iδ} on the other side; |e^{2iδ}|, by
    /// which powers before count there, is returned with Im δ.
    #[inline(always)]
    fn cross(&self, wave: &mut Wave<S>, kind: Kind, rows: &[f64], p: bool) -> Option<(Lanes<S>, Lanes<S>)> {
        let first = if p { 3 } else { 1 };
        let row = |i: usize| Lanes::load(self.s, rows, i);
        let z = |at: usize, i: usize| Complex { re: row(at + i), im: row(at + i + COEFFICIENTS) };
        match kind {
            Kind::Real => wave.cross_real(row(0), row(first), row(first + 1)),
            Kind::Complex => wave.cross_complex(z(0, 0), z(0, first), z(0, first + 1)),
            Kind::Waves => {
                wave.cross_as_waves(z(0, 0), z(0, first), z(0, first + 1));
                return Some((z(0, 0).norm_sqr().sqrt(), row(2 * COEFFICIENTS)));
            }
            Kind::Mixed => {
                let second = 2 * COEFFICIENTS;
                let mut other = *wave;
                wave.cross_complex(z(0, 0), z(0, first), z(0, first + 1));
                other.cross_as_waves(z(second, 0), z(second, first), z(second, first + 1));
                let decay = row(2 * second);
                let much = decay.gt(decay.number(0.0));
                wave.u = much.choose_complex(other.u, wave.u);
                wave.v = much.choose_complex(other.v, wave.v);
                return Some((much.choose(z(second, 0).norm_sqr().sqrt(), decay.number(1.0)), decay));
            }
        }
        None
    }
}

impl Steps {
    /// Makes room for the next layer; returns where its rows end.
    #[inline(always)]
    fn claim(&mut self, kind: Kind, start: usize, lanes: usize) -> usize {
        let end = start + kind.rows() * lanes;
        if self.rows.len() < end {
            self.rows.resize(end.next_power_of_two(), 0.0);
        }
        self.layers.push((kind, start));
        end
    }
}

#[inline(always)]
fn store<S: Simd>(step: &[Complex<S>; COEFFICIENTS], rows: &mut [f64]) {
    for (i, z) in step.iter().enumerate() {
        z.re.store(rows, i);
        z.im.store(rows, i + COEFFICIENTS);
    }
}

impl<S: Simd> Layered<S> {
    /// c, b and g; real ones where light travels.
    #[inline(always)]
    fn coefficients(&self) -> [Complex<S>; COEFFICIENTS] {
        let Self { n, kz, length, .. } = *self;
        let zero = length.number(0.0);
        let (sin, cos) = sin_cos(self.phase);
        // cosh and sinh of the decay, from e^−x − 1.
        let m = exp_m1_negative(-self.decay);
        let twice = (m + m.number(1.0)) * 2.0;
        let (rise, sinh) = ((m * m).over(twice), -(m * (m + m.number(2.0))).over(twice));
        let cosh = rise + m.number(1.0);
        let (c, s) = (Complex { re: cos * cosh, im: -(sin * sinh) }, Complex { re: sin * cosh, im: cos * sinh });
        let minus_i = |z: Complex<S>| Complex { re: z.im, im: -z.re };
        let standing = kz.norm_sqr().eq(zero);
        let b = standing.choose_complex(Complex { re: zero, im: length * -TAU }, minus_i(s.over(kz)));
        let (square, g) = (n * n, minus_i(s * kz));
        let step = [c, b, g, b * square, g.over(square)];
        if !self.normal.travels.any() {
            return step;
        }
        let real = real_step(n.re, self.normal.squared.re.sqrt(), length);
        let as_complex = |i: usize| if i == 0 { Complex::real(real[0]) } else { Complex { re: zero, im: -real[i] } };
        std::array::from_fn(|i| self.normal.travels.choose_complex(as_complex(i), step[i]))
    }

    /// e^{2iδ}, and the admittance and its inverse.
    #[inline(always)]
    fn waves(&self) -> [Complex<S>; COEFFICIENTS] {
        let (sin, cos) = sin_cos(self.phase);
        let (mantissa, twos) = exp_split(self.decay * 2.0);
        let size = mantissa * twos.max(twos.number(-1022.0)).power_of_two();
        let round_trip = Complex { re: (cos * cos - sin * sin) * size, im: sin * cos * 2.0 * size };
        let (square, inverse) = (self.n * self.n, self.kz.inverse());
        [round_trip, self.kz, inverse, self.kz.over(square), inverse * square]
    }
}

/// Fields stay within 2^±100, but for what a few layers can change; stacks of others are solved one by one.
const RESCALING: i32 = 200;
const STEPS_PER_RESCALING: usize = 4;

/// c, and ib, ig for s and p, of a layer in which light travels; `length` in wavelengths.
#[inline(always)]
fn real_step<S: Simd>(n: Lanes<S>, kz: Lanes<S>, length: Lanes<S>) -> [Lanes<S>; 5] {
    let (sin, cos) = sin_cos(reduced_phase(meaningful(kz * length)));
    let square = n * n;
    let (b, g) = (sin.over(kz), kz * sin);
    [cos, b, g, b * square, g.over(square)]
}

/// Turns of which something can be said, else none.
#[inline(always)]
fn meaningful<S: Simd>(turns: Lanes<S>) -> Lanes<S> {
    turns.number(MOST_TURNS).gt(turns).choose(turns, turns.number(0.0))
}

/// 2π·turns. Whole turns are dropped only where that helps: below some 100 rad sine and cosine are exact enough, and the
/// reduction would only add its own rounding.
#[inline(always)]
fn reduced_phase<S: Simd>(turns: Lanes<S>) -> Lanes<S> {
    const MANY: f64 = 16.0;
    turns.gt(turns.number(MANY)).choose(turns - turns.round(), turns) * TAU
}

/// Fields of a wave that left the stack, with the exponent of the power of two left out of them.
#[derive(Clone, Copy)]
struct Wave<S: Simd> {
    u: Complex<S>,
    v: Complex<S>,
    exponent: Lanes<S>,
}

impl<S: Simd> Wave<S> {
    #[inline(always)]
    fn outgoing(admittance: Complex<S>) -> Self {
        let one = admittance.re.number(1.0);
        Self { u: Complex::real(one), v: admittance, exponent: one.number(0.0) }
    }

    /// b and g stand for −ib and −ig.
    #[inline(always)]
    fn cross_real(&mut self, c: Lanes<S>, b: Lanes<S>, g: Lanes<S>) {
        let Self { u, v, .. } = *self;
        self.u = Complex { re: u.re * c + v.im * b, im: u.im * c - v.re * b };
        self.v = Complex { re: v.re * c + u.im * g, im: v.im * c - u.re * g };
    }

    /// Power that flows through the interface, in the units of these fields.
    #[inline(always)]
    fn flux(&self) -> Lanes<S> {
        self.u.re * self.v.re + self.u.im * self.v.im
    }

    /// The wave that grows on the way stays, the other one is multiplied by e^{2iδ}; see [`film`].
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

    /// Keeps the fields within range by exact powers of two.
    #[inline(always)]
    fn rescale(&mut self) {
        let size = self.u.re.abs().max(self.u.im.abs()).max(self.v.re.abs().max(self.v.im.abs()));
        let [low, high] = [-RESCALING, RESCALING].map(|e| size.number(2f64.powi(e / 2)));
        let (tiny, huge) = (low.gt(size), size.gt(high));
        if tiny.or(huge).any() {
            let pick = |of: fn(i32) -> f64| {
                let [up, none, down] = [RESCALING, 0, -RESCALING].map(|e| size.number(of(e)));
                tiny.choose(up, huge.choose(down, none))
            };
            let factor = pick(|e| 2f64.powi(e));
            self.u = self.u.times(factor);
            self.v = self.v.times(factor);
            self.exponent = self.exponent - pick(f64::from);
        }
    }
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
        [r.re, r.im, t.re, t.im, r_back.re, r_back.im, t_back.re, t_back.im, *flux_ratio].map(|x| x.to_array())
    }
}
