//! What is traced of a measurement so far. It can be kept, so that the work goes on where it was, and come in parts that
//! were traced apart; the result is the same to the last bit.

use std::fmt;
use std::ops::Range;

use serde::{Deserialize, Serialize};

use super::course::{Course, Ending, Goal};
use super::{BATCHES, Progress};
use crate::dome::{Measurement, Round, Shape, Tally};
use crate::trace::{Batch, Stacks, Unit};

/// What is traced of a measurement so far, and what comes next.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct State {
    course: Course,
    /// Of all rounds that are closed, one per incidence.
    measurements: Vec<Measurement>,
    stacks: Stacks,
    /// The round that is being traced; of a part it stays open.
    round: Option<Running>,
    /// Of the trees that are asked for these batches only, as [`State::batches`] counts them.
    part: Option<Range<u32>>,
    done: u64,
    /// Number of the first scramble of the round.
    scramble: u32,
    finished: bool,
    /// Time spent so far, all of it and on tracing, s.
    seconds: f64,
    tracing: f64,
}

/// A round that is being traced.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Running {
    /// Trees of each incidence.
    trees: Vec<u64>,
    collected: Vec<Collected>,
    batch: Caught,
    /// Units that are done.
    units: usize,
    progress: Progress,
}

/// What the batches of one incidence have yielded.
#[derive(Clone, Debug, Serialize, Deserialize)]
enum Collected {
    /// None of them is traced here.
    Nothing,
    /// All of them, put together.
    Sum(Round, Stacks),
    /// Some of them, as they are, and what they will be added to: sums depend on the order.
    Apart(Round, Vec<Caught>),
}

/// What a batch has yielded.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Caught {
    tally: Tally,
    stacks: Stacks,
}

/// How a dome is made.
#[derive(Clone, Copy, Debug)]
pub(super) struct Dome<'a> {
    /// Numbers per facet.
    pub shape: Shape,
    /// Its finest level.
    pub level: u8,
    /// Apertures of each incidence.
    pub apertures: &'a [usize],
}

/// Why parts do not make a whole.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Mismatch {
    /// These batches are missing.
    Missing(Range<u32>),
    /// These batches are there twice.
    Twice(Range<u32>),
    /// A part is of another measurement, or not finished.
    Foreign,
}

impl fmt::Display for Mismatch {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Missing(r) => write!(f, "batches {} to {} are missing", r.start, r.end - 1),
            Self::Twice(r) => write!(f, "batches {} to {} are there twice", r.start, r.end - 1),
            Self::Foreign => f.write_str("a part is not finished, or of another measurement"),
        }
    }
}

impl State {
    /// Nothing is traced yet; `seconds` were spent on what had to be done before. Scrambles begin with `scramble`.
    pub(super) fn new(course: Course, part: Option<Range<u32>>, seconds: f64, scramble: u32) -> Self {
        Self {
            course,
            measurements: Vec::new(),
            stacks: Stacks::default(),
            round: None,
            part,
            done: 0,
            scramble,
            finished: false,
            seconds,
            tracing: 0.0,
        }
    }

    /// Number of batches of a measurement of `trees` trees at each of so many incidences, by which parts of it are named:
    /// those of the first incidence, then those of the second, and so on.
    pub fn batches(trees: u64, incidences: usize) -> u32 {
        batches(trees) * incidences as u32
    }

    /// Whether all is traced.
    pub fn is_finished(&self) -> bool {
        self.finished
    }

    /// Trees traced, of all incidences.
    pub fn trees(&self) -> u64 {
        self.done
    }

    /// Goes on until another goal is reached.
    pub fn aim(&mut self, goal: Option<Goal>) {
        self.course.aim(goal);
    }

