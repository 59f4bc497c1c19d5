//! Takes what the tracer tells into a tally.

use glam::DVec3;

use super::apertures::Apertures;
use super::frame;
use super::geodesic::{Locator, count};
use super::tally::{Entry, Shape, Tally};
use crate::optics::field::Field;
use crate::trace::{Detect, Exit, Loss, Recorder};

/// What is told apart from the facets under one incidence: the directions in which a flat sample sends all its light, and
/// what detectors see through apertures.
#[derive(Clone, Debug, PartialEq)]
pub struct Apart {
    /// Mirror direction.
    pub specular: DVec3,
    /// Straight through, per lane: refracted by the medium below.
    pub undeflected: Vec<DVec3>,
    /// Detectors besides the dome; what they see is in its facets, too.
    pub apertures: Apertures,
}

/// Directions closer than this are the same: far above rounding, far below any lobe.
const SAME_DIRECTION: f64 = 1e-9;

/// The dome of one worker, reused from chunk to chunk.
pub struct Detector<'a> {
    locator: &'a Locator,
    tally: Tally,
    /// What is told apart per incidence, and under the one that holds now.
    all_apart: &'a [Apart],
    apart: &'a Apart,
    /// Row of each facet, and then of each aperture, in `power`, or [`NOT_HIT`].
    rows: Vec<u32>,
    hit: Vec<Hit>,
    power: Vec<f64>,
}

struct Hit {
    code: u32,
    trees: u32,
    last_tree: u32,
}

const NOT_HIT: u32 = u32::MAX;

impl<'a> Detector<'a> {
    /// A dome with the facets of `locator`; an element of `apart` for each incidence.
    ///
    /// # Panics
    /// When there is no incidence.
    pub fn new(locator: &'a Locator, shape: Shape, apart: &'a [Apart]) -> Self {
        let apertures = apart.iter().map(|a| a.apertures.len()).max().unwrap_or(0);
        Self {
            locator,
            tally: Tally::new(shape),
            all_apart: apart,
            apart: &apart[0],
            rows: vec![NOT_HIT; count(locator.level()) as usize + apertures],
            hit: Vec::new(),
            power: Vec::new(),
        }
    }

    fn row(&mut self, code: u32, tree: u32) -> &mut [f64] {
        let width = self.tally.shape().row();
        let row = &mut self.rows[code as usize];
        if *row == NOT_HIT {
            *row = self.hit.len() as u32;
            self.hit.push(Hit { code, trees: 0, last_tree: u32::MAX });
            self.power.resize(self.power.len() + width, 0.0);
        }
        let row = *row as usize;
        let hit = &mut self.hit[row];
        if hit.last_tree != tree {
            hit.last_tree = tree;
            hit.trees += 1;
        }
        &mut self.power[row * width..(row + 1) * width]
    }

    /// Power that detectors see. Their rows follow those of the facets, and have no matrices.
    fn take_apertures<F: Field>(&mut self, exit: &Exit<'_, F>) {
        let apart = self.apart;
        for aperture in apart.apertures.catching(exit.dir) {
            let row = self.row(count(self.locator.level()) + aperture, exit.tree);
            exit.loads().for_each(|(lane, field)| row[usize::from(lane) * F::COMPONENTS] += field.power());
        }
    }

    /// Light in the mirror direction, or straight behind the sample, in the s and p frame of that direction: its own
    /// differs by rounding, and at a pole any azimuth is that near.
    fn take_delta<F: Field>(&mut self, exit: &Exit<'_, F>, direction: DVec3) {
        let behind = direction.z < 0.0;
        let entry = if behind { Entry::Undeflected } else { Entry::Specular };
        let turn = frame::turn(exit.dir, exit.frame, frame::theta(direction));
        for (lane, field) in exit.loads() {
            self.tally.add(entry as usize, lane, field.power());
            if F::COMPONENTS > 1 {
                let mut components = [0.0; 16];
                field.rotated(turn[0], turn[1]).add_to(&mut components);
                for (i, x) in components.into_iter().enumerate() {
                    self.tally.add(self.tally.shape().delta(behind, i), lane, x);
                }
            }
        }
    }
}

fn same(a: DVec3, b: DVec3) -> bool {
    a.distance_squared(b) < SAME_DIRECTION * SAME_DIRECTION
}

