//! What one chunk of trees, or one batch of chunks, has put into the dome.

use glam::DVec3;

use super::geodesic::{Locator, count};
use crate::optics::field::Field;
use crate::trace::{Detect, Exit, Loss, Recorder};

/// Directions in which a flat sample sends all its light: kept apart from the facets.
#[derive(Clone, Debug, PartialEq)]
pub struct Delta {
    /// Mirror direction.
    pub specular: DVec3,
    /// Straight through, per lane: refracted by the medium below.
    pub undeflected: Vec<DVec3>,
}

/// Directions closer than this are the same: far above rounding, far below any lobe.
const SAME_DIRECTION: f64 = 1e-9;

/// Power per lane in each entry of the energy ledger, and per facet.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tally {
    lanes: usize,
    /// Trees traced.
    pub trees: u64,
    /// Segments traced.
    pub segments: u64,
    /// Upwards, the mirror direction included.
    pub reflected: Vec<f64>,
    /// Downwards, the straight direction included.
    pub transmitted: Vec<f64>,
    /// In the sample.
    pub absorbed: Vec<f64>,
    /// Sideways.
    pub side: Vec<f64>,
    /// Lost, by [`Loss::ALL`].
    pub lost: [Vec<f64>; 3],
    /// In the mirror direction.
    pub specular: Vec<f64>,
    /// In the straight direction.
    pub undeflected: Vec<f64>,
    /// Met faces so narrow that ray optics is in doubt.
    pub doubtful: Vec<f64>,
    /// Met films near to their edges.
    pub edge: Vec<f64>,
    /// Facets hit, ascending, with the trees that hit them.
    facets: Vec<(u32, u32)>,
    /// Their power: one row of lanes per facet.
    power: Vec<f64>,
}

impl Tally {
    /// Nothing yet.
    pub fn new(lanes: usize) -> Self {
        let zero = || vec![0.0; lanes];
        Self {
            lanes,
            reflected: zero(),
            transmitted: zero(),
            absorbed: zero(),
            side: zero(),
            lost: std::array::from_fn(|_| zero()),
            specular: zero(),
            undeflected: zero(),
            doubtful: zero(),
            edge: zero(),
            ..Self::default()
        }
    }

    /// Facets hit, ascending: number, trees, power per lane.
    pub fn facets(&self) -> impl ExactSizeIterator<Item = (u32, u32, &[f64])> {
        self.facets.iter().zip(self.power.chunks_exact(self.lanes)).map(|(&(code, trees), power)| (code, trees, power))
    }

    /// Adds another tally of other trees.
    pub fn merge(&mut self, other: &Self) {
        self.trees += other.trees;
        self.segments += other.segments;
        let terms = |t: &mut Self, i: usize| std::mem::take(t.term_mut(i));
        for i in 0..Self::TERMS {
            let mut sum = terms(self, i);
            sum.iter_mut().zip(other.term(i)).for_each(|(a, b)| *a += b);
            *self.term_mut(i) = sum;
        }
        self.merge_facets(other);
    }

    /// Number of entries of the ledger, deltas included.
    pub const TERMS: usize = 11;

    /// An entry of the ledger, per lane.
    pub fn term(&self, i: usize) -> &[f64] {
        match i {
            0 => &self.reflected,
            1 => &self.transmitted,
            2 => &self.absorbed,
            3 => &self.side,
            4 => &self.specular,
            5 => &self.undeflected,
            6 => &self.doubtful,
            7 => &self.edge,
            _ => &self.lost[i - 8],
        }
    }

    fn term_mut(&mut self, i: usize) -> &mut Vec<f64> {
        match i {
            0 => &mut self.reflected,
            1 => &mut self.transmitted,
            2 => &mut self.absorbed,
            3 => &mut self.side,
            4 => &mut self.specular,
            5 => &mut self.undeflected,
            6 => &mut self.doubtful,
            7 => &mut self.edge,
            _ => &mut self.lost[i - 8],
        }
    }

    /// Merges two ascending lists of facets.
    fn merge_facets(&mut self, other: &Self) {
        let (a, b) = (std::mem::take(&mut self.facets), &other.facets);
        let power = std::mem::take(&mut self.power);
        let lanes = self.lanes;
        let row = |power: &[f64], i: usize| -> std::ops::Range<usize> {
            debug_assert!(power.len() >= (i + 1) * lanes);
            i * lanes..(i + 1) * lanes
        };
        let (mut i, mut j) = (0, 0);
        while i < a.len() || j < b.len() {
            let (x, y) = (a.get(i).map(|f| f.0), b.get(j).map(|f| f.0));
            let code = [x, y].into_iter().flatten().min().unwrap_or_default();
            let mut trees = 0;
            let first = self.power.len();
            self.power.resize(first + lanes, 0.0);
            let sum = &mut self.power[first..];
            if x == Some(code) {
                trees += a[i].1;
                sum.copy_from_slice(&power[row(&power, i)]);
                i += 1;
            }
            if y == Some(code) {
                trees += b[j].1;
                sum.iter_mut().zip(&other.power[row(&other.power, j)]).for_each(|(s, p)| *s += p);
                j += 1;
            }
            self.facets.push((code, trees));
        }
    }
}

