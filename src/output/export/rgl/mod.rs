//! `measured` BSDFs of Mitsuba 3 (Dupuy and Jakob 2018), read by pbrt-v4 and powitacq, too: the BRDF times the cosine of the
//! exit on a square that is warped, for each incidence, so that most of it lies where the light goes.
//!
//! The reader's value is spectra(s) · D(m) / (4 σ(ω_i)) with s the inverse warp of the half vector m. Any positive warp and D
//! are right. Here the warp is the density of normals that the light sees, D the mean of f · 4 cos θ_i cos θ_o, which leaves
//! little to the spectra that is not smooth, and σ its projection. Half vectors are told by u = √(2θ/π), v = (φ + π) / 2π.

mod nodes;
pub mod tensor;
mod warp;

use glam::DVec3;
use rayon::prelude::*;

use super::points::{Beam, direction, incidence_from, node};
use super::{Channels, Export, Exported, Source, refuse};
use crate::colour;
use nodes::{Nodes, coordinates, direction_at, half};
use tensor::Field;
use warp::Warp;

/// Nodes of the warped square along each side.
const NODES: usize = 32;
/// Nodes of the density along φ and θ of the half vector: isotropic, anisotropic (there are many incidences).
const DENSITY: [[usize; 2]; 2] = [[64, 256], [48, 128]];
/// Density everywhere, of the means of the others.
const DARK: f64 = 0.02;
/// Points of each node's cell over which a measured value is a mean, along each side.
const POINTS: usize = 4;
/// The reader draws from within these.
const EDGE: f64 = f32::EPSILON as f64 / 2.0;

/// Directions of incidence of a table, radians.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// Polar angles, ascending.
    pub theta: Vec<f64>,
    /// Azimuths, ascending from −π to π; a single one for an isotropic sample.
    pub phi: Vec<f64>,
    /// Points of each node's cell over which a value is a mean, along each side.
    pub points: usize,
}

/// The tables of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Warped {
    grid: Grid,
    /// Values per direction.
    bands: usize,
    /// Nodes of the density along φ and θ.
    density: [usize; 2],
    /// D by [φ_m, θ_m].
    ndf: Nodes,
    /// By [φ_i, θ_i], finer than the incidences.
    sigma: Nodes,
    /// [φ_i, θ_i, φ_m, θ_m].
    vndf: Vec<f32>,
    /// [φ_i, θ_i, node, node].
    luminance: Vec<f32>,
    /// [φ_i, θ_i, band, node, node].
    values: Vec<f32>,
}

/// The BRDF spectra (1/sr) of all exits of one incidence: adds weight times the spectrum to what it is given.
pub type Exits<'a> = Box<dyn Fn(DVec3, f64, &mut [f64]) + 'a>;

/// The file with a spectrum per direction.
pub fn spectral(source: &Source<'_>) -> Export {
    let wavelengths = source.wavelengths();
    let nm: Vec<f32> = wavelengths.iter().map(|&w| source.bsdf().wavelength_nm[w] as f32).collect();
    let pick = |spectrum: &[f64], out: &mut [f64]| {
        out.iter_mut().zip(&wavelengths).for_each(|(out, &w)| *out += spectrum[w]);
    };
    let field = Field::floats("wavelengths", &[nm.len()], nm);
    write(source, wavelengths.len(), pick, "spectra", Some(field))
}

/// The file in linear sRGB.
pub fn rgb(source: &Source<'_>) -> Export {
    let channels = source.channels()?;
    if matches!(channels, Channels::One(_)) {
        return refuse("one wavelength has no colour: rgl holds it");
    }
    let pick = |spectrum: &[f64], out: &mut [f64]| {
        let rgb = colour::linear_srgb(channels.xyz(spectrum));
        out.iter_mut().zip(rgb).for_each(|(out, x)| *out += x);
    };
    let mut exported = write(source, 3, pick, "rgb", None)?;
    exported.notes.insert(0, "this file is for RGB variants of Mitsuba: rgl holds spectra".into());
    Ok(exported)
}

