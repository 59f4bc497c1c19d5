//! Mueller matrices of scattering samples: possible ones, in the right frames, and the same light that other polarizations
//! find.
//!
//! Statistics come from independent seeds; a right program fails each judgement with probability 1e-3 (but seeds are fixed).
#![allow(clippy::print_stdout, reason = "p-values are shown with --nocapture")]

use crate::common::matrices;

use std::f64::consts::TAU;

use crate::common::Mesh;
use crate::common::build::{Build, ball, fibre, light, mesh};
use crate::common::cones::lopsided;
use crate::common::listen::settings;
use crate::common::stats::{moments, student, welch};
use glam::{DMat3, DVec3};
use gonio_embree::bsdf::{FacetValue, Scattering};
use gonio_embree::dome::Estimate;
use gonio_embree::experiment::measure;
use gonio_embree::light::{Light, Polarization};
use gonio_embree::optics::C64;
use gonio_embree::plan::{Name, Wanted};
use gonio_embree::sample::description::Fill;
use gonio_embree::sample::generate::bricks::Bricks;
use gonio_embree::sample::generate::packing::Packing;
use matrices::{Mueller, applied, is_physical, product, turn};

const FALSE_ALARM: f64 = 1e-3;
const NM: [f64; 2] = [450.0, 600.0];
const ALUMINIUM: C64 = C64::new(0.96, 6.69);
/// What rounding makes of a sum of many matrices.
const ROUNDING: f64 = 1e-12;

/// Dispersive spheres: the wavelengths of a ray part.
fn spheres() -> Build {
    let size = DVec3::new(20.0, 20.0, 12.0);
    let packing = Packing { count: 350, radius: 1.0, size, periodic: true, seed: 3 };
    let mut build = Build::within(1.0).patch(size.x, size.y);
    let glass = build.cauchy(1.5, 2e4);
    let balls = packing.centers().unwrap();
    balls.into_iter().fold(build, |build, center| build.fill(ball(center, 1.0), Fill::Medium(glass.clone())))
}

fn fibres() -> Build {
    let patch = Build::within(1.0).patch(16.0, 16.0);
    let rods = [
        ([-7.0, -5.0, 1.5], [7.0, -3.0, 1.8]),
        ([-6.0, 4.0, 1.5], [6.0, 1.0, 1.7]),
        ([-4.0, -7.0, 5.0], [-1.0, 7.0, 4.5]),
        ([3.0, -6.0, 4.5], [4.5, 6.0, 5.0]),
    ];
    rods.iter().fold(patch, |build, &(from, to)| build.hollow(fibre(from, to, 1.25), 1.55, 0.6, 1.0))
}

/// Like a feather: films in most places, and some spheres on them.
fn bricks() -> Build {
    let bricks = Bricks { layers: 3, ..Bricks::default() };
    [[-1.0, 0.5], [1.5, -1.0]]
        .iter()
        .fold(Build::within(1.0).bricks(&bricks, 2.0, 1.5), |build, &[x, y]| build.put(ball([x, y, 2.0], 0.9), 1.5))
}

fn measured(build: &Build, light: &Light, trees: u64, level: u8, seed: u64) -> Vec<Scattering> {
    let mut settings = settings(trees);
    (settings.dome_level, settings.seed) = (level, seed);
    settings.options.wanted = Wanted::AUTO.with(Name::Polarization, true);
    measure(&build.sample(light), light, &settings, |_| {}).unwrap().bsdf.incidences
}

fn values(m: &[Estimate; 16]) -> Mueller {
    m.map(|e| e.value)
}

/// Every matrix is a sum of those of rays, each of which keeps its phase or has lost all polarization: Cloude's matrix is
/// positive semidefinite to rounding, not only within errors. And its first element is what is told without matrices.
#[test]
fn all_matrices_are_physical() {
    let light = light(&NM, &[(0.0, 20.0), (50.0, 20.0)], Polarization::Mueller);
    for (name, build) in [("spheres", spheres()), ("lopsided", lopsided()), ("fibres", fibres()), ("bricks", bricks())]
    {
        let mut count = 0;
        for s in measured(&build, &light, 20_000, 3, 1) {
            let deltas = s.deltas.as_ref().unwrap();
            let told = [(&deltas.specular, &s.ledger.specular), (&deltas.undeflected, &s.ledger.undeflected)];
            let facets = s.facets.iter().map(|f| (&f.mueller, &f.value));
            for (matrices, powers) in told.into_iter().chain(facets) {
                assert_eq!((matrices.len(), powers.len()), (NM.len(), NM.len()));
                for (m, power) in matrices.iter().zip(powers) {
                    assert_eq!(m[0], *power, "{name}");
                    let m = values(m);
                    assert!(m[0] == 0.0 || is_physical(&m, ROUNDING), "{name}: {m:?}");
                    assert!(m[1..4].iter().all(|x| x.abs() <= m[0] * (1.0 + ROUNDING)), "{name}: {m:?}");
                    count += usize::from(m[0] > 0.0);
                }
            }
        }
        println!("{name}: {count} matrices");
        assert!(count > 300, "{name}: {count} matrices");
    }
}

