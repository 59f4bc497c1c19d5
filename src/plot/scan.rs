//! Scans in the plane of incidence.

use super::panel::{Curve, Panel};
use crate::bsdf::Scan;

/// The readings over the exit angle, a curve for each incidence and wavelength, as SVG.
pub fn scans(scans: &[Scan], below: bool) -> String {
    let curves = scans.iter().flat_map(|scan| {
        (0..scan.wavelength_nm.len()).map(|w| {
            let at = scan.incidence;
            Curve {
                name: format!("θ {}°, φ {}°, {} nm", at.theta_deg, at.phi_deg, scan.wavelength_nm[w]),
                x: scan.readings.iter().map(|r| r.angle_deg).collect(),
                y: scan.readings.iter().map(|r| r.value[w]).collect(),
                ..Curve::default()
            }
        })
    });
    let panel = Panel {
        title: format!("Scan in the plane of incidence, {} the sample", if below { "below" } else { "above" }),
        x_name: "exit angle / ° (negative: the side of the source)".into(),
        y_name: format!("{} / (1/sr)", if below { "BTDF" } else { "BRDF" }),
        curves: curves.collect(),
        ..Panel::default()
    };
    super::panels("", &[panel])
}
