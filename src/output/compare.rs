//! What the comparison of two results has found, for people and as JSON.

use std::fmt::Write as _;

use serde::Serialize;

use crate::bsdf::Bsdf;
use crate::bsdf::compare::{Compared, Comparison, FALSE_ALARM};
use crate::colour::{self, Illuminant};

/// A line per incidence and wavelength, and the verdict.
pub fn text(comparison: &Comparison, colours: &[Difference]) -> String {
    let mut out = format!(
        "{:>7} {:>7} {:>8} {:>7} {:>10} {:>17} {:>10} {:>10}  {}\n",
        "θ/°", "φ/°", "λ/nm", "facets", "max |z|", "at θ, φ/°", "χ²/facets", "rms", "ledger, greatest |z|"
    );
    for c in &comparison.spectra {
        let (z, place) = c.greatest.map_or((0.0, "-".into()), |(z, facet)| {
            let d = facet.center();
            let (theta, phi) = (d.z.clamp(-1.0, 1.0).acos().to_degrees(), d.y.atan2(d.x).to_degrees());
            (z.abs(), format!("{theta:.1}, {phi:.1}"))
        });
        let _ = writeln!(
            out,
            "{:>7} {:>7} {:>8} {:>7} {z:>10.2} {place:>17} {:>10.3} {:>9.2}%  {}",
            c.incidence.theta_deg,
            c.incidence.phi_deg,
            c.wavelength_nm,
            c.facets,
            c.chi2 / (c.facets.max(1) as f64),
            100.0 * c.rms,
            worst(c),
        );
    }
    for d in colours {
        let _ = writeln!(
            out,
            "reflected colour, θ {}°, φ {}°: ΔE2000 {:.3} under D65, {:.3} under A",
            d.theta_deg, d.phi_deg, d.daylight, d.lamplight
        );
    }
    let _ = writeln!(
        out,
        "{} numbers; greatest |z| {:.2} (allowed {:.2}), greatest χ² {:+.2} standard deviations (allowed {:.2})",
        comparison.numbers,
        comparison.greatest_z(),
        comparison.allowed_z,
        comparison.greatest_square(),
        comparison.allowed_square
    );
    let _ = writeln!(
        out,
        "{} (false-alarm rate {FALSE_ALARM})",
        if comparison.agrees() { "the results agree" } else { "the results DIFFER by more than chance" }
    );
    out
}

fn worst(c: &Compared) -> String {
    let most = c.ledger_z.iter().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
    most.map_or_else(String::new, |(name, z)| format!("{name} {:.2}", z.abs()))
}

/// How the colour of the reflected light differs under one incidence, CIEDE2000.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Difference {
    /// Polar angle of the source, degrees.
    pub theta_deg: f64,
    /// Its azimuth, degrees.
    pub phi_deg: f64,
    /// Under D65.
    pub daylight: f64,
    /// Under A.
    pub lamplight: f64,
}

/// Differences of the colours of all light that is reflected, per common incidence; none where wavelengths tell no colour.
pub fn colours(a: &Bsdf, b: &Bsdf) -> Vec<Difference> {
    let lab = |bsdf: &Bsdf, i: usize, illuminant: Illuminant| {
        let weights = colour::weights(illuminant, &bsdf.wavelength_nm)?;
        let reflected = bsdf.incidences[i].ledger.reflected.iter().map(|e| e.value);
        Some(colour::lab(colour::summed(&weights, reflected), illuminant.white()))
    };
    let of = |(i, s): (usize, &crate::bsdf::Scattering)| {
        let j = b.incidences.iter().position(|t| t.incidence == s.incidence)?;
        let distance = |light| Some(colour::delta_e_2000(lab(a, i, light)?, lab(b, j, light)?));
        Some(Difference {
            theta_deg: s.incidence.theta_deg,
            phi_deg: s.incidence.phi_deg,
            daylight: distance(Illuminant::D65)?,
            lamplight: distance(Illuminant::A)?,
        })
    };
    a.incidences.iter().enumerate().filter_map(of).collect()
}

#[derive(Serialize)]
struct Document<'a> {
    schema: &'static str,
    agrees: bool,
    false_alarm: f64,
    numbers: usize,
    greatest_z: f64,
    allowed_z: f64,
    greatest_chi2_deviation: f64,
    allowed_chi2_deviation: f64,
    spectra: Vec<Row>,
    colours: &'a [Difference],
}

#[derive(Serialize)]
struct Row {
    theta_deg: f64,
    phi_deg: f64,
    wavelength_nm: f64,
    facets: usize,
    greatest_z: f64,
    chi2: f64,
    rms: f64,
    rms_of_noise: f64,
}

/// The same as a JSON document.
pub fn json(comparison: &Comparison, colours: &[Difference]) -> String {
    let row = |c: &Compared| Row {
        theta_deg: c.incidence.theta_deg,
        phi_deg: c.incidence.phi_deg,
        wavelength_nm: c.wavelength_nm,
        facets: c.facets,
        greatest_z: c.greatest.map_or(0.0, |g| g.0),
        chi2: c.chi2,
        rms: c.rms,
        rms_of_noise: c.noise,
    };
    let document = Document {
        schema: "gonio-comparison-1",
        agrees: comparison.agrees(),
        false_alarm: FALSE_ALARM,
        numbers: comparison.numbers,
        greatest_z: comparison.greatest_z(),
        allowed_z: comparison.allowed_z,
        greatest_chi2_deviation: comparison.greatest_square(),
        allowed_chi2_deviation: comparison.allowed_square,
        spectra: comparison.spectra.iter().map(row).collect(),
        colours,
    };
    serde_json::to_string_pretty(&document).expect("plain numbers and texts")
}
