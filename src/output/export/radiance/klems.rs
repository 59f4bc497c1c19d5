//! Klems matrices: light from each patch of a hemisphere into each patch of a hemisphere.

use std::f64::consts::PI;
use std::fmt::Write as _;

use glam::DVec3;
use rayon::prelude::*;

use super::{Block, Export, Exported, Grey, Source, Way, deltas, document, in_sample, measured, notes, refuse};
use crate::bsdf::Lookup;
use crate::dome::klems::{Basis, Cell, Ring};
use crate::dome::{Facet, Patch};
use crate::output::export::points::{direction, incidence_from};

/// The basis, as the files tell of it.
fn xml(basis: &Basis) -> String {
    let mut out = format!("<AngleBasis><AngleBasisName>{}</AngleBasisName>", basis.name);
    for Ring { lower, upper, count } in basis.rings() {
        let theta = if count > 1 { 0.5 * (lower + upper) } else { 0.0 };
        let _ = write!(
            out,
            "\n<AngleBasisBlock><Theta>{theta}</Theta><nPhis>{count}</nPhis><ThetaBounds><LowerTheta>{lower}</LowerTheta>\
             <UpperTheta>{upper}</UpperTheta></ThetaBounds></AngleBasisBlock>"
        );
    }
    out + "</AngleBasis>"
}

/// The matrices of all ways through the sample that were measured. The flux of each facet goes to the patches it lies in,
/// by exact overlap; the delta parts to the patch they hit. Light comes from the middle of its patch.
pub fn klems(source: &Source<'_>, basis: &Basis) -> Export {
    let channels = source.channels()?;
    let grey = Grey::new(source, &channels);
    let cells = basis.cells();
    let names: &[&str] = if source.wavelength.is_some() { &["Visible"] } else { &["CIE-X", "Visible", "CIE-Z"] };
    let mut blocks = Vec::new();
    for way in Way::ALL {
        let Some(lookup) = measured(source, way) else { continue };
        if lookup.bsdf().wavelength_nm != source.front.bsdf().wavelength_nm {
            return refuse("the two sides were measured at different wavelengths");
        }
        let matrix = matrix(lookup, way, &cells, &grey);
        for (i, &wavelength) in names.iter().enumerate() {
            let channel = if names.len() > 1 { i } else { 1 };
            blocks.push(Block { wavelength, way, data: rows(&matrix, cells.len(), channel) });
        }
    }
    Ok(Exported { bytes: document(source, "Columns", basis.name, &xml(basis), &blocks), notes: notes(source) })
}

/// A row per patch of the exit.
fn rows(matrix: &[[f64; 3]], columns: usize, channel: usize) -> String {
    let mut out = String::new();
    for row in matrix.chunks(columns) {
        let row: Vec<String> = row.iter().map(|xyz| format!("{:.6e}", xyz[channel].max(0.0))).collect();
        let _ = writeln!(out, "{},", row.join(","));
    }
    out
}

/// BSDF (1/sr) in X, Y, Z: rows are patches of the exit, columns those of the incidence.
fn matrix(lookup: &Lookup<'_>, way: Way, cells: &[Cell], grey: &Grey<'_>) -> Vec<[f64; 3]> {
    let columns: Vec<Vec<[f64; 3]>> = cells.par_iter().map(|cell| column(lookup, way, cells, grey, cell)).collect();
    (0..cells.len()).flat_map(|row| columns.iter().map(move |c| c[row])).collect()
}

/// What light from one patch does.
fn column(lookup: &Lookup<'_>, way: Way, cells: &[Cell], grey: &Grey<'_>, light: &Cell) -> Vec<[f64; 3]> {
    // Azimuths of incidence are those in which the light goes: half a turn from its source.
    let source = direction(light.theta, light.phi + PI);
    let source = if way.from_below { in_sample(source.with_z(-source.z), true) } else { source };
    let blend = lookup.at(&incidence_from(source));
    let mut flux = vec![[0.0; 3]; cells.len()];
    let mut put = |cell: usize, xyz: [f64; 3], share: f64| (0..3).for_each(|i| flux[cell][i] += share * xyz[i]);
    let goes_up = way.reflects;
    for part in blend.parts() {
        for f in &lookup.bsdf().incidences[part.incidence].facets {
            if (f.facet.center().z > 0.0) != goes_up || f.value.iter().all(|e| e.value == 0.0) {
                continue;
            }
            let spectrum: Vec<f64> = f.value.iter().map(|e| e.value).collect();
            let xyz = grey.xyz(&spectrum);
            let (turn, cap) = (-part.turn_deg.to_radians(), Cap::around(f.facet));
            for (cell, c) in cells.iter().enumerate() {
                // Light from below was measured on the sample turned over, which mirrors azimuths.
                let patch = if way.from_below { mirrored(&c.patch) } else { c.patch };
                let overlap = if cap.may_meet(&patch, turn) { patch.covers(f.facet, turn) } else { 0.0 };
                if overlap > 0.0 {
                    put(cell, xyz, part.weight * overlap);
                }
            }
        }
    }
    for (exit, xyz) in deltas(&blend, way, grey, lookup.bsdf().wavelength_nm.len()) {
        put(holding(cells, exit), xyz, 1.0);
    }
    flux.iter().zip(cells).map(|(xyz, c)| xyz.map(|x| x / c.patch.projected_solid_angle())).collect()
}

