//! Results as functions of directions, for formats that are tables of points.

use std::f64::consts::PI;

use glam::DVec3;

use super::Source;
use crate::bsdf::Blend;
use crate::dome::Apertures;
use crate::light::Incidence;

/// What leaves under one incidence.
pub struct Beam<'a> {
    blend: Blend<'a>,
    /// Where the delta parts go, with their shares over the projected solid angle of their lobes, per wavelength.
    deltas: Vec<(DVec3, Vec<f64>)>,
    /// Cosine of half the width of their lobes.
    cos: f64,
}

impl Source<'_> {
    /// What leaves under an incidence, both sides.
    pub(super) fn beam(&self, incidence: &Incidence) -> Beam<'_> {
        let blend = self.front.at(incidence);
        let Some(width) = self.specular_width_deg.map(f64::to_radians) else {
            return Beam { blend, deltas: Vec::new(), cos: 1.0 };
        };
        let wavelengths = 0..self.bsdf().wavelength_nm.len();
        let specular: Vec<f64> = wavelengths.clone().map(|w| blend.share(|l| &l.specular, w).value).collect();
        let mut deltas = vec![(blend.mirror(), specular)];
        // Straight directions may differ per wavelength.
        for w in wavelengths.clone() {
            let (share, Some(exit)) = (blend.share(|l| &l.undeflected, w).value, blend.straight(w)) else { continue };
            let mut shares = vec![0.0; wavelengths.len()];
            shares[w] = share;
            match deltas.iter_mut().find(|d| d.0 == exit) {
                Some((_, all)) => all[w] = share,
                None => deltas.push((exit, shares)),
            }
        }
        deltas.retain(|(_, shares)| shares.iter().any(|&s| s > 0.0));
        for (exit, shares) in &mut deltas {
            let angle = cap(*exit, width);
            shares.iter_mut().for_each(|s| *s /= angle);
        }
        Beam { blend, deltas, cos: (0.5 * width).cos() }
    }
}

/// Projected solid angle of a round lobe, as far as it is on its side of the horizon, sr.
fn cap(axis: DVec3, width: f64) -> f64 {
    let sin = (0.5 * width).sin();
    if axis.z.abs() >= sin {
        return PI * sin * sin * axis.z.abs();
    }
    Apertures::new(vec![axis], DVec3::X, width, axis.z < 0.0).projected_solid_angle(axis)
}

impl Beam<'_> {
    /// Adds the spectrum of the BSDF (1/sr) in a direction, with a weight; the delta parts are lobes.
    pub fn add(&self, exit: DVec3, weight: f64, spectrum: &mut [f64]) {
        self.blend.add_values(exit, weight, spectrum);
        for (axis, values) in &self.deltas {
            if axis.dot(exit) >= self.cos && axis.z * exit.z > 0.0 {
                spectrum.iter_mut().zip(values).for_each(|(s, v)| *s += weight * v);
            }
        }
    }

    /// The spectrum of the BSDF in a direction, 1/sr.
    pub fn spectrum(&self, exit: DVec3, wavelengths: usize) -> Vec<f64> {
        let mut spectrum = vec![0.0; wavelengths];
        self.add(exit, 1.0, &mut spectrum);
        spectrum
    }

    /// The measured incidences it is made of.
    pub fn blend(&self) -> &Blend<'_> {
        &self.blend
    }
}

/// Where node `i` of `n` lies from 0 to 1.
pub fn node(i: usize, n: usize) -> f64 {
    i as f64 / (n - 1) as f64
}

/// A direction from its polar angle and azimuth, radians.
pub fn direction(theta: f64, phi: f64) -> DVec3 {
    let ((sin, cos), (sin_phi, cos_phi)) = (theta.sin_cos(), phi.sin_cos());
    DVec3::new(sin * cos_phi, sin * sin_phi, cos)
}

/// The incidence towards a source.
pub fn incidence_from(source: DVec3) -> Incidence {
    let theta = source.truncate().length().atan2(source.z).to_degrees();
    let phi_deg = if source.x == 0.0 && source.y == 0.0 { 0.0 } else { source.y.atan2(source.x).to_degrees() };
    Incidence { theta_deg: theta.clamp(0.0, Incidence::MAX_THETA_DEG), phi_deg }
}
