//! Shares of the light over wavelength, one line per incidence.

use super::panel::{self, Curve, Panel};
use super::{Area, Drawn};
use crate::bsdf::{Bsdf, Scattering};
use crate::dome::Estimate;

/// Draws the `share` of each incidence.
pub fn draw(area: &Area<'_>, title: &str, bsdf: &Bsdf, share: impl Fn(&Scattering) -> Vec<Estimate>) -> Drawn {
    let curve = |s: &Scattering| {
        let at = s.incidence;
        let azimuth = if at.phi_deg == 0.0 { String::new() } else { format!(", φ {}°", at.phi_deg) };
        let name = format!("θ {}°{azimuth}", at.theta_deg);
        Curve { name, x: bsdf.wavelength_nm.clone(), y: share(s), ..Curve::default() }
    };
    let panel = Panel {
        title: title.into(),
        x_name: "vacuum wavelength / nm".into(),
        y_name: "share of the incident power".into(),
        curves: bsdf.incidences.iter().map(curve).collect(),
        ..Panel::default()
    };
    panel::draw(area, &panel)
}