fn write(
    source: &Source<'_>,
    bands: usize,
    pick: impl Fn(&[f64], &mut [f64]) + Sync,
    name: &'static str,
    more: Option<Field>,
) -> Export {
    let wavelengths = source.bsdf().wavelength_nm.len();
    let pick = &pick;
    let exits = |light: DVec3| -> Exits<'_> {
        let beam: Beam<'_> = source.beam(&incidence_from(light));
        Box::new(move |exit, weight, out| {
            let mut spectrum = vec![0.0; wavelengths];
            beam.add(exit, weight, &mut spectrum);
            pick(&spectrum, out);
        })
    };
    let table = Warped::new(&Grid::of(source), bands, exits);
    let mut notes = Vec::new();
    source.of_one_side(&mut notes);
    source.of_specular(&mut notes);
    let last = source.front.greatest_theta_deg();
    if last < 85.0 {
        notes.push(format!("readers take the incidence of {last}° for all that is more grazing: measure up to 88°"));
    }
    let fields = table.fields(&source.title, name).into_iter().chain(more);
    Ok(Exported { bytes: tensor::to_bytes(&fields.collect::<Vec<_>>()), notes })
}

impl Grid {
    /// The measured polar angles and azimuths, and the ends of the circle.
    fn of(source: &Source<'_>) -> Self {
        let sorted = |mut all: Vec<f64>| {
            all.sort_by(f64::total_cmp);
            all.dedup();
            all
        };
        let incidences = || source.bsdf().incidences.iter().map(|s| s.incidence);
        let theta = sorted(incidences().map(|i| i.theta_deg).collect());
        let phi = if source.front.is_isotropic() {
            vec![0.0]
        } else {
            let measured = incidences().map(|i| (i.phi_deg + 180.0).rem_euclid(360.0) - 180.0);
            sorted(measured.chain([-180.0, 180.0]).collect())
        };
        let radians = |all: Vec<f64>| all.into_iter().map(f64::to_radians).collect();
        Self { theta: radians(theta), phi: radians(phi), points: POINTS }
    }
}

impl Warped {
    /// From the BRDF: `exits` gives that of a direction towards the source.
    pub fn new<'a>(grid: &Grid, bands: usize, exits: impl Fn(DVec3) -> Exits<'a> + Sync) -> Self {
        let density = DENSITY[usize::from(grid.phi.len() > 1)];
        let lights: Vec<DVec3> =
            grid.phi.iter().flat_map(|&phi| grid.theta.iter().map(move |&theta| direction(theta, phi))).collect();
        let is_isotropic = grid.phi.len() == 1;
        let ndf = Nodes::normals(&lights, bands, is_isotropic, &exits);
        let sigma = ndf.projected(is_isotropic);
        let slice = |&light: &DVec3| {
            let factor = 4.0 * sigma.at(coordinates(light));
            Slice::new(light, bands, &ndf, factor, density, grid.points, &exits(light))
        };
        let slices: Vec<Slice> = lights.par_iter().map(slice).collect();
        let joined = |part: fn(&Slice) -> &Vec<f32>| slices.iter().flat_map(|s| part(s).iter().copied()).collect();
        Self {
            grid: grid.clone(),
            bands,
            density,
            ndf,
            sigma,
            vndf: joined(|s| &s.vndf),
            luminance: joined(|s| &s.luminance),
            values: joined(|s| &s.values),
        }
    }

    /// The fields of the file; `name` is `spectra` or `rgb`.
    pub fn fields(&self, description: &str, name: &'static str) -> Vec<Field> {
        let ([p, t], [h, w]) = ([self.grid.phi.len(), self.grid.theta.len()], self.density);
        let single = |all: &[f64]| all.iter().map(|&x| x as f32).collect();
        vec![
            Field::bytes("description", description.as_bytes()),
            Field::floats("theta_i", &[t], single(&self.grid.theta)),
            Field::floats("phi_i", &[p], single(&self.grid.phi)),
            Field::floats("ndf", &self.ndf.size, self.ndf.values.clone()),
            Field::floats("sigma", &self.sigma.size, self.sigma.values.clone()),
            Field::floats("vndf", &[p, t, h, w], self.vndf.clone()),
            Field::floats("luminance", &[p, t, NODES, NODES], self.luminance.clone()),
            Field::floats(name, &[p, t, self.bands, NODES, NODES], self.values.clone()),
            Field::bytes("jacobian", &[1]),
        ]
    }
}

