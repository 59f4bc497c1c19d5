//! What each layer of a stack absorbs: many wavelengths at once, one by one, and by what is missing.

use std::f64::consts::TAU;

use gonio_embree::optics::batch::{Film, Question, Sides, Solver, Spectrum};
use gonio_embree::optics::film::{Amplitudes, Incidence, Layer, absorptances};
use gonio_embree::optics::{C64, Pair};
use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};

/// A stack at several wavelengths; the last of the media lies behind it.
#[derive(Debug)]
struct Stack {
    incidences: Vec<Incidence>,
    media: Vec<Vec<C64>>,
    thicknesses: Vec<f64>,
    wavelengths: Vec<f64>,
}

impl Stack {
    /// With the wavelengths of these numbers.
    fn only(&self, lanes: &[usize]) -> Self {
        Self {
            incidences: lanes.iter().map(|&w| self.incidences[w]).collect(),
            media: self.media.iter().map(|n| lanes.iter().map(|&w| n[w]).collect()).collect(),
            thicknesses: self.thicknesses.clone(),
            wavelengths: lanes.iter().map(|&w| self.wavelengths[w]).collect(),
        }
    }

    fn layers(&self, w: usize) -> Vec<Layer> {
        let layer = |(&thickness, n): (&f64, &Vec<C64>)| Layer { index: n[w], thickness };
        self.thicknesses.iter().zip(&self.media).map(layer).collect()
    }

    fn last(&self, w: usize) -> C64 {
        self.media[self.thicknesses.len()][w]
    }

    /// For each wavelength one by one.
    fn twin(&self, w: usize) -> Pair<Vec<f64>> {
        absorptances(&self.incidences[w], &self.layers(w), self.last(w), self.wavelengths[w])
    }

    /// In lanes: what layers absorb, for each wavelength, and what the stack does.
    fn solve(&self, solver: &mut Solver) -> (Vec<Pair<Vec<f64>>>, Vec<Pair<Amplitudes>>) {
        let media: Vec<Spectrum> = self.media.iter().map(|n| n.iter().copied().collect()).collect();
        let film = |(medium, &thickness): (usize, &f64)| Film { medium, thickness };
        let films: Vec<Film> = self.thicknesses.iter().enumerate().map(film).collect();
        let question = Question {
            incidences: &self.incidences,
            media: &media,
            films: &films,
            last: films.len(),
            wavelengths: &self.wavelengths,
        };
        let (mut shares, mut amplitudes) = (Vec::new(), Vec::new());
        solver.absorptances(&question, &mut shares);
        solver.solve(&question, Sides::Front, &mut amplitudes);
        let both = |of: &[Pair<f64>]| Pair { s: of.iter().map(|x| x.s).collect(), p: of.iter().map(|x| x.p).collect() };
        (shares.chunks(films.len().max(1)).map(both).collect(), amplitudes)
    }
}

/// How much layers absorb.
#[derive(Clone, Copy, Debug)]
enum Media {
    Clear,
    Weak,
    Strong,
    Metal,
    /// Clear at some wavelengths and like a metal at others.
    Edge,
}

struct Draw {
    rng: Xoshiro256PlusPlus,
}

impl Draw {
    fn within(&mut self, low: f64, high: f64) -> f64 {
        self.rng.random_range(low..high)
    }

    fn decades(&mut self, low: f64, high: f64) -> f64 {
        10f64.powf(self.within(low, high))
    }

    fn one_of<T: Copy>(&mut self, all: &[T]) -> T {
        all[self.rng.random_range(0..all.len())]
    }

    fn medium(&mut self, kind: Media, count: usize) -> Vec<C64> {
        let (n, k) = match kind {
            Media::Clear => (self.within(1.0, 3.0), 0.0),
            Media::Weak => (self.within(1.0, 3.0), self.decades(-9.0, -2.0)),
            Media::Strong => (self.within(1.0, 4.0), self.within(0.01, 1.0)),
            Media::Metal | Media::Edge => (self.within(0.04, 2.0), self.within(1.0, 9.0)),
        };
        let edge = self.rng.random_range(0..=count);
        let at = |w: usize| {
            let slope = 1.0 - 0.01 * w as f64;
            let clear = matches!(kind, Media::Edge) && w >= edge;
            C64::new(n * slope, if clear { 0.0 } else { k * slope * slope })
        };
        (0..count).map(at).collect()
    }

