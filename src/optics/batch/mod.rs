//! Film stacks at many wavelengths at once: the sweep of [`super::film`] in [`super::lanes`].
//!
//! A `block` of wavelengths fills in the `steps` through all layers, each from what a `slab` does there:
//! what depends on a layer only (its wave number, its phase) is computed once for both polarizations and both directions.
//! A `wave` then goes through them, and its fields at the ends are the amplitudes that `solve` gives; its fluxes between
//! them, the `losses`.
//!
//! Only what is inlined into the functions that `pulp` calls knows the registers. The compiler may leave closures and the
//! functions that they are handed to, such as `array::map`, outside: where lanes are at work there are loops instead.

mod block;
mod losses;
mod slab;
mod solve;
mod steps;
mod wave;

use self::losses::Losses;
use self::solve::Work;
use self::steps::Steps;
use super::film::{self, Amplitudes, Incidence, Layer};
use super::lanes::WIDEST;
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

    /// Whether lanes may answer: they do not look after numbers whose squares leave the range.
    fn is_usual(&self, w: usize) -> bool {
        (1e-6..1e6).contains(&self.incidences[w].index)
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
    /// What [`film::solve`] gives, for each wavelength.
    pub fn solve(&mut self, q: &Question<'_>, sides: Sides, out: &mut Vec<Pair<Amplitudes>>) {
        out.clear();
        if q.films.is_empty() {
            out.extend((0..q.wavelengths.len()).map(|w| one_by_one(q, w, film::solve)));
            return;
        }
        self.arch.dispatch(Work { q, sides, steps: &mut self.steps, out });
        for (w, both) in out.iter_mut().enumerate() {
            if !both.s.is_finite() || !both.p.is_finite() || !q.is_usual(w) {
                *both = one_by_one(q, w, film::solve);
            }
        }
    }

    /// What [`film::absorptances`] gives: for each wavelength, what each layer absorbs.
    pub fn absorptances(&mut self, q: &Question<'_>, out: &mut Vec<Pair<f64>>) {
        out.clear();
        if q.films.is_empty() {
            return;
        }
        out.resize(q.wavelengths.len() * q.films.len(), Pair { s: 0.0, p: 0.0 });
        self.arch.dispatch(Losses { q, steps: &mut self.steps, out });
        for (w, shares) in out.chunks_exact_mut(q.films.len()).enumerate() {
            if !shares.iter().all(|both| both.s.is_finite() && both.p.is_finite()) || !q.is_usual(w) {
                let Pair { s, p } = one_by_one(q, w, film::absorptances);
                shares.iter_mut().zip(s.into_iter().zip(p)).for_each(|(share, (s, p))| *share = Pair { s, p });
            }
        }
    }
}

fn one_by_one<T>(q: &Question<'_>, w: usize, solve: impl Fn(&Incidence, &[Layer], C64, f64) -> Pair<T>) -> Pair<T> {
    let layers: Vec<Layer> =
        q.films.iter().map(|f| Layer { index: q.media[f.medium].at(w), thickness: f.thickness }).collect();
    solve(&q.incidences[w], &layers, q.last().at(w), q.wavelengths[w])
}
