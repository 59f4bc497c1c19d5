//! Tensor trees: incidence and exit on squares of equal projected solid angle (Shirley and Chiu 1997), equal values merged.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};
use std::fmt::Write as _;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::{Block, Export, Exported, Grey, Source, Way, deltas, document, in_sample, measured, notes, refuse};
use crate::bsdf::Lookup;
use crate::output::export::points::incidence_from;

/// Cells across, as powers of 2, of trees of three and of four dimensions.
const LEVELS: [u32; 2] = [6, 5];
/// Points across a cell of the exit.
const POINTS: usize = 4;
/// Relative difference of points that is none.
const EVEN: f64 = 1e-6;

/// The trees of all ways through the sample that were measured. The value of a cell is the mean over points of equal
/// projected solid angle, scaled so that each incidence keeps its flux.
pub fn tree(source: &Source<'_>, rank: usize) -> Export {
    if rank == 3 {
        source.must_be_isotropic("tensor-tree-4 holds it")?;
    }
    let channels = source.channels()?;
    let grey = Grey::new(source, &channels);
    let names: &[&str] = if source.wavelength.is_some() { &["Visible"] } else { &["Visible", "CIE-u", "CIE-v"] };
    let mut blocks = Vec::new();
    for way in Way::ALL {
        let Some(lookup) = measured(source, way) else { continue };
        if lookup.bsdf().wavelength_nm != source.front.bsdf().wavelength_nm {
            return refuse("the two sides were measured at different wavelengths");
        }
        let grid = Grid::new(lookup, way, rank, &grey);
        for (channel, &wavelength) in names.iter().enumerate() {
            blocks.push(Block { wavelength, way, data: grid.text(channel) });
        }
    }
    let structure = if rank == 3 { "TensorTree3" } else { "TensorTree4" };
    let mut notes = notes(source);
    if rank == 3 && source.wavelength.is_none() {
        notes.push(
            "Radiance mixes up colours of isotropic trees with a Lambertian part: tensor-tree-4 comes back right"
                .into(),
        );
    }
    Ok(Exported { bytes: document(source, structure, "LBNL/Shirley-Chiu", "", &blocks), notes })
}

/// Values of all cells: those of the incidence, then of the exit, the last index fastest.
struct Grid {
    rank: usize,
    level: u32,
    /// Y, u', v'.
    values: Vec<[f32; 3]>,
}

impl Grid {
    fn new(lookup: &Lookup<'_>, way: Way, rank: usize, grey: &Grey<'_>) -> Self {
        let level = LEVELS[rank - 3];
        let n = 1usize << level;
        let middle = |i: usize| (i as f64 + 0.5) / n as f64;
        let lights = n.pow(rank as u32 - 2);
        let slice = |at: usize| {
            let source = if rank == 3 {
                // Only the lower half is used: 0.5 (1 - sin θ). The light goes along +x.
                let sin = 1.0 - 2.0 * middle(at);
                if sin <= 0.0 {
                    return vec![[0.0; 3]; n * n];
                }
                DVec3::new(-sin, 0.0, (1.0 - sin * sin).sqrt())
            } else {
                let d = to_disk(DVec2::new(middle(at / n), middle(at % n)));
                DVec3::new(-d.x, -d.y, (1.0 - d.length_squared()).max(0.0).sqrt())
            };
            exits(lookup, way, grey, source, n)
        };
        let values = (0..lights).into_par_iter().flat_map_iter(slice).map(coded).collect();
        Self { rank, level, values }
    }

    fn text(&self, channel: usize) -> String {
        let mut out = String::new();
        self.write(&vec![0; self.rank], self.level, channel, &mut out);
        out.push('\n');
        out
    }

    /// Writes the part of the tree at `corner`, 2^level cells wide.
    fn write(&self, corner: &[usize], level: u32, channel: usize, out: &mut String) {
        let value = self.value(corner, channel);
        if self.is_even(corner, level, channel, value) {
            let _ = write!(out, "{{{}}}", short(value));
            return;
        }
        out.push('{');
        let half = 1usize << (level - 1);
        let corner_of = |child: usize, bit: &dyn Fn(usize) -> usize| -> Vec<usize> {
            corner.iter().enumerate().map(|(d, c)| c + (child >> bit(d) & 1) * half).collect()
        };
        for child in 0..1usize << self.rank {
            if level == 1 {
                // A grid of numbers counts its first dimension slowest ...
                let at = corner_of(child, &|d| self.rank - 1 - d);
                let _ = write!(out, "{} ", short(self.value(&at, channel)));
            } else {
                // ... while bit d of a branch's number is its half of dimension d.
                self.write(&corner_of(child, &|d| d), level - 1, channel, out);
            }
        }
        out.push_str("}\n");
    }

