//! Helmholtz reciprocity: exchanging source and detector changes no BRDF. What it is off tells of noise, of facets too
//! coarse for a lobe, or of an error.

use super::{Bsdf, Lookup};
use crate::dome::Estimate;

/// How well a result is its own mirror, over pairs of measured incidences and all wavelengths.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reciprocity {
    /// Values compared.
    pub pairs: usize,
    /// Root of the mean square of f(a → b) − f(b → a), over that of their means.
    pub rms: f64,
    /// What of `rms` noise explains, from the standard errors.
    pub noise: f64,
    /// Greatest difference in standard errors.
    pub greatest_z: f64,
}

impl Bsdf {
    /// Compares the BRDF from each measured incidence towards the source of each other with the way back, under
    /// unpolarized light. None if there is but one incidence.
    pub fn reciprocity(&self) -> Option<Reciprocity> {
        let lookup = Lookup::new(self);
        let sources: Vec<_> = self.incidences.iter().map(|s| s.incidence).collect();
        let mut sums = Sums::default();
        for (i, a) in sources.iter().enumerate() {
            for b in &sources[..i] {
                let (from_a, from_b) = (lookup.at(a), lookup.at(b));
                for w in 0..self.wavelength_nm.len() {
                    sums.add(from_a.value(-b.propagation(), w), from_b.value(-a.propagation(), w));
                }
            }
        }
        sums.result()
    }
}

#[derive(Default)]
struct Sums {
    pairs: usize,
    difference: f64,
    mean: f64,
    variance: f64,
    greatest_z: f64,
}

impl Sums {
    fn add(&mut self, there: Estimate, back: Estimate) {
        let (difference, variance) = (there.value - back.value, there.se.powi(2) + back.se.powi(2));
        self.pairs += 1;
        self.difference += difference * difference;
        self.mean += (0.5 * (there.value + back.value)).powi(2);
        self.variance += variance;
        if variance > 0.0 {
            self.greatest_z = self.greatest_z.max(difference.abs() / variance.sqrt());
        }
    }

    fn result(&self) -> Option<Reciprocity> {
        let Self { pairs, greatest_z, .. } = *self;
        let relative = |square: f64| if self.mean > 0.0 { (square / self.mean).sqrt() } else { 0.0 };
        let (rms, noise) = (relative(self.difference), relative(self.variance));
        (pairs > 0).then_some(Reciprocity { pairs, rms, noise, greatest_z })
    }
}