/// Ways are chosen by the power of unpolarized light: its numbers are the very same.
#[test]
fn unpolarized_light_is_in_the_matrices() {
    let from = [(0.0, 20.0), (50.0, 20.0)];
    for build in [spheres(), lopsided(), bricks()] {
        let [with, without] = [Polarization::Mueller, Polarization::Unpolarized]
            .map(|polarization| measured(&build, &light(&NM, &from, polarization), 10_000, 3, 1));
        for (with, without) in with.iter().zip(&without) {
            assert_eq!((&with.ledger, with.segments), (&without.ledger, without.segments));
            let told = |f: &FacetValue| (f.facet, f.trees, f.value.clone());
            assert!(with.facets.iter().map(told).eq(without.facets.iter().map(told)));
            assert!(without.facets.iter().all(|f| f.mueller.is_empty()) && without.deltas.is_none());
        }
    }
}

/// Independent measurements, and trees of each.
const SEEDS: u64 = 24;
const TREES: u64 = 4000;
/// Facets of fewer trees in all say nothing.
const FEWEST: u64 = 500;

/// Shares of light of a Stokes vector: reflected, transmitted, and per facet of the coarsest dome.
fn shares_by_matrices(s: &Scattering, lane: usize, stokes: [f64; 4]) -> Vec<f64> {
    let power = |m: &[Estimate; 16]| applied(&values(m), stokes)[0];
    let facets: Vec<f64> = s.facets.iter().map(|f| power(&f.mueller[lane]) * f.facet.projected_solid_angle()).collect();
    let deltas = s.deltas.as_ref().unwrap();
    let hemisphere = |above: bool| {
        let part = s.facets.iter().zip(&facets).filter(|(f, _)| is_above(f) == above);
        part.map(|(_, x)| x).sum::<f64>()
    };
    let reflected = hemisphere(true) + power(&deltas.specular[lane]);
    let transmitted = hemisphere(false) + power(&deltas.undeflected[lane]);
    [reflected, transmitted].into_iter().chain(facets).collect()
}

fn is_above(f: &FacetValue) -> bool {
    f.facet.center().z > 0.0
}

fn shares(s: &Scattering, lane: usize) -> Vec<f64> {
    let facets = s.facets.iter().map(|f| f.value[lane].value * f.facet.projected_solid_angle());
    [s.ledger.reflected[lane].value, s.ledger.transmitted[lane].value].into_iter().chain(facets).collect()
}

/// One row per seed.
fn seeds<T>(build: &Build, light: &Light, first: u64, row: impl Fn(&Scattering) -> T) -> Vec<T> {
    (first..first + SEEDS).map(|seed| row(&measured(build, light, TREES, 1, seed)[0])).collect()
}

fn column(rows: &[Vec<f64>], at: usize) -> Vec<f64> {
    rows.iter().map(|row| row[at]).collect()
}

/// Least p-value times the number of comparisons.
fn judge(name: &str, chances: &[f64]) {
    let least = chances.iter().copied().fold(1.0, f64::min);
    println!("{name}: {} comparisons, least p = {least:.2e}", chances.len());
    assert!(least * chances.len() as f64 > FALSE_ALARM, "{name}: p = {least:e} of {}", chances.len());
}

#[test]
fn light_of_any_polarization_is_in_the_matrices() {
    let from = [(40.0, 25.0)];
    let states = [
        Polarization::S,
        Polarization::P,
        Polarization::Stokes([1.0, 0.0, 1.0, 0.0]),
        Polarization::Stokes([1.0, 0.2, -0.3, 0.5]),
    ];
    for (name, build) in [("lopsided", lopsided()), ("spheres", spheres())] {
        let all = seeds(&build, &light(&NM, &from, Polarization::Mueller), 1, Scattering::clone);
        for (i, state) in states.into_iter().enumerate() {
            let alone = seeds(&build, &light(&NM, &from, state), 1000 * (i as u64 + 1), Scattering::clone);
            let mut chances = Vec::new();
            for lane in 0..NM.len() {
                let predicted: Vec<Vec<f64>> =
                    all.iter().map(|s| shares_by_matrices(s, lane, state.stokes())).collect();
                let found: Vec<Vec<f64>> = alone.iter().map(|s| shares(s, lane)).collect();
                for at in 0..found[0].len() {
                    let trees = |of: &[Scattering]| of.iter().map(|s| s.facets[at - 2].trees).sum::<u64>();
                    if at < 2 || trees(&all).min(trees(&alone)) > FEWEST {
                        chances.push(welch(&column(&predicted, at), &column(&found, at)));
                    }
                }
            }
            judge(&format!("{name}, {state}"), &chances);
        }
    }
}

