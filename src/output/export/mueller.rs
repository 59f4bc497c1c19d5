//! `measured_polarized` of Mitsuba 3 (Baek et al., Image-Based Acquisition and Modeling of Polarimetric Reflectance, 2020):
//! Mueller matrices of an isotropic BRDF over the angles of Rusinkiewicz, at five wavelengths.

use std::f64::consts::PI;

use glam::DVec3;
use rayon::prelude::*;

use super::points::{direction, incidence_from, node};
use super::rgl::tensor::{self, Field, Values};
use super::{Export, Exported, Source, refuse};
use crate::bsdf::{Blend, turned};
use crate::dome::{theta_direction, turn};
use crate::light::Incidence;
use crate::optics::field::{Field as _, Mueller, State as _};

/// The reader copies so many wavelengths.
const WAVELENGTHS: usize = 5;
/// Nodes along φ_d (−π to π), θ_d and θ_h (0 to π/2).
const NODES: [usize; 3] = [73, 31, 61];

pub fn write(source: &Source<'_>) -> Export {
    source.must_be_isotropic("the result itself holds all matrices")?;
    let bsdf = source.bsdf();
    if bsdf.incidences.iter().any(|s| s.facets.iter().any(|f| f.mueller.is_empty())) {
        return refuse("pbsdf holds Mueller matrices, which were not measured: measure with --polarization mueller");
    }
    let chosen = chosen(&bsdf.wavelength_nm);
    let Some(chosen) = chosen else {
        return refuse(format!(
            "pbsdf holds exactly {WAVELENGTHS} wavelengths of whole nm; expected at least so many, e.g. --wavelengths 450:650:50"
        ));
    };
    let [phi_d, theta_d, theta_h] = NODES;
    let cells = phi_d * theta_d * theta_h;
    let matrices: Vec<Vec<f32>> = (0..cells).into_par_iter().map(|cell| matrices(source, cell, &chosen)).collect();
    let grid =
        |n: usize, from: f64, to: f64| (0..n).map(|i| (from + (to - from) * node(i, n)) as f32).collect::<Vec<_>>();
    let nm = chosen.iter().map(|&w| bsdf.wavelength_nm[w].round() as u16).collect();
    let fields = [
        Field::bytes("description", source.title.as_bytes()),
        Field::floats("phi_d", &[1, phi_d], grid(phi_d, -PI, PI)),
        Field::floats("theta_d", &[1, theta_d], grid(theta_d, 0.0, 0.5 * PI)),
        Field::floats("theta_h", &[1, theta_h], grid(theta_h, 0.0, 0.5 * PI)),
        Field { name: "wvls", shape: vec![WAVELENGTHS], values: Values::U16(nm) },
        Field::floats("M", &[phi_d, theta_d, theta_h, WAVELENGTHS, 4, 4], matrices.concat()),
    ];
    let mut notes = Vec::new();
    if bsdf.wavelength_nm.len() > WAVELENGTHS {
        let names: Vec<String> = chosen.iter().map(|&w| bsdf.wavelength_nm[w].to_string()).collect();
        notes.push(format!("the format holds {WAVELENGTHS} wavelengths: {} nm are in it", names.join(", ")));
    }
    if bsdf.incidences.iter().any(|s| s.ledger.specular.iter().any(|e| e.value > 0.0)) {
        notes.push("the specular part has no place in this format and is left out".into());
    }
    source.of_one_side(&mut notes);
    Ok(Exported { bytes: tensor::to_bytes(&fields), notes })
}

/// Wavelengths from first to last, evenly.
fn chosen(nm: &[f64]) -> Option<[usize; WAVELENGTHS]> {
    let last = nm.len().checked_sub(WAVELENGTHS)? + WAVELENGTHS - 1;
    let at = std::array::from_fn(|i| (i * last + (WAVELENGTHS - 1) / 2) / (WAVELENGTHS - 1));
    at.iter().all(|&w| nm[w].fract() == 0.0 && nm[w] <= f64::from(u16::MAX)).then_some(at)
}

/// The matrices of a node, wavelength by wavelength; 0 where a direction is below the horizon.
fn matrices(source: &Source<'_>, cell: usize, wavelengths: &[usize; WAVELENGTHS]) -> Vec<f32> {
    let [n_phi, n_theta, n_half] = NODES;
    let (p, d, h) = (cell / (n_theta * n_half), cell / n_half % n_theta, cell % n_half);
    let (phi_d, theta_d, theta_h) =
        (PI * (2.0 * node(p, n_phi) - 1.0), 0.5 * PI * node(d, n_theta), 0.5 * PI * node(h, n_half));
    // The half vector in the x-z plane; b, t and h are the frame of the difference.
    let (half, b) = (direction(theta_h, 0.0), DVec3::Y);
    let t = b.cross(half);
    let across = phi_d.sin() * b + phi_d.cos() * t;
    let light = theta_d.cos() * half + theta_d.sin() * across;
    let exit = 2.0 * light.dot(half) * half - light;
    if light.z <= 0.0 || exit.z <= 0.0 {
        return vec![0.0; 16 * WAVELENGTHS];
    }
    let incidence = incidence_from(light);
    let blend = source.front.at(&incidence);
    let frames = Frames::new(light, exit);
    wavelengths.iter().flat_map(|&w| frames.turn(&mean(&blend, exit, w), &incidence, exit)).collect()
}

/// The matrix in the frames of the result: x̂ is p of the incidence, and θ̂ of the exit.
fn mean(blend: &Blend<'_>, exit: DVec3, wavelength: usize) -> Mueller {
    let mut sum = [0.0; 16];
    for (part, f) in blend.facets(exit) {
        let [cos, sin] = f.facet.turn_to_theta(turned(exit, part.turn_deg));
        let matrix = Mueller::from_rows(&f.mueller[wavelength].map(|e| e.value));
        matrix.rotated(cos, sin).scaled(part.weight).add_to(&mut sum);
    }
    Mueller::from_rows(&sum)
}

/// Frames of the format, in the plane of reflection.
struct Frames {
    light: DVec3,
    exit: DVec3,
}

impl Frames {
    /// x̂ of the light that comes along −`light`, and of that which goes along `exit`.
    fn new(light: DVec3, exit: DVec3) -> Self {
        let frame = |to: DVec3, other: DVec3, along: DVec3| {
            let t = (to - other).cross(along).normalize_or_zero();
            let y = t.cross(along).normalize_or_zero();
            y.cross(along)
        };
        Self { light: frame(light, exit, -light), exit: frame(exit, light, exit) }
    }

    /// The matrix told in them.
    fn turn(&self, matrix: &Mueller, incidence: &Incidence, exit: DVec3) -> [f32; 16] {
        if self.light == DVec3::ZERO {
            // Straight back there is no plane of reflection: the frames of the result are as good as any.
            return matrix.rows().map(|x| x as f32);
        }
        let [cos, sin] = turn(exit, theta_direction(exit), self.exit);
        let of_light = turn(incidence.propagation(), incidence.p_direction(), self.light);
        with_light_turned(&matrix.rotated(cos, sin), of_light).rows().map(|x| x as f32)
    }
}

/// The matrix for light whose frame is turned by an angle, from its cosine and sine: the transpose of what turning the frame of
/// the exit does.
fn with_light_turned(m: &Mueller, [cos, sin]: [f64; 2]) -> Mueller {
    transposed(&transposed(m).rotated(cos, sin))
}

fn transposed(m: &Mueller) -> Mueller {
    let rows = m.rows();
    Mueller::from_rows(&std::array::from_fn(|i| rows[4 * (i % 4) + i / 4]))
}
