//! How many trees are traced, round by round: as many as were asked for, or until a stated error is reached.
//!
//! What is decided between rounds follows from the statistics of all rounds before alone, so that the same command gives
//! the same result on any machine. Only running out of time does not; how far a measurement got then is a number of
//! rounds, which can be asked for ([`Goal::max_rounds`]).

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use super::BATCHES;
use crate::dome::{Measurement, Precision};
use crate::units::{percentage, show_percentage};

/// What error is aimed at; 95 of 100 measurements do not exceed it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Target {
    /// Of the BRDF and the BTDF over the dome, and of all reflected and all transmitted light ([`Precision::whole`]).
    Whole(f64),
    /// Of the worst facet ([`Precision::facet`]).
    Facet(f64),
}

impl Target {
    /// The error that is asked for.
    pub fn error(self) -> f64 {
        match self {
            Self::Whole(error) | Self::Facet(error) => error,
        }
    }

    /// The error that is there.
    pub fn of(self, precision: &Precision) -> f64 {
        match self {
            Self::Whole(_) => precision.whole,
            Self::Facet(_) => precision.facet,
        }
    }
}

impl fmt::Display for Target {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let facet = if matches!(self, Self::Facet(_)) { "facet:" } else { "" };
        write!(f, "{facet}{}", show_percentage(self.error()))
    }
}

impl FromStr for Target {
    type Err = String;

    fn from_str(s: &str) -> Result<Self, String> {
        let (text, make): (&str, fn(f64) -> Self) = match s.strip_prefix("facet:") {
            Some(rest) => (rest, Self::Facet),
            None => (s, Self::Whole),
        };
        match percentage(text) {
            Some(error) if error > 0.0 && error < 1.0 => Ok(make(error)),
            _ => Err(format!("`{s}`: expected an error greater than 0 and less than 100 %, such as 1% or facet:5%")),
        }
    }
}

/// When enough is traced, if not after a fixed number of trees.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Goal {
    /// When this is reached.
    pub target: Option<Target>,
    /// When so much time has passed, s.
    pub max_seconds: Option<f64>,
    /// After so many rounds, as a measurement without time had; of the last one a part.
    pub max_rounds: Option<f64>,
}

/// How a measurement with a goal has ended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Ending {
    /// Whether the target is reached.
    pub reached: bool,
    /// Whether it ended because of its time, or of the number of its rounds, and would else have gone on.
    pub out_of_time: bool,
    /// Rounds traced; of the last one it may be a part.
    pub rounds: f64,
    /// What was forecast as soon as it could be relied on, and the time that had been spent on tracing then, s.
    pub forecast: Option<(Forecast, f64)>,
}

/// What is still to come, for all incidences.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Forecast {
    /// Trees in all, those that are traced included.
    pub trees: u64,
    /// Time from now on, s.
    pub seconds: f64,
}

/// Trees of each incidence in the first round.
const FIRST: u64 = 4096;
/// After so many trees per incidence, or this part of what is needed, a forecast can be relied on: before, few rare paths have
/// been seen, and time goes to what is done only once.
const PILOT: u64 = 131_072;
const PILOT_PART: u64 = 4;
/// Forecasts of more trees are none.
const MOST_TREES: f64 = 1e15;
/// What is reached once must be reached again after so many more trees.
const CONFIRM: f64 = 0.1;
/// A round aims beyond the target: what an error will be is itself only estimated.
const MARGIN: f64 = 1.05;
/// An incidence has at most so many times its trees after a round.
const MOST: f64 = 4.0;
/// Where a round would take too long: parts of it, the first of which that fits is traced.
const PARTS: [f64; 4] = [1.0, 0.5, 0.25, 0.125];

/// Where an incidence stands.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
struct Standing {
    trees: u64,
    segments: u64,
    error: f64,
    /// Times in a row that the target was seen to be reached.
    passes: u32,
}

/// The course of a measurement.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Course {
    goal: Option<Goal>,
    fixed: u64,
    standings: Vec<Standing>,
    rounds: f64,
    out_of_time: bool,
    /// After the first rounds, and the time they have taken, s.
    forecast: Option<(Forecast, f64)>,
}

impl Course {
    /// Of `incidences`: until `goal` is reached, or, without one, `fixed` trees each.
    pub fn new(goal: Option<Goal>, fixed: u64, incidences: usize) -> Self {
        let standings = vec![Standing::default(); incidences];
        Self { goal, fixed, standings, rounds: 0.0, out_of_time: false, forecast: None }
    }

    /// Goes on until another goal is reached.
    pub fn aim(&mut self, goal: Option<Goal>) {
        self.goal = goal;
        self.out_of_time = false;
    }

