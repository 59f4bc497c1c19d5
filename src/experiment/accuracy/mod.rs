//! What accuracy costs: the same measurement in many ways, each compared with the truth, or with a far longer measurement.

mod grid;
mod meter;
mod rungs;
mod truth;

use std::fmt;

use super::{Bench, Error, Settings, measure};
use crate::light::Light;
use crate::plan::Plan;
use crate::sample::problem::Problems;
use crate::sample::{Description, Sample};

pub use grid::{Distance, Values};
pub use meter::{Cost, metered};
pub use rungs::{BASE, TREES};
use rungs::{Rung, rungs};

/// How much is done.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Effort {
    /// Measurements of each setting, each with its own seed.
    pub seeds: u64,
    /// How many times the trees of the measurement as given the reference has.
    pub reference: u64,
    /// Time for all of it, s: if it would take longer, all have fewer trees.
    pub seconds: Option<f64>,
}

impl Effort {
    /// Enough for a paper.
    pub const FULL: Self = Self { seeds: 10, reference: 30, seconds: None };
    /// Enough to see what matters, in two minutes.
    pub const QUICK: Self = Self { seeds: 3, reference: 30, seconds: Some(110.0) };
}

/// What one setting gave.
#[derive(Clone, Debug, PartialEq)]
pub struct Point {
    /// What is varied; [`BASE`] is the measurement as given.
    pub knob: &'static str,
    /// To what: an option of the command line, which begins with dashes, or words.
    pub setting: String,
    /// Root of the mean square of the errors of all seeds.
    pub error: Distance,
    /// Standard deviation of the error of the whole from seed to seed.
    pub spread: f64,
    /// What of the error stays however many trees are traced, as far as it can be told from noise; else 0.
    pub floor: f64,
    /// Largest share of the light that was lost.
    pub lost: f64,
    /// Cost of one measurement: the least time of all, and the most memory.
    pub cost: Cost,
    /// Trees per incidence.
    pub trees: u64,
}

/// What the points are compared with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reference {
    /// A formula.
    Formula,
    /// A measurement of so many trees per incidence, with another seed; its own error of the whole.
    Longer(u64, f64),
}

/// A measurement in many ways.
#[derive(Clone, Debug, PartialEq)]
pub struct Ladder {
    /// The measurement as given first.
    pub points: Vec<Point>,
    /// What they are compared with.
    pub reference: Reference,
    /// Measurements of each.
    pub seeds: u64,
    /// Threads.
    pub threads: usize,
}

impl Point {
    /// Square of what of the error more trees would lower.
    pub fn noise_square(&self) -> f64 {
        (self.error.whole * self.error.whole - self.floor * self.floor).max(0.0)
    }
}

impl Ladder {
    /// Time that a measurement takes whatever the number of its trees, s: from those with fewer and with more.
    pub fn fixed_seconds(&self) -> f64 {
        let rungs: Vec<&Point> = self.points.iter().filter(|p| [BASE, TREES].contains(&p.knob)).collect();
        let n = rungs.len() as f64;
        let mean = |of: fn(&Point) -> f64| rungs.iter().map(|p| of(p)).sum::<f64>() / n;
        let (x, y) = (mean(|p| p.trees as f64), mean(|p| p.cost.seconds));
        let slope = rungs.iter().map(|p| (p.trees as f64 - x) * (p.cost.seconds - y)).sum::<f64>()
            / rungs.iter().map(|p| (p.trees as f64 - x).powi(2)).sum::<f64>();
        let least = rungs.iter().map(|p| p.cost.seconds).fold(f64::INFINITY, f64::min);
        (y - slope * x).clamp(0.0, 0.9 * least)
    }

    /// Time a setting takes for an error, s; endless if its floor is higher.
    pub fn seconds_for(&self, point: &Point, error: f64) -> f64 {
        let room = error * error - point.floor * point.floor;
        let fixed = self.fixed_seconds();
        if room <= 0.0 { f64::INFINITY } else { fixed + (point.cost.seconds - fixed) * point.noise_square() / room }
    }

