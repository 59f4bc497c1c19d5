//! What the pictures of a page are drawn from.

use serde::Serialize;

use super::pack::{Codes, base64};
use crate::bsdf::{Arm, Bsdf, Reading, Scattering};
use crate::colour::{self, Illuminant};
use crate::dome::{Estimate, RESOLVED};
use crate::light::Incidence;

/// Full width of the detector's aperture in scans, degrees, and the step from one reading to the next.
pub const APERTURE_DEG: f64 = 2.0;
/// Codes of values: 16 bits.
const VALUES: u32 = 65_534;
/// Codes of standard errors, as shares of their values: 8 bits.
const ERRORS: u32 = 254 - 1;
/// Standard errors below this share of their value are told as this.
pub const LEAST_ERROR: f64 = 1e-6;

/// The payload: one JSON document with numbers as base64, little-endian.
#[derive(Serialize)]
pub struct Data<'a> {
    /// Vacuum wavelengths, nm.
    wavelength_nm: &'a [f64],
    /// Facets hit by fewer trees have a standard error that means little.
    resolved: u64,
    /// How values are packed, 1/sr.
    values: Codes,
    /// How standard errors are packed, as shares of their values.
    errors: Codes,
    /// Which column of the facets holds a wavelength: those that shared rays all the way have the same numbers.
    columns: Vec<usize>,
    /// X, Y and Z of each wavelength; none if the colour is not known.
    eye: Option<Vec<[f64; 3]>>,
    /// Names of the entries of the ledger, then of the bodies that absorb.
    ledger: Vec<&'a str>,
    groups: &'a [String],
    aperture_deg: f64,
    transmits: bool,
    mueller: bool,
    incidences: Vec<OfIncidence>,
}

#[derive(Serialize)]
struct OfIncidence {
    theta_deg: f64,
    phi_deg: f64,
    trees: u64,
    segments: u64,
    /// Degrees from the normal, per wavelength; null where nothing can go straight on.
    straight_deg: Vec<f64>,
    /// u32 per facet: level · 2²⁸ + code.
    facets: String,
    /// u32 per facet: trees that hit it.
    hits: String,
    /// Of the facets that were hit, per column.
    bsdf: Packed,
    /// f32 [entry, or body that absorbs][wavelength][value, standard error].
    ledger: String,
    /// First angle of the scans, degrees.
    from_deg: f64,
    readings: usize,
    /// [reading][wavelength]
    above: Packed,
    below: Option<Packed>,
}

/// Estimates: u16 codes of the values, and u8 codes of the standard errors.
#[derive(Serialize)]
struct Packed {
    values: String,
    errors: String,
}

/// Estimates of one incidence before they are packed.
struct Loose<'a> {
    scattering: &'a Scattering,
    bsdf: Vec<Estimate>,
    above: Vec<Reading>,
    below: Option<Vec<Reading>>,
}

impl<'a> Data<'a> {
    /// From a result.
    pub fn new(bsdf: &'a Bsdf) -> Self {
        let columns = columns(bsdf);
        let transmits = bsdf.incidences.iter().any(|s| s.ledger.transmitted.iter().any(|e| e.value > 0.0));
        let loose: Vec<Loose<'_>> =
            (0..bsdf.incidences.len()).map(|i| Loose::new(bsdf, i, &columns, transmits)).collect();
        let all = || loose.iter().flat_map(Loose::estimates);
        let values = Codes::over(all().map(|e| e.value), VALUES);
        let errors = Codes::over(all().map(error), ERRORS);
        Self {
            wavelength_nm: &bsdf.wavelength_nm,
            resolved: RESOLVED,
            values,
            errors,
            columns,
            eye: colour::weights(Illuminant::D65, &bsdf.wavelength_nm),
            ledger: bsdf.incidences.first().map_or_else(Vec::new, |s| s.ledger.entries().map(|(n, _)| n).to_vec()),
            groups: &bsdf.groups,
            aperture_deg: APERTURE_DEG,
            transmits,
            mueller: bsdf.incidences.iter().any(|s| s.deltas.is_some()),
            incidences: loose.into_iter().map(|l| l.packed(&values, &errors)).collect(),
        }
    }

    /// Largest relative errors of packed values and of packed standard errors.
    pub fn rounding(&self) -> (f64, f64) {
        (self.values.error(), self.errors.error())
    }

    /// Whether there is a colour to tell.
    pub fn colour(&self) -> bool {
        self.eye.is_some()
    }

