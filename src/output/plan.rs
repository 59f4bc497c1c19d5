//! A plan with its costs, for people and, as `gonio-plan-1`, for scripts.

use std::fmt::Write as _;

use serde::Serialize;

use crate::plan::features::SMALL;
use crate::plan::{Plan, State};
use crate::units::{show_length, significant};

/// A plan with its costs.
#[derive(Clone, Debug)]
pub struct Explanation {
    /// The plan, with nothing left open.
    pub plan: Plan,
    /// Per effect, in the order of the plan: time of a tree with it over that without it; none if that makes no difference
    /// to what is traced.
    pub costs: Vec<Option<f64>>,
    /// Estimated time of the whole measurement, s.
    pub seconds: f64,
    /// Trees of the whole measurement.
    pub trees: u64,
    /// Threads.
    pub threads: usize,
    /// The error aimed at.
    pub error: f64,
    /// Vacuum wavelengths, nm.
    pub wavelength_nm: Vec<f64>,
}

/// The table.
pub fn text(explanation: &Explanation) -> String {
    let Explanation { plan, costs, seconds, trees, threads, error, wavelength_nm } = explanation;
    let mut out = String::new();
    let _ = writeln!(out, "{:<14}{:<6}{:>10}{:>12}  reason", "effect", "", "bound", "time with/");
    let _ = writeln!(out, "{:<14}{:<6}{:>10}{:>12}", "", "", "", "without");
    for (effect, cost) in plan.effects.iter().zip(costs) {
        let on = if effect.on { "on" } else { "off" };
        let bound = match effect.bound {
            b if b >= 1.0 => "any".into(),
            0.0 => "0".into(),
            b => format!("{} %", significant(100.0 * b, 2)),
        };
        let cost = cost.map_or_else(|| "-".into(), |f| format!("{f:.2}"));
        let _ = writeln!(out, "{:<14}{on:<6}{bound:>10}{cost:>12}  {}", effect.name.to_string(), effect.reason);
    }
    let _ = writeln!(
        out,
        "\nbound: no part of the reflected or of the transmitted light changes by more than this share of it\n\
         when the effect is left out; what may be left out is {} % per effect (a fifth of the error aimed at)",
        significant(20.0 * error, 2)
    );
    let _ = writeln!(out, "rays carry {}", carried(plan));
    let _ = writeln!(out, "{}", features(plan, wavelength_nm));
    let _ = writeln!(out, "estimated time: {} s for {trees} trees on {threads} threads", significant(*seconds, 2));
    out
}

fn carried(plan: &Plan) -> String {
    let state = match plan.kernel.state {
        State::Power => "power",
        State::Stokes => "Stokes vectors",
        State::Mueller => "Mueller matrices",
        State::Jones => "Jones matrices with their phase",
    };
    let (lanes, count) = (plan.lanes.len(), plan.lane_of.len());
    match (lanes == count, plan.kernel.parts) {
        (false, _) => format!("{state} for {lanes} of {count} wavelengths, which stands for all"),
        (true, true) => format!(
            "{state} for all {count} wavelengths, parted where refraction spreads them by more than {}°",
            significant(plan.limits.spread.to_degrees(), 2)
        ),
        (true, false) => format!("{state} for all {count} wavelengths together"),
    }
}

/// Sizes against the wavelength.
fn features(plan: &Plan, wavelength_nm: &[f64]) -> String {
    let longest = wavelength_nm[wavelength_nm.len() - 1] / 1e3;
    let smallest = plan.features.smallest();
    if smallest.is_infinite() {
        return "every face is endless: ray optics holds".into();
    }
    let ratio = smallest / longest;
    let verdict = if ratio < SMALL {
        "outside of films ray optics is in doubt there; the result tells how much of the light met such faces"
    } else {
        "ray optics holds"
    };
    let (width, ratio) = (show_length(smallest), significant(ratio, 2));
    format!("the narrowest face is {width} wide, {ratio} times the longest wavelength: {verdict}")
}

#[derive(Serialize)]
struct Document {
    schema: &'static str,
    effects: Vec<Effect>,
    state: String,
    lanes: usize,
    parts: bool,
    smallest_feature_um: Option<f64>,
    estimated_seconds: f64,
    threads: usize,
}

#[derive(Serialize)]
struct Effect {
    name: String,
    on: bool,
    reason: String,
    bound: f64,
    time_with_over_without: Option<f64>,
}

/// The document.
pub fn json(explanation: &Explanation) -> String {
    let Explanation { plan, costs, seconds, threads, .. } = explanation;
    let effects = plan.effects.iter().zip(costs).map(|(e, cost)| Effect {
        name: e.name.to_string(),
        on: e.on,
        reason: e.reason.clone(),
        bound: e.bound,
        time_with_over_without: *cost,
    });
    let document = Document {
        schema: "gonio-plan-1",
        effects: effects.collect(),
        state: format!("{:?}", plan.kernel.state).to_lowercase(),
        lanes: plan.lanes.len(),
        parts: plan.kernel.parts,
        smallest_feature_um: Some(plan.features.smallest()).filter(|um| um.is_finite()),
        estimated_seconds: *seconds,
        threads: *threads,
    };
    serde_json::to_string_pretty(&document).expect("plain numbers and texts")
}