    /// Whether no other setting is both faster and better.
    pub fn is_on_front(&self, point: &Point) -> bool {
        let beats = |p: &Point| {
            p.cost.seconds <= point.cost.seconds && p.error.whole <= point.error.whole && !std::ptr::eq(p, point)
        };
        !self.points.iter().any(beats)
    }
}

/// Why there is no ladder.
#[derive(Debug)]
pub enum LadderError {
    /// The sample cannot be had in the light of a rung.
    Sample(Problems),
    /// It cannot be measured.
    Measure(Error),
}

impl fmt::Display for LadderError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Sample(e) => e.fmt(f),
            Self::Measure(e) => e.fmt(f),
        }
    }
}

impl std::error::Error for LadderError {}

/// How far a ladder is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Climbed {
    /// Measurements done, and all of them.
    pub done: usize,
    /// All of them.
    pub total: usize,
    /// Seconds since the start.
    pub seconds: f64,
}

/// Seed of the reference: none of a point comes near it.
const REFERENCE_SEED: u64 = 1 << 40;
/// A floor is told if it is beyond what its own noise explains by so many standard deviations.
const SIGMAS: f64 = 3.0;
/// Trees by which the time of all is estimated.
const TRIAL: u64 = 4096;
/// Time of all measurements in those as given, without the reference: some settings take longer.
const WORK_PER_SEED: f64 = 60.0;

/// Measures the sample in many ways; `watch` is told how far it is.
///
/// # Errors
/// When the sample cannot be had in some light, or the backend cannot work.
pub fn climb(
    description: &Description,
    light: &Light,
    settings: &Settings,
    effort: &Effort,
    mut watch: impl FnMut(Climbed),
) -> Result<Ladder, LadderError> {
    let start = std::time::Instant::now();
    let mut settings = Settings { goal: None, arm: None, ..settings.clone() };
    let whole = sample(description, light)?;
    settings.backend = settings.backend.fit(&whole.primitives, whole.domain);
    let (plan, rate) = trial(description, light, &settings)?;
    // As a long measurement has it: what is told of errors and times is to hold for more trees, too.
    settings.options.limits.splits = plan.limits.splits;
    if let Some(seconds) = effort.seconds {
        let work = effort.reference as f64 + WORK_PER_SEED * effort.seeds as f64;
        settings.trees = settings.trees.min((seconds * rate / work) as u64).max(TRIAL);
    }
    let all = rungs(&settings, light, &plan);
    let total = all.len() * effort.seeds as usize + 1;
    let nm = light.wavelengths.nm();
    let (values, reference) = reference(description, light, &settings, effort)?;
    let mut done = 1;
    let mut points = Vec::new();
    for rung in &all {
        points.push(point(description, rung, effort.seeds, (nm, &values), || {
            done += 1;
            watch(Climbed { done, total, seconds: start.elapsed().as_secs_f64() });
        })?);
    }
    Ok(Ladder { points, reference, seeds: effort.seeds, threads: settings.threads })
}

fn sample(description: &Description, light: &Light) -> Result<Sample, LadderError> {
    Sample::new(description, &light.wavelengths, light.coherence()).map_err(LadderError::Sample)
}

/// The plan, and trees of each incidence per second.
fn trial(description: &Description, light: &Light, settings: &Settings) -> Result<(Plan, f64), LadderError> {
    let few = Settings { trees: settings.trees.min(TRIAL), ..settings.clone() };
    let outcome = measure(&sample(description, light)?, light, &few, |_| {}).map_err(LadderError::Measure)?;
    // Of the plan counts that of a long measurement, whose pilots are larger.
    let sample = sample(description, light)?;
    let long = Settings { trees: settings.trees.max(Settings::default().trees), ..settings.clone() };
    let plan = Bench::new(&sample, light, &long).map_err(LadderError::Measure)?.plan();
    Ok((plan, few.trees as f64 / outcome.tracing_seconds))
}

