//! A film stack over the cosine of incidence: for films on curved faces, where no two rays come at one angle.
//!
//! Amplitudes are analytic in the cosine but for the critical angle of the last medium, where they depend on the square
//! root of the distance to it. In a variable that has that root in it they are smooth, and short Chebyshev series in
//! pieces of its range give them to any accuracy (Trefethen, *Approximation Theory and Approximation Practice*, ch. 8).
//! Layers need no such care: stacks are even functions of the wave numbers in them.

use std::f64::consts::{FRAC_PI_2, PI};

use super::batch::{Film, Question, Sides, Solver, Spectrum};
use super::film::Incidence;
use super::fresnel::other_leg;
use super::{C64, Coefficients, Pair};

/// A stack that is to be tabulated.
#[derive(Clone, Copy, Debug)]
pub struct Tabulated<'a> {
    /// Complex index of every medium.
    pub media: &'a [Spectrum],
    /// Number of the first medium, which is transparent.
    pub first: usize,
    /// Layers, from the side of the light.
    pub films: &'a [Film],
    /// Number of the last medium.
    pub last: usize,
    /// Vacuum wavelengths.
    pub wavelengths: &'a [f64],
}

/// Largest error of an amplitude. Twice that is what tabulated coefficients may miss of the power.
pub const TOLERANCE: f64 = 1e-10;
/// Terms of a series.
const TERMS: usize = 16;
/// Most series, for each side of the critical angle.
const MOST_PIECES: usize = 64;
/// Numbers per wavelength: r and t, s and p, real and imaginary parts.
const PARTS: usize = 8;

/// Amplitude coefficients over the cosine of incidence, at many wavelengths.
#[derive(Clone, Debug)]
pub struct Table {
    wavelengths: usize,
    /// Index of the first medium, and square and inverse of that of the last, for the flux behind.
    first: Vec<f64>,
    last: Vec<C64>,
    /// Cosine of the critical angle; 0 without one.
    critical: f64,
    /// Beyond the critical angle, and before it.
    sides: [Side; 2],
}

/// Series that follow one another.
#[derive(Clone, Debug, Default)]
struct Side {
    /// Where each begins; all end at the beginning of the next, the last at [`Map::end`].
    starts: Vec<f64>,
    end: f64,
    /// [`TERMS`] rows of coefficients for each.
    coefficients: Vec<f64>,
}

/// A variable in which amplitudes are smooth.
#[derive(Clone, Copy, Debug)]
enum Map {
    /// cos θ = c* sin x.
    Beyond(f64),
    /// cos² θ = c*² + x².
    Before(f64),
}

impl Map {
    fn cos(self, x: f64) -> f64 {
        match self {
            Self::Beyond(critical) => critical * x.sin(),
            Self::Before(critical) => critical.hypot(x).min(1.0),
        }
    }

    /// Whether the critical angle is so near that the rounding of a cosine, 1e-16/x of the variable, would show.
    fn is_critical(self, x: f64) -> bool {
        const NEAR: f64 = 2e-5;
        match self {
            Self::Beyond(_) => FRAC_PI_2 - x < NEAR,
            Self::Before(critical) => critical > 0.0 && x < NEAR,
        }
    }

    fn end(self) -> f64 {
        match self {
            Self::Beyond(critical) if critical > 0.0 => FRAC_PI_2,
            Self::Beyond(_) => 0.0,
            Self::Before(critical) => other_leg(critical),
        }
    }
}