    /// Parts of one measurement of fixed trees put together, in the order of their batches. With `partial` some may be
    /// missing: the numbers of the incidences of which there is something come with it.
    ///
    /// # Errors
    /// When they do not fit together.
    pub fn join(mut parts: Vec<Self>, partial: bool) -> Result<(Self, Vec<usize>), Mismatch> {
        parts.sort_by_key(|p| p.part.as_ref().map_or(0, |r| r.start));
        if !parts.iter().all(|p| p.finished) || parts.is_empty() {
            return Err(Mismatch::Foreign);
        }
        if parts.len() == 1 && parts[0].round.is_none() {
            let whole = parts.remove(0);
            let all = (0..whole.measurements.len()).collect();
            return Ok((whole, all));
        }
        let mut wanted = 0;
        let mut sums: Vec<Option<(Round, Stacks)>> = Vec::new();
        let mut whole: Option<Self> = None;
        for mut part in parts {
            let (Some(range), Some(round)) = (part.part.clone(), part.round.take()) else {
                return Err(Mismatch::Foreign);
            };
            match &range {
                r if r.start > wanted && !partial => return Err(Mismatch::Missing(wanted..r.start)),
                r if r.start < wanted => return Err(Mismatch::Twice(r.start..wanted.min(r.end))),
                r => wanted = r.end,
            }
            sums.resize_with(round.collected.len(), || None);
            for (sum, collected) in sums.iter_mut().zip(round.collected) {
                collected.put_to(sum);
            }
            let total = Self::batches(round.trees[0], round.trees.len());
            match &mut whole {
                None => whole = Some(Self { part: Some(0..total), ..part }),
                Some(w) if w.part != Some(0..total) => return Err(Mismatch::Foreign),
                Some(w) => {
                    w.done += part.done;
                    w.seconds += part.seconds;
                    w.tracing += part.tracing;
                }
            }
        }
        let mut whole = whole.ok_or(Mismatch::Foreign)?;
        let total = whole.part.take().map_or(0, |r| r.end);
        if wanted < total && !partial {
            return Err(Mismatch::Missing(wanted..total));
        }
        let there = (0..sums.len()).filter(|&i| sums[i].is_some()).collect();
        whole.close(sums.into_iter().flatten());
        Ok((whole, there))
    }

    /// Time spent so far, in all and on tracing, s.
    pub(super) fn times(&self) -> [f64; 2] {
        [self.seconds, self.tracing]
    }

    /// Whether there is more to trace; then a round is open. So much time has been spent, in all and on tracing, s.
    pub(super) fn open(&mut self, dome: Dome<'_>, [spent, tracing]: [f64; 2]) -> bool {
        if self.finished || self.round.is_some() {
            return !self.finished;
        }
        match self.course.next(spent, tracing) {
            None => self.finished = true,
            Some(trees) => {
                let forecast = self.course.forecast(tracing);
                let range = self.part.clone().unwrap_or(0..u32::MAX);
                let mut running = Running::new(trees, &range, dome);
                let ours: u64 = running.units(0, 0, &range).map(|u| u64::from(u.count)).sum();
                running.progress = Progress {
                    done: self.done,
                    total: forecast.map_or(self.done + ours, |f| f.trees),
                    incidences: 0,
                    seconds: 0.0,
                    error: self.course.error(),
                };
                self.round = Some(running);
            }
        }
        !self.finished
    }

    /// Units of the open round that are still to be traced.
    pub(super) fn units(&self, seed: u64) -> Vec<Unit> {
        let range = self.part.clone().unwrap_or(0..u32::MAX);
        let units = |r: &Running| r.units(seed, self.scramble, &range).skip(r.units).collect();
        self.round.as_ref().map(units).unwrap_or_default()
    }

    /// Takes what the next unit of the open round has yielded; so much time has been spent, in all and on tracing, s.
    pub(super) fn take(&mut self, unit: &Unit, tally: &Tally, stacks: &Stacks, [spent, tracing]: [f64; 2]) {
        (self.seconds, self.tracing) = (spent, tracing);
        if let Some(round) = &mut self.round {
            round.take(unit, tally, stacks, self.scramble);
            self.done += u64::from(unit.count);
            round.progress.done = self.done;
            round.progress.seconds = spent;
        }
    }

    /// How far the work is.
    pub(super) fn progress(&self) -> Option<Progress> {
        self.round.as_ref().map(|r| r.progress)
    }

    /// Ends the open round, all of which is traced.
    pub(super) fn end_round(&mut self) {
        if self.part.is_some() {
            self.finished = true;
            return;
        }
        let Some(round) = self.round.take() else { return };
        let mut sums: Vec<Option<(Round, Stacks)>> = vec![None; round.collected.len()];
        round.collected.into_iter().zip(&mut sums).for_each(|(collected, sum)| collected.put_to(sum));
        self.scramble += BATCHES;
        self.close(sums.into_iter().flatten());
        self.course.look(&self.measurements, &round.trees, self.tracing);
    }