    /// Trees of each incidence in the next round, if there is one. `seconds` have passed since the start, `tracing` of them
    /// by tracing.
    pub fn next(&mut self, seconds: f64, tracing: f64) -> Option<Vec<u64>> {
        let first = self.rounds == 0.0;
        let Some(goal) = self.goal else {
            self.rounds = 1.0;
            return first.then(|| vec![self.fixed; self.standings.len()]);
        };
        let whole = if first { vec![FIRST; self.standings.len()] } else { self.round() };
        if self.out_of_time || whole.iter().all(|&n| n == 0) {
            return None;
        }
        let rounds_left = goal.max_rounds.map_or(1.0, |most| (most - self.rounds).min(1.0));
        let time_left = goal.max_seconds.map_or(f64::INFINITY, |most| most - seconds);
        let trees: Vec<f64> = whole.iter().map(|&n| n as f64).collect();
        let needed = if first { 0.0 } else { self.seconds_for(&trees, tracing) };
        let part = PARTS.into_iter().find(|part| *part <= rounds_left && part * needed <= time_left);
        self.out_of_time = part.is_none_or(|part| part < 1.0);
        self.rounds += part?;
        Some(whole.into_iter().map(|n| portion(n, part.unwrap_or(1.0))).collect())
    }

    /// Looks at what is measured after a round of so many trees per incidence. `tracing` seconds were spent on tracing.
    pub fn look(&mut self, measurements: &[Measurement], round: &[u64], tracing: f64) {
        let Some(target) = self.goal.map(|g| g.target.unwrap_or(Target::Whole(0.0))) else { return };
        for ((standing, m), _) in self.standings.iter_mut().zip(measurements).zip(round).filter(|(_, n)| **n > 0) {
            let error = target.of(&m.precision());
            let passes = if error <= target.error() { standing.passes + 1 } else { 0 };
            *standing = Standing { trees: m.trees(), segments: m.segments(), error, passes };
        }
        let Some(forecast) = self.forecast(tracing) else { return };
        let traced: u64 = self.standings.iter().map(|s| s.trees).sum();
        if traced >= PILOT * self.standings.len() as u64 || forecast.trees <= PILOT_PART * traced {
            self.forecast.get_or_insert((forecast, tracing));
        }
    }

    /// The greatest error of all incidences, once there is one.
    pub fn error(&self) -> Option<f64> {
        (self.goal.is_some() && self.rounds > 0.0).then(|| self.standings.iter().map(|s| s.error).fold(0.0, f64::max))
    }

    /// What is to come, if that can be told: there is a target, and some error is known. `tracing` seconds were spent on
    /// tracing.
    pub fn forecast(&self, tracing: f64) -> Option<Forecast> {
        let target = self.goal?.target?;
        let more: Vec<f64> = self.standings.iter().map(|s| s.rest(target.error())).collect();
        let trees: f64 = self.standings.iter().zip(&more).map(|(s, n)| s.trees as f64 + n).sum();
        // Nothing is traced yet, or nothing is seen yet.
        (trees > 0.0 && trees < MOST_TREES)
            .then(|| Forecast { trees: trees as u64, seconds: self.seconds_for(&more, tracing) })
    }

    /// How it has ended.
    pub fn ending(&self) -> Option<Ending> {
        let goal = self.goal?;
        let reached = goal.target.is_some() && self.standings.iter().all(|s| s.passes >= 2);
        let out_of_time = self.out_of_time && !reached;
        Some(Ending { reached, out_of_time, rounds: self.rounds, forecast: self.forecast })
    }

    fn target(&self) -> f64 {
        self.goal.and_then(|g| g.target).map_or(0.0, Target::error)
    }

    /// Time for so many trees of each incidence, after `tracing` seconds for what is traced.
    fn seconds_for(&self, trees: &[f64], tracing: f64) -> f64 {
        let segments: u64 = self.standings.iter().map(|s| s.segments).sum();
        let more: f64 = self.standings.iter().zip(trees).map(|(s, n)| s.cost() * n).sum();
        more * tracing / segments as f64
    }

    /// Trees of each incidence in the next round. All work is done as often again, where it is needed most: such that all
    /// incidences come to the same error; never below the target.
    fn round(&self) -> Vec<u64> {
        let past: f64 = self.standings.iter().map(|s| s.segments as f64).sum();
        let work = |aim: f64| -> f64 { self.standings.iter().map(|s| s.cost() * s.lacks(aim)).sum() };
        let (mut low, mut high) = (self.target(), self.standings.iter().map(|s| s.error).fold(0.0, f64::max).min(1e3));
        if work(low) > past {
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                *(if work(middle) > past { &mut low } else { &mut high }) = middle;
            }
            return self.standings.iter().map(|s| portion(s.lacks(high) as u64, 1.0)).collect();
        }
        let enough = |s: &Standing| if s.passes >= 2 { 0.0 } else { s.lacks(low).max(CONFIRM * s.trees as f64) };
        self.standings.iter().map(|s| portion(enough(s) as u64, 1.0)).collect()
    }
}

impl Standing {
    /// Segments of a tree.
    fn cost(&self) -> f64 {
        self.segments as f64 / self.trees as f64
    }

    /// Trees that are missing to come to the error `aim`, in one round.
    fn lacks(&self, aim: f64) -> f64 {
        if self.passes >= 2 || self.error <= aim {
            return 0.0;
        }
        (self.needed(aim).min(MOST) - 1.0).max(0.0) * self.trees as f64
    }

