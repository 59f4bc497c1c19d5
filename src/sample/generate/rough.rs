//! Random rough surfaces: Gaussian heights of Gaussian autocorrelation, on a periodic patch.
//!
//! White noise is smoothed along x and along y by K(d) ∝ exp(−2d²/l²), repeated with the period and normalised to
//! ΣK² = 1. Every height is then normal with mean 0 and standard deviation `rms`, exactly, and two heights at a distance d
//! have the correlation exp(−d²/l²), l being `length`, repeated with the period. Sampling changes it by at most
//! 4 exp(−π²l²/4) for l in pixels (Poisson's sum): 2.1e-4 for two pixels, the fewest that are taken, and 1e-9 for three.
//! Repetition is no matter as the patch is at least eight l wide. Slopes along x and y have the standard deviation
//! √2 rms/l. The rms and the mean of one surface vary from seed to seed, as those of a measured patch of that size do.

use glam::DVec2;
use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};

use super::super::description::{Body, Fill, Object, Shape};
use super::super::fill::read_fill;
use super::super::problem::Place;
use super::super::reader::Table;
use super::super::relief::{DEPTH, HeightField, MOST_HEIGHTS, Relief};
use crate::units;

/// A surface to make.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rough {
    /// Standard deviation of the heights, µm.
    pub rms: f64,
    /// Distance at which the correlation of heights has fallen to 1/e, µm.
    pub length: f64,
    /// Edge lengths of the patch, µm.
    pub size: DVec2,
    /// Heights along x and y.
    pub points: [usize; 2],
    /// Seed.
    pub seed: u64,
}

impl Rough {
    /// The heights, around 0.
    ///
    /// # Errors
    /// When the points cannot hold such a surface, or the patch not enough of it.
    pub fn field(&self) -> Result<HeightField, String> {
        self.check()?;
        let [columns, rows] = self.points;
        let pixel = self.pixel();
        let noise = noise(self.seed, columns * rows);
        let [along_x, along_y] = [0, 1].map(|i| kernel(self.points[i], self.length / pixel[i]));
        let smooth = transposed(&smoothed(&noise, columns, &along_x), columns);
        let mut heights = transposed(&smoothed(&smooth, rows, &along_y), rows);
        heights.iter_mut().for_each(|z| *z *= self.rms);
        Ok(HeightField { columns, rows, pixel, heights })
    }

    fn pixel(&self) -> DVec2 {
        self.size / DVec2::from_array(self.points.map(|n| n as f64))
    }

    /// Whether it can be made.
    ///
    /// # Errors
    /// Why not.
    pub fn check(&self) -> Result<(), String> {
        let [columns, rows] = self.points;
        if columns.checked_mul(rows).is_none_or(|count| count > MOST_HEIGHTS) {
            return Err(format!("points = [{columns}, {rows}]: at most {MOST_HEIGHTS} in all are taken"));
        }
        let show = units::show_length;
        for (size, n, axis) in [(self.size.x, columns, "x"), (self.size.y, rows, "y")] {
            let [smallest, most] = [(2.0 * size / self.length).ceil(), size / 8.0];
            if self.length > most {
                return Err(format!(
                    "size = {} along {axis}: expected at least eight times the length, {}, so that the patch stands for \
                     the surface",
                    show(size),
                    show(8.0 * self.length)
                ));
            }
            if (n as f64) < smallest {
                return Err(format!(
                    "points = {n} along {axis}: expected at least {smallest}, two in each length of {}",
                    show(self.length)
                ));
            }
        }
        Ok(())
    }
}

/// Independent normal numbers (Box and Muller, Ann. Math. Stat. 29, 610 (1958)).
fn noise(seed: u64, count: usize) -> Vec<f64> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut pair = || {
        let radius = (-2.0 * (1.0 - rng.random::<f64>()).ln()).sqrt();
        let (sin, cos) = (std::f64::consts::TAU * rng.random::<f64>()).sin_cos();
        [radius * cos, radius * sin]
    };
    (0..count.div_ceil(2)).flat_map(|_| pair()).take(count).collect()
}

/// Weights of the points at distances −m to m, of `n` in a period, for a correlation length in pixels.
fn kernel(n: usize, length: f64) -> Vec<f64> {
    // Beyond it weights are below rounding.
    let reach = ((4.3 * length).ceil() as usize).min((n - 1) / 2) as i64;
    let weight = |d: i64| (-2.0 * (d as f64 / length).powi(2)).exp();
    let weights: Vec<f64> = (-reach..=reach).map(weight).collect();
    let norm = weights.iter().map(|w| w * w).sum::<f64>().sqrt();
    weights.into_iter().map(|w| w / norm).collect()
}

