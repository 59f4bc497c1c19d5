//! Scans in the plane of incidence, as tables.

use std::fmt::Write as _;

use crate::bsdf::{Reading, Scan};
use crate::dome::Estimate;

/// `angle_deg,value,se`, angle by angle; before them the incidence and the wavelength, if there are several.
pub fn csv(scans: &[Scan]) -> String {
    let single = single(scans);
    let mut out =
        String::from(if single { "" } else { "theta_i_deg,phi_i_deg,wavelength_nm," }) + "angle_deg,value,se\n";
    for (scan, w, reading) in rows(scans) {
        if !single {
            let _ = write!(out, "{},{},{},", scan.incidence.theta_deg, scan.incidence.phi_deg, scan.wavelength_nm[w]);
        }
        let Estimate { value, se } = reading.value[w];
        let _ = writeln!(out, "{},{value:e},{se:e}", reading.angle_deg);
    }
    out
}

/// The same for people.
pub fn table(scans: &[Scan]) -> String {
    let mut out = String::new();
    let mut last = None;
    for (scan, w, reading) in rows(scans) {
        let this = (scan.incidence.theta_deg, scan.incidence.phi_deg, scan.wavelength_nm[w]);
        if last != Some(this) {
            let (theta, phi, nm) = this;
            let _ = writeln!(out, "incidence θ {theta}°, φ {phi}°, {nm} nm\n{:>8}{:>24}", "exit/°", "BSDF/(1/sr)");
            last = Some(this);
        }
        let Estimate { value, se } = reading.value[w];
        let _ = writeln!(out, "{:>8}{value:>14.6} ±{se:.6}", reading.angle_deg);
    }
    out
}

/// Whether there is but one incidence and one wavelength.
fn single(scans: &[Scan]) -> bool {
    matches!(scans, [scan] if scan.wavelength_nm.len() == 1)
}

fn rows(scans: &[Scan]) -> impl Iterator<Item = (&Scan, usize, &Reading)> {
    scans.iter().flat_map(|scan| {
        (0..scan.wavelength_nm.len()).flat_map(move |w| scan.readings.iter().map(move |reading| (scan, w, reading)))
    })
}