fn mirrored(patch: &Patch) -> Patch {
    Patch { phi: patch.phi.map(|[from, to]| [-to, -from]), ..*patch }
}

/// The directions around the centre of a facet that hold it: angles in radians.
struct Cap {
    theta: f64,
    phi: f64,
    radius: f64,
    /// Half the range of azimuths that it spans, unless it holds a pole.
    half: f64,
}

impl Cap {
    fn around(facet: Facet) -> Self {
        let center = facet.center();
        let radius = facet.corners().iter().map(|c| c.angle_between(center)).fold(0.0, f64::max);
        let theta = center.z.abs().acos();
        let half = (radius.sin() / theta.sin()).min(1.0).asin();
        Self { theta, phi: center.y.atan2(center.x), radius, half }
    }

    /// Whether the facet, turned by some azimuth, is near enough to a patch to reach into it.
    fn may_meet(&self, patch: &Patch, turn: f64) -> bool {
        let &Self { theta, phi, radius, half } = self;
        let [from, to] = patch.theta;
        if theta + radius < from || theta - radius > to {
            return false;
        }
        let Some([from, to]) = patch.phi else { return true };
        if theta <= radius {
            return true;
        }
        let phi = phi + turn - 0.5 * (from + to);
        let phi = (phi + PI).rem_euclid(2.0 * PI) - PI;
        phi.abs() <= half + 0.5 * (to - from)
    }
}

/// Number of the patch that holds a direction.
fn holding(cells: &[Cell], dir: DVec3) -> usize {
    let (theta, phi) = (dir.z.abs().clamp(0.0, 1.0).acos(), dir.y.atan2(dir.x));
    let holds = |c: &Cell| {
        let [from, to] = c.patch.theta;
        let off = c
            .patch
            .phi
            .map_or(0.0, |[a, b]| ((phi - 0.5 * (a + b) + PI).rem_euclid(2.0 * PI) - PI).abs() - 0.5 * (b - a));
        theta >= from && theta < to && off <= 1e-12
    };
    cells.iter().position(holds).unwrap_or(cells.len() - 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dome::klems::{FULL, HALF, QUARTER};

    #[test]
    fn patches_hold_their_own_directions() {
        for basis in [FULL, HALF, QUARTER] {
            let cells = basis.cells();
            for (i, c) in cells.iter().enumerate() {
                assert_eq!(holding(&cells, direction(c.theta, c.phi)), i, "{basis:?}");
            }
        }
    }

    /// Of a dome that is turned by the azimuth of any patch, every patch gets all of its solid angle.
    #[test]
    fn turned_domes_fill_all_patches() {
        for basis in [FULL, HALF, QUARTER] {
            let cells = basis.cells();
            for turn in cells.iter().map(|c| c.phi).chain([0.3]) {
                for c in &cells {
                    let sum: f64 = Facet::all(2)
                        .filter(|f| f.center().z > 0.0 && Cap::around(*f).may_meet(&c.patch, turn))
                        .map(|f| c.patch.covers(f, turn))
                        .sum();
                    let whole = c.patch.projected_solid_angle();
                    assert!((sum - whole).abs() < 1e-12, "{:?} {turn}: {sum} of {whole}", c.patch);
                }
            }
        }
    }

    /// What is passed over does not reach into the patch.
    #[test]
    fn nothing_that_overlaps_is_passed_over() {
        let cells = FULL.cells();
        for facet in Facet::all(3).step_by(7) {
            let cap = Cap::around(facet);
            for c in cells.iter().filter(|c| !cap.may_meet(&c.patch, 0.7)) {
                assert!(c.patch.covers(facet, 0.7) < 1e-14, "{facet:?} {:?}", c.patch);
            }
        }
    }
}
