//! Results on a grid of their own, so that those of different settings can be compared.

use super::super::Outcome;
use crate::bsdf::{Bsdf, FacetValue};
use crate::dome::{Estimate, FAINT, Facet, RESOLUTION, count};

/// Relative root mean square errors, as [`crate::dome::Precision`] has them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Distance {
    /// Of the BRDF over the dome.
    pub above: f64,
    /// Of the BTDF.
    pub below: f64,
    /// Of all reflected light.
    pub reflected: f64,
    /// Of all transmitted light.
    pub transmitted: f64,
    /// The greatest of these, but for faint light.
    pub whole: f64,
}

/// What a result says, per part: the BRDF and the BTDF (facets of [`RESOLUTION`], per incidence and wavelength, weighted by
/// the root of the solid angle), then all reflected and all transmitted light.
#[derive(Clone, Debug, Default)]
pub struct Values {
    parts: [Vec<f64>; 4],
    variances: [Vec<f64>; 4],
    /// Squares of what is spread over the dome above and below, sums over incidences and wavelengths.
    spread: [f64; 2],
}

impl Values {
    /// Of a result, at these wavelengths (nm, ascending), interpolated linearly between its own. Its domes may be told apart.
    pub fn new<'f>(bsdf: &Bsdf, domes: impl Iterator<Item = &'f [FacetValue]>, wavelength_nm: &[f64]) -> Self {
        let mut values = Self::default();
        let places: Vec<(usize, usize, f64)> = wavelength_nm.iter().map(|&nm| place(&bsdf.wavelength_nm, nm)).collect();
        for (s, dome) in bsdf.incidences.iter().zip(domes) {
            let of_facets = on_grid(dome);
            for (facet, spectrum) in of_facets {
                let part = usize::from(facet.center().z < 0.0);
                values.push(part, &spectrum, &places, facet.solid_angle().sqrt());
            }
            let ledger = &s.ledger;
            values.push(2, &ledger.reflected, &places, 1.0);
            values.push(3, &ledger.transmitted, &places, 1.0);
            let pairs = [(&ledger.reflected, &ledger.specular), (&ledger.transmitted, &ledger.undeflected)];
            for (sum, (all, straight)) in values.spread.iter_mut().zip(pairs) {
                *sum += places.iter().map(|&(i, ..)| (all[i].value - straight[i].value).powi(2)).sum::<f64>();
            }
        }
        values
    }

    /// Of what was measured, before any facets were put together: so nothing but chance differs from what the settings make of
    /// it.
    pub fn measured(outcome: &Outcome, wavelength_nm: &[f64]) -> Self {
        Self::new(&outcome.bsdf, outcome.grids.iter().map(|grid| &grid[..]), wavelength_nm)
    }

    /// What is known exactly: reflectance and transmittance of a sample that scatters nothing, in the order of [`Self::new`].
    pub fn exact(reflected: Vec<f64>, transmitted: Vec<f64>) -> Self {
        let zeros = |v: &Vec<f64>| vec![0.0; v.len()];
        let variances = [Vec::new(), Vec::new(), zeros(&reflected), zeros(&transmitted)];
        Self { parts: [Vec::new(), Vec::new(), reflected, transmitted], variances, spread: [0.0; 2] }
    }

    fn push(&mut self, part: usize, spectrum: &[Estimate], places: &[(usize, usize, f64)], weight: f64) {
        for &(i, j, x) in places {
            let (a, b) = (spectrum[i], spectrum[j]);
            self.parts[part].push(weight * (a.value + x * (b.value - a.value)));
            let se = a.se + x * (b.se - a.se);
            self.variances[part].push(weight * weight * se * se);
        }
    }

    /// Adds the values of another result.
    pub fn add(&mut self, other: &Self) {
        for (a, b) in self.parts.iter_mut().zip(&other.parts) {
            if a.is_empty() {
                a.resize(b.len(), 0.0);
            }
            a.iter_mut().zip(b).for_each(|(a, b)| *a += b);
        }
    }

    /// The mean of `n` results whose sum this is.
    #[must_use]
    pub fn over(mut self, n: f64) -> Self {
        self.parts.iter_mut().flatten().for_each(|x| *x /= n);
        self
    }

    /// Squares of the distances to a reference, per part: without what the standard error of the reference adds, and relative
    /// to its norm.
    pub fn squares(&self, reference: &Self) -> [f64; 4] {
        std::array::from_fn(|part| {
            let noise: f64 = reference.variances[part].iter().sum();
            let distance: f64 =
                self.parts[part].iter().zip(&reference.parts[part]).map(|(a, b)| (a - b) * (a - b)).sum();
            let norm = reference.norm(part);
            if norm > 0.0 { (distance - noise) / norm } else { 0.0 }
        })
    }

    /// Square of its own standard error of a part, relative to its norm.
    pub fn noise(&self, part: usize) -> f64 {
        let norm = self.norm(part);
        if norm > 0.0 { self.variances[part].iter().sum::<f64>() / norm } else { 0.0 }
    }

    /// Square of the norm of a part, without noise.
    fn norm(&self, part: usize) -> f64 {
        let square: f64 = self.parts[part].iter().map(|x| x * x).sum();
        square - self.variances[part].iter().sum::<f64>()
    }

    /// Distances from their squares to this reference.
    pub fn distance(&self, squares: [f64; 4]) -> Distance {
        let [above, below, reflected, transmitted] = squares.map(|s| s.max(0.0).sqrt());
        let judged = |side: f64, total: f64, part: usize| {
            let mean = |square: f64| (square.max(0.0) / self.parts[part].len().max(1) as f64).sqrt();
            let light = mean(self.norm(part));
            let total = if light < FAINT { total * light / FAINT } else { total };
            if mean(self.spread[part - 2]) < FAINT { total } else { total.max(side) }
        };
        let whole = judged(above, reflected, 2).max(judged(below, transmitted, 3));
        Distance { above, below, reflected, transmitted, whole }
    }
}

