//! Scans in the plane of incidence, by the detector itself and from the dome.

use std::f64::consts::PI;

use crate::common::build::{Build, ball, cuboid, light};
use crate::common::listen::settings;
use gonio_embree::bsdf::{Arm, Scan};
use gonio_embree::experiment::{Outcome, Settings, measure};
use gonio_embree::light::{Light, Polarization};
use gonio_embree::sample::description::{Fill, Shape};

fn arm(from: i32, to: i32, step: usize, aperture_deg: f64, below: bool) -> Arm {
    Arm { angles_deg: (from..=to).step_by(step).map(f64::from).collect(), aperture_deg, below, turn_deg: 0.0 }
}

fn measured(build: &Build, light: &Light, arm: &Arm, trees: u64, dome_level: u8) -> Outcome {
    let settings = Settings { arm: Some(arm.clone()), dome_level, ..settings(trees) };
    measure(&build.sample(light), light, &settings, |_| {}).unwrap()
}

fn matt() -> Build {
    let white = Shape::Slab { top: 0.0, bottom: -1.0 };
    Build::within(1.0).patch(1.0, 1.0).fill(white, Fill::Diffuse(0.8))
}

/// Largest difference of the readings from `truth` in standard errors, and the sum of the squares.
fn deviations(scan: &Scan, truth: f64) -> (f64, f64) {
    let z = scan.readings.iter().map(|r| (r.value[0].value - truth) / r.value[0].se);
    z.fold((0.0, 0.0), |(most, sum), z| (f64::max(most, z.abs()), sum + z * z))
}

/// 13 apertures that do not overlap, and the same out of the dome: a |z| above 4.8 (Student, 31 degrees of freedom)
/// has a probability of 4e-5.
#[test]
fn a_lambertian_is_the_same_from_everywhere() {
    let light = light(&[550.0], &[(45.0, 30.0)], Polarization::Unpolarized);
    let arm = arm(-90, 90, 15, 12.0, false);
    let outcome = measured(&matt(), &light, &arm, 200_000, 4);
    let of_dome = outcome.bsdf.scan(&arm, 0);
    for scan in [&outcome.scans[0], &of_dome] {
        let (most, sum) = deviations(scan, 0.8 / PI);
        assert!(most < 4.8 && sum < 45.0, "{most} {sum}");
    }
    assert!(of_dome.readings.iter().zip(&outcome.scans[0].readings).all(|(d, s)| d.value[0].se < s.value[0].se));
}

/// Under a coarse dome and on spheres, whose lobe is steep, the detector itself and the facets agree within what a facet
/// blurs: here facets are 2° and apertures 8° wide, and only noise is left. A |z| above 5 in 23 readings: 1e-5.
#[test]
fn facets_and_detectors_see_the_same() {
    let spheres = [[-3.0, -2.0, 2.0], [2.0, 2.0, 4.0], [3.0, -3.0, 3.0]];
    let floor = cuboid([-6.0, -6.0, -1.0], [6.0, 6.0, 0.0]);
    let base = Build::within(1.0).patch(12.0, 12.0).fill(floor, Fill::Diffuse(0.9));
    let build = spheres.into_iter().fold(base, |b, center| b.put(ball(center, 2.0), 1.5));
    let light = light(&[550.0], &[(30.0, 70.0)], Polarization::S);
    let arm = arm(-88, 88, 8, 8.0, false);
    let outcome = measured(&build, &light, &arm, 400_000, 5);
    for (facets, detector) in outcome.bsdf.scan(&arm, 0).readings.iter().zip(&outcome.scans[0].readings) {
        let (a, b) = (facets.value[0], detector.value[0]);
        // The same trees: the errors are not independent, so that this is cautious.
        assert!((a.value - b.value).abs() < 5.0 * a.se.hypot(b.se), "{}°: {a:?} {b:?}", detector.angle_deg);
        assert!(b.se < 0.2 * b.value, "too noisy to tell");
    }
}