    /// How many times its trees it needs.
    fn needed(&self, aim: f64) -> f64 {
        MARGIN * (self.error / aim).powi(2)
    }

    /// Trees that are missing to be sure of the error `aim`.
    fn rest(&self, aim: f64) -> f64 {
        let times = match self.passes {
            0 => self.needed(aim).max(1.0) * (1.0 + CONFIRM) - 1.0,
            1 => CONFIRM,
            _ => 0.0,
        };
        times * self.trees as f64
    }
}

/// A part of so many trees, as many in each batch.
fn portion(trees: u64, part: f64) -> u64 {
    ((trees as f64 * part) as u64).next_multiple_of(u64::from(BATCHES))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn course(target: f64, standings: &[(u64, f64, u32)]) -> Course {
        let goal = Goal { target: Some(Target::Whole(target)), ..Goal::default() };
        let mut course = Course::new(Some(goal), 0, standings.len());
        course.rounds = 1.0;
        course.standings = standings
            .iter()
            .map(|&(trees, error, passes)| Standing { trees, segments: 3 * trees, error, passes })
            .collect();
        course
    }

    #[test]
    fn targets_are_read_and_told() {
        for text in ["1%", "facet:5%", "0.25%", "facet:12.5%"] {
            assert_eq!(text.parse::<Target>().unwrap().to_string(), text);
        }
        assert_eq!("0.01".parse(), Ok(Target::Whole(0.01)));
        for bad in ["", "0%", "100%", "-1%", "facet:", "one"] {
            assert!(bad.parse::<Target>().is_err(), "{bad}");
        }
    }

    #[test]
    fn far_from_the_target_the_work_doubles() {
        assert_eq!(course(1e-4, &[(32_000, 0.1, 0)]).next(0.0, 0.0), Some(vec![32_000]));
    }

    #[test]
    fn the_worst_incidence_gets_most_and_one_that_is_better_than_all_will_be_nothing() {
        let round = course(1e-4, &[(32_000, 0.2, 0), (32_000, 0.1, 0), (32_000, 0.01, 0)]).next(0.0, 0.0).unwrap();
        assert!(round[0] > 2 * round[1] && round[2] == 0, "{round:?}");
        let total: u64 = round.iter().sum();
        assert!(total.abs_diff(96_000) < 100, "{total}");
    }

    #[test]
    fn near_the_target_no_more_is_traced_than_it_takes() {
        let round = course(0.01, &[(32_000, 0.011, 0)]).next(0.0, 0.0).unwrap();
        assert_eq!(round, [(32_000f64 * (1.05 * 1.21 - 1.0)) as u64 / 32 * 32 + 32]);
        // Seen once: again a tenth. Seen twice: it ends.
        assert_eq!(course(0.01, &[(32_000, 0.009, 1)]).next(0.0, 0.0), Some(vec![3200]));
        let mut done = course(0.01, &[(32_000, 0.009, 2)]);
        assert_eq!(done.next(0.0, 0.0), None);
        assert!(done.ending().unwrap().reached);
    }

    #[test]
    fn a_round_that_does_not_fit_is_made_smaller_and_is_the_last() {
        let mut course = course(1e-4, &[(32_000, 0.1, 0)]);
        course.goal = course.goal.map(|g| Goal { max_seconds: Some(10.0), ..g });
        // 32,000 trees have taken 7 s, 3 are left.
        assert_eq!(course.next(7.0, 7.0), Some(vec![8000]));
        assert_eq!(course.next(9.0, 9.0), None);
        let ending = course.ending().unwrap();
        assert!(ending.out_of_time && !ending.reached && ending.rounds == 1.25);
    }

    /// A facet that is not seen yet has an endless error.
    #[test]
    fn nothing_is_forecast_where_nothing_is_known() {
        let unseen = course(0.05, &[(32_000, f64::INFINITY, 0), (32_000, 0.1, 0)]);
        assert_eq!(unseen.forecast(1.0), None);
        assert!(unseen.round()[0] >= 32_000);
        let mut timed = Course::new(Some(Goal { max_seconds: Some(9.0), ..Goal::default() }), 0, 1);
        assert_eq!((timed.next(0.0, 0.0), timed.forecast(1.0)), (Some(vec![FIRST]), None));
    }

    #[test]
    fn rounds_can_be_asked_for() {
        let mut course = course(1e-4, &[(32_000, 0.1, 0)]);
        course.goal = course.goal.map(|g| Goal { max_rounds: Some(1.25), ..g });
        assert_eq!(course.next(0.0, 0.0), Some(vec![8000]));
        assert_eq!(course.next(0.0, 0.0), None);
    }

    #[test]
    fn without_a_goal_there_is_one_round() {
        let mut course = Course::new(None, 1000, 2);
        assert_eq!(course.next(0.0, 0.0), Some(vec![1000, 1000]));
        assert_eq!(course.next(0.0, 0.0), None);
        assert_eq!(course.ending(), None);
    }
}
