//! Errors that are asked for, and what they cost, as people ask for them at the terminal.

use crate::desk::{Desk, code, errors};
use serde_json::Value;

/// A sphere under a beam, measured quickly.
const SPHERE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/samples/glass-sphere.toml");
const QUICKLY: [&str; 6] = ["--sample", SPHERE, "--wavelengths", "550", "--dome-level", "2"];

fn measured(desk: &Desk, more: &[&str]) -> std::process::Output {
    desk.run(&[&QUICKLY[..], &["-o", "out.nc", "--json", "--quiet"], more].concat())
}

#[test]
fn an_error_is_asked_for_and_told() {
    let desk = Desk::new("target");
    let output = measured(&desk, &["--target-error", "5%"]);
    assert_eq!(code(&output), Some(0), "{}", errors(&output));
    let json: Value = serde_json::from_slice(&output.stdout).unwrap();
    let at = &json["incidences"][0];
    assert!(["brdf", "btdf", "reflected", "transmitted"].iter().all(|e| at["errors"][e].as_f64().unwrap() <= 0.05));
    assert_eq!(json["goal"]["reached"], true);
    assert!(json["goal"]["rounds"].as_f64().unwrap() >= 2.0);
    // To the bit what the command in the result makes.
    let first = desk.read("out.nc");
    assert_eq!(code(&measured(&desk, &["--target-error", "5%", "--threads", "1"])), Some(0));
    assert_eq!(desk.read("out.nc"), first);
}

#[test]
fn what_was_reached_without_time_is_kept_and_can_be_repeated() {
    let desk = Desk::new("time");
    let output = measured(&desk, &["--target-error", "0.01%", "--max-time", "1s"]);
    assert_eq!(code(&output), Some(1));
    let said = errors(&output);
    assert!(said.contains("--target-error 0.01% was not reached: --max-time is over at "), "{said}");
    let json: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!([&json["goal"]["reached"], &json["goal"]["out_of_time"]], [false, true]);
    let first = desk.read("out.nc");
    let rounds = json["goal"]["rounds"].to_string();
    let again = measured(&desk, &["--target-error", "0.01%", "--max-rounds", &rounds]);
    assert!(code(&again) == Some(1) && errors(&again).contains("--max-rounds are over"), "{}", errors(&again));
    assert_eq!(desk.read("out.nc"), first);
}

#[test]
fn wrong_targets_and_times_are_refused() {
    let desk = Desk::new("wrong");
    for (args, said) in [
        (&["--target-error", "0%"][..], "expected an error greater than 0 and less than 100 %, such as 1% or facet:5%"),
        (&["--target-error", "facets:5%"], "such as 1% or facet:5%"),
        (&["--target-error", "1%", "--trees", "1k"], "cannot be used with"),
        (&["--max-time", "-5s"], "expected a time such as 60s, 5min or 2h"),
        (&["--max-rounds", "0.5"], "--max-rounds 0.5: expected 1 or more"),
    ] {
        let output = measured(&desk, args);
        assert_eq!(code(&output), Some(2), "{args:?}");
        assert!(errors(&output).contains(said), "{args:?}: {}", errors(&output));
    }
}

#[test]
fn a_ladder_is_a_table_a_picture_and_advice() {
    let desk = Desk::new("ladder");
    let args = [&["accuracy"], &QUICKLY[..], &["--trees", "512", "--seeds", "2", "-o", "ladder.svg"]].concat();
    let output = desk.run(&args);
    assert_eq!(code(&output), Some(0), "{}", errors(&output));
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    for said in
        ["as given", "--depth 16", "--effects auto,-polarization", "splits", "for 1 %:", "compared with 15360 trees"]
    {
        assert!(text.contains(said), "{said}: {text}");
    }
    assert_eq!(desk.names(), ["ladder.csv", "ladder.svg"]);
    let csv = String::from_utf8(desk.read("ladder.csv")).unwrap();
    let columns = |line: &str| line.split(',').count() - line.matches("auto,").count();
    let lines: Vec<&str> = csv.lines().skip(1).collect();
    assert!(lines.len() > 20 && lines.iter().all(|line| columns(line) == columns(lines[0])), "{csv}");
    // Light that meets more than four interfaces is lost with --depth 4.
    let lost = lines.iter().find(|line| line.contains("--depth 4\"")).unwrap().split(',').nth(10).unwrap();
    assert!(lost.parse::<f64>().unwrap() > 1e-3, "{lost}");
}

/// Films have a formula; with few trees nothing but chance is between them.
#[test]
fn films_are_compared_with_their_formula() {
    let desk = Desk::new("formula");
    let film = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/samples/morpho.toml");
    let args = ["accuracy", film, "--incident", "20", "--wavelengths", "450,460", "--trees", "512", "--seeds", "2"];
    let output = desk.run(&args);
    assert_eq!(code(&output), Some(0), "{}", errors(&output));
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(text.contains("compared with the formula of the films"), "{text}");
    assert_eq!(desk.names(), ["morpho-accuracy.csv", "morpho-accuracy.svg"]);
}