    /// Layers in front of a clear medium.
    fn stack(&mut self, kind: &Kind) -> Stack {
        let Kind { media, most_layers, thickness: [low, high] } = *kind;
        let count = self.one_of(&[1, 3, 8, 17]);
        let layers = self.rng.random_range(1..=most_layers);
        let kinds: Vec<Media> = (0..layers).map(|_| self.one_of(media)).chain([Media::Clear]).collect();
        let (first, angle, spread) =
            (self.one_of(&[1.0, 1.33, 1.5]), self.within(0.0, 89.9), self.one_of(&[0.0, 0.02]));
        let incidence = |w: usize| Incidence::from_angle(first, (angle * (1.0 - spread * w as f64)).to_radians());
        Stack {
            incidences: (0..count).map(incidence).collect(),
            media: kinds.into_iter().map(|kind| self.medium(kind, count)).collect(),
            thicknesses: (0..layers).map(|_| self.decades(low, high)).collect(),
            wavelengths: (0..count).map(|w| 0.4 + 0.02 * w as f64).collect(),
        }
    }
}

/// Kinds of stacks.
struct Kind {
    media: &'static [Media],
    most_layers: usize,
    /// Decades of the thickness (µm).
    thickness: [f64; 2],
}

const ALL: &[Media] = &[Media::Clear, Media::Weak, Media::Strong, Media::Metal, Media::Edge];
const FILMS: [f64; 2] = [-3.0, -0.5];

/// Small differences of large fluxes: shares are known to so much of the power, but not each to its own digits.
const RESONANT: [Kind; 2] = [
    Kind { media: &[Media::Clear, Media::Weak], most_layers: 60, thickness: FILMS },
    Kind { media: ALL, most_layers: 60, thickness: FILMS },
];

/// Where shares are known to their own digits, too; also with hardly anything left, or nothing, behind; and with fields
/// that leave the range many times in layers that absorb little each.
const LOSSY: [Kind; 5] = [
    Kind { media: &[Media::Clear, Media::Strong], most_layers: 60, thickness: FILMS },
    Kind { media: &[Media::Clear, Media::Edge], most_layers: 60, thickness: FILMS },
    Kind { media: &[Media::Metal], most_layers: 60, thickness: [-3.0, 3.0] },
    Kind { media: &[Media::Metal], most_layers: 1000, thickness: [-3.0, -2.0] },
    Kind { media: &[Media::Strong, Media::Metal, Media::Edge], most_layers: 1000, thickness: [-3.0, -2.0] },
];

/// Calls `check` with random stacks and what lanes say of them; the solver is the same for all.
fn check(kinds: &[Kind], most: usize, mut check: impl FnMut(&Stack, &[Pair<Vec<f64>>], &[Pair<Amplitudes>])) {
    let mut draw = Draw { rng: Xoshiro256PlusPlus::seed_from_u64(1) };
    let mut solver = Solver::default();
    for kind in kinds {
        for _ in 0..most.min(most * 60 / kind.most_layers) {
            let stack = draw.stack(kind);
            let (shares, amplitudes) = stack.solve(&mut solver);
            check(&stack, &shares, &amplitudes);
        }
    }
}

/// Largest difference from the twin, and that relative to shares of more than 1e-140.
fn worst(stack: &Stack, shares: &[Pair<Vec<f64>>]) -> (f64, f64) {
    let (mut error, mut relative) = (0f64, 0f64);
    for (w, got) in shares.iter().enumerate() {
        let twin = stack.twin(w);
        for (x, y) in got.s.iter().chain(&got.p).zip(twin.s.iter().chain(&twin.p)) {
            assert!((0.0..=1.0 + 1e-12).contains(x), "{x} of {stack:?}");
            let difference = (x - y).abs();
            error = error.max(difference);
            relative = relative.max(if *y > 1e-140 { difference / y } else { 0.0 });
        }
    }
    (error, relative)
}

#[test]
fn lanes_are_like_one_by_one() {
    check(&RESONANT, 1500, |stack, shares, _| {
        let (error, _) = worst(stack, shares);
        assert!(error <= 1e-12, "{error:e} in {stack:?}");
    });
    check(&LOSSY, 1500, |stack, shares, _| {
        let (error, relative) = worst(stack, shares);
        assert!(error <= 1e-12 && relative <= 1e-10, "{error:e}, relative {relative:e} in {stack:?}");
    });
}