/// A sphere alone in the middle.
fn one_sphere() -> (Build, Light) {
    let build = Build::within(1.0).open().patch(4.0, 4.0).put(ball([0.0; 3], 2.0), 1.5);
    (build, light(&[550.0], &[(0.0, 0.0)], Polarization::Mueller))
}

/// The matrix of a facet for light from above, told in the frame (−ê, φ̂) of the plane of scattering at its centre, where
/// what leaves is told, too. At φ = 0, p̂ is −x̂ and ŝ is ŷ.
fn in_plane(f: &FacetValue) -> Mueller {
    let center = f.facet.center();
    let across = center.truncate().normalize();
    product(&values(&f.mueller[0]), &turn(across.x, across.y))
}

/// The facet whose centre is here.
fn facet_at(facets: &[FacetValue], center: DVec3) -> usize {
    facets.iter().position(|f| f.facet.center().distance(center) < 1e-9).unwrap()
}

/// The dome is the same after a fifth of a turn about z, and in a mirror: so are the matrices, but for the sign that a
/// mirror gives to U and V. A facet that is its own image has none of the elements that change their sign.
#[test]
fn a_sphere_scatters_the_same_all_round() {
    let (build, light) = one_sphere();
    let runs = seeds(&build, &light, 1, |s| s.facets.clone());
    let facets = &runs[0];
    let matrices: Vec<Vec<Mueller>> = runs.iter().map(|facets| facets.iter().map(in_plane).collect()).collect();
    let trees = |at: usize| runs.iter().map(|facets| facets[at].trees).sum::<u64>();
    let (mut chances, mut own) = (Vec::new(), 0);
    for (at, facet) in facets.iter().enumerate().filter(|(at, _)| trees(*at) > FEWEST) {
        for (mirrored, turns) in (0..10).map(|i| (i >= 5, i % 5)) {
            let mirror = DVec3::new(1.0, if mirrored { -1.0 } else { 1.0 }, 1.0);
            let image = DMat3::from_rotation_z(TAU / 5.0 * f64::from(turns)) * (mirror * facet.facet.center());
            let other = facet_at(facets, image);
            own += usize::from(mirrored && other == at);
            for element in (0..16).filter(|_| mirrored && other == at || other > at) {
                let sign = if mirrored && (element / 4 < 2) != (element % 4 < 2) { -1.0 } else { 1.0 };
                let differences: Vec<f64> =
                    matrices.iter().map(|m| m[at][element] - sign * m[other][element]).collect();
                if differences.iter().any(|d| d.abs() > 1e-12) {
                    chances.push(student(&differences, 0.0));
                }
            }
        }
    }
    assert!(own > 20, "{own} facets are their own images");
    judge("sphere, all round", &chances);
}

/// Tilted plates, metal and glass balls, turned about z: with the light, it reflects and transmits the same of any
/// polarization.
#[test]
fn a_turned_cluster_takes_its_light_along() {
    let cluster = |degrees: f64| {
        let turn = DMat3::from_rotation_z(degrees.to_radians());
        let tilt = DMat3::from_axis_angle(DVec3::new(1.0, 0.6, 0.2).normalize(), 0.9);
        let plate =
            |at: DVec3| mesh(Mesh::cube().map(|p| turn * (tilt * ((p - 0.5) * DVec3::new(4.0, 4.0, 0.5)) + at)));
        Build::within(1.0)
            .open()
            .patch(12.0, 12.0)
            .put(plate(DVec3::ZERO), 1.7)
            .put(plate(DVec3::Z), 2.0)
            .put(ball(turn * DVec3::new(-2.5, -1.5, 0.0), 1.0), ALUMINIUM)
            .priority(1)
            .put(ball(turn * DVec3::new(2.5, 1.5, 0.5), 1.0), 1.5)
            .priority(1)
    };
    let row = |s: &Scattering| -> Vec<f64> {
        let units = (0..4).map(|c| std::array::from_fn(|i| if i == c { 1.0 } else { 0.0 }));
        units.flat_map(|unit| shares_by_matrices(s, 0, unit)[..2].to_vec()).collect()
    };
    let at = |degrees: f64, seed| {
        let light = light(&[550.0], &[(40.0, 10.0 + degrees)], Polarization::Mueller);
        seeds(&cluster(degrees), &light, seed, row)
    };
    let (a, b) = (at(0.0, 1), at(77.0, 1000));
    let chances: Vec<f64> = (0..8).map(|i| welch(&column(&a, i), &column(&b, i))).collect();
    judge("turned cluster", &chances);
    let seen = (0..8).filter(|&i| {
        let (mean, variance, _) = moments(&column(&a, i));
        mean * mean > 25.0 * variance
    });
    assert!(seen.count() >= 6, "too noisy to tell");
}
