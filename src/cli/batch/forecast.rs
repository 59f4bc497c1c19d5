//! What measurements will take, from a few trees of each.

use std::time::Instant;

use gonio_embree::experiment::{Experiment, Goal, Settings};
use gonio_embree::units::significant;

use super::prepared::{Wanted, earlier};
use crate::cli::progress::duration;
use crate::cli::work::Work;
use crate::cli::{Failure, answer};

/// Trees of all incidences that are tried.
const TREES: u64 = 4096;
const FEWEST: u64 = 64;

/// What a few trees tell.
pub struct Forecast {
    /// Time that planning and writing take, s.
    pub planning: f64,
    /// Time of tracing, s.
    pub tracing: f64,
    /// Segments of a batch of each incidence, or of all of it if it has a target.
    pub segments: Vec<f64>,
    /// Trees of all incidences.
    pub trees: f64,
}

/// Work that is guessed without looking at the sample; of a measurement with a target nothing is known.
pub fn rough_work(job: &Wanted) -> f64 {
    let light = job.options.setup.light().map_or(1, |l| l.incidences.len());
    job.options.setup.settings().map_or(1.0, |s| (s.trees * light as u64) as f64)
}

impl Forecast {
    /// Tries some trees.
    pub fn new(work: &Work) -> Result<Self, Failure> {
        let start = Instant::now();
        let incidences = work.scene.light.incidences.len() as u64;
        let few = (TREES / incidences).max(FEWEST);
        let (trees, goal) = match work.settings.goal {
            // The first round tells what the error is.
            Some(goal) => (work.settings.trees, Some(Goal { max_rounds: Some(1.0), max_seconds: None, ..goal })),
            None => (few.min(work.settings.trees), None),
        };
        let settings = Settings { trees, goal, ..work.settings.clone() };
        let failed = |e: gonio_embree::experiment::Error| Failure::Cannot(e.to_string());
        let experiment = Experiment::new(&work.scene.sample, &work.scene.light, &settings).map_err(failed)?;
        let planning = start.elapsed().as_secs_f64();
        let mut state = experiment.start();
        experiment.advance(&mut state, |_, _| true);
        let tried = state.trees() as f64;
        let outcome = experiment.outcome(&state, None);
        let (seconds, segments) = (outcome.tracing_seconds, outcome.bsdf.incidences.iter().map(|s| s.segments as f64));
        if let Some(goal) = work.settings.goal {
            let error = |target: gonio_embree::experiment::Target| {
                let of = |s: &gonio_embree::bsdf::Scattering| target.of(&s.derived.precision) / target.error();
                outcome.bsdf.incidences.iter().map(of).fold(0.0, f64::max)
            };
            // A tenth more to see it twice.
            let times = goal.target.map_or(1.0, |t| (1.1 * error(t).powi(2)).max(1.1));
            let most = goal.max_seconds.unwrap_or(f64::INFINITY);
            let tracing = if goal.target.is_some() { (times * seconds).min(most) } else { most };
            return Ok(Self {
                planning,
                tracing,
                segments: vec![segments.sum::<f64>() * tracing / seconds],
                trees: tried * tracing / seconds,
            });
        }
        let times = work.settings.trees as f64 / trees as f64;
        Ok(Self {
            planning,
            tracing: times * seconds,
            segments: segments.map(|s| times * s).collect(),
            trees: times * tried,
        })
    }
}

/// Tells what would be measured.
pub fn run(wanted: &[Wanted], threads: usize) -> Result<(), Failure> {
    let width = wanted.iter().map(|w| w.name.chars().count()).max().unwrap_or(0).max("measurement".len());
    answer(&format!("{:<width$} {:>10} {:>12} {:>10}  state\n", "measurement", "incidences", "trees", "time"))?;
    let (mut all, mut wrong) = (0.0, Vec::new());
    for job in wanted {
        let told = job.work(threads).and_then(|work| {
            let (incidences, done) = (work.scene.light.incidences.len(), earlier(&work).is_some());
            let forecast = Forecast::new(&work)?;
            Ok((incidences, forecast, done))
        });
        let line = match told {
            Ok((incidences, forecast, done)) => {
                let time = forecast.planning + forecast.tracing;
                all += if done { 0.0 } else { time };
                let trees = significant(forecast.trees, 3);
                format!("{incidences:>10} {trees:>12} {:>10}  {}", duration(time), if done { "done" } else { "" })
            }
            Err(e) => {
                wrong.push(format!("{}: {e}", job.name));
                format!("{:>10} {:>12} {:>10}  cannot be measured", "", "", "")
            }
        };
        answer(&format!("{}\n", format!("{:<width$} {line}", job.name).trim_end()))?;
    }
    answer(&format!("{} measurements, about {} with {threads} threads\n", wanted.len(), duration(all)))?;
    if wrong.is_empty() { Ok(()) } else { Err(Failure::Input(wrong.join("\n"))) }
}