    fn value(&self, at: &[usize], channel: usize) -> f32 {
        let n = 1usize << self.level;
        self.values[at.iter().fold(0, |sum, i| sum * n + i)][channel]
    }

    fn is_even(&self, corner: &[usize], level: u32, channel: usize, value: f32) -> bool {
        let cells = 1usize << (level as usize * self.rank);
        let mask = (1usize << level) - 1;
        let at = |cell: usize| -> Vec<usize> {
            corner.iter().enumerate().map(|(d, c)| c + (cell >> (d * level as usize) & mask)).collect()
        };
        (0..cells).all(|cell| self.value(&at(cell), channel) == value)
    }
}

fn short(x: f32) -> String {
    if x == 0.0 { "0".into() } else { format!("{x:.4e}") }
}

/// Y and CIE 1976 u', v' of X, Y, Z, rounded as they are written; what is black is grey.
fn coded([x, y, z]: [f64; 3]) -> [f32; 3] {
    let sum = x + 15.0 * y + 3.0 * z;
    let (u, v) = if sum > 0.0 { (4.0 * x / sum, 9.0 * y / sum) } else { (4.0 / 19.0, 9.0 / 19.0) };
    [y.max(0.0), u, v].map(|x| short(x as f32).parse().unwrap_or_default())
}

/// Mean BSDF of X, Y, Z in the cells of the exit.
fn exits(lookup: &Lookup<'_>, way: Way, grey: &Grey<'_>, source: DVec3, n: usize) -> Vec<[f64; 3]> {
    let towards = if way.from_below { in_sample(source.with_z(-source.z), true) } else { source };
    let blend = lookup.at(&incidence_from(towards));
    let wavelengths = lookup.bsdf().wavelength_nm.len();
    // In the frame of the result, exits of reflection are above.
    let sign = if way.reflects { 1.0 } else { -1.0 };
    let in_result = |d: DVec2| {
        let y = if way.from_below { -d.y } else { d.y };
        DVec3::new(d.x, y, sign * (1.0 - d.length_squared()).max(0.0).sqrt())
    };
    let points = POINTS * n;
    let weight = 1.0 / (POINTS * POINTS) as f64;
    let (mut spectrum, mut point) = (vec![0.0; wavelengths], vec![0.0; wavelengths]);
    let mut values = vec![[0.0; 3]; n * n];
    let mut is_even = vec![true; n * n];
    for (cell, value) in values.iter_mut().enumerate() {
        spectrum.fill(0.0);
        let mut first = f64::NAN;
        for p in 0..POINTS * POINTS {
            let (i, j) = (cell / n * POINTS + p / POINTS, cell % n * POINTS + p % POINTS);
            let at = DVec2::new(i as f64 + 0.5, j as f64 + 0.5) / points as f64;
            point.fill(0.0);
            blend.add_values(in_result(to_disk(at)), weight, &mut point);
            spectrum.iter_mut().zip(&point).for_each(|(s, x)| *s += x);
            let sum: f64 = point.iter().sum();
            if p == 0 {
                first = sum;
            }
            is_even[cell] &= (sum - first).abs() <= EVEN * first.abs();
        }
        *value = grey.xyz(&spectrum);
    }
    let area = PI / (n * n) as f64;
    keep_flux(&mut values, &is_even, area, grey.xyz(&scattered(lookup, way, &blend)));
    for (exit, xyz) in deltas(&blend, way, grey, wavelengths) {
        let at = to_square(exit.truncate());
        let index = |x: f64| ((x * n as f64) as usize).min(n - 1);
        let cell = &mut values[index(at.x) * n + index(at.y)];
        *cell = std::array::from_fn(|i| cell[i] + xyz[i] / area);
    }
    values
}

