//! Text after ASTM E1392 and E2387: key words, then a line per pair of directions. Readers need `NUM_POINTS` and `VARS`.

use std::f64::consts::PI;
use std::fmt::Write as _;

use super::points::direction;
use super::{Export, Exported, Source};

/// Steps of the exits, degrees.
const THETA_STEP: u32 = 2;
const PHI_STEP: u32 = 5;
/// Exits at the horizon have no BSDF.
const LAST_THETA: u32 = 88;

pub fn write(source: &Source<'_>) -> Export {
    let bsdf = source.bsdf();
    let wavelengths = source.wavelengths();
    let columns: Vec<String> = wavelengths.iter().map(|&w| format!("{}nm", bsdf.wavelength_nm[w])).collect();
    let points = bsdf.incidences.len() * exits().count();
    let mut out = String::new();
    for (key, value) in [
        ("SOURCE", format!("gonio-embree {}", env!("CARGO_PKG_VERSION"))),
        ("SAMPLE", source.title.replace('\n', " ")),
        ("MEASUREMENT", if source.below { "BTDF" } else { "BRDF" }.into()),
        ("UNITS", "radians, 1/sr".into()),
        ("NUM_POINTS", points.to_string()),
        ("VARS", format!("theta_i,phi_i,theta_s,phi_s,{}", columns.join(","))),
    ] {
        let _ = writeln!(out, "{key} {value}");
    }
    let mut spectrum = vec![0.0; bsdf.wavelength_nm.len()];
    for s in &bsdf.incidences {
        let beam = source.beam(&s.incidence);
        for (theta, phi) in exits() {
            let exit = direction(theta, phi);
            spectrum.fill(0.0);
            beam.add(if source.below { exit.with_z(-exit.z) } else { exit }, 1.0, &mut spectrum);
            let (theta_i, phi_i) = (s.incidence.theta_deg.to_radians(), s.incidence.phi_deg.to_radians());
            let _ = write!(out, "{theta_i:.6},{:.6},{theta:.6},{phi:.6}", phi_i.rem_euclid(2.0 * PI));
            for &w in &wavelengths {
                let _ = write!(out, ",{:.6e}", spectrum[w]);
            }
            out.push('\n');
        }
    }
    let mut notes = Vec::new();
    source.of_one_side(&mut notes);
    source.of_specular(&mut notes);
    if source.below {
        notes.push("theta_s is told from the normal below".into());
    }
    Ok(Exported { bytes: out.into_bytes(), notes })
}

/// Polar angles and azimuths of the exits, radians.
fn exits() -> impl Iterator<Item = (f64, f64)> {
    let thetas = (0..=LAST_THETA).step_by(THETA_STEP as usize);
    let radians = |deg: u32| f64::from(deg).to_radians();
    thetas.flat_map(move |t| (0..360).step_by(PHI_STEP as usize).map(move |p| (radians(t), radians(p))))
}
