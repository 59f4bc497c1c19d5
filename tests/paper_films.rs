//! The paper's stacks, `assets/samples/morpho*.toml` and `assets/samples/hummingbird/*.toml`, against independent numbers.
#![allow(missing_docs, clippy::print_stdout, reason = "distances are shown with --nocapture")]

mod common;

use std::collections::BTreeMap;

use common::build::{Build, light};
use common::listen::settings;
use common::reference::{Row, csv};
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

fn rms(all: impl Iterator<Item = f64>) -> f64 {
    let all: Vec<f64> = all.collect();
    (all.iter().map(|x| x * x).sum::<f64>() / all.len() as f64).sqrt()
}

/// The highest reflectance on the blue side of the band.
fn side_lobe(of: &[f64]) -> f64 {
    let peak = (0..of.len()).max_by(|&a, &b| of[a].total_cmp(&of[b])).unwrap();
    let valley = (1..=peak).rev().find(|&i| of[i - 1] > of[i]).unwrap();
    of[..valley].iter().copied().fold(0.0, f64::max)
}

/// Rays see columns of films: on average over the area, for they cannot do else. 33 wavelengths twice: a |z| above 5 (Student,
/// 31 degrees of freedom) has a probability of 1.4e-3.
fn check_bricks(trees: u64) {
    for around in ["air", "keratin"] {
        let rows = csv(&format!("rcwa_bricks2d_{around}.csv"));
        let column = |name: &str| rows.iter().map(|r| r.number(name)).collect::<Vec<f64>>();
        let nm = column("wavelength_nm");
        let light = line(&nm, &[0.0], Polarization::Unpolarized);
        let bricks = &reflectance(&description(&format!("hummingbird/bricks-optical-{around}")), &light, trees)[0];
        let films = column("R_plane_film");
        let mut worst = 0.0f64;
        for (e, truth) in bricks.iter().zip(column("R_columns_incoherent")) {
            // Columns are printed with eight digits.
            worst = worst.max(((e.value - truth).abs() - 1e-8).max(0.0) / e.se);
        }
        assert!(worst < 5.0, "{around}: {worst} standard errors off the columns");
        let bricks: Vec<f64> = bricks.iter().map(|e| e.value).collect();
        assert!(side_lobe(&bricks) < side_lobe(&films), "{around}");
        let (x, y) = (column("R_rcwa_xpol_total"), column("R_rcwa_ypol_total"));
        let waves: Vec<f64> = x.iter().zip(&y).map(|(x, y)| 0.5 * (x + y)).collect();
        let distance = |of: &[f64]| rms(of.iter().zip(&waves).map(|(a, b)| a - b));
        println!(
            "{around}: {worst:.2} standard errors off the columns; off the waves {:.4}, films {:.4}",
            distance(&bricks),
            distance(&films)
        );
        assert!(distance(&bricks) < distance(&films), "{around}");
        // What rays cannot know.
        assert!(
            (distance(&bricks) - if around == "air" { 0.1453 } else { 0.1187 }).abs() < 2e-3,
            "{around}: {}",
            distance(&bricks)
        );
    }
}

#[test]
fn bricks_are_columns_of_films() {
    check_bricks(20_000);
}

#[test]
#[ignore = "slow: cargo test --release --test paper_films -- --ignored"]
fn bricks_are_columns_of_films_for_4e5_trees() {
    check_bricks(400_000);
}
