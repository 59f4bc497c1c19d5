//! Tables over directions: the density of normals and its projection.

use std::f64::consts::PI;

use glam::DVec3;
use rayon::prelude::*;

use super::super::points::{direction, node};
use super::Exits;

/// Nodes of D along φ and θ.
const NORMALS: [usize; 2] = [64, 256];
/// Nodes of σ: isotropic, anisotropic.
const SIGMA: [[usize; 2]; 2] = [[2, 128], [64, 64]];
/// Least D, of its greatest.
const LEAST: f64 = 1e-4;
/// Azimuths over which D of an isotropic sample is a mean.
const AZIMUTHS: usize = 16;

/// The coordinates (u, v) of a direction.
pub fn coordinates(m: DVec3) -> [f64; 2] {
    let theta = m.truncate().length().atan2(m.z);
    [(2.0 * theta / PI).sqrt(), (m.y.atan2(m.x) + PI) / (2.0 * PI)]
}

/// The direction of coordinates (u, v), and solid angle per area of them.
pub fn direction_at([u, v]: [f64; 2]) -> (DVec3, f64) {
    let theta = 0.5 * PI * u * u;
    (direction(theta, (2.0 * v - 1.0) * PI), 2.0 * PI * PI * u * theta.sin())
}

/// The half vector of coordinates (u, v), and solid angle of exits per area of them.
pub fn half(at: [f64; 2], light: DVec3) -> (DVec3, f64) {
    let (m, area) = direction_at(at);
    (m, area * 4.0 * m.dot(light).max(0.0))
}

/// Values on nodes of directions, along φ and θ.
#[derive(Clone, Debug, PartialEq)]
pub struct Nodes {
    /// Along φ and θ.
    pub size: [usize; 2],
    /// Row by row.
    pub values: Vec<f32>,
}

impl Nodes {
    /// Bilinear between the nodes, as the reader has it.
    pub fn at(&self, [u, v]: [f64; 2]) -> f64 {
        let [height, width] = self.size;
        let cell = |x: f64, n: usize| {
            let at = (x * (n - 1) as f64).clamp(0.0, (n - 1) as f64);
            let low = (at as usize).min(n - 2);
            (low, at - low as f64)
        };
        let ((column, tx), (row, ty)) = (cell(u, width), cell(v, height));
        let value = |r: usize, c: usize| f64::from(self.values[r * width + c]);
        let along = |r: usize| (1.0 - tx) * value(r, column) + tx * value(r, column + 1);
        (1.0 - ty) * along(row) + ty * along(row + 1)
    }

    /// D: the mean of f · 4 cos θ_i cos θ_o over incidences and bands, of an isotropic sample over azimuths, too.
    pub fn normals<'a>(
        lights: &[DVec3],
        bands: usize,
        is_isotropic: bool,
        exits: impl Fn(DVec3) -> Exits<'a> + Sync,
    ) -> Self {
        let size @ [height, width] = NORMALS;
        let rows = if is_isotropic { AZIMUTHS } else { height };
        let of_light = |&light: &DVec3| {
            let exits = exits(light);
            let mut out = vec![0.0; bands];
            let mut value = |i: usize| {
                // Of the whole circle, the last row is the first; azimuths of an isotropic sample are counted once each.
                let row = if is_isotropic { (i / width) as f64 / rows as f64 } else { node(i / width, rows) };
                let (m, _) = half([node(i % width, width), row], light);
                let exit = 2.0 * m.dot(light) * m - light;
                if m.dot(light) <= 0.0 || exit.z <= 0.0 {
                    return (0.0, 0.0);
                }
                out.fill(0.0);
                exits(exit, 4.0 * light.z * exit.z / bands as f64, &mut out);
                // What grazes counts less: it says little of what is seen.
                (exit.z * light.z * out.iter().sum::<f64>(), exit.z * light.z)
            };
            (0..rows * width).map(&mut value).collect::<Vec<(f64, f64)>>()
        };
        let add = |mut a: Vec<(f64, f64)>, b: Vec<(f64, f64)>| {
            a.iter_mut().zip(b).for_each(|(a, b)| *a = (a.0 + b.0, a.1 + b.1));
            a
        };
        // One after the other, so that sums do not depend on the number of threads.
        let all: Vec<_> = lights.par_iter().map(of_light).collect();
        let mut sums = all.into_iter().reduce(add).unwrap_or_default();
        if is_isotropic {
            let row = |c: usize| (0..rows).map(|r| sums[r * width + c]).fold((0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1));
            let row: Vec<_> = (0..width).map(row).collect();
            sums = row.iter().copied().cycle().take(height * width).collect();
        }
        Self { size, values: floored(&sums) }
    }

    /// σ: the area of the normals that a direction sees, ∫ D max(0, m·ω) dm, for D in these nodes.
    pub fn projected(&self, is_isotropic: bool) -> Self {
        let [height, width] = self.size;
        let size = SIGMA[usize::from(!is_isotropic)];
        let step = 1.0 / (height * width) as f64;
        let middle = |i: usize, n: usize| (i as f64 + 0.5) / n as f64;
        let normals: Vec<(DVec3, f64)> = (0..height * width)
            .map(|i| {
                let at = [middle(i % width, width), middle(i / width, height)];
                let (m, area) = direction_at(at);
                (m, self.at(at) * area * step)
            })
            .collect();
        let sigma = |i: usize| {
            let (light, _) = direction_at([node(i % size[1], size[1]), node(i / size[1], size[0])]);
            normals.iter().map(|(m, weight)| weight * m.dot(light).max(0.0)).sum::<f64>() as f32
        };
        let rows = if is_isotropic { 1 } else { size[0] };
        let some: Vec<f32> = (0..rows * size[1]).into_par_iter().map(sigma).collect();
        Self { size, values: some.iter().copied().cycle().take(size[0] * size[1]).collect() }
    }
}

/// Means of sums and weights, none of them less than a part of the greatest.
fn floored(sums: &[(f64, f64)]) -> Vec<f32> {
    let mean = |&(sum, weight): &(f64, f64)| if weight > 0.0 { sum / weight } else { 0.0 };
    let most = sums.iter().map(mean).fold(0.0, f64::max);
    let least = if most > 0.0 { LEAST * most } else { 1.0 };
    sums.iter().map(|s| mean(s).max(least) as f32).collect()
}
