//! The tracing of a whole measurement: tallies are put together in their order, units into batches, batches into
//! measurements.

use std::time::Instant;

use super::apart::apart;
use super::{BATCHES, Bench, Progress, Settings};
use crate::dome::{Apart, Detector, Locator, Measurement, Shape, Tally};
use crate::light::Light;
use crate::optics::field::Field;
use crate::trace::{Batch, Effects, Job, Kernel, Stacks, Unit, run};

/// The work, and what it has yielded.
pub struct Gather<'b, 'k, W> {
    bench: &'b Bench<'b>,
    kernel: &'b Kernel<'k>,
    start: Instant,
    watch: W,
}

/// What the dome caught.
pub struct Gathered {
    /// One per incidence.
    pub measurements: Vec<Measurement>,
    /// Stacks of films met.
    pub stacks: Stacks,
    batch: Tally,
    progress: Progress,
}

impl<'b, 'k, W: FnMut(Progress)> Gather<'b, 'k, W> {
    /// The work of a kernel; `watch` is told how far it is.
    pub fn new(bench: &'b Bench<'b>, kernel: &'b Kernel<'k>, start: Instant, watch: W) -> Self {
        Self { bench, kernel, start, watch }
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
        let units: Vec<Unit> = units(light, settings).collect();
        let make = || Detector::new(&locator, shape, &apart);
        let mut gathered = Gathered::new(settings, shape, &apart);
        run::<F, E, _>(self.kernel, light, &units, pool, make, |unit, tally, stacks| {
            gathered.stacks.merge(&stacks);
            gathered.take(unit, &tally, settings.trees);
            gathered.progress.seconds = self.start.elapsed().as_secs_f64();
            (self.watch)(gathered.progress);
            true
        });
        gathered
    }
}

impl Gathered {
    fn new(settings: &Settings, shape: Shape, apart: &[Apart]) -> Self {
        let total = settings.trees * apart.len() as u64;
        let measurement = |apart: &Apart| Measurement::new(shape, settings.dome_level, apart.apertures.len());
        Self {
            measurements: apart.iter().map(measurement).collect(),
            stacks: Stacks::default(),
            batch: Tally::new(shape),
            progress: Progress { done: 0, total, incidences: 0, seconds: 0.0 },
        }
    }

    fn take(&mut self, unit: &Unit, tally: &Tally, trees: u64) {
        self.batch.merge(tally);
        let Batch { scramble, incidence, .. } = unit.batch;
        if unit.first + unit.count == trees_of_batch(trees, scramble) {
            let batch = std::mem::replace(&mut self.batch, Tally::new(tally.shape()));
            self.measurements[incidence as usize].add(&batch);
            if scramble + 1 == batches(trees) {
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

fn units<'a>(light: &'a Light, settings: &'a Settings) -> impl Iterator<Item = Unit> + 'a {
    let Settings { seed, trees, .. } = *settings;
    (0..light.incidences.len() as u32).flat_map(move |incidence| {
        (0..batches(trees))
            .flat_map(move |scramble| Unit::cut(Batch { seed, incidence, scramble }, trees_of_batch(trees, scramble)))
    })
}
