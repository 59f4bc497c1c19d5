//! A long table: a line for each incidence, facet and wavelength, then for each delta part.

use std::fmt::Write as _;

use super::rows::rows;
use super::{Exported, Source};

/// What the columns are, after a `#`.
const LEGEND: &str = "# part: facet (bsdf in 1/sr, solid angles in sr), specular or undeflected (bsdf is the share of the incident light)";

pub fn write(source: &Source<'_>) -> Exported {
    let mut out = format!("# {}\n{LEGEND}\n", source.title.replace('\n', " "));
    out += "theta_i_deg,phi_i_deg,theta_o_deg,phi_o_deg,wavelength_nm,part,bsdf,se,solid_angle,projected_solid_angle,trees\n";
    for r in rows(source) {
        let _ = writeln!(
            out,
            "{},{},{:.9},{:.9},{},{},{:e},{:e},{:e},{:e},{}",
            r.theta_i,
            r.phi_i,
            r.theta_o,
            r.phi_o,
            r.wavelength,
            PARTS[usize::from(r.part)],
            r.bsdf,
            r.se,
            r.solid_angle,
            r.projected_solid_angle,
            r.trees
        );
    }
    Exported { bytes: out.into_bytes(), notes: Vec::new() }
}

/// Names of the parts by their numbers.
const PARTS: [&str; 3] = ["facet", "specular", "undeflected"];