impl<F: Field> Recorder<F> for Detector<'_> {
    fn exit(&mut self, exit: &Exit<'_, F>) {
        let up = exit.dir.z > 0.0;
        let total = if up { Entry::Reflected } else { Entry::Transmitted };
        exit.loads().for_each(|(lane, field)| self.tally.add(total as usize, lane, field.power()));
        if !self.apart.apertures.is_empty() {
            self.take_apertures(exit);
        }
        // The straight direction may differ between lanes, but only where each has a ray of its own.
        let straight = || exit.loads().next().map(|(lane, _)| self.apart.undeflected[usize::from(lane)]);
        let delta = if up { Some(self.apart.specular) } else { straight() };
        if let Some(direction) = delta.filter(|&d| same(exit.dir, d)) {
            return self.take_delta(exit, direction);
        }
        let row = self.row(self.locator.code(exit.dir), exit.tree);
        if F::COMPONENTS == 1 {
            return exit.loads().for_each(|(lane, field)| row[usize::from(lane)] += field.power());
        }
        let [cos, sin] = frame::turn(exit.dir, exit.frame, frame::carried(exit.dir));
        for (lane, field) in exit.loads() {
            field.rotated(cos, sin).add_to(&mut row[usize::from(lane) * F::COMPONENTS..]);
        }
    }

    fn side(&mut self, lane: u16, power: f64) {
        self.tally.add(Entry::Side as usize, lane, power);
    }

    fn absorb(&mut self, group: u16, lane: u16, power: f64) {
        self.tally.add(Entry::Absorbed as usize, lane, power);
        let shape = self.tally.shape();
        if usize::from(group) < shape.groups {
            self.tally.add(shape.group(group.into()), lane, power);
        }
    }

    fn lose(&mut self, why: Loss, lane: u16, power: f64) {
        let entry = match why {
            Loss::Medium => Entry::LostMedium,
            Loss::Depth => Entry::LostDepth,
            Loss::Numeric => Entry::LostNumeric,
        };
        self.tally.add(entry as usize, lane, power);
    }

    fn doubt(&mut self, lane: u16, power: f64) {
        self.tally.add(Entry::Doubtful as usize, lane, power);
    }

    fn edge(&mut self, lane: u16, power: f64) {
        self.tally.add(Entry::Edge as usize, lane, power);
    }

    fn segments(&mut self, count: usize) {
        self.tally.segments += count as u64;
    }
}

impl<F: Field> Detect<F> for Detector<'_> {
    type Part = Tally;

    fn begin(&mut self, incidence: usize) {
        self.apart = &self.all_apart[incidence];
    }

    fn finish(&mut self, trees: u64) -> Tally {
        let shape = self.tally.shape();
        let width = shape.row();
        let mut tally = std::mem::replace(&mut self.tally, Tally::new(shape));
        let mut order: Vec<usize> = (0..self.hit.len()).collect();
        order.sort_unstable_by_key(|&i| self.hit[i].code);
        for i in order {
            let Hit { code, trees, .. } = self.hit[i];
            self.rows[code as usize] = NOT_HIT;
            tally.push_facet(code, trees, &self.power[i * width..(i + 1) * width]);
        }
        self.hit.clear();
        self.power.clear();
        tally.trees = trees;
        tally
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::field::Mueller;
    use crate::trace::testing;

    /// Light that left a tilted plate has an azimuth of mere rounding.
    #[test]
    fn rounding_at_a_pole_turns_no_frame() {
        let locator = Locator::new(1);
        let apart = [Apart { specular: DVec3::Z, undeflected: vec![DVec3::NEG_Z], apertures: Apertures::default() }];
        let shape = Shape { lanes: 1, components: 16, groups: 0 };
        for behind in [false, true] {
            let mut detector = Detector::new(&locator, shape, &apart);
            for (tree, azimuth) in [0.0, 0.8, 1.6, 2.5].into_iter().enumerate() {
                let z = if behind { -1.0 } else { 1.0 };
                let dir = DVec3::new(1e-16 * f64::cos(azimuth), 1e-16 * f64::sin(azimuth), z);
                testing::exit(&mut detector, tree as u32, dir, Mueller::incident([0.25; 4]));
            }
            let tally = Detect::<Mueller>::finish(&mut detector, 4);
            for i in 0..16 {
                let expected = if i % 5 == 0 { 1.0 } else { 0.0 };
                assert!((tally.terms()[shape.delta(behind, i)] - expected).abs() < 1e-12, "{behind} {i}");
            }
        }
    }
}
