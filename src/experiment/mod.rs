//! The order of work: plan, trace, evaluate.

mod provenance;

use std::time::Instant;

use glam::DVec3;

use crate::bsdf::Bsdf;
use crate::dome::{Delta, Detector, Locator, Measurement, Rule, Tally};
use crate::intersect::Scene;
use crate::intersect::choose::{Backend, BackendError};
use crate::light::{Incidence, Light};
use crate::optics::field::{Field, Jones, Stokes};
use crate::optics::fresnel;
use crate::plan::{self, Plan, State};
use crate::sample::Sample;
use crate::trace::{Batch, Kernel, Stacks, Unit, run};

pub use provenance::Origin;

/// Independent scrambles per incidence.
pub const BATCHES: u32 = 32;

/// What the user decides besides sample and light.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Trees per incidence.
    pub trees: u64,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Threads.
    pub threads: usize,
    /// Who intersects.
    pub backend: Backend,
    /// Finest level of the dome.
    pub dome_level: u8,
    /// What is simulated.
    pub options: plan::Options,
}

impl Default for Settings {
    /// Those of the command line.
    fn default() -> Self {
        Self {
            trees: 200_000,
            seed: 1,
            threads: std::thread::available_parallelism().map_or(1, usize::from),
            backend: Backend::auto(),
            dome_level: 5,
            options: plan::Options::default(),
        }
    }
}

/// What came out besides the BSDF.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The result.
    pub bsdf: Bsdf,
    /// The plan it was made by.
    pub plan: Plan,
    /// Stacks of films met.
    pub stacks: Stacks,
    /// Wall time, s.
    pub seconds: f64,
    /// Part of it spent on tracing, s.
    pub tracing_seconds: f64,
}

/// How far the work is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// Trees traced, of all incidences.
    pub done: u64,
    /// Trees to trace.
    pub total: u64,
    /// Incidences completed.
    pub incidences: usize,
    /// Seconds since the start.
    pub seconds: f64,
}

/// Measures `sample` under `light`; `watch` is told how far the work is.
///
/// # Errors
/// When the backend cannot work.
pub fn measure(
    sample: &Sample,
    light: &Light,
    settings: &Settings,
    watch: impl FnMut(Progress),
) -> Result<Outcome, BackendError> {
    let start = Instant::now();
    let scene = Scene::new(sample.primitives.clone(), sample.domain, settings.backend)?;
    let plan = Plan::new(sample, light, &settings.options);
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(settings.threads)
        .build()
        .map_err(|e| BackendError::Library(format!("cannot start {} threads: {e}", settings.threads)))?;
    let kernel = Kernel::new(sample, &scene, &plan, light);
    let tracing = Instant::now();
    let mut gather = Gather::new(light, &plan, settings, start, watch);
    match plan.state {
        State::Stokes => gather.run::<Stokes>(sample, light, settings, &kernel, &pool),
        State::Jones => gather.run::<Jones>(sample, light, settings, &kernel, &pool),
    }
    let tracing_seconds = tracing.elapsed().as_secs_f64();
    let bsdf = Bsdf::new(light, &gather.measurements, &plan, &Rule::default());
    let stacks = gather.stacks;
    Ok(Outcome { bsdf, plan, stacks, seconds: start.elapsed().as_secs_f64(), tracing_seconds })
}

/// Puts tallies together in their order: units into batches, batches into measurements.
struct Gather<W> {
    measurements: Vec<Measurement>,
    batch: Tally,
    stacks: Stacks,
    lanes: usize,
    trees: u64,
    progress: Progress,
    start: Instant,
    watch: W,
}

impl<W: FnMut(Progress)> Gather<W> {
    fn new(light: &Light, plan: &Plan, settings: &Settings, start: Instant, watch: W) -> Self {
        let lanes = plan.lanes.len();
        let measurement = |_: &Incidence| Measurement::new(lanes, settings.dome_level);
        let total = settings.trees * light.incidences.len() as u64;
        Self {
            measurements: light.incidences.iter().map(measurement).collect(),
            batch: Tally::new(lanes),
            stacks: Stacks::default(),
            lanes,
            trees: settings.trees,
            progress: Progress { done: 0, total, incidences: 0, seconds: 0.0 },
            start,
            watch,
        }
    }

    fn run<F: Field>(
        &mut self,
        sample: &Sample,
        light: &Light,
        settings: &Settings,
        kernel: &Kernel<'_>,
        pool: &rayon::ThreadPool,
    ) {
        let locator = Locator::new(settings.dome_level);
        let deltas: Vec<Delta> = light.incidences.iter().map(|i| delta(sample, kernel.plan(), i)).collect();
        let units: Vec<Unit> = units(light, settings).collect();
        let make = || Detector::new(&locator, kernel.lanes(), &deltas);
        run::<F, _>(kernel, light, &units, pool, make, |unit, tally, stacks| {
            self.stacks.merge(&stacks);
            self.deliver(unit, &tally);
            true
        });
    }

    fn deliver(&mut self, unit: &Unit, tally: &Tally) {
        self.batch.merge(tally);
        let Batch { scramble, incidence, .. } = unit.batch;
        let batch_trees = trees_of_batch(self.trees, scramble);
        if unit.first + unit.count == batch_trees {
            let batch = std::mem::replace(&mut self.batch, Tally::new(self.lanes));
            self.measurements[incidence as usize].add(&batch);
            if scramble + 1 == batches(self.trees) {
                self.progress.incidences += 1;
            }
        }
        self.progress.done += u64::from(unit.count);
        self.progress.seconds = self.start.elapsed().as_secs_f64();
        (self.watch)(self.progress);
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

/// The mirror direction, and the straight one behind the sample per lane; unreachable where refraction is total.
fn delta(sample: &Sample, plan: &Plan, incidence: &Incidence) -> Delta {
    let d = incidence.propagation();
    let index =
        |medium: crate::sample::MediumId, wavelength: usize| sample.media[usize::from(medium.0)].index[wavelength].re;
    let straight = |&wavelength: &usize| {
        let (n1, n2) = (index(sample.above, wavelength), index(sample.below, wavelength));
        if n1 == n2 {
            return d;
        }
        fresnel::refracted_cos(n1, n2, -d.z, fresnel::other_leg(-d.z))
            .map_or(DVec3::ZERO, |cos| (n1 / n2 * d).with_z(-cos))
    };
    Delta { specular: d.with_z(-d.z), undeflected: plan.lanes.iter().map(straight).collect() }
}