/// Rows of `n` numbers, each folded with the kernel as if it went round.
fn smoothed(values: &[f64], n: usize, kernel: &[f64]) -> Vec<f64> {
    let reach = kernel.len() / 2;
    let row = |row: &[f64]| -> Vec<f64> {
        let round: Vec<f64> = (0..n + 2 * reach).map(|i| row[(i + n - reach) % n]).collect();
        round.windows(kernel.len()).map(|w| w.iter().zip(kernel).map(|(a, b)| a * b).sum()).collect()
    };
    values.chunks_exact(n).flat_map(row).collect()
}

/// Columns as rows.
fn transposed(values: &[f64], columns: usize) -> Vec<f64> {
    let rows = values.len() / columns;
    (0..columns).flat_map(|c| (0..rows).map(move |r| values[r * columns + c])).collect()
}

/// A rough surface with what lies under it.
#[derive(Clone, Debug, PartialEq)]
pub struct RoughSurface {
    /// Its heights.
    pub rough: Rough,
    /// Mean height, µm.
    pub base: f64,
    /// Depth of the floor below the lowest height, µm, if it is given.
    pub depth: Option<f64>,
    /// Material.
    pub fill: Fill,
    /// Priority of the body.
    pub priority: i32,
}

impl RoughSurface {
    /// Reads a `[[generate]]` table.
    pub(super) fn read(t: &Table<'_>) -> Option<Self> {
        let rms = t.positive_length("rms").or_else(|| t.missing_if_absent("rms", "\"100 nm\""));
        let length = t.positive_length("length").or_else(|| t.missing_if_absent("length", "\"2 um\""));
        let size = t.lengths::<2>("size", "two lengths such as [40, 40]");
        let size = size.or_else(|| t.missing_if_absent("size", "[40, 40]")).map(DVec2::from_array);
        let points = read_points(t);
        let seed = t.integer("seed", 0..i64::MAX).unwrap_or(1) as u64;
        let base = t.length("base").unwrap_or(0.0);
        let depth = t.positive_length("bottom");
        let priority = t.integer("priority", -1_000_000..1_000_001).unwrap_or(0) as i32;
        let fill = read_fill(t);
        let rough = Rough { rms: rms?, length: length?, size: size?, points: points?, seed };
        if rough.size.min_element() <= 0.0 {
            t.complain(format!("size = {} µm: expected two lengths greater than 0", rough.size));
            return None;
        }
        Some(Self { rough, base, depth, fill: fill?, priority })
    }

    /// What it is, in a line.
    pub fn title(&self) -> String {
        let Rough { rms, length, points: [columns, rows], .. } = self.rough;
        format!("random rough surface of {columns} x {rows} heights, rms {rms} um, correlation length {length} um")
    }

    /// The body.
    ///
    /// # Errors
    /// As for [`Rough::field`].
    pub fn objects(&self, place: &Place) -> Result<Vec<Object>, String> {
        let mut field = self.rough.field()?;
        field.heights.iter_mut().for_each(|z| *z += self.base);
        let [lowest, highest] = field.range();
        let floor = lowest - self.depth.unwrap_or((highest - lowest).max(DEPTH));
        let body =
            Body::Solid(Shape::Relief(Box::new(Relief { field, center: DVec2::ZERO, floor })), self.fill.clone());
        let name = "rough surface".into();
        Ok(vec![Object { name, body, priority: self.priority, nesting: 0, place: place.clone() }])
    }
}

