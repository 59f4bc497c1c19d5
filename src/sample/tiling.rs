//! The footprint of the beam, and how the sample repeats beside it.
//!
//! A periodic sample is traced in one cell. The cell is a little larger than the period on every side, by
//! `Cell::overlap`: a ray that reaches a seam is moved by one period and lands well inside. Around it, copies of
//! the bodies fill a zone in which stacks of films can be probed. Seams are put where no wall stands, so that no
//! face is met twice or never.

use glam::{DVec2, DVec3};

use crate::geometry::{Aabb, PrimId, Primitives};

/// The footprint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cell {
    /// Edge lengths, µm.
    pub size: DVec2,
    /// Its centre in the user's coordinates; inside the program it is the origin.
    pub center: DVec3,
    /// Whether it repeats.
    pub periodic: bool,
    /// Heights between which all bodies lie, µm.
    pub heights: (f64, f64),
    /// How far along a normal stacks of films are searched, µm.
    pub reach: f64,
    /// Distance of the seams from the edge of the cell, µm.
    overlap: DVec2,
}

/// Parts of the period at which a seam is tried.
const OVERLAPS: [f64; 8] = [0.061_803, 0.038_197, 0.051_237, 0.073_205, 0.029_289, 0.046_709, 0.067_621, 0.033_851];

impl Cell {
    /// A cell of edge lengths `size` around `center`.
    pub fn new(size: DVec2, center: DVec3, periodic: bool, heights: (f64, f64), reach: f64) -> Self {
        Self { size, center, periodic, heights, reach, overlap: size * OVERLAPS[0] }
    }

    /// Moves the seams away from walls, given as (axis, coordinate).
    pub(super) fn place_seams(&mut self, walls: impl Iterator<Item = (usize, f64)>) {
        let mut clear: [Vec<f64>; 2] = std::array::from_fn(|_| vec![f64::INFINITY; OVERLAPS.len()]);
        for (axis, x) in walls {
            for (k, part) in OVERLAPS.iter().enumerate() {
                for seam in [0.5 + part, -0.5 - part] {
                    let d = (x / self.size[axis] - seam).rem_euclid(1.0);
                    clear[axis][k] = clear[axis][k].min(d.min(1.0 - d));
                }
            }
        }
        for (axis, clear) in clear.iter().enumerate() {
            let best =
                (0..OVERLAPS.len()).max_by(|&a, &b| clear[a].min(1e-3).total_cmp(&clear[b].min(1e-3)).then(b.cmp(&a)));
            self.overlap[axis] = self.size[axis] * OVERLAPS[best.unwrap_or(0)];
        }
    }

    /// Where the seams are: a ray stays within ±this, µm.
    pub fn seam(&self) -> DVec2 {
        0.5 * self.size + self.overlap
    }

    /// One period, µm: whatever is anywhere, a repetition of it is here.
    pub(super) fn tile(&self) -> Aabb {
        let half = (0.5 * self.size).extend(f64::INFINITY);
        Aabb { min: -half, max: half }
    }

    /// Whether a point of a periodic sample lies beyond a seam.
    #[inline]
    pub fn is_beyond(&self, p: DVec3) -> bool {
        self.periodic && p.truncate().abs().cmpgt(self.seam()).any()
    }

    /// By how many periods a point must be moved to lie within the seams.
    pub fn shift_home(&self, p: DVec3) -> [i32; 2] {
        std::array::from_fn(|i| {
            let periods = ((p[i].abs() - self.seam()[i]) / self.size[i]).ceil().max(0.0);
            -periods.copysign(p[i]) as i32
        })
    }

    /// Everything a ray or a probe can see in a periodic sample, µm.
    pub(super) fn zone(&self) -> Aabb {
        if !self.periodic {
            return Aabb::INFINITE;
        }
        let half = self.seam() + self.reach + 1e-6 * self.size.max_element();
        Aabb { min: DVec3::new(-half.x, -half.y, f64::NEG_INFINITY), max: DVec3::new(half.x, half.y, f64::INFINITY) }
    }

    /// Bounds of all places a ray can be at, µm; endless bodies end there.
    pub(super) fn domain(&self, primitives: &Primitives) -> Aabb {
        let zone = self.zone();
        if self.periodic {
            return zone;
        }
        let all = (0..primitives.bounded_count() as u32).map(|i| primitives.bounds(PrimId(i)));
        let far = all.fold(Aabb::EMPTY, Aabb::union);
        if far.is_empty() || far.min.is_finite() && far.max.is_finite() {
            return Aabb::INFINITE;
        }
        let reach = Self::FAR * self.size.max_element();
        Aabb { min: DVec3::splat(-reach), max: DVec3::splat(reach) }
    }

    /// In an open sample endless bodies are followed this many footprints far.
    pub(super) const FAR: f64 = 128.0;

    /// Bodies may lie this many footprints beside the patch that they repeat on.
    const FARTHEST: f64 = 1e6;