/// Spectrum of what leaves on a side, without the delta part.
fn scattered(lookup: &Lookup<'_>, way: Way, blend: &crate::bsdf::Blend<'_>) -> Vec<f64> {
    let share = |w: usize| {
        let (all, delta) = if way.reflects {
            (blend.share(|l| &l.reflected, w), blend.share(|l| &l.specular, w))
        } else {
            (blend.share(|l| &l.transmitted, w), blend.share(|l| &l.undeflected, w))
        };
        (all.value - delta.value).max(0.0)
    };
    (0..lookup.bsdf().wavelength_nm.len()).map(share).collect()
}

/// Scales cells to a flux, for points miss the edges of facets: those through which edges go, if that is enough.
fn keep_flux(values: &mut [[f64; 3]], is_even: &[bool], area: f64, flux: [f64; 3]) {
    for i in 0..3 {
        let sum = |even: bool| -> f64 {
            let some = values.iter().zip(is_even).filter(|(_, e)| **e == even);
            some.map(|(v, _)| v[i] * area).sum()
        };
        let (even, mixed) = (sum(true), sum(false));
        let scale = (flux[i] - even) / mixed;
        if (0.5..2.0).contains(&scale) {
            values.iter_mut().zip(is_even).filter(|(_, e)| !**e).for_each(|(v, _)| v[i] *= scale);
        } else if even + mixed > 0.0 {
            let scale = flux[i] / (even + mixed);
            values.iter_mut().for_each(|v| v[i] *= scale);
        }
    }
}

/// From the square to the disk.
fn to_disk(at: DVec2) -> DVec2 {
    let DVec2 { x: a, y: b } = 2.0 * at - DVec2::ONE;
    if a == 0.0 && b == 0.0 {
        return DVec2::ZERO;
    }
    let (r, phi) = match (a > -b, a > b) {
        (true, true) => (a, FRAC_PI_4 * b / a),
        (true, false) => (b, FRAC_PI_4 * (2.0 - a / b)),
        (false, false) => (-a, FRAC_PI_4 * (4.0 + b / a)),
        (false, true) => (-b, FRAC_PI_4 * (6.0 - a / b)),
    };
    r * DVec2::new(phi.cos(), phi.sin())
}

/// From the disk to the square.
fn to_square(d: DVec2) -> DVec2 {
    let r = d.length();
    let phi = d.y.atan2(d.x);
    let phi = if phi < -FRAC_PI_4 { phi + 2.0 * PI } else { phi };
    let (a, b) = match phi {
        p if p < FRAC_PI_4 => (r, p * r / FRAC_PI_4),
        p if p < 3.0 * FRAC_PI_4 => (-(p - FRAC_PI_2) * r / FRAC_PI_4, r),
        p if p < 5.0 * FRAC_PI_4 => (-r, -(p - PI) * r / FRAC_PI_4),
        p => ((p - 3.0 * FRAC_PI_2) * r / FRAC_PI_4, -r),
    };
    0.5 * DVec2::new(a, b) + DVec2::splat(0.5)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn disk_and_square_are_inverse_and_keep_areas() {
        let n = 40;
        for i in 0..n * n {
            let at = DVec2::new(f64::from(i % n) + 0.43, f64::from(i / n) + 0.57) / f64::from(n);
            let d = to_disk(at);
            assert!(d.length() < 1.0 && to_square(d).distance(at) < 1e-12, "{at}");
            let step = 1e-6;
            let (x, y) = (to_disk(at + DVec2::new(step, 0.0)) - d, to_disk(at + DVec2::new(0.0, step)) - d);
            assert!((x.perp_dot(y) / (step * step) / PI - 1.0).abs() < 1e-4, "{at}");
        }
    }

    #[test]
    fn even_trees_are_one_number_and_grids_count_the_last_dimension_fastest() {
        let even = Grid { rank: 3, level: 2, values: vec![[0.25; 3]; 64] };
        assert_eq!(even.text(0), "{2.5000e-1}\n");
        // The value is the index along the first dimension.
        let values = (0..8).map(|i| [(i / 4) as f32; 3]).collect();
        let grid = Grid { rank: 3, level: 1, values };
        assert_eq!(grid.text(0).replace(['{', '}', '\n'], ""), "0 0 0 0 1.0000e0 1.0000e0 1.0000e0 1.0000e0 ");
    }
}
