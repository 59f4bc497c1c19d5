//! Shares of the light over wavelength and angle, and the colour they give.

use super::{Films, Stack, StackError};
use crate::colour::{self, Srgb};
use crate::light::Polarization;
use crate::optics::film::{Amplitudes, Incidence};

/// Where the power goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shares {
    /// Reflected.
    pub reflected: f64,
    /// Transmitted into the last medium.
    pub transmitted: f64,
}

impl Shares {
    /// What remains.
    pub fn absorbed(&self) -> f64 {
        1.0 - self.reflected - self.transmitted
    }
}

/// What a stack does to light from one direction.
#[derive(Clone, Debug, PartialEq)]
pub struct Spectrum {
    /// Angle of incidence in the first medium, degrees.
    pub angle_deg: f64,
    /// Per wavelength.
    pub shares: Vec<Shares>,
    /// Colour of the reflected daylight; none if a medium is not known for all that is visible.
    pub colour: Option<Srgb>,
}

/// What a stack does to light of some wavelengths from some directions.
#[derive(Clone, Debug, PartialEq)]
pub struct Sweep {
    /// Vacuum wavelengths, nm.
    pub wavelength_nm: Vec<f64>,
    /// State of polarization of the light.
    pub polarization: Polarization,
    /// One per angle.
    pub spectra: Vec<Spectrum>,
}

/// Solves a stack at all wavelengths (nm) and angles (degrees, 0 to 90).
///
/// # Errors
/// Where a medium is not known at a wavelength, or the first one absorbs.
pub fn sweep(
    stack: &Stack,
    wavelength_nm: &[f64],
    angles_deg: &[f64],
    polarization: Polarization,
) -> Result<Sweep, StackError> {
    let films: Vec<Films> = wavelength_nm.iter().map(|&nm| stack.at(nm)).collect::<Result<_, _>>()?;
    let spectrum = |&angle_deg: &f64| Spectrum {
        angle_deg,
        shares: films.iter().map(|f| shares(f, angle_deg, polarization)).collect(),
        colour: colour_of(stack, angle_deg, polarization),
    };
    let spectra = angles_deg.iter().map(spectrum).collect();
    Ok(Sweep { wavelength_nm: wavelength_nm.to_vec(), polarization, spectra })
}

fn shares(films: &Films, angle_deg: f64, polarization: Polarization) -> Shares {
    let both = films.solve(&Incidence::from_angle(films.first, angle_deg.to_radians()));
    let of = |a: &Amplitudes| Shares { reflected: a.reflectance(), transmitted: a.transmittance() };
    let ([a, b], s, p) = (polarization.shares(), of(&both.s), of(&both.p));
    Shares { reflected: a * s.reflected + b * p.reflected, transmitted: a * s.transmitted + b * p.transmitted }
}

fn colour_of(stack: &Stack, angle_deg: f64, polarization: Polarization) -> Option<Srgb> {
    let reflected = |nm: f64| stack.at(nm).map(|films| shares(&films, angle_deg, polarization).reflected);
    colour::xyz(reflected).ok().map(colour::srgb)
}