    /// The displacement of a repetition, µm.
    pub fn offset(&self, shift: [i32; 2]) -> DVec3 {
        DVec3::new(f64::from(shift[0]) * self.size.x, f64::from(shift[1]) * self.size.y, 0.0)
    }

    /// Why a body of these bounds cannot repeat, if it cannot.
    pub(super) fn refuses(&self, bounds: Option<Aabb>) -> Option<String> {
        let bounds = bounds?;
        let endless = bounds.size().to_array().map(|e| !e.is_finite());
        let far = bounds.min.abs().max(bounds.max.abs()).truncate() / self.size;
        match endless {
            [false, ..] | [_, false, _] if self.periodic && (0..2).any(|i| !endless[i] && far[i] > Self::FARTHEST) => {
                Some("reaches more than a million patch widths beside the patch; enlarge the patch".into())
            }
            [true, true, _] if self.periodic => {
                Some("has no ends and lies askew: in a periodic sample it must lie along x or y; give it caps".into())
            }
            [_, _, true] => Some("has no end downwards; give it caps".into()),
            _ => None,
        }
    }

    /// The repetitions of a body that reach into `zone`; itself only, where nothing repeats.
    pub(super) fn shifts(&self, bounds: Option<Aabb>, zone: Aabb) -> Vec<[i32; 2]> {
        let [[x0, x1], [y0, y1]] = self.shift_range(bounds, zone).map(|range| range.map(|shift| shift as i32));
        (y0..=y1).flat_map(|y| (x0..=x1).map(move |x| [x, y])).collect()
    }

    /// How many [`Cell::shifts`] there are.
    pub(super) fn copies(&self, bounds: Option<Aabb>, zone: Aabb) -> f64 {
        self.shift_range(bounds, zone).map(|[first, last]| (last - first + 1.0).max(0.0)).into_iter().product()
    }

    /// First and last shift along x and y.
    fn shift_range(&self, bounds: Option<Aabb>, zone: Aabb) -> [[f64; 2]; 2] {
        let Some(b) = bounds.filter(|_| self.periodic) else { return [[0.0; 2]; 2] };
        std::array::from_fn(|i| {
            if !b.size()[i].is_finite() {
                return [0.0; 2];
            }
            let first = ((zone.min[i] - b.max[i]) / self.size[i]).ceil();
            let last = ((zone.max[i] - b.min[i]) / self.size[i]).floor();
            [first, last]
        })
    }
}

/// A primitive as a repetition of another.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Placed {
    /// Shape, and triangle of it.
    pub base: (u32, u32),
    /// By how many periods it is moved.
    pub shift: [i32; 2],
}

/// Which primitives are repetitions of which.
#[derive(Clone, Debug, Default)]
pub struct Tiling {
    placed: Vec<Placed>,
    sorted: Vec<u32>,
}

impl Tiling {
    /// From the placing of each primitive.
    pub(super) fn new(placed: Vec<Placed>) -> Self {
        let mut sorted: Vec<u32> = (0..placed.len() as u32).collect();
        sorted.sort_by_key(|&i| placed[i as usize]);
        Self { placed, sorted }
    }

    /// The repetition of `prim` that is `shift` periods away, if it is near enough to be there.
    pub fn neighbour(&self, prim: PrimId, shift: [i32; 2]) -> Option<PrimId> {
        let from = self.placed[prim.0 as usize];
        let wanted = Placed { base: from.base, shift: [from.shift[0] + shift[0], from.shift[1] + shift[1]] };
        let at = self.sorted.binary_search_by_key(&wanted, |&i| self.placed[i as usize]).ok()?;
        Some(PrimId(self.sorted[at]))
    }

    /// Number of the shape a primitive repeats: the same for all repetitions.
    pub fn base(&self, prim: PrimId) -> (u32, u32) {
        self.placed[prim.0 as usize].base
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seams_keep_away_from_walls() {
        let mut cell = Cell::new(DVec2::new(6.0, 6.0), DVec3::ZERO, true, (0.0, 1.0), 0.5);
        let at = 0.5 * 6.0 + 6.0 * OVERLAPS[0];
        cell.place_seams([(0, at - 6.0), (1, 0.0)].into_iter());
        assert!((cell.seam().x - at).abs() > 1e-3);
        assert_eq!(cell.seam().y, at);
        // A ray that leaves at one seam lands well inside the other.
        assert!(cell.seam().x - 6.0 > -cell.seam().x);
    }

    #[test]
    fn repetitions_fill_the_zone() {
        let cell = Cell::new(DVec2::new(2.0, 2.0), DVec3::ZERO, true, (0.0, 1.0), 0.0);
        let unit = Aabb { min: DVec3::splat(-0.9), max: DVec3::splat(0.9) };
        assert_eq!(cell.shifts(Some(unit), cell.zone()).len(), 9);
        assert_eq!(cell.shifts(None, cell.zone()), vec![[0, 0]]);
    }
}
