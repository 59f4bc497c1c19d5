//! At how many interfaces of a tree both beams are followed: what gives the least error for the same work, found by a pilot.
//!
//! Following both takes more work and leaves less to chance. Which counts for more depends on the sample: behind the first
//! interface of a glass sphere the faint reflections carry most of the noise; in a thick packing nothing is gained.

use super::course::Course;
use super::gather::advance;
use super::state::State;
use super::{BATCHES, Bench, Settings};
use crate::dome::{Measurement, Noise, RESOLUTION};
use crate::plan::{Limits, Plan};

/// What is tried, the least work first.
const CANDIDATES: [u32; 6] = [1, 2, 3, 4, 6, 8];
/// Of scores that differ by less the higher number counts: rare paths make the noise of few splits look smaller than it is.
const EQUAL: f64 = 1.25;
/// Where a tree takes so many times the work of the first trial and is not the best, nothing better follows.
const HEAVY: f64 = 3.0;
/// Trees of the measurement per tree of a pilot, and the fewest and the most of a pilot that is worth its while.
const SHARE: u64 = 96;
const FEWEST: u64 = 512;
const MOST: u64 = 4096;
/// A pilot's scrambles begin where neither a measurement nor another pilot gets.
const FIRST_SCRAMBLE: u32 = 1 << 17;

/// The plan with the best number of splits, if nobody has chosen one.
pub fn choose(bench: &Bench<'_>, mut plan: Plan) -> Plan {
    let trees = (bench.settings.trees / SHARE).min(MOST).next_multiple_of(u64::from(BATCHES));
    if plan.limits.splits.is_some() || trees < FEWEST {
        return plan;
    }
    let settings = Settings {
        trees,
        goal: None,
        dome_level: bench.settings.dome_level.min(RESOLUTION),
        arm: None,
        ..bench.settings.clone()
    };
    let pilot = Bench { settings: &settings, ..bench.clone() };
    let mut trials: Vec<Trial> = Vec::new();
    for splits in CANDIDATES {
        plan.limits = Limits { splits: Some(splits), ..plan.limits };
        trials.push(Trial::new(&pilot, &plan, splits));
        let scores = scores(&trials);
        let least = scores.iter().copied().fold(f64::INFINITY, f64::min);
        let last = trials.len() - 1;
        if scores[last] > EQUAL * least && trials[last].segments > HEAVY * trials[0].segments {
            break;
        }
    }
    let scores = scores(&trials);
    let least = scores.iter().copied().fold(f64::INFINITY, f64::min);
    let mut equal = trials.iter().zip(scores).filter(|(_, score)| *score > 0.0 && *score <= EQUAL * least);
    plan.limits.splits = equal.next_back().map(|(trial, _)| trial.splits);
    plan
}

/// What a number of splits gave.
struct Trial {
    splits: u32,
    segments: f64,
    /// Of all incidences.
    noises: Vec<[Noise; 4]>,
}

impl Trial {
    fn new(bench: &Bench<'_>, plan: &Plan, splits: u32) -> Self {
        let course = Course::new(None, bench.settings.trees, bench.light.incidences.len());
        let mut state = State::new(course, None, 0.0, FIRST_SCRAMBLE);
        advance(bench, plan, &mut state, |_, _| true);
        let measurements = state.measurements();
        let segments = measurements.iter().map(|m| m.segments() as f64).sum();
        Self { splits, segments, noises: measurements.iter().map(Measurement::noises).collect() }
    }
}

/// Square of the error times the work, of each trial: of what has the greatest relative error, mean of all incidences. What
/// the signal is, all trials tell together.
fn scores(trials: &[Trial]) -> Vec<f64> {
    let incidences = trials.first().map_or(0, |t| t.noises.len());
    let mut scores = vec![0.0; trials.len()];
    for i in 0..incidences {
        let relative = |k: usize| {
            let sum = |of: fn(&Noise) -> f64| trials.iter().map(|t| of(&t.noises[i][k])).sum::<f64>();
            let (signal, noise) = (sum(|n| n.signal), sum(|n| n.noise));
            let signal = signal.max(1e-3 * noise);
            let judged = trials.iter().all(|t| t.noises[i][k].judged) && signal > 0.0;
            trials.iter().map(|t| if judged { t.noises[i][k].noise / signal } else { 0.0 }).collect::<Vec<f64>>()
        };
        let all = [0, 1, 2, 3].map(relative);
        for (at, (score, trial)) in scores.iter_mut().zip(trials).enumerate() {
            *score += trial.segments * all.iter().map(|r| r[at]).fold(0.0, f64::max);
        }
    }
    scores
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trial(splits: u32, segments: f64, noise: f64) -> Trial {
        let of = |noise| Noise { signal: 1.0, noise, judged: true };
        Trial { splits, segments, noises: vec![[of(noise), of(0.1 * noise), of(0.0), of(0.0)]] }
    }

    #[test]
    fn the_score_is_the_work_for_an_error() {
        let scores = scores(&[trial(0, 100.0, 0.4), trial(1, 200.0, 0.1), trial(2, 400.0, 0.1)]);
        assert!(scores[1] < 0.51 * scores[0] && scores[1] < 0.51 * scores[2], "{scores:?}");
    }
}