/// The tables of one incidence.
struct Slice {
    vndf: Vec<f32>,
    luminance: Vec<f32>,
    values: Vec<f32>,
}

impl Slice {
    fn new(
        light: DVec3,
        bands: usize,
        ndf: &Nodes,
        factor: f64,
        [height, width]: [usize; 2],
        points: usize,
        exits: &Exits<'_>,
    ) -> Self {
        // BRDF times cosine times 4 σ over D, added with a weight.
        let add = |m: DVec3, d: f64, weight: f64, out: &mut [f64]| {
            let exit = 2.0 * m.dot(light) * m - light;
            if m.dot(light) > 0.0 && exit.z > 0.0 {
                exits(exit, factor * weight * exit.z / d, out);
            }
        };
        let scaled = |density: &dyn Fn([f64; 2]) -> f64| {
            let at = |i: usize| density([node(i % width, width), node(i / width, height)]);
            let all: Vec<f64> = (0..height * width).map(at).collect();
            let mean = all.iter().sum::<f64>() / all.len() as f64;
            all.into_iter().map(move |x| if mean > 0.0 { x / mean } else { 0.0 })
        };
        let seen = |at: [f64; 2]| direction_at(at).0.dot(light).max(0.0);
        // Lobes have their place by the density of normals, what is around them by its root. Near the pole solid angles are so
        // small that the table would have a kink there.
        let lobe = scaled(&|at| ndf.at(at) * half(at, light).1);
        let around = scaled(&|at| ndf.at(at).sqrt() * half(at, light).1);
        let pole = scaled(&|at| ndf.at(at).sqrt() * seen(at));
        let table: Vec<f64> = lobe.zip(around).zip(pole).map(|((l, a), p)| l + a + 0.5 * p + DARK).collect();
        // The reader's numbers are single.
        let vndf: Vec<f32> = table.iter().map(|&x| x as f32).collect();
        let warp = Warp::new(&vndf.iter().map(|&x| f64::from(x)).collect::<Vec<_>>(), width);
        let mut values = vec![0.0f32; bands * NODES * NODES];
        let mut luminance = Vec::with_capacity(NODES * NODES);
        for at in 0..NODES * NODES {
            let s = [node(at % NODES, NODES), node(at / NODES, NODES)];
            let mut value = vec![0.0; bands];
            for point in cell(s, points) {
                let (to, _) = warp.draw(point);
                add(half(to, light).0, ndf.at(to), 1.0 / (points * points) as f64, &mut value);
            }
            let (to, density) = warp.draw(s.map(inside));
            let mean = value.iter().sum::<f64>() / bands as f64;
            luminance.push((mean * ndf.at(to) / factor * half(to, light).1 / density).max(1e-5) as f32);
            (0..bands).for_each(|b| values[b * NODES * NODES + at] = value[b] as f32);
        }
        Self { vndf, luminance, values }
    }
}

fn inside(x: f64) -> f64 {
    x.clamp(EDGE, 1.0 - EDGE)
}

/// Points spread over the cell of a node, which is the same to both of its sides.
fn cell(node: [f64; 2], points: usize) -> impl Iterator<Item = [f64; 2]> {
    let half = node.map(|x| (0.5 / (NODES - 1) as f64).min(x).min(1.0 - x));
    let at = move |i: usize| (2.0 * i as f64 + 1.0) / points as f64 - 1.0;
    (0..points * points).map(move |i| {
        let offset = [at(i % points), at(i / points)];
        std::array::from_fn(|k| inside(node[k] + half[k] * offset[k]))
    })
}
