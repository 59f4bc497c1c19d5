//! How far a measurement may be from the truth, all in all.

use super::Entry;
use super::geodesic::{Facet, count};
use super::leaves::RESOLVED;
use super::statistics::{Estimate, Measurement};

/// Level of the dome on which errors are stated, if it goes that far: facets 8° wide, as what detectors and other programs
/// see. In finer ones the same light has greater errors, though nobody wants to know it that finely.
pub const RESOLUTION: u8 = 3;

/// All light on one side that is less than this share of the incident power is not judged by its relative error: in the
/// error of the whole it counts as so much. What is spread over the dome does not count if it is less.
pub const FAINT: f64 = 0.01;

/// Facets that are darker than this part of the brightest one on their side are not judged by themselves.
const DIM: f64 = 0.01;

/// Relative errors that 95 of 100 measurements do not exceed. Those of a dome are the root of the integral of the squared
/// error over that of the squared BSDF over the solid angle, all lanes together; those of light in all directions
/// likewise without the integral. 0 where nothing varies.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Precision {
    /// Of the BRDF, over the facets of [`RESOLUTION`].
    pub above: f64,
    /// Of the BTDF.
    pub below: f64,
    /// Of all reflected light.
    pub reflected: f64,
    /// Of all transmitted light.
    pub transmitted: f64,
    /// The greatest of these, but for faint light.
    pub whole: f64,
    /// Of the worst facet by itself that has at least a hundredth of the brightest; endless if one of these is unresolved.
    pub facet: f64,
}

/// How much of what is seen is noise: squares of a norm, per [`Measurement::noises`].
#[derive(Clone, Copy, Debug, Default)]
pub struct Noise {
    /// Of the true values, as far as it is known.
    pub signal: f64,
    /// Of the standard errors.
    pub noise: f64,
    /// Whether there is enough light to care.
    pub judged: bool,
}

/// Square of a norm, and of the error of what has that norm, facet by facet.
#[derive(Clone, Copy, Debug, Default)]
struct Norm {
    square: f64,
    error: f64,
    /// Sum of the squares of the errors' contributions.
    errors_squared: f64,
}

impl Norm {
    /// Adds values that vary together, each with its weight.
    fn add(&mut self, values: impl Iterator<Item = Estimate>, weight: f64) {
        let mut error = 0.0;
        for e in values {
            self.square += weight * (e.value * e.value - e.se * e.se);
            error += weight * e.se * e.se;
        }
        self.error += error;
        self.errors_squared += error * error;
    }

    /// The relative error that 95 of 100 do not exceed. A sum of squares of so many independent errors is like χ²; their
    /// estimates have `freedom` degrees of freedom each.
    fn relative(&self, freedom: f64) -> f64 {
        match self.bound(freedom) {
            0.0 => 0.0,
            // Where all that is seen may be noise, nothing is known.
            bound if self.square > 0.0 => bound / self.square.sqrt(),
            _ => f64::INFINITY,
        }
    }

    /// The same, not relative.
    fn bound(&self, freedom: f64) -> f64 {
        if self.error == 0.0 {
            return 0.0;
        }
        let independent = self.error * self.error / self.errors_squared;
        (self.error * fisher_95(independent, freedom * independent)).sqrt()
    }
}

impl Measurement {
    /// Of the BRDF, the BTDF, all reflected light and all transmitted light.
    pub fn noises(&self) -> [Noise; 4] {
        let (sides, totals) = self.norms();
        let lanes = self.shape().lanes as f64;
        let of = |norm: Norm, light: f64| Noise { signal: norm.square, noise: norm.error, judged: light >= FAINT };
        let total = |norm: Norm| (norm.square.max(0.0) / lanes).sqrt();
        let spread = self.spread();
        [
            of(sides[0], spread[0]),
            of(sides[1], spread[1]),
            of(totals[0], total(totals[0])),
            of(totals[1], total(totals[1])),
        ]
    }

    /// Root of the mean square over all lanes of the light that is spread over the dome, above and below.
    fn spread(&self) -> [f64; 2] {
        let lanes = self.shape().lanes;
        [[Entry::Reflected, Entry::Specular], [Entry::Transmitted, Entry::Undeflected]].map(|[all, straight]| {
            let of = |lane| self.term(all as usize, lane).value - self.term(straight as usize, lane).value;
            ((0..lanes).map(of).map(|x| x * x).sum::<f64>() / lanes as f64).sqrt()
        })
    }

