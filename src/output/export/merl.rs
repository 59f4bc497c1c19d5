//! The binary table of Matusik et al. (A Data-Driven Reflectance Model, 2003): isotropic, in half vector and difference
//! angles (Rusinkiewicz 1998).

use glam::DVec3;
use rayon::prelude::*;

use super::points::{direction, incidence_from};
use super::{Export, Exported, Source};
use crate::colour;

/// Cells along θ_h, θ_d and φ_d.
const CELLS: [usize; 3] = [90, 90, 180];
/// What is stored is the BRDF over these, of red, green and blue.
const SCALE: [f64; 3] = [1.0 / 1500.0, 1.15 / 1500.0, 1.66 / 1500.0];
/// Where a direction is below the horizon.
const INVALID: f64 = -1.0;

pub fn write(source: &Source<'_>) -> Export {
    source.must_be_isotropic("rgl-rgb holds it")?;
    let channels = source.channels()?;
    let wavelengths = source.bsdf().wavelength_nm.len();
    let [theta_h, theta_d, phi_d] = CELLS;
    let cells = theta_h * theta_d * phi_d;
    let value = |cell: usize| {
        let (light, exit) = directions(cell);
        if light.z <= 0.0 || exit.z <= 0.0 {
            return [INVALID; 3];
        }
        let spectrum = source.beam(&incidence_from(light)).spectrum(exit, wavelengths);
        let rgb = colour::linear_srgb(channels.xyz(&spectrum));
        std::array::from_fn(|i| rgb[i].max(0.0) / SCALE[i])
    };
    let values: Vec<[f64; 3]> = (0..cells).into_par_iter().map(value).collect();
    let mut bytes = Vec::with_capacity(12 + 24 * cells);
    CELLS.iter().for_each(|&n| bytes.extend((n as i32).to_le_bytes()));
    for channel in 0..3 {
        values.iter().for_each(|v| bytes.extend(v[channel].to_le_bytes()));
    }
    let mut notes = vec!["MERL holds linear sRGB: rgl, astm, csv and npy hold spectra".into()];
    source.of_one_side(&mut notes);
    source.of_specular(&mut notes);
    Ok(Exported { bytes, notes })
}

/// Towards the source, and of the exit, at the middle of a cell.
fn directions(cell: usize) -> (DVec3, DVec3) {
    let [_, theta_d, phi_d] = CELLS;
    let (h, d, p) = (cell / (theta_d * phi_d), cell / phi_d % theta_d, cell % phi_d);
    let middle = |i: usize| i as f64 + 0.5;
    // θ_h goes as the square of its index.
    let theta_h = (middle(h).powi(2) / CELLS[0] as f64).to_radians();
    let (theta_d, phi_d) = (middle(d).to_radians(), middle(p).to_radians());
    let half = direction(theta_h, 0.0);
    // The difference vector is told in the frame of the half vector: z along it, y as that of the sample.
    let (x, y) = (direction(theta_h + std::f64::consts::FRAC_PI_2, 0.0), DVec3::Y);
    let diff = direction(theta_d, phi_d);
    let light = diff.x * x + diff.y * y + diff.z * half;
    (light, 2.0 * light.dot(half) * half - light)
}