/// What neither comes back nor goes through is in the layers.
#[test]
fn what_is_missing_is_absorbed() {
    let closed = |stack: &Stack, shares: &[Pair<Vec<f64>>], amplitudes: &[Pair<Amplitudes>]| {
        for (absorbed, a) in shares.iter().zip(amplitudes) {
            for (absorbed, a) in [(&absorbed.s, a.s), (&absorbed.p, a.p)] {
                let missing = 1.0 - a.reflectance() - a.transmittance() - absorbed.iter().sum::<f64>();
                assert!(missing.abs() <= 1e-12, "{missing:e} in {stack:?}");
            }
        }
    };
    check(&RESONANT, 1500, closed);
    check(&LOSSY, 1500, closed);
}

/// Each layer by itself: the only one that absorbs, in front of a last medium that is clear.
#[test]
fn the_only_absorbing_layer_takes_all() {
    let kind = Kind { media: &[Media::Clear], most_layers: 60, thickness: FILMS };
    let mut draw = Draw { rng: Xoshiro256PlusPlus::seed_from_u64(1) };
    for i in 0..3000 {
        let mut stack = draw.stack(&kind);
        let (count, at) = (stack.wavelengths.len(), i % stack.thicknesses.len());
        let absorbing = draw.one_of(&ALL[1..]);
        stack.media[at] = draw.medium(absorbing, count);
        let (shares, amplitudes) = stack.solve(&mut Solver::default());
        for (w, (got, a)) in shares.iter().zip(&amplitudes).enumerate() {
            for (got, a) in [(&got.s, a.s), (&got.p, a.p)] {
                let missing = 1.0 - a.reflectance() - a.transmittance();
                assert!((got[at] - missing).abs() <= 1e-12, "{} for {missing} in {stack:?}", got[at]);
                assert!(got.iter().enumerate().all(|(i, x)| i == at || *x == 0.0), "{got:?}");
                assert!(stack.media[at][w].im > 0.0 || got[at] == 0.0);
            }
        }
    }
}

/// Beer and Lambert: layers of one index that absorb so little that nothing is reflected, between media of that index.
#[test]
fn faint_layers_absorb_along_the_path() {
    const K: f64 = 1e-7;
    let (n, cos) = (1.5, 0.6);
    for k in [[K, K, K], [K, 0.3 * K, 0.0], [0.1 * K, 0.0, K]] {
        let thicknesses = vec![2e5, 1e5, 4e5];
        let media = k.iter().chain(&[0.0]).map(|&k| vec![C64::new(n, k); 3]).collect();
        let incidences = vec![Incidence::from_cos(n, cos); 3];
        let stack = Stack { incidences, media, thicknesses, wavelengths: vec![0.4, 0.55, 0.7] };
        let (shares, _) = stack.solve(&mut Solver::default());
        for (got, wavelength) in shares.iter().zip(&stack.wavelengths) {
            let mut left = 1.0;
            for (i, (k, d)) in k.iter().zip(&stack.thicknesses).enumerate() {
                let share = left * -(-2.0 * TAU * k * d / (wavelength * cos)).exp_m1();
                left -= share;
                // Waves reflected within are K/n of the light.
                assert!((got.s[i] - share).abs() <= 2.0 * K && (got.p[i] - share).abs() <= 2.0 * K, "{share}: {got:?}");
            }
        }
    }
}

/// The same bits alone, in any company and order, and after any other stack.
#[test]
fn no_wavelength_looks_at_its_neighbours() {
    let alike = |stack: &Stack, shares: &[Pair<Vec<f64>>], _: &[Pair<Amplitudes>]| {
        let count = shares.len();
        let back: Vec<usize> = (0..count).rev().collect();
        let (reversed, _) = stack.only(&back).solve(&mut Solver::default());
        for (w, share) in shares.iter().enumerate() {
            let (alone, _) = stack.only(&[w]).solve(&mut Solver::default());
            assert!(*share == alone[0] && *share == reversed[count - 1 - w], "{w} of {stack:?}");
        }
    };
    check(&RESONANT, 300, alike);
    check(&LOSSY, 300, alike);
}

#[test]
fn without_layers_nothing_is_absorbed() {
    let incidences = vec![Incidence::from_cos(1.0, 0.5)];
    let media = vec![vec![C64::new(1.5, 0.1)]];
    let (shares, _) =
        Stack { incidences, media, thicknesses: vec![], wavelengths: vec![0.5] }.solve(&mut Solver::default());
    assert!(shares.iter().all(|both| both.s.is_empty() && both.p.is_empty()));
}
