//! Means and standard errors from independent batches.

use super::geodesic::{Facet, count};
use super::tally::Tally;

/// A value with its standard error.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimate {
    /// Mean.
    pub value: f64,
    /// Standard error of the mean; 0 where batches agree to rounding.
    pub se: f64,
}

/// Sums and sums of squares of batch means, per facet of one level.
#[derive(Clone, Debug, Default)]
struct Level {
    /// Row of each facet, or [`ABSENT`].
    rows: Vec<u32>,
    trees: Vec<u64>,
    /// Power of all batches, mean power of batches, its square: per row and lane.
    sums: Vec<[f64; 3]>,
}

const ABSENT: u32 = u32::MAX;

/// Everything measured at one incidence.
#[derive(Clone, Debug)]
pub struct Measurement {
    lanes: usize,
    finest: u8,
    trees: u64,
    segments: u64,
    /// Ledger entries of each batch: mean power per tree, per term and lane.
    batches: Vec<Vec<f64>>,
    /// Sum of the ledger entries of all batches.
    totals: Vec<f64>,
    levels: Vec<Level>,
}

/// Variances below this part of the mean square are rounding.
const ROUNDING: f64 = 1e-15;

impl Measurement {
    /// Nothing yet, for a dome of level `finest`.
    pub fn new(lanes: usize, finest: u8) -> Self {
        let level = |l| Level { rows: vec![ABSENT; count(l) as usize], ..Level::default() };
        Self {
            lanes,
            finest,
            trees: 0,
            segments: 0,
            batches: Vec::new(),
            totals: vec![0.0; lanes * Tally::TERMS],
            levels: (0..=finest).map(level).collect(),
        }
    }

    /// Adds a whole batch.
    pub fn add(&mut self, batch: &Tally) {
        let n = batch.trees as f64;
        self.trees += batch.trees;
        self.segments += batch.segments;
        let terms: Vec<f64> = (0..Tally::TERMS).flat_map(|i| batch.term(i)).copied().collect();
        self.totals.iter_mut().zip(&terms).for_each(|(sum, x)| *sum += x);
        self.batches.push(terms.iter().map(|x| x / n).collect());
        let mut rows: Vec<(u32, u64, Vec<f64>)> =
            batch.facets().map(|(code, trees, power)| (code, u64::from(trees), power.to_vec())).collect();
        for level in (0..=self.finest).rev() {
            for (code, trees, power) in &rows {
                self.levels[usize::from(level)].add(*code, *trees, power, n);
            }
            rows = parents(rows);
        }
    }

    /// Trees traced.
    pub fn trees(&self) -> u64 {
        self.trees
    }

    /// Segments traced.
    pub fn segments(&self) -> u64 {
        self.segments
    }

    /// Finest level of the dome.
    pub fn finest(&self) -> u8 {
        self.finest
    }

    /// Number of lanes.
    pub fn lanes(&self) -> usize {
        self.lanes
    }

    /// Number of batches.
    pub fn batches(&self) -> usize {
        self.batches.len()
    }

    /// An entry of the ledger (numbered as in [`Tally::term`]) for a lane, as a share of the incident power.
    pub fn term(&self, term: usize, lane: usize) -> Estimate {
        let at = term * self.lanes + lane;
        let values = self.batches.iter().map(|b| b[at]);
        let b = self.batches.len() as f64;
        let mean = values.clone().sum::<f64>() / b;
        let variance = values.map(|x| (x - mean) * (x - mean)).sum::<f64>() / (b - 1.0) / b;
        let square = mean * mean;
        let se = if variance <= ROUNDING * ROUNDING * square { 0.0 } else { variance.sqrt() };
        Estimate { value: self.totals[at] / self.trees as f64, se: if b > 1.0 { se } else { f64::NAN } }
    }

    /// Share of the incident power in a facet, for a lane.
    pub fn facet(&self, facet: Facet, lane: usize) -> Estimate {
        let level = &self.levels[usize::from(facet.level)];
        let row = level.rows[facet.code as usize];
        if row == ABSENT {
            return Estimate::default();
        }
        let [power, sum, square] = level.sums[row as usize * self.lanes + lane];
        let b = self.batches.len() as f64;
        let spread = square - sum * sum / b;
        let se = if spread <= ROUNDING * square { 0.0 } else { (spread / (b - 1.0) / b).sqrt() };
        Estimate { value: power / self.trees as f64, se: if b > 1.0 { se } else { f64::NAN } }
    }

    /// Trees that hit a facet (one that hits two of its parts counts twice).
    pub fn facet_trees(&self, facet: Facet) -> u64 {
        let level = &self.levels[usize::from(facet.level)];
        match level.rows[facet.code as usize] {
            ABSENT => 0,
            row => level.trees[row as usize],
        }
    }
}

impl Level {
    fn add(&mut self, code: u32, trees: u64, power: &[f64], n: f64) {
        let row = &mut self.rows[code as usize];
        if *row == ABSENT {
            *row = self.trees.len() as u32;
            self.trees.push(0);
            self.sums.resize(self.sums.len() + power.len(), [0.0; 3]);
        }
        let row = *row as usize;
        self.trees[row] += trees;
        let sums = &mut self.sums[row * power.len()..];
        for (sum, p) in sums.iter_mut().zip(power) {
            let mean = p / n;
            *sum = [sum[0] + p, sum[1] + mean, sum[2] + mean * mean];
        }
    }
}

/// Rows of the next coarser level; `rows` ascend by code.
fn parents(rows: Vec<(u32, u64, Vec<f64>)>) -> Vec<(u32, u64, Vec<f64>)> {
    let mut out: Vec<(u32, u64, Vec<f64>)> = Vec::new();
    for (code, trees, power) in rows {
        match out.last_mut() {
            Some(last) if last.0 == code / 4 => {
                last.1 += trees;
                last.2.iter_mut().zip(power).for_each(|(sum, p)| *sum += p);
            }
            _ => out.push((code / 4, trees, power)),
        }
    }
    out
}