/// The truth, or what comes next to it.
fn reference(
    description: &Description,
    light: &Light,
    settings: &Settings,
    effort: &Effort,
) -> Result<(Values, Reference), LadderError> {
    if let Some(values) = truth::of(description, &sample(description, light)?, light) {
        return Ok((values, Reference::Formula));
    }
    let trees = effort.reference * settings.trees;
    let settings = Settings { trees, seed: settings.seed ^ REFERENCE_SEED, ..settings.clone() };
    let outcome = measure(&sample(description, light)?, light, &settings, |_| {}).map_err(LadderError::Measure)?;
    let error = outcome.bsdf.incidences.iter().map(|s| s.derived.precision.whole).fold(0.0, f64::max);
    Ok((Values::measured(&outcome, light.wavelengths.nm()), Reference::Longer(trees, error)))
}

/// Measures by one setting, once for each seed.
fn point(
    description: &Description,
    rung: &Rung,
    seeds: u64,
    (nm, truth): (&[f64], &Values),
    mut watch: impl FnMut(),
) -> Result<Point, LadderError> {
    let mut sum = Values::default();
    let (mut squares, mut raw_squares) = (Vec::new(), Vec::new());
    let (mut cost, mut lost) = (None, 0.0f64);
    for i in 0..seeds {
        let settings = Settings { seed: rung.settings.seed + i, ..rung.settings.clone() };
        let (outcome, spent) = metered(|| -> Result<_, LadderError> {
            let sample = sample(description, &rung.light)?;
            measure(&sample, &rung.light, &settings, |_| {}).map_err(LadderError::Measure)
        });
        let outcome = outcome?;
        let domes = outcome.bsdf.incidences.iter().map(|s| &s.facets[..]);
        squares.push(Values::new(&outcome.bsdf, domes, nm).squares(truth));
        let raw = Values::measured(&outcome, nm);
        raw_squares.push(raw.squares(truth));
        sum.add(&raw);
        lost = lost.max(outcome.bsdf.largest_loss());
        cost = cost.map_or(Some(spent), |c: Cost| Some(c.least(spent)));
        watch();
    }
    let n = seeds as f64;
    let mean = |all: &[[f64; 4]]| std::array::from_fn(|part| all.iter().map(|s| s[part]).sum::<f64>() / n);
    let error = truth.distance(mean(&squares));
    let wholes: Vec<f64> = squares.iter().map(|&s| truth.distance(s).whole).collect();
    let average = wholes.iter().sum::<f64>() / n;
    let spread = (wholes.iter().map(|w| (w - average) * (w - average)).sum::<f64>() / (n - 1.0).max(1.0)).sqrt();
    // What more trees would lower is no floor of a number of trees.
    let floor = if rung.knob == TREES { 0.0 } else { floor(&sum.over(n), truth, mean(&raw_squares), n) };
    Ok(Point {
        knob: rung.knob,
        setting: rung.setting.clone(),
        error,
        spread,
        floor,
        lost,
        cost: cost.unwrap_or_default(),
        trees: rung.settings.trees,
    })
}

/// What of the error all seeds share: the distance of their mean from the truth, without the noise that is left in it.
fn floor(average: &Values, truth: &Values, mean: [f64; 4], seeds: f64) -> f64 {
    let of_average = average.squares(truth);
    let told: [f64; 4] = std::array::from_fn(|part| {
        // Squares of an error: mean = shared + noise, of_average = shared + noise/seeds.
        let noise = ((mean[part] - of_average[part]) * seeds / (seeds - 1.0).max(1.0)).max(0.0);
        let shared = mean[part] - noise;
        let doubt = noise / seeds + truth.noise(part);
        if shared > SIGMAS * doubt { shared } else { 0.0 }
    });
    truth.distance(told).whole
}
