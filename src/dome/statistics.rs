//! Means and standard errors from independent batches.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};

use super::frame;
use super::geodesic::{Facet, count};
use super::tally::{Shape, Tally};
use crate::optics::field::{Mueller, State};

/// Independent scrambles per incidence, from which the standard errors come.
pub const BATCHES: u32 = 32;

/// A value with its standard error.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimate {
    /// Mean.
    pub value: f64,
    /// Standard error of the mean; 0 where batches agree to rounding.
    pub se: f64,
}

/// Rows of facets, of one level or of apertures, each with `N` numbers per lane and component.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(bound(serialize = "[f64; N]: Serialize", deserialize = "[f64; N]: Deserialize<'de>"))]
struct Level<const N: usize> {
    /// Row of each facet, or [`ABSENT`].
    rows: Vec<u32>,
    trees: Vec<u64>,
    sums: Vec<[f64; N]>,
}

const ABSENT: u32 = u32::MAX;

/// What is collected of independent scrambles of equally many trees, which together are a round.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Round {
    whole: Measurement,
    /// Sum over all batches, sum of the means of batches, and of their squares.
    levels: Vec<Level<3>>,
    apertures: Level<3>,
}

/// Everything measured at one incidence. Rounds are independent: their variances add up.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Measurement {
    shape: Shape,
    finest: u8,
    trees: u64,
    segments: u64,
    /// By number of the batch; the same of all rounds are put together.
    batches: Vec<Batch>,
    /// Sum of the terms of all batches, and its variance.
    terms: Vec<[f64; 2]>,
    /// Sum of what a facet got, and its variance.
    levels: Vec<Level<2>>,
    /// Rows of apertures.
    apertures: Level<2>,
}

/// Terms of the ledger of a batch: sums, per term and lane.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Batch {
    trees: u64,
    terms: Vec<f64>,
}

/// Variances below this part of the mean square are rounding.
const ROUNDING: f64 = 1e-15;

impl Round {
    /// Nothing yet, for a dome of level `finest` and so many apertures.
    pub fn new(shape: Shape, finest: u8, apertures: usize) -> Self {
        Self {
            whole: Measurement::new(shape, finest, apertures),
            levels: (0..=finest).map(|l| Level::new(count(l) as usize)).collect(),
            apertures: Level::new(apertures),
        }
    }

    /// Adds a whole batch.
    pub fn add(&mut self, batch: &Tally) {
        let (n, whole) = (batch.trees as f64, &mut self.whole);
        whole.trees += batch.trees;
        whole.segments += batch.segments;
        whole.batches.push(Batch { trees: batch.trees, terms: batch.terms().to_vec() });
        let finest = whole.finest;
        let mut rows: Vec<(u32, u64, Vec<f64>)> =
            batch.facets().map(|(code, trees, power)| (code, u64::from(trees), power.to_vec())).collect();
        let apertures = rows.split_off(rows.partition_point(|row| row.0 < count(finest)));
        for (code, trees, power) in apertures {
            self.apertures.add(code - count(finest), trees, &power, n);
        }
        for level in (0..=finest).rev() {
            for (code, trees, power) in &rows {
                let told = self.told(Facet { level, code: *code }, power);
                self.levels[usize::from(level)].add(*code, *trees, &told, n);
            }
            rows = parents(rows);
        }
    }

    /// What all its batches have measured.
    pub fn close(self) -> Measurement {
        let Self { mut whole, levels, apertures } = self;
        let scale = whole.trees as f64 * whole.trees as f64;
        let b = whole.batches.len() as f64;
        let of = |[sum, means, squares]: [f64; 3]| {
            let spread = squares - means * means / b;
            let variance = if spread <= ROUNDING * squares { 0.0 } else { spread / (b - 1.0) / b };
            [sum, scale * if b > 1.0 { variance } else { f64::NAN }]
        };
        whole.terms = (0..whole.terms.len()).map(|at| term(&whole.batches, at, scale)).collect();
        whole.levels = levels.into_iter().map(|level| level.map(of)).collect();
        whole.apertures = apertures.map(of);
        whole
    }

    /// What a facet got, as it is told: matrices in the frame of s and p at its centre.
    fn told<'p>(&self, facet: Facet, power: &'p [f64]) -> Cow<'p, [f64]> {
        if self.whole.shape.components == 1 {
            return Cow::Borrowed(power);
        }
        let center = facet.center();
        let [cos, sin] = frame::turn(center, frame::carried(center), frame::theta(center));
        let mut told = power.to_vec();
        told.as_chunks_mut()
            .0
            .iter_mut()
            .for_each(|matrix| *matrix = Mueller::from_rows(matrix).rotated(cos, sin).rows());
        Cow::Owned(told)
    }
}

impl Measurement {
    fn new(shape: Shape, finest: u8, apertures: usize) -> Self {
        Self {
            shape,
            finest,
            trees: 0,
            segments: 0,
            batches: Vec::new(),
            terms: vec![[0.0; 2]; shape.lanes * shape.terms()],
            levels: (0..=finest).map(|l| Level::new(count(l) as usize)).collect(),
            apertures: Level::new(apertures),
        }
    }