/// Takes what the tracer tells into a [`Tally`]. One per worker, reused from chunk to chunk.
pub struct Detector<'a> {
    locator: &'a Locator,
    tally: Tally,
    /// Delta directions per incidence, and which of them holds now.
    deltas: &'a [Delta],
    delta: &'a Delta,
    /// Row of each facet in `power`, or [`NOT_HIT`].
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
    /// A dome with the facets of `locator`, for light of the incidences with these delta directions.
    ///
    /// # Panics
    /// When there is no incidence.
    pub fn new(locator: &'a Locator, lanes: usize, deltas: &'a [Delta]) -> Self {
        Self {
            locator,
            tally: Tally::new(lanes),
            deltas,
            delta: &deltas[0],
            rows: vec![NOT_HIT; count(locator.level()) as usize],
            hit: Vec::new(),
            power: Vec::new(),
        }
    }

    fn row(&mut self, dir: DVec3, tree: u32) -> &mut [f64] {
        let lanes = self.tally.lanes;
        let code = self.locator.code(dir);
        let row = &mut self.rows[code as usize];
        if *row == NOT_HIT {
            *row = self.hit.len() as u32;
            self.hit.push(Hit { code, trees: 0, last_tree: u32::MAX });
            self.power.resize(self.power.len() + lanes, 0.0);
        }
        let row = *row as usize;
        let hit = &mut self.hit[row];
        if hit.last_tree != tree {
            hit.last_tree = tree;
            hit.trees += 1;
        }
        &mut self.power[row * lanes..(row + 1) * lanes]
    }
}

fn same(a: DVec3, b: DVec3) -> bool {
    a.distance_squared(b) < SAME_DIRECTION * SAME_DIRECTION
}

impl<F: Field> Recorder<F> for Detector<'_> {
    fn exit(&mut self, exit: &Exit<'_, F>) {
        let up = exit.dir.z > 0.0;
        let specular = up && same(exit.dir, self.delta.specular);
        let loads = || exit.loads().map(|(lane, field)| (usize::from(lane), field.power()));
        let total = if up { &mut self.tally.reflected } else { &mut self.tally.transmitted };
        loads().for_each(|(lane, power)| total[lane] += power);
        if specular {
            return loads().for_each(|(lane, power)| self.tally.specular[lane] += power);
        }
        // The straight direction may differ between lanes, but only where each has a ray of its own.
        let straight = |lane: usize| !up && same(exit.dir, self.delta.undeflected[lane]);
        if loads().next().is_some_and(|(lane, _)| straight(lane)) {
            return loads().for_each(|(lane, power)| self.tally.undeflected[lane] += power);
        }
        let row = self.row(exit.dir, exit.tree);
        loads().for_each(|(lane, power)| row[lane] += power);
    }

    fn side(&mut self, lane: u16, power: f64) {
        self.tally.side[usize::from(lane)] += power;
    }

    fn absorb(&mut self, lane: u16, power: f64) {
        self.tally.absorbed[usize::from(lane)] += power;
    }

    fn lose(&mut self, why: Loss, lane: u16, power: f64) {
        self.tally.lost[why as usize][usize::from(lane)] += power;
    }

    fn doubt(&mut self, lane: u16, power: f64) {
        self.tally.doubtful[usize::from(lane)] += power;
    }

    fn edge(&mut self, lane: u16, power: f64) {
        self.tally.edge[usize::from(lane)] += power;
    }

    fn segments(&mut self, count: usize) {
        self.tally.segments += count as u64;
    }
}

impl<F: Field> Detect<F> for Detector<'_> {
    type Part = Tally;

    fn begin(&mut self, incidence: usize) {
        self.delta = &self.deltas[incidence];
    }

    fn finish(&mut self, trees: u64) -> Tally {
        let lanes = self.tally.lanes;
        let mut tally = std::mem::replace(&mut self.tally, Tally::new(lanes));
        let mut order: Vec<usize> = (0..self.hit.len()).collect();
        order.sort_unstable_by_key(|&i| self.hit[i].code);
        for i in order {
            let Hit { code, trees, .. } = self.hit[i];
            self.rows[code as usize] = NOT_HIT;
            tally.facets.push((code, trees));
            tally.power.extend_from_slice(&self.power[i * lanes..(i + 1) * lanes]);
        }
        self.hit.clear();
        self.power.clear();
        tally.trees = trees;
        tally
    }
}