/// A pane of glass: its mirror image and what passes it are in the aperture that looks there, and in no other.
#[test]
fn deltas_are_in_the_aperture_that_looks_there() {
    let build = Build::within(1.0).below(1.5).patch(1.0, 1.0);
    let film = build.films(0.0, &[(1.5, 0.2)]);
    let light = light(&[550.0], &[(40.0, 200.0)], Polarization::P);
    let sine: f64 = f64::to_radians(40.0).sin() / 1.5;
    for (below, at) in [(false, 40.0), (true, sine.asin().to_degrees())] {
        let mut arm = arm(-80, 80, 10, 3.0, below);
        arm.angles_deg.push(at + 1.2);
        let outcome = measured(&film, &light, &arm, 1000, 3);
        let ledger = &outcome.bsdf.incidences[0].ledger;
        let share = if below { &ledger.undeflected } else { &ledger.specular }[0].value;
        assert!(share > 0.0 && (outcome.bsdf.incidences[0].straight_deg[0] - sine.asin().to_degrees()).abs() < 1e-12);
        for scan in [&outcome.scans[0], &outcome.bsdf.scan(&arm, 0)] {
            for reading in &scan.readings {
                let apertures = arm.apertures(&scan.incidence);
                let axis = scan.incidence.in_plane(reading.angle_deg, below);
                let looks = (reading.angle_deg - at).abs() < 1.5;
                let expected = if looks { share / apertures.projected_solid_angle(axis) } else { 0.0 };
                let value = reading.value[0].value;
                assert!(
                    (value - expected).abs() <= 1e-9 * expected,
                    "{below} {}°: {value} {expected}",
                    reading.angle_deg
                );
            }
        }
    }
}

/// A detector changes nothing of what the dome measures.
#[test]
fn a_detector_takes_no_light() {
    let light = light(&[500.0, 600.0], &[(10.0, 0.0), (60.0, 90.0)], Polarization::Unpolarized);
    let with = measured(&matt(), &light, &arm(-90, 90, 1, 4.0, false), 5000, 3);
    let without = measure(&matt().sample(&light), &light, &settings(5000), |_| {}).unwrap();
    assert_eq!(with.bsdf, without.bsdf);
    assert!(without.scans.is_empty() && with.scans.len() == 2);
}

#[test]
fn arms_that_reach_nowhere_are_refused() {
    let fine = arm(-90, 90, 30, 2.0, false);
    assert!(fine.check().is_ok());
    assert!(Arm { angles_deg: vec![91.0], ..fine.clone() }.check().is_err());
    assert!(Arm { aperture_deg: 0.0, ..fine.clone() }.check().is_err());
    assert!(Arm { aperture_deg: f64::NAN, ..fine }.check().is_err());
}

/// An arm that is turned by 180° reads the same the other way round; by 90° it leaves the plane of incidence, where a lobe
/// towards +x is seen from the side.
#[test]
fn turned_arms_leave_the_plane_of_incidence() {
    use crate::common::synthetic::result;
    let bsdf = result(5, &[(30.0, 180.0)], &[550.0], 0.0, |_, o, _| if o.x > 0.5 { 1.0 } else { 0.1 + 0.05 * o.y });
    let arm = |turn_deg: f64| Arm { turn_deg, ..arm(-80, 80, 20, 2.0, false) };
    let values = |turn_deg: f64| -> Vec<f64> {
        bsdf.scan(&arm(turn_deg), 0).readings.iter().map(|r| r.value[0].value).collect()
    };
    let (plain, round) = (values(0.0), values(180.0));
    assert!(plain.iter().zip(round.iter().rev()).all(|(a, b)| (a - b).abs() < 1e-9));
    assert!(plain[8] > 0.99 && plain[0] < 0.2, "{plain:?}");
    assert!(values(90.0).iter().all(|v| *v < 0.2) && values(90.0)[8] > values(90.0)[0], "{:?}", values(90.0));
    assert!(Arm { turn_deg: f64::NAN, ..arm(0.0) }.check().is_err());
}
