//! Two results of the same sample: do they differ by more than chance?
//!
//! Their domes have facets of different size; they are compared in the coarser one of each place, or in one coarser still
//! that enough trees have hit, where the fluxes of the finer ones add up. Wavelengths share their rays, so that each has a sum
//! of squares of its own.

use super::{Bsdf, FacetValue, Scattering};
use crate::dome::{BATCHES, Estimate, Facet, critical};
use crate::light::Incidence;

/// Chance that two results of one sample are said to differ, over everything that is compared.
pub const FALSE_ALARM: f64 = 1e-3;
/// Degrees of freedom of the difference of two such results.
const FREEDOM: f64 = 2.0 * (BATCHES as f64 - 1.0);
/// Facets hit by fewer trees in either are too rough for a test.
const FEWEST_TREES: u64 = 100;
/// Relative difference that is none: numbers without statistics differ by their rounding.
const ROUNDING: f64 = 1e-6;

/// What the comparison of two results has found.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Comparison {
    /// What was compared, per common incidence and wavelength.
    pub spectra: Vec<Compared>,
    /// Greatest difference allowed, in standard errors: of so many numbers one is beyond it with half of [`FALSE_ALARM`].
    pub allowed_z: f64,
    /// Greatest deviation of a sum of squares allowed, in its standard deviations, likewise.
    pub allowed_square: f64,
    /// Numbers compared.
    pub numbers: usize,
}

/// The comparison of one incidence and wavelength.
#[derive(Clone, Debug, PartialEq)]
pub struct Compared {
    /// Direction towards the source.
    pub incidence: Incidence,
    /// Vacuum wavelength, nm.
    pub wavelength_nm: f64,
    /// Facets that enough trees have hit in both.
    pub facets: usize,
    /// Greatest difference of a facet, in standard errors, and where it is.
    pub greatest: Option<(f64, Facet)>,
    /// Sum of the squares of the differences in standard errors, scaled to a mean of 1 per facet if chance is all.
    pub chi2: f64,
    /// How far that is from the number of facets, in standard deviations.
    pub chi2_deviation: f64,
    /// Root of the mean square of the differences over that of the values, weighted by projected solid angle.
    pub rms: f64,
    /// What of it the standard errors explain.
    pub noise: f64,
    /// Differences of the ledger's entries, in standard errors.
    pub ledger_z: Vec<(&'static str, f64)>,
}

impl Comparison {
    /// Whether nothing differs by more than chance.
    pub fn agrees(&self) -> bool {
        self.greatest_z() <= self.allowed_z && self.greatest_square() <= self.allowed_square
    }

    /// The greatest difference of all facets and entries, in standard errors.
    pub fn greatest_z(&self) -> f64 {
        let of = |c: &Compared| {
            let ledger = c.ledger_z.iter().map(|(_, z)| z.abs()).fold(0.0, f64::max);
            c.greatest.map_or(0.0, |(z, _)| z.abs()).max(ledger)
        };
        self.spectra.iter().map(of).fold(0.0, f64::max)
    }

    /// The greatest deviation of a sum of squares, in its standard deviations.
    pub fn greatest_square(&self) -> f64 {
        self.spectra.iter().map(|c| c.chi2_deviation).fold(f64::NEG_INFINITY, f64::max)
    }
}

/// Compares what two results have in common.
///
/// # Errors
/// When that is nothing.
pub fn compare(a: &Bsdf, b: &Bsdf) -> Result<Comparison, String> {
    let mut spectra = Vec::new();
    for one in &a.incidences {
        let Some(other) = b.incidences.iter().find(|s| s.incidence == one.incidence) else { continue };
        let cells = resolved(common(&one.facets, &other.facets), [&one.facets, &other.facets]);
        for (wa, nm) in a.wavelength_nm.iter().enumerate() {
            let Some(wb) = b.wavelength_nm.iter().position(|w| w == nm) else { continue };
            spectra.push(Compared::new((one, wa), (other, wb), *nm, &cells));
        }
    }
    if spectra.is_empty() {
        return Err("they have no incidence and wavelength in common".into());
    }
    let numbers: usize = spectra.iter().map(|c| c.facets + c.ledger_z.len()).sum();
    let freedom = FREEDOM as usize + 1;
    let allowed = |tests: usize| critical(0.5 * FALSE_ALARM / tests.max(1) as f64, freedom);
    // A sum of squares is too great on one side only.
    let allowed_square = critical(FALSE_ALARM / spectra.len() as f64, usize::MAX);
    Ok(Comparison { allowed_z: allowed(numbers), allowed_square, numbers, spectra })
}

/// A place that both domes have: one facet, and all facets within it of either.
#[derive(Clone, Debug)]
struct Cell<'a> {
    facet: Facet,
    parts: [&'a [FacetValue]; 2],
}

/// The coarser facets of each place. Facets ascend along both domes.
fn common<'a>(a: &'a [FacetValue], b: &'a [FacetValue]) -> Vec<Cell<'a>> {
    let (mut rest_a, mut rest_b) = (a, b);
    let mut cells = Vec::new();
    while let (Some(first_a), Some(first_b)) = (rest_a.first(), rest_b.first()) {
        let facet = if first_a.facet.level <= first_b.facet.level { first_a.facet } else { first_b.facet };
        let within = |f: &FacetValue| {
            f.facet.level >= facet.level && f.facet.code >> (2 * (f.facet.level - facet.level)) == facet.code
        };
        let take = |rest: &mut &'a [FacetValue]| {
            let n = rest.iter().take_while(|f| within(f)).count();
            let (taken, after) = rest.split_at(n);
            *rest = after;
            taken
        };
        let parts = [take(&mut rest_a), take(&mut rest_b)];
        if parts.iter().any(|p| p.is_empty()) {
            // Domes that do not cover the same: nothing more can be said.
            break;
        }
        cells.push(Cell { facet, parts });
    }
    cells
}