/// One number, or two.
fn read_points(t: &Table<'_>) -> Option<[usize; 2]> {
    let Some(value) = t.get("points") else { return t.missing("points", "512") };
    if value.get_ref().as_array().is_none() {
        return t.integer("points", 2..MOST_HEIGHTS as i64).map(|n| [n as usize; 2]);
    }
    let points = t.numbers::<2>("points", "a number of points, or two such as [512, 256]")?;
    let whole = |x: &f64| *x >= 2.0 && *x <= MOST_HEIGHTS as f64 && x.fract() == 0.0;
    if points.iter().all(whole) {
        return Some(points.map(|x| x as usize));
    }
    let message = format!("points = {points:?}: expected two whole numbers from 2 on");
    t.source().note(t.place_of("points").problem(message));
    None
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{E, PI};

    use super::*;

    const ROUGH: Rough = Rough { rms: 0.3, length: 1.5, size: DVec2::new(96.0, 48.0), points: [512, 256], seed: 0 };
    const SEEDS: u64 = 16;

    /// The mean over all heights and seeds of a product of two numbers at each place.
    fn mean(product: impl Fn(&HeightField, usize, usize) -> f64) -> f64 {
        let one = |seed| {
            let field = Rough { seed, ..ROUGH }.field().unwrap();
            let rows = (0..field.rows).map(|r| (0..field.columns).map(|c| product(&field, c, r)).sum::<f64>());
            rows.sum::<f64>() / field.heights.len() as f64
        };
        (0..SEEDS).map(one).sum::<f64>() / SEEDS as f64
    }

    /// A mean of squares of a normal field with variance v differs from v by v√(2∫ρ²/area), ρ being its correlation; here
    /// ∫ρ² is that of heights, πl²/2, times `factor`. Bounds are five of it: one seed in a million would fail.
    fn bound(factor: f64) -> f64 {
        let areas = SEEDS as f64 * ROUGH.size.element_product() / ROUGH.length.powi(2);
        5.0 * (2.0 * factor * 0.5 * PI / areas).sqrt()
    }

    #[test]
    fn heights_have_the_variance_and_correlation_asked_for() {
        let variance = mean(|f, c, r| f.at(c, r).powi(2)) / ROUGH.rms.powi(2);
        assert!((variance - 1.0).abs() < bound(1.0), "{variance}");
        // 1.5 µm are 8 pixels. The product of heights l apart varies by ∫ρ(d)² + ρ(d − l)ρ(d + l), half of that in squares.
        for (x, y) in [(8, 0), (0, 8)] {
            let apart = |f: &HeightField, c: usize, r: usize| f.at((c + x) % f.columns, (r + y) % f.rows);
            let correlation = mean(|f, c, r| f.at(c, r) * apart(f, c, r)) / ROUGH.rms.powi(2);
            let factor = 0.5 * (1.0 + E.powi(-2));
            assert!((correlation - 1.0 / E).abs() < bound(factor), "{correlation}");
        }
    }

    /// Slopes over one pixel, seam included: 2(1 − ρ(pixel)) of the variance. Their ∫ρ² is 3/4 of that of heights.
    #[test]
    fn slopes_have_the_variance_that_follows() {
        let pixel = ROUGH.pixel();
        let expected = -2.0 * (-(pixel.x / ROUGH.length).powi(2)).exp_m1();
        assert!(
            (expected / (2.0 * (pixel.x / ROUGH.length).powi(2)) - 1.0).abs() < 0.01,
            "nearly that of a smooth surface"
        );
        for (x, y) in [(1, 0), (0, 1)] {
            let step = |f: &HeightField, c: usize, r: usize| f.at((c + x) % f.columns, (r + y) % f.rows) - f.at(c, r);
            let slope = mean(|f, c, r| step(f, c, r).powi(2)) / ROUGH.rms.powi(2);
            assert!((slope / expected - 1.0).abs() < bound(0.75), "{slope} {expected}");
        }
    }

    #[test]
    fn the_correlation_is_gaussian_but_for_the_sampling() {
        for (n, length) in [(64, 2.0), (64, 8.0), (512, 10.0), (333, 7.3)] {
            let k = kernel(n, length);
            for lag in 0..20.min(n / 2) {
                let found: f64 = k.iter().skip(lag).zip(&k).map(|(a, b)| a * b).sum();
                let expected = (-(lag as f64 / length).powi(2)).exp();
                let sampling = 4.0 * (-0.25 * (PI * length).powi(2)).exp();
                assert!((found - expected).abs() < sampling + 1e-12, "{n} {length} {lag}: {found} {expected}");
            }
        }
    }

    #[test]
    fn surfaces_repeat_and_depend_on_the_seed_only() {
        let field = ROUGH.field().unwrap();
        assert_eq!(field.seams(), None);
        assert_eq!(field, ROUGH.field().unwrap());
        assert_ne!(field, Rough { seed: 1, ..ROUGH }.field().unwrap());
    }

    #[test]
    fn what_cannot_be_told_is_refused() {
        assert!(Rough { length: 8.0, ..ROUGH }.field().unwrap_err().contains("at least eight times"));
        assert!(Rough { length: 0.3, ..ROUGH }.field().unwrap_err().contains("at least 640"));
        assert!(Rough { points: [usize::MAX, 3], ..ROUGH }.field().unwrap_err().contains("at most"));
    }
}
