//! Scans in the plane of incidence.

use super::panel::{Curve, Panel};
use crate::bsdf::{Overlay, Scan};

/// The readings over the exit angle, a curve for each incidence and wavelength, as SVG.
pub fn scans(scans: &[Scan], below: bool) -> String {
    super::panels("", &[panel(scans, below)])
}

fn panel(scans: &[Scan], below: bool) -> Panel {
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
    Panel {
        title: format!("Scan in the plane of incidence, {} the sample", if below { "below" } else { "above" }),
        x_name: "exit angle / ° (negative: the side of the source)".into(),
        y_name: format!("{} / (1/sr)", if below { "BTDF" } else { "BRDF" }),
        curves: curves.collect(),
        ..Panel::default()
    }
}

/// Readings of one incidence and wavelength with measured ones over them, and below them the residuals with a band of two
/// standard errors, as SVG.
pub fn overlaid(scan: &Scan, overlay: &Overlay, below: bool) -> String {
    let x: Vec<f64> = overlay.points.iter().map(|p| p.angle_deg).collect();
    let measured = Curve {
        name: "measured".into(),
        x: x.clone(),
        y: overlay.points.iter().map(|p| p.value).collect(),
        color: Some((220, 80, 30)),
        dashed: true,
    };
    let mut above = panel(std::slice::from_ref(scan), below);
    above.curves.push(measured);
    let largest =
        overlay.residuals.iter().map(|e| e.value.abs() + 2.0 * e.se).filter(|x| x.is_finite()).fold(0.0, f64::max);
    let residuals = Curve { y: overlay.residuals.clone(), ..Curve::exact("simulated − measured", x.clone(), []) };
    let zero =
        Curve { dashed: true, color: Some((120, 120, 120)), ..Curve::exact("", x.clone(), x.iter().map(|_| 0.0)) };
    let under = Panel {
        title: "Residuals".into(),
        x_name: above.x_name.clone(),
        y_name: above.y_name.clone(),
        y_range: Some((-1.1 * largest.max(1e-12), 1.1 * largest.max(1e-12))),
        curves: vec![residuals, zero],
        ..Panel::default()
    };
    super::panels("", &[above, under])
}