    /// Of both sides of the dome, and of all light that goes to them.
    fn norms(&self) -> ([Norm; 2], [Norm; 2]) {
        let lanes = self.shape().lanes;
        let level = self.finest().min(RESOLUTION);
        let mut sides = [Norm::default(); 2];
        for facet in (0..count(level)).map(|code| Facet { level, code }).filter(|&f| self.facet_trees(f) > 0) {
            let (solid, projected) = (facet.solid_angle(), facet.projected_solid_angle());
            sides[below(facet)].add((0..lanes).map(|l| self.facet(facet, l)), solid / projected / projected);
        }
        let totals = [Entry::Reflected, Entry::Transmitted].map(|entry| {
            let mut norm = Norm::default();
            norm.add((0..lanes).map(|l| self.term(entry as usize, l)), 1.0);
            norm
        });
        (sides, totals)
    }

    /// What can be said of it all in all.
    pub fn precision(&self) -> Precision {
        let (sides, totals) = self.norms();
        let (lanes, freedom) = (self.shape().lanes as f64, self.batches() as f64 - 1.0);
        let faint = lanes.sqrt() * FAINT;
        let judged = |((side, total), spread): ((&Norm, &Norm), f64)| {
            let total = total.bound(freedom) / total.square.max(0.0).sqrt().max(faint);
            if spread < FAINT { total } else { total.max(side.relative(freedom)) }
        };
        // Of a single batch nothing is known.
        let greatest = |a: f64, b: f64| if b.is_nan() { f64::INFINITY } else { a.max(b) };
        Precision {
            above: sides[0].relative(freedom),
            below: sides[1].relative(freedom),
            reflected: totals[0].relative(freedom),
            transmitted: totals[1].relative(freedom),
            whole: sides.iter().zip(&totals).zip(self.spread()).map(judged).fold(0.0, greatest),
            facet: self.worst_facet(self.finest().min(RESOLUTION)),
        }
    }

    fn worst_facet(&self, level: u8) -> f64 {
        let t = super::critical(0.05, self.batches());
        let facets = || (0..count(level)).map(|code| Facet { level, code }).filter(|&f| self.facet_trees(f) > 0);
        let radiance = |f: Facet, lane| self.facet(f, lane).value / f.projected_solid_angle();
        let mut worst: f64 = 0.0;
        for lane in 0..self.shape().lanes {
            let mut brightest = [0.0f64; 2];
            facets().for_each(|f| brightest[below(f)] = brightest[below(f)].max(radiance(f, lane)));
            for f in facets().filter(|&f| radiance(f, lane) > DIM * brightest[below(f)]) {
                let Estimate { value, se } = self.facet(f, lane);
                worst = worst.max(if self.facet_trees(f) < RESOLVED { f64::INFINITY } else { t * se / value });
            }
        }
        worst
    }
}

/// 0 above the sample, 1 below.
fn below(facet: Facet) -> usize {
    usize::from(facet.center().z < 0.0)
}

/// What Fisher's F exceeds once in 20 times, for these degrees of freedom (Paulson 1942; 2.5 % too low for 1, less for
/// more).
fn fisher_95(numerator: f64, denominator: f64) -> f64 {
    const Z: f64 = 1.644_854;
    let (a, b) = (2.0 / (9.0 * numerator), 2.0 / (9.0 * denominator));
    let square = (1.0 - b) * (1.0 - b) - Z * Z * b;
    let half = (1.0 - a) * (1.0 - b);
    let rest = (1.0 - a) * (1.0 - a) - Z * Z * a;
    ((half + (half * half - square * rest).max(0.0).sqrt()) / square).powi(3)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fisher_is_that_of_tables() {
        for (numerator, denominator, f) in
            [(1.0, 31.0, 4.160), (10.0, 310.0, 1.862), (100.0, 3100.0, 1.248), (3.0, 93.0, 2.703)]
        {
            let ours = fisher_95(numerator, denominator);
            assert!((ours / f - 1.0).abs() < 0.03, "{numerator} {denominator}: {ours}, {f}");
        }
    }

    /// Errors of many facets that do not vary together hardly vary in their sum; a single one does as Student says.
    #[test]
    fn a_norm_of_one_value_has_the_interval_of_student() {
        let mut one = Norm::default();
        one.add(std::iter::once(Estimate { value: 2.0, se: 0.1 }), 1.0);
        assert!((one.relative(31.0) / (2.04 * 0.05) - 1.0).abs() < 0.02);
        let mut many = Norm::default();
        (0..1000).for_each(|_| many.add(std::iter::once(Estimate { value: 2.0, se: 0.1 }), 1.0));
        assert!((many.relative(31.0) / 0.05 - 1.0).abs() < 0.05);
        assert_eq!(Norm::default().relative(31.0), 0.0);
    }
}
