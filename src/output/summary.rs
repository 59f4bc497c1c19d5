//! The JSON summary of a measurement, schema `gonio-summary-1`.

use std::collections::BTreeMap;

use serde::Serialize;

use super::measured::{Measured, StackHits, UsedBackend, Validity};
use crate::bsdf::Scattering;
use crate::dome::Estimate;
use crate::experiment::{Ending, Goal};

/// What the result itself does not know: it may differ from run to run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Run {
    /// Wall time, s.
    pub seconds: f64,
    /// Threads.
    pub threads: usize,
    /// What was aimed at, and how it ended.
    pub goal: Option<(Goal, Ending)>,
}

#[derive(Serialize)]
struct Summary<'a> {
    schema: &'static str,
    version: &'a str,
    seconds: f64,
    backend: &'a UsedBackend,
    threads: usize,
    seed: u64,
    effects: BTreeMap<&'a str, Effect<'a>>,
    wavelength_nm: &'a [f64],
    incidences: Vec<Incidence>,
    validity: &'a Validity,
    stacks: &'a [StackHits],
    #[serde(skip_serializing_if = "Option::is_none")]
    goal: Option<Aimed>,
}

#[derive(Serialize)]
struct Aimed {
    target_error: Option<String>,
    reached: bool,
    out_of_time: bool,
    rounds: f64,
    forecast_trees: Option<u64>,
    forecast_seconds: Option<f64>,
}

/// Relative errors that 95 of 100 measurements do not exceed; of the worst facet none if it cannot be told.
#[derive(Serialize)]
struct Errors {
    brdf: f64,
    btdf: f64,
    reflected: f64,
    transmitted: f64,
    worst_facet: Option<f64>,
}

#[derive(Serialize)]
struct Effect<'a> {
    on: bool,
    reason: &'a str,
    bound: f64,
}

#[derive(Serialize)]
struct Incidence {
    theta_deg: f64,
    phi_deg: f64,
    trees: u64,
    segments: u64,
    reflected: Vec<f64>,
    reflected_se: Vec<f64>,
    transmitted: Vec<f64>,
    transmitted_se: Vec<f64>,
    absorbed: Vec<f64>,
    side: Vec<f64>,
    lost: Vec<f64>,
    specular: Vec<f64>,
    undeflected: Vec<f64>,
    errors: Errors,
    /// CIE L*a*b* of the reflected light, and their standard errors.
    #[serde(skip_serializing_if = "Option::is_none")]
    reflected_lab: Option<[f64; 3]>,
    #[serde(skip_serializing_if = "Option::is_none")]
    reflected_lab_se: Option<[f64; 3]>,
}

/// The document.
pub fn json(measured: &Measured, run: &Run) -> String {
    let p = &measured.provenance;
    let summary = Summary {
        schema: "gonio-summary-1",
        version: &p.version,
        seconds: run.seconds,
        backend: &p.backend,
        threads: run.threads,
        seed: p.seed,
        effects: p
            .effects
            .iter()
            .map(|e| (&e.name[..], Effect { on: e.on, reason: &e.reason, bound: e.bound }))
            .collect(),
        wavelength_nm: &measured.bsdf.wavelength_nm,
        incidences: measured.bsdf.incidences.iter().map(incidence).collect(),
        validity: &p.validity,
        stacks: &p.stacks,
        goal: run.goal.map(aimed),
    };
    serde_json::to_string_pretty(&summary).expect("plain numbers and texts")
}

fn aimed((goal, ending): (Goal, Ending)) -> Aimed {
    Aimed {
        target_error: goal.target.map(|t| t.to_string()),
        reached: ending.reached,
        out_of_time: ending.out_of_time,
        rounds: ending.rounds,
        forecast_trees: ending.forecast.map(|(f, _)| f.trees),
        forecast_seconds: ending.forecast.map(|(f, _)| f.seconds),
    }
}

fn incidence(s: &Scattering) -> Incidence {
    let values = |all: &[Estimate]| all.iter().map(|e| e.value).collect();
    let errors = |all: &[Estimate]| all.iter().map(|e| e.se).collect();
    let (l, precision) = (&s.ledger, &s.derived.precision);
    Incidence {
        theta_deg: s.incidence.theta_deg,
        phi_deg: s.incidence.phi_deg,
        trees: s.trees,
        segments: s.segments,
        reflected: values(&l.reflected),
        reflected_se: errors(&l.reflected),
        transmitted: values(&l.transmitted),
        transmitted_se: errors(&l.transmitted),
        absorbed: values(&l.absorbed),
        side: values(&l.side),
        lost: l.lost(),
        specular: values(&l.specular),
        undeflected: values(&l.undeflected),
        errors: Errors {
            brdf: precision.above,
            btdf: precision.below,
            reflected: precision.reflected,
            transmitted: precision.transmitted,
            worst_facet: Some(precision.facet).filter(|e| e.is_finite()),
        },
        reflected_lab: s.derived.reflected_lab.map(|lab| lab.map(|e| e.value)),
        reflected_lab_se: s.derived.reflected_lab.map(|lab| lab.map(|e| e.se)),
    }
}
