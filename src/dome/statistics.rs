//! Means and standard errors from independent batches.

use std::borrow::Cow;

use super::frame;
use super::geodesic::{Facet, count};
use super::tally::{Shape, Tally};
use crate::optics::field::{Field, Mueller};

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

/// Sums and sums of squares of batch means, per facet of one level.
#[derive(Clone, Debug, Default)]
struct Level {
    /// Row of each facet, or [`ABSENT`].
    rows: Vec<u32>,
    trees: Vec<u64>,
    /// Sum over all batches, sum of the means of batches, and of their squares: per row, lane and component.
    sums: Vec<[f64; 3]>,
}

const ABSENT: u32 = u32::MAX;

/// Everything measured at one incidence.
#[derive(Clone, Debug)]
pub struct Measurement {
    shape: Shape,
    finest: u8,
    trees: u64,
    segments: u64,
    /// Terms of the ledger of each batch: mean per tree, per term and lane.
    batches: Vec<Vec<f64>>,
    /// Sum of the terms of all batches.
    totals: Vec<f64>,
    levels: Vec<Level>,
    /// Rows of apertures.
    apertures: Level,
}

/// Variances below this part of the mean square are rounding.
const ROUNDING: f64 = 1e-15;

impl Measurement {
    /// Nothing yet, for a dome of level `finest` and so many apertures.
    pub fn new(shape: Shape, finest: u8, apertures: usize) -> Self {
        let level = |rows: usize| Level { rows: vec![ABSENT; rows], ..Level::default() };
        Self {
            shape,
            finest,
            trees: 0,
            segments: 0,
            batches: Vec::new(),
            totals: vec![0.0; shape.lanes * shape.terms()],
            levels: (0..=finest).map(|l| level(count(l) as usize)).collect(),
            apertures: level(apertures),
        }
    }

    /// Adds a whole batch.
    pub fn add(&mut self, batch: &Tally) {
        let n = batch.trees as f64;
        self.trees += batch.trees;
        self.segments += batch.segments;
        let terms = batch.terms();
        self.totals.iter_mut().zip(terms).for_each(|(sum, x)| *sum += x);
        self.batches.push(terms.iter().map(|x| x / n).collect());
        let mut rows: Vec<(u32, u64, Vec<f64>)> =
            batch.facets().map(|(code, trees, power)| (code, u64::from(trees), power.to_vec())).collect();
        let apertures = rows.split_off(rows.partition_point(|row| row.0 < count(self.finest)));
        for (code, trees, power) in apertures {
            self.apertures.add(code - count(self.finest), trees, &power, n);
        }
        for level in (0..=self.finest).rev() {
            for (code, trees, power) in &rows {
                let told = self.told(Facet { level, code: *code }, power);
                self.levels[usize::from(level)].add(*code, *trees, &told, n);
            }
            rows = parents(rows);
        }
    }

    /// What a facet got, as it is told: matrices in the frame of s and p at its centre.
    fn told<'p>(&self, facet: Facet, power: &'p [f64]) -> Cow<'p, [f64]> {
        if self.shape.components == 1 {
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
        let at = term * self.shape.lanes + lane;
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

    fn estimate(&self, level: &Level, at: usize, lane: usize, component: usize) -> Estimate {
        let row = level.rows[at];
        if row == ABSENT {
            return Estimate::default();
        }
        let [power, sum, square] =
            level.sums[row as usize * self.shape.row() + lane * self.shape.components + component];
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
