//! The samples of `assets/samples`: all run and account for all light; stacks of films reflect what independent numbers say.
//! What else the paper says of them is in `paper_figures.rs`.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::Command;

use crate::common::build::{Build, light};
use crate::common::listen::settings;
use crate::common::reference::{Row, csv};
use glam::DVec2;
use gonio_embree::dome::Estimate;
use gonio_embree::experiment::measure;
use gonio_embree::light::{Light, Polarization, SourceMode};
use gonio_embree::sample::Description;
use gonio_embree::sample::description::{Patch, Sides};

fn description(file: &str) -> Description {
    Description::from_toml(format!("assets/samples/{file}.toml").as_ref()).unwrap_or_else(|e| panic!("{e}"))
}

fn line(nm: &[f64], from: &[f64], polarization: Polarization) -> Light {
    let from: Vec<(f64, f64)> = from.iter().map(|&theta| (theta, 40.0)).collect();
    Light { source: SourceMode::Line, ..light(nm, &from, polarization) }
}

/// Reflectance per incidence and wavelength.
fn reflectance(d: &Description, light: &Light, trees: u64) -> Vec<Vec<Estimate>> {
    let outcome = measure(&Build(d.clone()).sample(light), light, &settings(trees), |_| {}).unwrap();
    outcome.bsdf.incidences.into_iter().map(|s| s.ledger.reflected).collect()
}

/// A spectrum at normal incidence against a column of a table.
fn check_normal(file: &str, rows: &[Row], column: &str) {
    let nm: Vec<f64> = rows.iter().map(|r| r.number("wavelength_nm")).collect();
    let measured = &reflectance(&description(file), &line(&nm, &[0.0], Polarization::Unpolarized), 32)[0];
    for (row, e) in rows.iter().zip(measured) {
        assert!((e.value - row.number(column)).abs() < 1e-9, "{file}, {} nm: {e:?}", row.word("wavelength_nm"));
    }
}

/// The stack and its spectra over angles, `R_s` and `R_p`.
fn check_angles(file: &str, rows: &[Row]) {
    let mut by_angle: BTreeMap<u32, Vec<&Row>> = BTreeMap::new();
    rows.iter().for_each(|r| by_angle.entry(r.number("angle_deg") as u32).or_default().push(r));
    let angles: Vec<f64> = by_angle.keys().map(|&a| f64::from(a)).collect();
    let nm: Vec<f64> = by_angle[&0].iter().map(|r| r.number("wavelength_nm")).collect();
    for (polarization, column) in [(Polarization::S, "R_s"), (Polarization::P, "R_p")] {
        let measured = reflectance(&description(file), &line(&nm, &angles, polarization), 32);
        for (rows, measured) in by_angle.values().zip(&measured) {
            assert_eq!(rows.len(), nm.len());
            for (row, e) in rows.iter().zip(measured) {
                let at = (row.word("angle_deg"), row.word("wavelength_nm"));
                assert!((e.value - row.number(column)).abs() < 1e-9, "{file} {at:?}: {e:?}");
            }
        }
    }
}

#[test]
fn morpho_stacks_are_the_reference() {
    let (normal, angles) = (csv("morpho_normal.csv"), csv("morpho_angles.csv"));
    for films in 1..=12 {
        let file = if films == 12 { "morpho".into() } else { format!("morpho-{films}") };
        check_normal(&file, &normal, &format!("R_{films}films"));
        let these: Vec<Row> = angles.iter().filter(|r| r.number("films") == f64::from(films)).cloned().collect();
        if !these.is_empty() {
            check_angles(&file, &these);
        }
    }
}

#[test]
fn films_and_plates_of_a_hummingbird_are_the_reference() {
    let (normal, angles) = (csv("hummingbird_normal.csv"), csv("hummingbird_angles.csv"));
    for (around, film, plate) in
        [("air", "humm15_air_air", "plates_abut_air_air"), ("keratin", "humm15_keratin_keratin", "plates_abut_keratin")]
    {
        for kind in ["films", "plates"] {
            for (reading, name) in [("literal", film), ("optical", plate)] {
                let file = format!("hummingbird/{kind}-{reading}-{around}");
                check_normal(&file, &normal, &format!("R_{name}"));
                let these: Vec<Row> = angles.iter().filter(|r| r.word("stack") == name).cloned().collect();
                if !these.is_empty() {
                    check_angles(&file, &these);
                }
            }
        }
    }
}

/// Light that enters in the middle of a column of bricks meets films.
#[test]
fn bricks_far_from_their_walls_are_films() {
    let nm: Vec<f64> = (0..36).map(|i| 400.0 + 10.0 * f64::from(i)).collect();
    for around in ["air", "keratin"] {
        for reading in ["optical", "literal"] {
            let light = line(&nm, &[0.0, 20.0], Polarization::Unpolarized);
            let films = reflectance(&description(&format!("hummingbird/films-{reading}-{around}")), &light, 32);
            let mut bricks = description(&format!("hummingbird/bricks-{reading}-{around}"));
            // Walls are at multiples of 0.75 µm along x and of 1 µm along y.
            let center = DVec2::new(0.375, 0.5);
            (bricks.patch, bricks.sides) = (Some(Patch { size: DVec2::splat(0.05), center }), Sides::Open);
            for (a, b) in films.iter().flatten().zip(reflectance(&bricks, &light, 200).iter().flatten()) {
                assert!((a.value - b.value).abs() < 1e-9, "{reading}, {around}: {a:?} {b:?}");
            }
        }
    }
}

/// All sample files, in folders too.
fn samples() -> Vec<PathBuf> {
    let mut folders = vec![PathBuf::from("assets/samples")];
    let mut files = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "toml") {
                files.push(path);
            }
        }
    }
    files.sort();
    files
}

/// As the README says, with fewer trees. What is lost would be exit code 1 at more than 1e-5.
#[test]
fn every_sample_runs_and_accounts_for_all_light() {
    let folder = std::env::temp_dir().join(format!("gonio-embree-samples-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let files = samples();
    assert!(files.len() > 25, "{}", files.len());
    for file in files {
        let output = Command::new(env!("CARGO_BIN_EXE_gonio-embree"))
            .args([
                "--incident",
                "0,60",
                "--wavelengths",
                "450:650:100",
                "--trees",
                "500",
                "--max-lost",
                "1e-5",
                "--json",
                "--quiet",
            ])
            .arg("--sample")
            .arg(&file)
            .arg("-o")
            .arg(folder.join("result.nc"))
            .output()
            .unwrap();
        let told = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "{}: {told}", file.display());
        let json: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
        for incidence in json["incidences"].as_array().unwrap() {
            for w in 0..3 {
                let share = |name: &str| incidence[name][w].as_f64().unwrap_or_else(|| panic!("{name}"));
                let sum: f64 = ["reflected", "transmitted", "absorbed", "side", "lost"].map(share).iter().sum();
                assert!((sum - 1.0).abs() < 1e-9, "{}: {sum}", file.display());
            }
        }
    }
    std::fs::remove_dir_all(folder).unwrap();
}
