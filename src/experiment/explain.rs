//! What a plan says, and what each of its effects costs: measured on some trees.

use std::time::Instant;

use super::course::Course;
use super::gather::advance;
use super::state::State;
use super::{Bench, Error, Settings};
use crate::light::Light;
use crate::output::plan::Explanation;
use crate::plan::{Name, Plan};
use crate::sample::Sample;

/// Trees that are timed, in all, and how often: the shortest time counts.
const TREES: u64 = 4096;
const TIMES: usize = 3;

/// Plans a measurement, and times some trees of it.
///
/// # Errors
/// When the light comes from nowhere, or the backend cannot work.
pub fn explain(sample: &Sample, light: &Light, settings: &Settings) -> Result<Explanation, Error> {
    let bench = Bench::new(sample, light, settings)?;
    let plan = bench.plan();
    let others: Vec<Option<Plan>> = plan.effects.iter().map(|e| other(&bench, &plan, e.name)).collect();
    let few =
        Settings { trees: (TREES / light.incidences.len() as u64).max(32).min(settings.trees), ..settings.clone() };
    let timed = Bench { settings: &few, ..bench.clone() };
    let mut least = vec![f64::INFINITY; 1 + others.len()];
    for _ in 0..TIMES {
        let plans = std::iter::once(Some(&plan)).chain(others.iter().map(Option::as_ref));
        for (least, plan) in least.iter_mut().zip(plans) {
            *least = plan.map_or(*least, |plan| least.min(time(&timed, plan)));
        }
    }
    let cost = |(i, other): (usize, &Option<Plan>)| {
        let (this, that) = (least[0], least[1 + i]);
        other.as_ref().map(|_| if plan.effects[i].on { this / that } else { that / this })
    };
    let costs = others.iter().enumerate().map(cost).collect();
    let seconds = least[0] * settings.trees as f64 / few.trees as f64;
    Ok(Explanation {
        plan,
        costs,
        seconds,
        trees: settings.trees * light.incidences.len() as u64,
        threads: settings.threads,
        error: settings.options.error,
        wavelength_nm: light.wavelengths.nm().to_vec(),
    })
}

/// The plan with an effect switched over; none if that would be traced by the same code.
fn other(bench: &Bench<'_>, plan: &Plan, name: Name) -> Option<Plan> {
    let other = plan.switched(name, bench.sample, bench.light);
    (name.is_for_hands() && (other.kernel != plan.kernel || other.lanes != plan.lanes || other.media != plan.media))
        .then_some(other)
}

/// Seconds that the trees take.
fn time(bench: &Bench<'_>, plan: &Plan) -> f64 {
    let course = Course::new(None, bench.settings.trees, bench.light.incidences.len());
    let start = Instant::now();
    advance(bench, plan, &mut State::new(course, None, 0.0, 0), |_, _| true);
    start.elapsed().as_secs_f64()
}