    fn close(&mut self, sums: impl Iterator<Item = (Round, Stacks)>) {
        let first = self.measurements.is_empty();
        for (i, (round, stacks)) in sums.enumerate() {
            self.stacks.merge(&stacks);
            let closed = round.close();
            if first {
                self.measurements.push(closed);
            } else if closed.trees() > 0 {
                // Some incidences may have had no part in it.
                self.measurements[i].merge(&closed);
            }
        }
    }

    /// What the dome caught, per incidence.
    pub(super) fn measurements(&self) -> &[Measurement] {
        &self.measurements
    }

    /// Stacks of films that were met.
    pub(super) fn stacks(&self) -> &Stacks {
        &self.stacks
    }

    /// How it ended, if there was a goal.
    pub(super) fn ending(&self) -> Option<Ending> {
        self.course.ending()
    }
}

impl Running {
    fn new(trees: Vec<u64>, range: &Range<u32>, dome: Dome<'_>) -> Self {
        let mut first = 0;
        let collected = trees.iter().zip(dome.apertures).map(|(&trees, &apertures)| {
            let all = first..first + batches(trees);
            first = all.end;
            let empty = || Round::new(dome.shape, dome.level, apertures);
            match range {
                r if r.start <= all.start && all.end <= r.end => Collected::Sum(empty(), Stacks::default()),
                r if r.start < all.end && all.start < r.end => Collected::Apart(empty(), Vec::new()),
                _ => Collected::Nothing,
            }
        });
        let collected = collected.collect();
        Self { trees, collected, batch: Caught::new(dome.shape), units: 0, progress: Progress::default() }
    }

    /// All units of the batches in `range`; the first scramble of the round is `first`.
    fn units(&self, seed: u64, first: u32, range: &Range<u32>) -> impl Iterator<Item = Unit> + '_ {
        let range = range.clone();
        let batches =
            (0..).zip(&self.trees).flat_map(|(incidence, &n)| (0..batches(n)).map(move |i| (incidence, n, i)));
        let ours = (0..).zip(batches).filter(move |(number, _)| range.contains(number));
        ours.flat_map(move |(_, (incidence, trees, i))| {
            Unit::cut(Batch { seed, incidence, scramble: first + i }, trees_of_batch(trees, i))
        })
    }

    fn take(&mut self, unit: &Unit, tally: &Tally, stacks: &Stacks, first: u32) {
        self.units += 1;
        self.batch.tally.merge(tally);
        self.batch.stacks.merge(stacks);
        let Batch { scramble, incidence, .. } = unit.batch;
        let (trees, number) = (self.trees[incidence as usize], scramble - first);
        if unit.first + unit.count < trees_of_batch(trees, number) {
            return;
        }
        let batch = std::mem::replace(&mut self.batch, Caught::new(tally.shape()));
        match &mut self.collected[incidence as usize] {
            Collected::Sum(round, stacks) => {
                round.add(&batch.tally);
                stacks.merge(&batch.stacks);
            }
            Collected::Apart(_, batches) => batches.push(batch),
            Collected::Nothing => {}
        }
        if number + 1 == batches(trees) {
            self.progress.incidences += 1;
        }
    }
}

impl Collected {
    /// Adds it to what earlier batches have yielded.
    fn put_to(self, sum: &mut Option<(Round, Stacks)>) {
        match self {
            Self::Nothing => {}
            Self::Sum(round, stacks) => *sum = Some((round, stacks)),
            Self::Apart(empty, batches) => {
                let (round, stacks) = sum.get_or_insert((empty, Stacks::default()));
                for batch in batches {
                    round.add(&batch.tally);
                    stacks.merge(&batch.stacks);
                }
            }
        }
    }
}

impl Caught {
    fn new(shape: Shape) -> Self {
        Self { tally: Tally::new(shape), stacks: Stacks::default() }
    }
}

/// Number of scrambles for so many trees: each has at least one.
fn batches(trees: u64) -> u32 {
    trees.min(u64::from(BATCHES)) as u32
}

/// Trees of one scramble: all have the same, or one more.
fn trees_of_batch(trees: u64, scramble: u32) -> u32 {
    let n = u64::from(batches(trees));
    (trees / n + u64::from(u64::from(scramble) < trees % n)) as u32
}
