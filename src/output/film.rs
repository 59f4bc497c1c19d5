//! Film stacks: a table for people, CSV, and the answers to a file of cases as JSON.

use std::fmt::Write as _;

use crate::films::Sweep;
use crate::films::cases::Case;
use crate::optics::C64;
use crate::optics::film::Amplitudes;

/// One table per angle of incidence.
pub fn table(sweep: &Sweep) -> String {
    let mut out = String::new();
    for spectrum in &sweep.spectra {
        let _ = write!(out, "incidence {}°, {}", spectrum.angle_deg, sweep.polarization);
        let _ = match spectrum.colour {
            Some(colour) => writeln!(out, "; colour of reflected daylight {colour}"),
            None => writeln!(out, "; no colour: a medium is not known for all visible light"),
        };
        let _ = writeln!(out, "{:>10}{:>11}{:>11}{:>11}", "λ/nm", "R", "T", "A");
        for (nm, shares) in sweep.wavelength_nm.iter().zip(&spectrum.shares) {
            let [r, t, a] = [shares.reflected, shares.transmitted, shares.absorbed()].map(rounded);
            let _ = writeln!(out, "{nm:>10}{r:>11.6}{t:>11.6}{a:>11.6}");
        }
        out.push('\n');
    }
    out
}

/// A share without the sign of a zero that rounding leaves.
fn rounded(share: f64) -> f64 {
    if share.abs() < 5e-7 { 0.0 } else { share }
}

/// One line per angle and wavelength, as many digits as the numbers have.
pub fn csv(sweep: &Sweep) -> String {
    let mut out = String::from("angle_deg,wavelength_nm,R,T,A\n");
    for spectrum in &sweep.spectra {
        for (nm, shares) in sweep.wavelength_nm.iter().zip(&spectrum.shares) {
            let (r, t, a) = (shares.reflected, shares.transmitted, shares.absorbed());
            let _ = writeln!(out, "{},{nm},{r:?},{t:?},{a:?}", spectrum.angle_deg);
        }
    }
    out
}

/// Shares for people, one line per case.
pub fn cases_table(solved: &[(&Case, Amplitudes)]) -> String {
    let width = solved.iter().map(|(case, _)| case.id.chars().count()).max().unwrap_or(0).max(4);
    let mut out = format!("{:<width$}{:>11}{:>11}\n", "case", "R", "T");
    for (case, a) in solved {
        let _ = writeln!(out, "{:<width$}{:>11.6}{:>11.6}", case.id, a.reflectance(), a.transmittance());
    }
    out
}

/// The document of schema `gonio-films-result-1`: 17 significant digits, so that every number comes back as it was.
pub fn json(solved: &[(&Case, Amplitudes)]) -> String {
    let cases: Vec<String> = solved.iter().map(|(case, a)| case_json(case, a)).collect();
    format!("{{\"schema\": \"gonio-films-result-1\", \"cases\": [\n{}\n]}}\n", cases.join(",\n"))
}

fn case_json(case: &Case, a: &Amplitudes) -> String {
    let mut out = format!("{{\"id\": {}", serde_json::Value::from(&case.id[..]));
    for (name, z) in [("r", a.r), ("t", a.t), ("r_back", a.r_back), ("t_back", a.t_back)] {
        let C64 { re, im } = z;
        let _ = write!(out, ", \"{name}\": [{}, {}]", number(re), number(im));
    }
    let (r, t) = (a.reflectance(), a.transmittance());
    let back = case.back(a);
    let (r_back, t_back) = (back.map(|b| b.0), back.map(|b| b.1));
    let shares = [("R", Some(r)), ("T", Some(t)), ("R_back", r_back), ("T_back", t_back), ("A", Some(1.0 - r - t))];
    for (name, share) in shares {
        let _ = write!(out, ", \"{name}\": {}", share.map_or_else(|| "null".into(), number));
    }
    out + "}"
}

/// JSON knows no NaN.
fn number(x: f64) -> String {
    if x.is_finite() { format!("{x:.16e}") } else { "null".into() }
}