impl Table {
    /// Tabulates a stack, with errors up to [`TOLERANCE`]; `None` where that takes too many pieces (a resonance), or the
    /// critical angle differs from wavelength to wavelength.
    pub fn new(solver: &mut Solver, stack: &Tabulated<'_>) -> Option<Self> {
        let wavelengths = stack.wavelengths.len();
        let (first, last) = (&stack.media[stack.first], &stack.media[stack.last]);
        let sine = |w: usize| if last.at(w).im == 0.0 { (last.at(w).re / first.at(w).re).min(1.0) } else { 1.0 };
        let critical = other_leg(sine(0));
        if (1..wavelengths).any(|w| sine(w) != sine(0)) {
            return None;
        }
        let mut work = Work { solver, stack, incidences: Vec::new(), solved: Vec::new() };
        let sides = [work.side(Map::Beyond(critical))?, work.side(Map::Before(critical))?];
        Some(Self {
            wavelengths,
            first: (0..wavelengths).map(|w| first.at(w).re).collect(),
            last: (0..wavelengths).map(|w| last.at(w)).collect(),
            critical,
            sides,
        })
    }

    /// Power-normalised coefficients at every wavelength; `scratch` is overwritten.
    pub fn at(&self, cos: f64, scratch: &mut Vec<f64>, out: &mut Vec<Coefficients>) {
        let (side, x) = self.place(cos);
        side.sum(x, self.wavelengths * PARTS, scratch);
        out.clear();
        out.extend(scratch.chunks_exact(PARTS).enumerate().map(|(w, x)| {
            let (first, last) = (self.first[w], self.last[w]);
            let incidence = Incidence::from_cos(first, cos);
            let flux = |p: bool| cos * incidence.flux_ratio(last, p).sqrt();
            let z = |i: usize| C64::new(x[i], x[i + 1]);
            Coefficients { r: Pair { s: z(0), p: z(4) }, t: Pair { s: z(2) * flux(false), p: z(6) * flux(true) } }
        }));
    }
}

impl Table {
    /// The variable in which a cosine is looked up, and the side of the critical angle. Near that, where amplitudes change
    /// fast, the wave number behind decides, as it does in the formula.
    fn place(&self, cos: f64) -> (&Side, f64) {
        let [beyond, before] = &self.sides;
        if self.critical == 0.0 {
            return (before, cos);
        }
        let behind = Incidence::from_cos(self.first[0], cos).normal(self.last[0]) / self.first[0];
        if behind.im > 0.0 { (beyond, cos.atan2(behind.im)) } else { (before, behind.re) }
    }
}

impl Side {
    /// Clenshaw's sum of the series at `x`.
    fn sum(&self, x: f64, row: usize, out: &mut Vec<f64>) {
        let piece = self.starts.partition_point(|&start| start <= x).saturating_sub(1);
        let from = self.starts[piece];
        let to = self.starts.get(piece + 1).copied().unwrap_or(self.end);
        let y = (2.0 * x - from - to) / (to - from);
        let rows = &self.coefficients[piece * TERMS * row..(piece + 1) * TERMS * row];
        // b_k = c_k + 2y b_{k+1} − b_{k+2}, the two rows of b in turn.
        out.clear();
        out.resize(2 * row, 0.0);
        let (mut b1, mut b2) = out.split_at_mut(row);
        for c in rows.chunks_exact(row).skip(1).rev() {
            b2.iter_mut().zip(&*b1).zip(c).for_each(|((b2, b1), c)| *b2 = c + 2.0 * y * b1 - *b2);
            std::mem::swap(&mut b1, &mut b2);
        }
        b1.iter_mut().zip(&*b2).zip(rows).for_each(|((b1, b2), c)| *b1 = c + y * *b1 - b2);
        // After an odd number of swaps the sum stands in the second half.
        if (TERMS - 1) % 2 == 1 {
            out.copy_within(row.., 0);
        }
        out.truncate(row);
    }
}

struct Work<'w, 'q> {
    solver: &'w mut Solver,
    stack: &'q Tabulated<'q>,
    incidences: Vec<Incidence>,
    solved: Vec<Pair<super::film::Amplitudes>>,
}

