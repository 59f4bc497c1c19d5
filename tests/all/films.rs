//! The film solver against 40-digit truth.

use std::collections::BTreeMap;

use gonio_embree::optics::batch::{Film, Question, Sides, Solver, Spectrum};
use gonio_embree::optics::film::{Amplitudes, Incidence, Layer, solve};
use gonio_embree::optics::{C64, Pair};
use serde_json::Value;

fn complex(v: &Value) -> C64 {
    let part = |i: usize| match &v[i] {
        Value::String(s) => s.parse::<f64>().unwrap(),
        other => other.as_f64().unwrap(),
    };
    C64::new(part(0), part(1))
}

type Solve = fn(&Incidence, &[Layer], C64, f64) -> Pair<Amplitudes>;

const REFERENCE: &str = "tests/reference/films.json";

#[test]
fn films_match_reference() {
    matches_truth(REFERENCE, solve);
}

#[test]
fn lanes_match_reference() {
    matches_truth(REFERENCE, solve_in_lanes);
}

/// Hundreds of weakly absorbing layers, and bound modes behind evanescent ones: where digits were lost once.
#[test]
fn found_cases_match() {
    matches_truth("tests/reference/films_found.json", solve);
    matches_truth("tests/reference/films_found.json", solve_in_lanes);
}

/// One wavelength of many.
fn solve_in_lanes(incidence: &Incidence, layers: &[Layer], last: C64, wavelength: f64) -> Pair<Amplitudes> {
    let indices = layers.iter().map(|l| l.index).chain([last]);
    let media: Vec<Spectrum> = indices.map(|n| [n].into_iter().collect()).collect();
    let film = |(medium, l): (usize, &Layer)| Film { medium, thickness: l.thickness };
    let films: Vec<Film> = layers.iter().enumerate().map(film).collect();
    let (incidences, wavelengths) = (&[*incidence], &[wavelength]);
    let question = Question { incidences, media: &media, films: &films, last: layers.len(), wavelengths };
    let mut out = Vec::new();
    Solver::default().solve(&question, Sides::Both, &mut out);
    out[0]
}

/// Every case within 4 times the effect of rounding its input, plus 2e-15.
fn matches_truth(file: &str, solve: Solve) {
    let text = std::fs::read_to_string(file).unwrap();
    let file: Value = serde_json::from_str(&text).unwrap();
    let mut failed = Vec::new();
    let mut classes: BTreeMap<String, (usize, f64)> = BTreeMap::new();
    for case in file["cases"].as_array().unwrap() {
        let n0 = complex(&case["n_first"]).re;
        let value = case["angle"]["value"].as_f64().unwrap();
        let incidence = match case["angle"]["kind"].as_str().unwrap() {
            "cos0" => Incidence::from_cos(n0, value),
            "kx" => Incidence::from_kx(n0, value),
            _ => Incidence::from_angle(n0, value.to_radians()),
        };
        let once: Vec<Layer> = case["layers"]
            .as_array()
            .unwrap()
            .iter()
            .map(|l| Layer { index: complex(l), thickness: l[2].as_f64().unwrap() })
            .collect();
        let layers = once.repeat(case["repeat"].as_u64().unwrap() as usize);
        let both = solve(&incidence, &layers, complex(&case["n_last"]), case["wavelength_nm"].as_f64().unwrap());
        let got = if case["pol"] == "s" { both.s } else { both.p };
        for (name, x) in [("r", got.r), ("t", got.t), ("r_back", got.r_back), ("t_back", got.t_back)] {
            let truth = complex(&case[name]);
            let noise = case["noise_1ulp"][name].as_f64().unwrap();
            let error = (x - truth).norm();
            let allowed = 4.0 * noise + 2e-15 * truth.norm().max(1.0);
            let worst = classes.entry(case["cls"].as_str().unwrap().into()).or_default();
            worst.0 += 1;
            worst.1 = worst.1.max(error / allowed);
            if error > allowed || error.is_nan() {
                failed.push(format!("{} {name}: {x} for {truth}, error {error:e} > {allowed:e}", case["name"]));
            }
        }
    }
    // Per class: how many, and the largest part of the allowance used.
    assert!(failed.is_empty(), "{} failed of {classes:?}:\n{}", failed.len(), failed.join("\n"));
}