/// The cells with those put together that too few trees have hit, as far as one side of the sample goes. They cover `facets`
/// from the first on.
fn resolved<'a>(mut cells: Vec<Cell<'a>>, facets: [&'a [FacetValue]; 2]) -> Vec<Cell<'a>> {
    let finest = cells.iter().map(|c| c.facet.level).max().unwrap_or(0);
    for level in (2..=finest).rev() {
        let above = |f: Facet| (f.level >= level).then(|| f.code >> (2 * (f.level + 1 - level)));
        let mut done = [0, 0];
        let mut kept = Vec::new();
        for family in cells.chunk_by(|a, b| above(a.facet).is_some() && above(a.facet) == above(b.facet)) {
            let from = done;
            family.iter().for_each(|c| done = [0, 1].map(|k| done[k] + c.parts[k].len()));
            let rough = family.iter().any(|c| c.facet.level == level && !c.is_resolved());
            match above(family[0].facet).filter(|_| rough) {
                Some(code) => kept.push(Cell {
                    facet: Facet { level: level - 1, code },
                    parts: [0, 1].map(|k| &facets[k][from[k]..done[k]]),
                }),
                None => kept.extend_from_slice(family),
            }
        }
        cells = kept;
    }
    cells
}

impl Cell<'_> {
    /// Share of the incident power in the cell.
    fn flux(&self, which: usize, w: usize) -> Estimate {
        let (mut value, mut variance) = (0.0, 0.0);
        for f in self.parts[which] {
            let angle = f.facet.projected_solid_angle();
            value += angle * f.value[w].value;
            variance += (angle * f.value[w].se).powi(2);
        }
        Estimate { value, se: variance.sqrt() }
    }

    fn is_resolved(&self) -> bool {
        self.parts.iter().all(|p| p.iter().map(|f| f.trees).sum::<u64>() >= FEWEST_TREES)
    }
}

/// Difference in standard errors; that of numbers without statistics is infinite, unless it is rounding.
fn z(a: Estimate, b: Estimate) -> f64 {
    let difference = a.value - b.value;
    if difference.abs() <= ROUNDING * a.value.abs().max(b.value.abs()) {
        return 0.0;
    }
    difference / a.se.hypot(b.se)
}

impl Compared {
    fn new((a, wa): (&Scattering, usize), (b, wb): (&Scattering, usize), nm: f64, cells: &[Cell<'_>]) -> Self {
        let (mut facets, mut square, mut greatest) = (0, 0.0, None::<(f64, Facet)>);
        let (mut difference, mut noise, mut size) = (0.0, 0.0, 0.0);
        for cell in cells {
            let (p, q) = (cell.flux(0, wa), cell.flux(1, wb));
            let angle = cell.facet.projected_solid_angle();
            difference += (p.value - q.value).powi(2) / angle;
            noise += (p.se.powi(2) + q.se.powi(2)) / angle;
            size += (0.5 * (p.value + q.value)).powi(2) / angle;
            if !cell.is_resolved() {
                continue;
            }
            let z = z(p, q);
            facets += 1;
            square += z * z;
            if greatest.is_none_or(|(most, _)| z.abs() > most.abs()) {
                greatest = Some((z, cell.facet));
            }
        }
        let entries = a.ledger.entries().into_iter().zip(b.ledger.entries());
        let ledger_z: Vec<(&'static str, f64)> =
            entries.map(|((name, p), (_, q))| (name, z(p[wa], q[wb]))).filter(|(_, z)| !z.is_nan()).collect();
        // Squares of Student's t have the mean ν / (ν − 2) and this variance about it.
        let mean = FREEDOM / (FREEDOM - 2.0);
        let variance = 2.0 * FREEDOM.powi(2) * (FREEDOM - 1.0) / ((FREEDOM - 2.0).powi(2) * (FREEDOM - 4.0));
        let n = facets as f64;
        let relative = |x: f64| if size > 0.0 { (x / size).sqrt() } else { 0.0 };
        Self {
            incidence: a.incidence,
            wavelength_nm: nm,
            facets,
            greatest,
            chi2: square / mean,
            chi2_deviation: if facets > 0 { root_deviation(square, n * mean, n * variance) } else { 0.0 },
            rms: relative(difference),
            noise: relative(noise),
            ledger_z,
        }
    }
}

/// How far a sum of squares is from its mean, in standard deviations: its cube root is nearly normal (Wilson and Hilferty,
/// PNAS 17, 684 (1931)), with the degrees of freedom that its mean and variance stand for.
fn root_deviation(square: f64, mean: f64, variance: f64) -> f64 {
    let freedom = 2.0 * mean * mean / variance;
    let part = 2.0 / (9.0 * freedom);
    ((square / mean).cbrt() - (1.0 - part)) / part.sqrt()
}
