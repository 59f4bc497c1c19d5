//! The light: its wavelengths, directions of incidence, polarization and bandwidth.

use glam::DVec3;

use crate::text::words;

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

    /// Direction of propagation of the light, in the sample frame.
    pub fn propagation(&self) -> DVec3 {
        let (sin, cos) = exact_sin_cos(self.theta_deg);
        let (sin_phi, cos_phi) = exact_sin_cos(self.phi_deg);
        -DVec3::new(sin * cos_phi, sin * sin_phi, cos)
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

/// State of the incident light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Polarization {
    /// Equal, incoherent parts of s and p.
    Unpolarized,
    /// Electric field perpendicular to the plane of incidence.
    S,
    /// Electric field in the plane of incidence.
    P,
}

words!(Polarization { Unpolarized = "unpolarized", S = "s", P = "p" });

/// What each wavelength of the grid stands for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SourceMode {
    /// Its band: the coherence length is finite.
    Band,
    /// A laser line: everything plane-parallel is coherent.
    Line,
}

words!(SourceMode { Band = "band", Line = "line" });

/// Band of a single wavelength, nm: that of the default grid.
const LONELY_BAND_NM: f64 = 20.0;

/// Over which differences of optical paths waves interfere, µm: surely up to `full`, not at all beyond `none`, and in
/// between for a share of the trees that falls linearly, so that nothing jumps when a film grows into a slab.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coherence {
    /// Up to this path all is coherent.
    pub full: f64,
    /// From this path on nothing is.
    pub none: f64,
}

impl Coherence {
    /// Of a laser line.
    pub const LINE: Self = Self { full: f64::INFINITY, none: f64::INFINITY };

    /// The path over which waves of a tree interfere, for a number of the tree in [0, 1).
    #[inline]
    pub fn length(&self, number: f64) -> f64 {
        if self.full == f64::INFINITY { self.full } else { self.full + number * (self.none - self.full) }
    }

    /// Share of the trees whose waves interfere over a path.
    pub fn degree(&self, path: f64) -> f64 {
        if path <= self.full { 1.0 } else { ((self.none - path) / (self.none - self.full)).max(0.0) }
    }
}

impl Light {
    /// Over which paths waves interfere. The band of a wavelength is as wide as the step of the grid; up to λ²/Δλ, the
    /// first zero of its degree of coherence at the shortest wavelength, the grid shows the fringes of films, and the
    /// value at a wavelength is that of the wavelength itself. Beyond twice that path there is none but the mean.
    pub fn coherence(&self) -> Coherence {
        if self.source == SourceMode::Line {
            return Coherence::LINE;
        }
        let nm = self.wavelengths.nm();
        let band = if nm.len() > 1 { (nm[nm.len() - 1] - nm[0]) / (nm.len() - 1) as f64 } else { LONELY_BAND_NM };
        let full = nm[0] * nm[0] / band / 1e3;
        Coherence { full, none: 2.0 * full }
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
    fn coherence_follows_the_band() {
        let mut light = Light {
            wavelengths: Wavelengths::from_nm((0..16).map(|i| 400.0 + 20.0 * f64::from(i)).collect()).unwrap(),
            incidences: Vec::new(),
            polarization: Polarization::Unpolarized,
            source: SourceMode::Band,
        };
        let coherence = light.coherence();
        assert_eq!(coherence, Coherence { full: 8.0, none: 16.0 });
        assert_eq!([4.0, 8.0, 10.0, 20.0].map(|path| coherence.degree(path)), [1.0, 1.0, 0.75, 0.0]);
        light.source = SourceMode::Line;
        assert_eq!(light.coherence().length(0.5), f64::INFINITY);
    }

    #[test]
    fn bad_grids_are_refused() {
        assert!(Wavelengths::from_nm(vec![]).is_err());
        assert!(Wavelengths::from_nm(vec![500.0, 500.0]).is_err());
        assert!(Wavelengths::from_nm(vec![f64::NAN]).is_err());
        assert!(Wavelengths::from_nm(vec![0.5]).is_err());
    }
}