impl Work<'_, '_> {
    fn side(&mut self, map: Map) -> Option<Side> {
        let mut side = Side { end: map.end(), ..Side::default() };
        if side.end == 0.0 {
            return Some(side);
        }
        let mut waiting = vec![(0.0, side.end)];
        while let Some((from, to)) = waiting.pop() {
            let series = self.series(map, from, to);
            if self.holds(map, from, to, &series) {
                side.starts.push(from);
                side.coefficients.extend(series);
            } else {
                let middle = 0.5 * (from + to);
                waiting.extend([(middle, to), (from, middle)]);
            }
            if side.starts.len() + waiting.len() > MOST_PIECES {
                return None;
            }
        }
        Some(side)
    }

    /// The numbers that are tabulated: r, and t of the electric field over cos θ.
    fn values(&mut self, cos: f64) -> Vec<f64> {
        let Tabulated { media, first, films, last, wavelengths } = *self.stack;
        self.incidences.clear();
        self.incidences.extend((0..wavelengths.len()).map(|w| Incidence::from_cos(media[first].at(w).re, cos)));
        let question = Question { incidences: &self.incidences, media, films, last, wavelengths };
        self.solver.solve(&question, Sides::Front, &mut self.solved);
        let parts = |a: &super::film::Amplitudes| [a.r.re, a.r.im, a.t.re / cos, a.t.im / cos];
        self.solved.iter().flat_map(|both| [parts(&both.s), parts(&both.p)]).flatten().collect()
    }

    /// The Chebyshev series through the values at the roots of the next polynomial.
    fn series(&mut self, map: Map, from: f64, to: f64) -> Vec<f64> {
        let angle = |i: usize| PI * (i as f64 + 0.5) / TERMS as f64;
        let at: Vec<Vec<f64>> = (0..TERMS).map(|i| self.values(map.cos(place(from, to, angle(i).cos())))).collect();
        let coefficient = |k: usize, part: usize| {
            let sum: f64 = (0..TERMS).map(|i| at[i][part] * (k as f64 * angle(i)).cos()).sum();
            sum * if k == 0 { 1.0 } else { 2.0 } / TERMS as f64
        };
        (0..TERMS).flat_map(|k| (0..at[0].len()).map(move |part| (k, part))).map(|(k, p)| coefficient(k, p)).collect()
    }

    /// Whether the series gives the values between its roots, too: there its error is largest.
    fn holds(&mut self, map: Map, from: f64, to: f64, series: &[f64]) -> bool {
        let side = Side { starts: vec![from], end: to, coefficients: series.to_vec() };
        let mut sum = Vec::new();
        (0..=TERMS).all(|i| {
            let x = place(from, to, (PI * i as f64 / TERMS as f64).cos());
            let cos = map.cos(x);
            // Grazing incidence is a limit.
            if cos <= 0.0 || map.is_critical(x) {
                return true;
            }
            let values = self.values(cos);
            side.sum(x, values.len(), &mut sum);
            sum.iter().zip(&values).all(|(a, b)| (a - b).abs() <= 0.25 * TOLERANCE)
        })
    }
}

/// The point of an interval at y of −1..1.
fn place(from: f64, to: f64, y: f64) -> f64 {
    0.5 * (from + to) + 0.5 * (to - from) * y
}

#[cfg(test)]
mod tests {
    use rand::rngs::Xoshiro256PlusPlus;
    use rand::{RngExt, SeedableRng};

    use super::super::film::{Layer, solve};
    use super::*;

    const WAVELENGTHS: [f64; 3] = [0.4, 0.55, 0.7];

    fn spectra(media: &[C64]) -> Vec<Spectrum> {
        media.iter().map(|&n| [n; WAVELENGTHS.len()].into_iter().collect()).collect()
    }

