//! Results held against each other: chance is no difference, and a difference is told.

use crate::common::build::{Build, ball, cuboid, light};
use crate::common::listen::settings;
use crate::common::synthetic;
use gonio_embree::bsdf::Bsdf;
use gonio_embree::bsdf::compare::compare;
use gonio_embree::dome::Estimate;
use gonio_embree::experiment::{Settings, measure};
use gonio_embree::light::Polarization;
use gonio_embree::output::compare as output;
use gonio_embree::sample::description::Fill;

/// Glass spheres of this index on a grey floor.
fn spheres(index: f64, seed: u64) -> Bsdf {
    let light = light(&[450.0, 550.0, 650.0], &[(10.0, 0.0), (50.0, 20.0)], Polarization::Unpolarized);
    let floor = cuboid([-6.0, -6.0, -1.0], [6.0, 6.0, 0.0]);
    let base = Build::within(1.0).patch(12.0, 12.0).fill(floor, Fill::Diffuse(0.6));
    let centers = [[-3.0, -2.0, 2.0], [2.0, 2.0, 4.0], [3.0, -3.0, 3.0]];
    let build = centers.into_iter().fold(base, |b, center| b.put(ball(center, 1.9), index));
    let settings = Settings { seed, dome_level: 4, ..settings(20_000) };
    measure(&build.sample(&light), &light, &settings, |_| {}).unwrap().bsdf
}

/// 15 pairs of seeds, each with a false-alarm rate of 1e-3: one of them alarms with a probability of 1.5 %.
#[test]
fn seeds_differ_by_chance_alone() {
    let results: Vec<Bsdf> = (1..=6).map(|seed| spheres(1.5, seed)).collect();
    for (i, a) in results.iter().enumerate() {
        for b in &results[..i] {
            let comparison = compare(a, b).unwrap();
            assert!(comparison.spectra.len() == 6 && comparison.numbers > 100);
            assert!(comparison.agrees(), "{}", output::text(&comparison, &[]));
        }
    }
}

#[test]
fn another_sample_is_told_apart() {
    let comparison = compare(&spheres(1.5, 1), &spheres(1.8, 2)).unwrap();
    assert!(!comparison.agrees() && comparison.greatest_z() > 8.0, "{}", output::text(&comparison, &[]));
}

#[test]
fn a_result_is_the_same_as_itself_and_has_its_colour() {
    let nm: Vec<f64> = (0..16).map(|i| 400.0 + 20.0 * f64::from(i)).collect();
    let of = |x: f64| synthetic::result(2, &[(0.0, 0.0)], &nm, 0.1, move |_, o, nm| o.z.max(0.0) * x * nm / 3000.0);
    let (a, b) = (of(1.0), of(1.05));
    let same = compare(&a, &a).unwrap();
    assert!(same.agrees() && same.greatest_z() == 0.0);
    assert!(output::colours(&a, &a)[0].daylight == 0.0);
    let colour = output::colours(&a, &b)[0];
    assert!(colour.daylight > 0.3 && colour.daylight < 3.0 && colour.lamplight > 0.3, "{colour:?}");
    assert!(!compare(&a, &b).unwrap().agrees(), "5 % in every facet, with errors of 1 %");
}

/// Fine facets of one dome add up to the coarse facet of the other.
#[test]
fn domes_are_compared_in_their_coarser_facets() {
    let of = |level| synthetic::result(level, &[(20.0, 0.0)], &[550.0], 0.0, |_, o, _| 0.2 + 0.1 * o.x);
    let (coarse, fine) = (of(2), of(4));
    for (a, b) in [(&coarse, &fine), (&fine, &coarse)] {
        let comparison = compare(a, b).unwrap();
        let c = &comparison.spectra[0];
        assert_eq!(c.facets, 320);
        assert!(c.rms < 1e-3, "{}", c.rms);
    }
}

#[test]
fn results_without_anything_in_common_are_refused() {
    let of = |theta: f64, nm: f64| synthetic::result(1, &[(theta, 0.0)], &[nm], 0.0, |_, _, _| 0.1);
    assert!(compare(&of(0.0, 500.0), &of(10.0, 500.0)).is_err() && compare(&of(0.0, 500.0), &of(0.0, 510.0)).is_err());
}

/// Deterministic parts: a mirror is the same but for rounding, or it differs without bound.
#[test]
fn numbers_without_errors_are_equal_or_not() {
    let of = |specular: f64| {
        let mut bsdf = synthetic::result(1, &[(0.0, 0.0)], &[500.0], specular, |_, _, _| 0.0);
        bsdf.incidences[0].ledger.specular[0] = Estimate { value: specular, se: 0.0 };
        bsdf
    };
    assert!(compare(&of(0.3), &of(0.3 + 1e-9)).unwrap().agrees());
    assert!(compare(&of(0.3), &of(0.301)).unwrap().greatest_z().is_infinite());
}