/// Where a wavelength lies between others: two of them, and how far from the first to the second.
fn place(all: &[f64], nm: f64) -> (usize, usize, f64) {
    let after = all.partition_point(|&x| x < nm).clamp(usize::from(all.len() > 1), all.len() - 1);
    let before = after.saturating_sub(1);
    let width = all[after] - all[before];
    (before, after, if width > 0.0 { ((nm - all[before]) / width).clamp(0.0, 1.0) } else { 0.0 })
}

/// BSDF of each facet of [`RESOLUTION`], 1/sr: that of the coarser facet it is in, or the mean of the finer ones in it.
fn on_grid(dome: &[FacetValue]) -> Vec<(Facet, Vec<Estimate>)> {
    let lanes = dome.first().map_or(0, |f| f.value.len());
    let all = (0..count(RESOLUTION)).map(|code| Facet { level: RESOLUTION, code });
    let mut grid: Vec<(Facet, Vec<Estimate>)> = all.map(|f| (f, vec![Estimate::default(); lanes])).collect();
    for f in dome {
        let Facet { level, code } = f.facet;
        if level <= RESOLUTION {
            let parts = 4usize.pow(u32::from(RESOLUTION - level));
            grid[code as usize * parts..][..parts].iter_mut().for_each(|g| g.1.clone_from(&f.value));
            continue;
        }
        let (facet, sums) = &mut grid[code as usize >> (2 * (level - RESOLUTION))];
        let share = f.facet.projected_solid_angle() / facet.projected_solid_angle();
        for (sum, e) in sums.iter_mut().zip(&f.value) {
            *sum = Estimate { value: sum.value + share * e.value, se: sum.se.hypot(share * e.se) };
        }
    }
    grid
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wavelengths_lie_between_others() {
        assert_eq!(place(&[400.0, 500.0, 600.0], 525.0), (1, 2, 0.25));
        assert_eq!(place(&[400.0, 500.0], 400.0), (0, 1, 0.0));
        assert_eq!(place(&[400.0, 500.0], 700.0), (0, 1, 1.0));
        assert_eq!(place(&[400.0], 555.0), (0, 0, 0.0));
    }

    #[test]
    fn the_noise_of_a_reference_is_taken_away() {
        let mut reference = Values::exact(vec![3.0, 4.0], vec![1.0, 1.0]);
        reference.variances[2] = vec![0.5, 0.5];
        let other = Values::exact(vec![4.0, 4.0], vec![1.0, 1.5]);
        let squares = other.squares(&reference);
        assert_eq!(squares, [0.0, 0.0, 0.0, 0.125]);
        assert_eq!(reference.distance(squares).whole, 0.125f64.sqrt());
    }
}
