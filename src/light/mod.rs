//! The light: its wavelengths, directions of incidence, polarization and bandwidth.

mod coherence;
mod polarization;

use glam::DVec3;

pub use coherence::{Coherence, SourceMode};
pub use polarization::Polarization;

/// What shines on the sample.
#[derive(Clone, Debug, PartialEq)]
pub struct Light {
    /// Wavelengths.
    pub wavelengths: Wavelengths,
    /// Directions towards the source.
    pub incidences: Vec<Incidence>,
    /// State of polarization.
    pub polarization: Polarization,
    /// What a wavelength stands for.
    pub source: SourceMode,
}

impl Light {
    /// The same from these directions only.
    #[must_use]
    pub fn only(&self, incidences: &[usize]) -> Self {
        Self { incidences: incidences.iter().map(|&i| self.incidences[i]).collect(), ..self.clone() }
    }
}

/// A grid of vacuum wavelengths, ascending.
#[derive(Clone, Debug, PartialEq)]
pub struct Wavelengths {
    nm: Vec<f64>,
}

impl Wavelengths {
    /// Shortest and longest wavelength taken, nm.
    pub const RANGE_NM: (f64, f64) = (10.0, 1e6);

    /// A grid from values in nm.
    ///
    /// # Errors
    /// When a value is out of range or the values do not ascend.
    pub fn from_nm(nm: Vec<f64>) -> Result<Self, String> {
        let (low, high) = Self::RANGE_NM;
        if nm.is_empty() {
            return Err("no wavelength".into());
        }
        if let Some(bad) = nm.iter().find(|&&w| !(low..=high).contains(&w)) {
            return Err(format!("wavelength {bad} nm: expected {low} to {high} nm"));
        }
        if let Some(w) = nm.windows(2).find(|w| w[0] >= w[1]) {
            return Err(format!("wavelengths must ascend: {} nm is followed by {} nm", w[0], w[1]));
        }
        Ok(Self { nm })
    }

    /// As given, nm.
    pub fn nm(&self) -> &[f64] {
        &self.nm
    }

    /// In internal units, µm.
    pub fn um(&self) -> impl ExactSizeIterator<Item = f64> + '_ {
        self.nm.iter().map(|w| w / 1e3)
    }

    /// How many.
    pub fn len(&self) -> usize {
        self.nm.len()
    }

    /// Never true: a grid has at least one wavelength.
    pub fn is_empty(&self) -> bool {
        self.nm.is_empty()
    }
}

/// A direction towards the source.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Incidence {
    /// Angle from +z, degrees, 0..90.
    pub theta_deg: f64,
    /// Azimuth from +x towards +y, degrees.
    pub phi_deg: f64,
}

impl Incidence {
    /// Largest polar angle taken, degrees.
    pub const MAX_THETA_DEG: f64 = 89.99;

    /// Whether it is a direction above the sample.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn check(&self) -> Result<(), String> {
        let most = Self::MAX_THETA_DEG;
        if !(0.0..=most).contains(&self.theta_deg) {
            return Err(format!("{}°: expected 0 to {most}°", self.theta_deg));
        }
        if !self.phi_deg.is_finite() {
            return Err(format!("azimuth {}°: expected a number", self.phi_deg));
        }
        Ok(())
    }

    /// Direction of propagation of the light, in the sample frame.
    pub fn propagation(&self) -> DVec3 {
        let (sin, cos) = exact_sin_cos(self.theta_deg);
        let (sin_phi, cos_phi) = exact_sin_cos(self.phi_deg);
        -DVec3::new(sin * cos_phi, sin * sin_phi, cos)
    }

    /// The exit in the plane of incidence at this signed angle from the normal, degrees, above or below the sample:
    /// positive on the side of the mirror direction and of the straight one.
    pub fn in_plane(&self, angle_deg: f64, below: bool) -> DVec3 {
        let ((sin, cos), (sin_phi, cos_phi)) = (exact_sin_cos(angle_deg), exact_sin_cos(self.phi_deg));
        DVec3::new(-sin * cos_phi, -sin * sin_phi, if below { -cos } else { cos })
    }

    /// Direction of s polarization: perpendicular to the plane of incidence, which at θ = 0 is that of the azimuth.
    pub fn s_direction(&self) -> DVec3 {
        let (sin_phi, cos_phi) = exact_sin_cos(self.phi_deg);
        DVec3::new(-sin_phi, cos_phi, 0.0)
    }

    /// Direction of p polarization, ŝ × k̂.
    pub fn p_direction(&self) -> DVec3 {
        self.s_direction().cross(self.propagation())
    }
}

/// Sine and cosine of an angle in degrees, exact at multiples of 90°.
fn exact_sin_cos(deg: f64) -> (f64, f64) {
    let turned = deg.rem_euclid(360.0);
    match turned {
        0.0 => (0.0, 1.0),
        90.0 => (1.0, 0.0),
        180.0 => (0.0, -1.0),
        270.0 => (-1.0, 0.0),
        _ => turned.to_radians().sin_cos(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_are_right_handed() {
        for (theta_deg, phi_deg) in [(0.0, 0.0), (30.0, 0.0), (45.0, 90.0), (80.0, 200.0)] {
            let i = Incidence { theta_deg, phi_deg };
            let (k, s, p) = (i.propagation(), i.s_direction(), i.p_direction());
            assert!((k.cross(p) - s).length() < 1e-15);
            assert!(k.z < 0.0 && s.z == 0.0);
            assert!((k.cross(DVec3::Z) - s * k.with_z(0.0).length()).length() < 1e-15);
        }
        assert_eq!(Incidence { theta_deg: 0.0, phi_deg: 0.0 }.propagation(), DVec3::NEG_Z);
    }

    #[test]
    fn bad_grids_are_refused() {
        assert!(Wavelengths::from_nm(vec![]).is_err());
        assert!(Wavelengths::from_nm(vec![500.0, 500.0]).is_err());
        assert!(Wavelengths::from_nm(vec![f64::NAN]).is_err());
        assert!(Wavelengths::from_nm(vec![0.5]).is_err());
    }
}