    /// Largest difference from the formula, if the stack is tabulated.
    fn error(media: &[C64], films: &[Film]) -> Option<f64> {
        let spectra = spectra(media);
        let last = media.len() - 1;
        let stack = Tabulated { media: &spectra, first: 0, films, last, wavelengths: &WAVELENGTHS };
        let table = Table::new(&mut Solver::default(), &stack)?;
        let layers: Vec<Layer> =
            films.iter().map(|f| Layer { index: media[f.medium], thickness: f.thickness }).collect();
        let (mut scratch, mut out) = (Vec::new(), Vec::new());
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(5);
        let mut worst = 0.0f64;
        for i in 0..4000 {
            // Everywhere, and near grazing incidence and the critical angle.
            let near = 10f64.powf(-12.0 * rng.random::<f64>());
            let cos = match i % 4 {
                0 => near,
                1 => (table.critical + near).min(1.0),
                2 => (table.critical - near).max(1e-12),
                _ => rng.random(),
            };
            table.at(cos, &mut scratch, &mut out);
            for (c, wavelength) in out.iter().zip(WAVELENGTHS) {
                let exact = solve(&Incidence::from_cos(media[0].re, cos), &layers, media[last], wavelength);
                for (r, t, a) in [(c.r.s, c.t.s, exact.s), (c.r.p, c.t.p, exact.p)] {
                    worst = worst.max((r - a.r).norm()).max((t - a.t_power()).norm());
                }
            }
        }
        Some(worst)
    }

    fn alternating(high: usize, low: usize, layers: usize) -> Vec<Film> {
        let film = |i: usize| match i % 2 {
            0 => Film { medium: high, thickness: 0.074 },
            _ => Film { medium: low, thickness: 0.098 },
        };
        (0..layers).map(film).collect()
    }

    #[test]
    fn tables_are_as_good_as_they_say() {
        let real = |n: [f64; 4]| n.map(C64::from);
        let mut absorbing = real([1.0, 2.0, 1.5, 1.6]);
        absorbing[1].im = 0.05;
        let mut on_metal = real([1.0, 2.0, 1.5, 0.2]);
        on_metal[3].im = 3.4;
        for (name, media, most) in [
            ("into glass", real([1.0, 2.0, 1.5, 1.52]), 15),
            ("out of silica", real([1.45, 2.0, 1.5, 1.0]), 15),
            ("between equal media", real([1.33, 2.0, 1.5, 1.33]), 15),
            ("evanescent layers", real([1.6, 2.0, 1.2, 1.4]), 5),
            ("absorbing", absorbing, 15),
            ("on metal", on_metal, 15),
        ] {
            for layers in [1, 5, 15].into_iter().filter(|&n| n <= most) {
                let worst = error(&media, &alternating(1, 2, layers)).unwrap_or_else(|| panic!("{name} refused"));
                assert!(worst <= TOLERANCE, "{name}, {layers} layers: {worst:e}");
            }
        }
    }

    #[test]
    fn resonances_are_refused() {
        let media = [1.0, 3.5, 1.2, 1.0].map(C64::from);
        let mut films = alternating(1, 2, 43);
        films[21].thickness = 5.0;
        assert_eq!(error(&media, &films), None);
        // Waves guided by the high layers, which many low ones part.
        assert_eq!(error(&[1.6, 2.0, 1.2, 1.4].map(C64::from), &alternating(1, 2, 15)), None);
    }

    #[test]
    fn critical_angles_that_differ_are_refused() {
        let mut spectra = spectra(&[1.5, 2.0, 1.5, 1.0].map(C64::from));
        spectra[0] = [1.5, 1.51, 1.52].map(C64::from).into_iter().collect();
        let films = alternating(1, 2, 7);
        let stack = Tabulated { media: &spectra, first: 0, films: &films, last: 3, wavelengths: &WAVELENGTHS };
        assert!(Table::new(&mut Solver::default(), &stack).is_none());
        // In the other direction there is none.
        let stack = Tabulated { media: &spectra, first: 3, films: &films, last: 0, wavelengths: &WAVELENGTHS };
        assert!(Table::new(&mut Solver::default(), &stack).is_some());
    }
}
