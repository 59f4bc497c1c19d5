//! The tracing of a whole measurement: tallies are put together in their order, units into batches, batches into rounds,
//! rounds into measurements.

use std::time::Instant;

use super::apart::apart;
use super::course::{Course, Ending};
use super::{BATCHES, Bench, Progress};
use crate::dome::{Apart, Detector, Locator, Measurement, Round, Shape, Tally};
use crate::optics::field::Field;
use crate::trace::{Batch, Effects, Job, Kernel, Stacks, Unit, run};

/// The work, and what it has yielded.
pub struct Gather<'b, 'k, W> {
    bench: &'b Bench<'b>,
    kernel: &'b Kernel<'k>,
    start: Instant,
    watch: W,
    /// Number of the first scramble.
    scramble: u32,
}

/// What the dome caught.
pub struct Gathered {
    /// One per incidence.
    pub measurements: Vec<Measurement>,
    /// Stacks of films met.
    pub stacks: Stacks,
    /// How it ended, if there was a goal.
    pub ending: Option<Ending>,
}

/// What a round has yielded so far.
struct Gathering {
    rounds: Vec<Round>,
    stacks: Stacks,
    batch: Tally,
    progress: Progress,
}

impl<'b, 'k, W: FnMut(Progress)> Gather<'b, 'k, W> {
    /// The work of a kernel; `watch` is told how far it is.
    pub fn new(bench: &'b Bench<'b>, kernel: &'b Kernel<'k>, start: Instant, watch: W) -> Self {
        Self { bench, kernel, start, watch, scramble: 0 }
    }

    /// With other scrambles, beginning at this one.
    pub fn from_scramble(self, scramble: u32) -> Self {
        Self { scramble, ..self }
    }
}

impl<W: FnMut(Progress)> Job for Gather<'_, '_, W> {
    type Yield = Gathered;

    fn run<F: Field, E: Effects>(mut self) -> Gathered {
        let Bench { sample, light, settings, pool, .. } = self.bench;
        let plan = self.kernel.plan();
        let groups = if plan.kernel.absorbs { sample.groups.names.len() } else { 0 };
        let shape = Shape { lanes: self.kernel.lanes(), components: F::COMPONENTS, groups };
        let locator = Locator::new(settings.dome_level);
        let arm = settings.arm.as_ref();
        let apart: Vec<Apart> = light.incidences.iter().map(|i| apart(sample, plan, i, arm)).collect();
        let make = || Detector::new(&locator, shape, &apart);
        let mut course = Course::new(settings.goal, settings.trees, apart.len());
        let (mut measurements, mut stacks): (Vec<Measurement>, _) = (Vec::new(), Stacks::default());
        let tracing = Instant::now();
        let (mut done, mut scramble) = (0, self.scramble);
        let seconds = |since: Instant| since.elapsed().as_secs_f64();
        while let Some(round) = course.next(seconds(self.start), seconds(tracing)) {
            let units: Vec<Unit> = units(settings.seed, &round, scramble).collect();
            let forecast = course.forecast(seconds(tracing));
            let mut gathering = Gathering {
                rounds: apart.iter().map(|a| Round::new(shape, settings.dome_level, a.apertures.len())).collect(),
                stacks: Stacks::default(),
                batch: Tally::new(shape),
                progress: Progress {
                    done,
                    total: forecast.map_or(done + round.iter().sum::<u64>(), |f| f.trees),
                    incidences: 0,
                    seconds: 0.0,
                    error: course.error(),
                },
            };
            run::<F, E, _>(self.kernel, light, &units, pool, make, |unit, tally, stacks| {
                gathering.stacks.merge(&stacks);
                gathering.take(unit, &tally, &round, scramble);
                gathering.progress.seconds = seconds(self.start);
                (self.watch)(gathering.progress);
                true
            });
            done = gathering.progress.done;
            scramble += BATCHES;
            stacks.merge(&gathering.stacks);
            let closed = gathering.rounds.into_iter().map(Round::close);
            if measurements.is_empty() {
                measurements = closed.collect();
            } else {
                // Some incidences may have had no part in it.
                let traced = measurements.iter_mut().zip(closed).filter(|(_, later)| later.trees() > 0);
                traced.for_each(|(m, later)| m.merge(&later));
            }
            course.look(&measurements, &round, seconds(tracing));
        }
        Gathered { measurements, stacks, ending: course.ending() }
    }
}

impl Gathering {
    /// Takes what a unit has yielded, of a round whose first scramble is `first`.
    fn take(&mut self, unit: &Unit, tally: &Tally, round: &[u64], first: u32) {
        self.batch.merge(tally);
        let Batch { scramble, incidence, .. } = unit.batch;
        let trees = round[incidence as usize];
        if unit.first + unit.count == trees_of_batch(trees, scramble - first) {
            let batch = std::mem::replace(&mut self.batch, Tally::new(tally.shape()));
            self.rounds[incidence as usize].add(&batch);
            if scramble - first + 1 == batches(trees) {
                self.progress.incidences += 1;
            }
        }
        self.progress.done += u64::from(unit.count);
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

/// Units of a round of so many trees per incidence, whose first scramble is `first`.
fn units(seed: u64, round: &[u64], first: u32) -> impl Iterator<Item = Unit> + '_ {
    (0..).zip(round).flat_map(move |(incidence, &trees)| {
        (0..batches(trees))
            .flat_map(move |i| Unit::cut(Batch { seed, incidence, scramble: first + i }, trees_of_batch(trees, i)))
    })
}
