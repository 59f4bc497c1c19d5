//! The tabular BSDF of Zemax OpticStudio. Exits are told about the specular direction (of a BTDF the straight one): a radial
//! angle from it, and an azimuth that is 0 towards the normal.

use std::fmt::Write as _;

use glam::DVec3;

use super::{Channels, Export, Exported, Source};
use crate::bsdf::turned;
use crate::light::Incidence;

/// Radial angles, degrees: fine where a lobe is.
const RADIAL: [f64; 30] = [
    0.0, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 12.0, 15.0, 18.0, 22.0, 26.0, 30.0, 35.0, 40.0,
    50.0, 60.0, 70.0, 80.0, 90.0, 110.0, 130.0, 150.0, 180.0,
];
/// Step of the azimuths, degrees.
const AZIMUTH_STEP: u32 = 10;

pub fn write(source: &Source<'_>) -> Export {
    let channels = source.channels()?;
    let names: &[&str] = match channels {
        Channels::Colour(_) => &["TristimulusX", "TristimulusY", "TristimulusZ"],
        Channels::One(_) => &["Monochrome"],
    };
    let table = Table::new(source);
    let mut out = table.header(source, names.len() > 1);
    let values = table.values(source, &channels);
    for (channel, name) in names.iter().enumerate() {
        let _ = writeln!(out, "\n{name}\nDataBegin");
        for block in &values {
            let _ = writeln!(out, "TIS {:.6}", block.tis[channel]);
            for row in block.rows.chunks(RADIAL.len()) {
                let row: Vec<String> = row.iter().map(|xyz| format!("{:.5e}", xyz[channel])).collect();
                let _ = writeln!(out, "{}", row.join(" "));
            }
        }
        out += "DataEnd\n";
    }
    let mut notes = Vec::new();
    if names.len() > 1 {
        notes.push(
            "OpticStudio holds X, Y, Z or one wavelength (--wavelength): rgl, astm, csv and npy hold spectra".into(),
        );
    }
    source.of_one_side(&mut notes);
    source.of_specular(&mut notes);
    Ok(Exported { bytes: out.into_bytes(), notes })
}

struct Table {
    /// Azimuths of the light in the frame of the sample, degrees.
    rotations: Vec<f64>,
    incidences: Vec<f64>,
    azimuths: Vec<f64>,
    is_isotropic: bool,
}

struct Block {
    tis: [f64; 3],
    /// Azimuth by azimuth.
    rows: Vec<[f64; 3]>,
}

impl Table {
    fn new(source: &Source<'_>) -> Self {
        let distinct = |value: fn(&Incidence) -> f64| {
            let mut all: Vec<f64> = source.bsdf().incidences.iter().map(|s| value(&s.incidence)).collect();
            all.sort_by(f64::total_cmp);
            all.dedup();
            all
        };
        let is_isotropic = source.front.is_isotropic();
        let rotations = if is_isotropic { vec![0.0] } else { distinct(|i| i.phi_deg) };
        let last = if is_isotropic { 180 } else { 360 - AZIMUTH_STEP };
        let azimuths = (0..=last).step_by(AZIMUTH_STEP as usize).map(f64::from).collect();
        Self { rotations, incidences: distinct(|i| i.theta_deg), azimuths, is_isotropic }
    }

    fn header(&self, source: &Source<'_>, is_colour: bool) -> String {
        let list = |all: &[f64]| {
            let all: Vec<String> = all.iter().map(f64::to_string).collect();
            format!("{}\n{}\n", all.len(), all.join(" "))
        };
        let what = source.wavelength.map_or_else(
            || format!("under {}", source.illuminant),
            |w| format!("at {} nm", source.bsdf().wavelength_nm[w]),
        );
        let mut out =
            format!("#{}\n#gonio-embree {}, {what}\n", source.title.replace('\n', " "), env!("CARGO_PKG_VERSION"));
        out += "Source  Measured\n";
        out += if self.is_isotropic { "Symmetry  PlaneSymmetrical\n" } else { "Symmetry  ASymmetrical4D\n" };
        out += if is_colour { "SpectralContent  XYZ\n" } else { "SpectralContent  Monochrome\n" };
        out += if source.below { "ScatterType  BTDF\n" } else { "ScatterType  BRDF\n" };
        let _ = write!(out, "SampleRotation  {}", list(&self.rotations));
        let _ = write!(out, "AngleOfIncidence  {}", list(&self.incidences));
        let _ = write!(out, "ScatterAzimuth  {}", list(&self.azimuths));
        let _ = write!(out, "ScatterRadial  {}", list(&RADIAL));
        out
    }

    fn values(&self, source: &Source<'_>, channels: &Channels) -> Vec<Block> {
        let grid = self.rotations.iter().flat_map(|&phi| self.incidences.iter().map(move |&theta| (theta, phi)));
        grid.map(|(theta, phi)| self.block(source, channels, theta, phi)).collect()
    }

    fn block(&self, source: &Source<'_>, channels: &Channels, theta_deg: f64, phi_deg: f64) -> Block {
        let incidence = Incidence { theta_deg, phi_deg };
        let (beam, wavelengths) = (source.beam(&incidence), source.bsdf().wavelength_nm.len());
        let value = |azimuth: f64, radial: f64| {
            let exit = exit(&incidence, azimuth, radial, source.below);
            // Below the horizon of its side there is nothing.
            if (exit.z < 0.0) != source.below {
                return [0.0; 3];
            }
            channels.xyz(&beam.spectrum(exit, wavelengths))
        };
        let both = |azimuth: f64, radial: f64| {
            let one = value(azimuth, radial);
            if !self.is_isotropic {
                return one;
            }
            // The table has one side of the plane of incidence for both.
            let other = value(-azimuth, radial);
            std::array::from_fn(|i| 0.5 * (one[i] + other[i]))
        };
        let rows =
            self.azimuths.iter().flat_map(|&a| RADIAL.iter().map(move |&r| (a, r))).map(|(a, r)| both(a, r)).collect();
        let total: Vec<f64> = (0..wavelengths)
            .map(|w| {
                let share = |entry| beam.blend().share(entry, w).value;
                let (all, delta) = if source.below {
                    (share(|l| &l.transmitted), share(|l| &l.undeflected))
                } else {
                    (share(|l| &l.reflected), share(|l| &l.specular))
                };
                if source.specular_width_deg.is_some() { all } else { all - delta }
            })
            .collect();
        Block { tis: channels.xyz(&total), rows }
    }
}

/// The exit at these angles (degrees) about the specular direction: with the source in the plane x > 0, specular is at −x, and
/// azimuths are counted from there towards the normal, then +y.
fn exit(incidence: &Incidence, azimuth: f64, radial: f64, below: bool) -> DVec3 {
    let ((sin_r, cos_r), (sin_a, cos_a)) = (radial.to_radians().sin_cos(), azimuth.to_radians().sin_cos());
    let (sin, cos) = incidence.theta_deg.to_radians().sin_cos();
    let (toward, along) = (sin_r * cos_a, cos_r);
    let up = DVec3::new(cos * toward - sin * along, sin_r * sin_a, sin * toward + cos * along);
    turned(if below { up.with_z(-up.z) } else { up }, incidence.phi_deg)
}