    /// Adds what a later round has measured, of other trees.
    pub fn merge(&mut self, later: &Self) {
        self.trees += later.trees;
        self.segments += later.segments;
        self.terms.iter_mut().zip(&later.terms).for_each(|(a, b)| add(a, b));
        for (i, batch) in later.batches.iter().enumerate() {
            match self.batches.get_mut(i) {
                None => self.batches.push(batch.clone()),
                Some(own) => {
                    own.trees += batch.trees;
                    own.terms.iter_mut().zip(&batch.terms).for_each(|(a, b)| *a += b);
                }
            }
        }
        let width = self.shape.row();
        self.levels.iter_mut().zip(&later.levels).for_each(|(a, b)| a.merge(b, width));
        self.apertures.merge(&later.apertures, width);
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

    /// How many numbers it holds.
    pub fn shape(&self) -> Shape {
        self.shape
    }

    /// Number of batches.
    pub fn batches(&self) -> usize {
        self.batches.len()
    }

    /// A term of the ledger (an [entry](super::Entry), or as [`Shape`] numbers them) for a lane, as a share of the incident
    /// power.
    pub fn term(&self, term: usize, lane: usize) -> Estimate {
        self.mean(self.terms[term * self.shape.lanes + lane])
    }

    /// A function of the terms of the ledger, each the share of the incident power as [`Self::term`] numbers them, a row of
    /// lanes each; its standard error by leaving out one batch after the other (the jackknife).
    pub fn jackknife(&self, function: impl Fn(&[f64]) -> f64) -> Estimate {
        let share = |without: Option<&Batch>| {
            let trees = (self.trees - without.map_or(0, |b| b.trees)) as f64;
            let terms = self.terms.iter().enumerate();
            let rest = terms.map(|(i, [sum, _])| (sum - without.map_or(0.0, |b| b.terms[i])) / trees);
            function(&rest.collect::<Vec<f64>>())
        };
        let b = self.batches.len() as f64;
        let parts: Vec<f64> = self.batches.iter().map(|batch| share(Some(batch))).collect();
        let mean = parts.iter().sum::<f64>() / b;
        let spread: f64 = parts.iter().map(|x| (x - mean) * (x - mean)).sum();
        Estimate { value: share(None), se: if b > 1.0 { ((b - 1.0) / b * spread).sqrt() } else { f64::NAN } }
    }

    /// Share of the incident power in a facet, for a lane.
    pub fn facet(&self, facet: Facet, lane: usize) -> Estimate {
        self.component(facet, lane, 0)
    }

    /// The same for a component of what the facet got: 0 is its power.
    pub fn component(&self, facet: Facet, lane: usize, component: usize) -> Estimate {
        self.estimate(&self.levels[usize::from(facet.level)], facet.code as usize, lane, component)
    }

    /// Share of the incident power that went through an aperture, for a lane.
    pub fn aperture(&self, aperture: usize, lane: usize) -> Estimate {
        self.estimate(&self.apertures, aperture, lane, 0)
    }

    /// Trees whose light went through an aperture.
    pub fn aperture_trees(&self, aperture: usize) -> u64 {
        match self.apertures.rows[aperture] {
            ABSENT => 0,
            row => self.apertures.trees[row as usize],
        }
    }

    fn estimate(&self, level: &Level<2>, at: usize, lane: usize, component: usize) -> Estimate {
        match level.rows[at] {
            ABSENT => Estimate::default(),
            row => self.mean(level.sums[row as usize * self.shape.row() + lane * self.shape.components + component]),
        }
    }

    /// From a sum and its variance.
    fn mean(&self, [sum, variance]: [f64; 2]) -> Estimate {
        Estimate { value: sum / self.trees as f64, se: variance.sqrt() / self.trees as f64 }
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

/// Sum of a term over all batches, and its variance; `scale` is the square of the number of trees.
fn term(batches: &[Batch], at: usize, scale: f64) -> [f64; 2] {
    let values = batches.iter().map(|b| b.terms[at] / b.trees as f64);
    let b = batches.len() as f64;
    let mean = values.clone().sum::<f64>() / b;
    let variance = values.map(|x| (x - mean) * (x - mean)).sum::<f64>() / (b - 1.0) / b;
    let variance = if variance <= ROUNDING * ROUNDING * mean * mean { 0.0 } else { variance };
    [batches.iter().map(|b| b.terms[at]).sum(), scale * if b > 1.0 { variance } else { f64::NAN }]
}

fn add<const N: usize>(sum: &mut [f64; N], other: &[f64; N]) {
    sum.iter_mut().zip(other).for_each(|(a, b)| *a += b);
}

impl<const N: usize> Level<N> {
    fn new(facets: usize) -> Self {
        Self { rows: vec![ABSENT; facets], trees: Vec::new(), sums: Vec::new() }
    }

    /// Numbers of a facet, which has as many as `width`.
    fn row(&mut self, code: u32, trees: u64, width: usize) -> &mut [[f64; N]] {
        let row = &mut self.rows[code as usize];
        if *row == ABSENT {
            *row = self.trees.len() as u32;
            self.trees.push(0);
            self.sums.resize(self.sums.len() + width, [0.0; N]);
        }
        let row = *row as usize;
        self.trees[row] += trees;
        &mut self.sums[row * width..(row + 1) * width]
    }

    fn merge(&mut self, other: &Self, width: usize) {
        for (code, &row) in other.rows.iter().enumerate().filter(|(_, row)| **row != ABSENT) {
            let row = row as usize;
            let sums = self.row(code as u32, other.trees[row], width);
            sums.iter_mut().zip(&other.sums[row * width..]).for_each(|(a, b)| add(a, b));
        }
    }
}

impl Level<3> {
    fn add(&mut self, code: u32, trees: u64, power: &[f64], n: f64) {
        for (sum, p) in self.row(code, trees, power.len()).iter_mut().zip(power) {
            let mean = p / n;
            add(sum, &[*p, mean, mean * mean]);
        }
    }

    fn map(self, of: impl Fn([f64; 3]) -> [f64; 2]) -> Level<2> {
        Level { rows: self.rows, trees: self.trees, sums: self.sums.into_iter().map(of).collect() }
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