    /// The document, fit to stand in a page: no text in it ends the element that holds it.
    pub fn json(&self) -> String {
        serde_json::to_string(self).expect("plain numbers and texts").replace('<', "\\u003c")
    }
}

/// Which of the columns that differ holds each wavelength.
fn columns(bsdf: &Bsdf) -> Vec<usize> {
    let same = |a: usize, b: usize| {
        let mut facets = bsdf.incidences.iter().flat_map(|s| &s.facets);
        facets.all(|f| f.value[a].value == f.value[b].value && f.value[a].se.to_bits() == f.value[b].se.to_bits())
    };
    let mut first: Vec<usize> = Vec::new();
    let mut column = |w: usize| {
        first.iter().position(|&f| same(f, w)).unwrap_or_else(|| {
            first.push(w);
            first.len() - 1
        })
    };
    (0..bsdf.wavelength_nm.len()).map(&mut column).collect()
}

/// The standard error as a share of the value.
fn error(e: Estimate) -> f64 {
    if e.se == 0.0 || e.value == 0.0 { 0.0 } else { (e.se / e.value).max(LEAST_ERROR) }
}

/// Exits every [`APERTURE_DEG`] degrees, so that apertures touch, and one of them looks in the mirror direction.
fn exits(incidence: &Incidence) -> Vec<f64> {
    let at = |k: i32| incidence.theta_deg + f64::from(k) * APERTURE_DEG;
    (-90..=90).map(at).filter(|a| (-90.0..=90.0).contains(a)).collect()
}

impl<'a> Loose<'a> {
    fn new(bsdf: &'a Bsdf, i: usize, columns: &[usize], transmits: bool) -> Self {
        let scattering = &bsdf.incidences[i];
        let angles_deg = exits(&scattering.incidence);
        let scan = |below: bool| {
            bsdf.scan(&Arm { angles_deg: angles_deg.clone(), aperture_deg: APERTURE_DEG, below, turn_deg: 0.0 }, i)
                .readings
        };
        let count = columns.iter().max().map_or(0, |most| most + 1);
        let first = |column: usize| columns.iter().position(|&c| c == column).unwrap_or(0);
        let of_column: Vec<usize> = (0..count).map(first).collect();
        let hit = scattering.facets.iter().filter(|f| f.trees > 0);
        let bsdf = hit.flat_map(|f| of_column.iter().map(|&w| f.value[w])).collect();
        Self { scattering, bsdf, above: scan(false), below: transmits.then(|| scan(true)) }
    }

    fn estimates(&self) -> impl Iterator<Item = Estimate> {
        let readings = self.above.iter().chain(self.below.iter().flatten());
        self.bsdf.iter().copied().chain(readings.flat_map(|r| r.value.iter().copied()))
    }

    fn packed(self, values: &Codes, errors: &Codes) -> OfIncidence {
        let s = self.scattering;
        let pack = |all: &[Estimate]| Packed::new(all, values, errors);
        let scan = |readings: &[Reading]| pack(&readings.iter().flat_map(|r| r.value.clone()).collect::<Vec<_>>());
        let number = |x: u64| u32::try_from(x).unwrap_or(u32::MAX).to_le_bytes();
        OfIncidence {
            theta_deg: s.incidence.theta_deg,
            phi_deg: s.incidence.phi_deg,
            trees: s.trees,
            segments: s.segments,
            straight_deg: s.straight_deg.clone(),
            facets: base64(s.facets.iter().flat_map(|f| (u32::from(f.facet.level) << 28 | f.facet.code).to_le_bytes())),
            hits: base64(s.facets.iter().flat_map(|f| number(f.trees))),
            bsdf: pack(&self.bsdf),
            ledger: ledger(s),
            from_deg: self.above[0].angle_deg,
            readings: self.above.len(),
            above: scan(&self.above),
            below: self.below.as_deref().map(scan),
        }
    }
}

impl Packed {
    fn new(all: &[Estimate], values: &Codes, errors: &Codes) -> Self {
        Self {
            values: base64(all.iter().flat_map(|e| (values.code(e.value) as u16).to_le_bytes())),
            errors: base64(all.iter().map(|&e| errors.code(error(e)) as u8)),
        }
    }
}

fn ledger(s: &Scattering) -> String {
    let entries = s.ledger.entries().into_iter().map(|(_, entry)| entry).chain(&s.absorbed_by);
    let numbers = entries.flatten().flat_map(|e| [e.value as f32, e.se as f32]);
    base64(numbers.flat_map(f32::to_le_bytes))
}

#[cfg(test)]
mod tests;
