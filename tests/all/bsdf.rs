//! The result as a function: interpolation, reciprocity, sampling.

use crate::common::synthetic::{ggx, result};
use glam::DVec3;
use gonio_embree::bsdf::{Lookup, Sampler, turned};
use gonio_embree::light::Incidence;
use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};

const NM: [f64; 2] = [450.0, 650.0];

fn at(theta_deg: f64, phi_deg: f64) -> Incidence {
    Incidence { theta_deg, phi_deg }
}

fn grid(theta: &[f64], phi: &[f64]) -> Vec<(f64, f64)> {
    theta.iter().flat_map(|&t| phi.iter().map(move |&p| (t, p))).collect()
}

#[test]
fn measured_incidences_are_their_own_values() {
    let bsdf = result(3, &grid(&[0.0, 30.0, 60.0], &[0.0, 90.0, 200.0]), &NM, 0.1, |i, _, nm| {
        1e-3 * (i.theta_deg + i.phi_deg) + 1e-6 * nm
    });
    let lookup = Lookup::new(&bsdf);
    for (n, s) in bsdf.incidences.iter().enumerate().filter(|(_, s)| s.incidence.theta_deg > 0.0) {
        let blend = lookup.at(&s.incidence);
        assert_eq!(blend.parts().len(), 1, "{n}");
        for f in s.facets.iter().step_by(37) {
            assert_eq!(blend.value(f.facet.center(), 1).value, f.value[1].value);
        }
        assert_eq!(blend.share(|l| &l.reflected, 0).value, s.ledger.reflected[0].value);
    }
}

/// Between incidences values go straight, also across 360°, and errors of independent measurements add as squares.
#[test]
fn values_between_are_those_of_the_four_nearest() {
    let f = |i: &Incidence, _: DVec3, _: f64| 0.01 * i.theta_deg + 0.001 * i.phi_deg;
    let bsdf = result(1, &grid(&[10.0, 30.0], &[0.0, 90.0, 270.0]), &NM, 0.0, f);
    let lookup = Lookup::new(&bsdf);
    let value = |theta, phi| lookup.at(&at(theta, phi)).value(DVec3::Z, 0);
    assert!((value(15.0, 30.0).value - (0.15 + 0.03)).abs() < 1e-12);
    assert!((value(25.0, -45.0).value - (0.25 + 0.5 * 0.27)).abs() < 1e-12);
    assert!((value(25.0, 315.0).value - (0.25 + 0.5 * 0.27)).abs() < 1e-12);
    assert!((value(50.0, 90.0).value - (0.3 + 0.09)).abs() < 1e-12, "beyond the last, the last");
    assert!((value(0.0, 90.0).value - (0.1 + 0.09)).abs() < 1e-12);
    let four = lookup.at(&at(20.0, 45.0));
    assert_eq!(four.parts().len(), 4);
    let whole: f64 = four.parts().iter().map(|p| p.weight).sum();
    assert!((whole - 1.0).abs() < 1e-15);
    let errors = [0.1, 0.19, 0.3, 0.39].map(|v| (0.25 * 0.01 * v * 1.0f64).powi(2)).iter().sum::<f64>().sqrt();
    assert!((four.value(DVec3::Z, 0).se - errors).abs() < 1e-12);
}

/// One azimuth stands for all: the lobe turns with the light. Between many azimuths it is where they have it.
#[test]
fn lobes_turn_with_the_light() {
    let f = |i: &Incidence, o: DVec3, _: f64| ggx(i, o, [0.3, 0.3]);
    let many: Vec<f64> = (0..36).map(|i| 10.0 * f64::from(i)).collect();
    for azimuths in [&[40.0][..], &many] {
        let bsdf = result(5, &grid(&[0.0, 45.0], azimuths), &NM, 0.0, f);
        let lookup = Lookup::new(&bsdf);
        assert_eq!(lookup.is_isotropic(), azimuths.len() == 1);
        for phi in [0.0, 77.0, 190.0, 333.0] {
            let i = at(45.0, phi);
            let (here, truth) =
                (lookup.at(&i).value(i.in_plane(45.0, false), 0).value, f(&i, i.in_plane(45.0, false), 0.0));
            assert!((here / truth - 1.0).abs() < 0.05, "{phi}: {here} {truth}");
        }
    }
}

#[test]
fn undeflected_light_follows_snell() {
    let mut bsdf = result(1, &[(0.0, 0.0), (30.0, 0.0), (60.0, 0.0)], &NM, 0.0, |_, _, _| 0.1);
    let refracted = |deg: f64, n: f64| (deg.to_radians().sin() / n).asin().to_degrees();
    for s in &mut bsdf.incidences {
        s.straight_deg = vec![refracted(s.incidence.theta_deg, 1.5), refracted(s.incidence.theta_deg, 0.8)];
    }
    let lookup = Lookup::new(&bsdf);
    let straight = |theta: f64, w| lookup.at(&at(theta, 20.0)).straight(w);
    let expected = at(45.0, 20.0).in_plane(refracted(45.0, 1.5), true);
    assert!(straight(45.0, 0).unwrap().distance(expected) < 1e-14);
    assert_eq!(straight(0.0, 0), Some(DVec3::NEG_Z));
    assert!(straight(50.0, 1).is_some() && straight(60.0, 1).is_none(), "total reflection");
}

#[test]
fn a_reciprocal_lobe_is_told_from_one_that_is_not() {
    let angles: Vec<(f64, f64)> = grid(&[10.0, 30.0, 50.0], &[0.0, 60.0, 180.0]);
    let lobe = result(5, &angles, &NM, 0.0, |i, o, _| ggx(i, o, [0.6, 0.4]));
    let good = lobe.reciprocity().unwrap();
    assert_eq!(good.pairs, 36 * 2);
    assert!(good.rms < 0.03, "{good:?}");
    let skew = result(5, &angles, &NM, 0.0, |i, o, _| o.z + 0.5 * i.theta_deg.to_radians());
    let bad = skew.reciprocity().unwrap();
    assert!(bad.rms > 0.1 && bad.greatest_z > 10.0 && bad.rms > 5.0 * bad.noise, "{bad:?}");
    assert!(result(1, &[(0.0, 0.0)], &NM, 0.0, |_, _, _| 0.1).reciprocity().is_none());
}

/// Directions fall into facets as often as light does (χ² over 80 facets: above 130 with a probability of 3e-4), and the
/// mean weight is the albedo.
#[test]
fn drawn_directions_follow_the_light() {
    let f = |i: &Incidence, o: DVec3, _: f64| if o.z > 0.0 { 0.5 * ggx(i, o, [0.5, 0.5]) } else { 0.02 };
    let bsdf = result(2, &[(20.0, 0.0), (40.0, 0.0)], &NM, 0.2, f);
    let lookup = Lookup::new(&bsdf);
    let light = at(32.0, 15.0);
    let sampler = Sampler::new(&lookup, &light, 0);
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(4);
    let (n, mut deltas, mut sum, mut power) = (200_000, 0.0, 0.0, std::collections::BTreeMap::new());
    let locator = gonio_embree::dome::Locator::new(1);
    for _ in 0..n {
        let drawn = sampler.draw(std::array::from_fn(|_| rng.random())).unwrap();
        sum += drawn.weight;
        match drawn.density {
            None => {
                deltas += drawn.weight;
                assert!(drawn.exit.distance(light.in_plane(32.0, false)) < 1e-14);
            }
            Some(density) => {
                assert!((sampler.density(drawn.exit) / density - 1.0).abs() < 1e-12);
                *power.entry(locator.code(drawn.exit)).or_insert(0.0) += drawn.weight;
            }
        }
    }
    let n = f64::from(n);
    assert!((sum / n - sampler.albedo()).abs() < 0.01 * sampler.albedo(), "{} {}", sum / n, sampler.albedo());
    assert!((deltas / n - 0.2).abs() < 0.005, "{deltas}");
    // The same flux by quadrature of the value, facet by facet.
    let blend = lookup.at(&light);
    for facet in gonio_embree::dome::Facet::all(1) {
        let fine = |f: gonio_embree::dome::Facet| f.children();
        let parts = fine(facet).into_iter().flat_map(fine).flat_map(fine).flat_map(fine);
        let flux: f64 = parts.map(|p| blend.value(p.center(), 0).value * p.projected_solid_angle()).sum();
        let drawn = power.get(&facet.code).copied().unwrap_or(0.0) / n;
        // Six binomial standard deviations and the quadrature's own error.
        assert!((drawn - flux).abs() < 6.0 * (flux / n).sqrt() + 0.01 * flux, "{facet:?}: {drawn} {flux}");
    }
    // The density is one.
    let parts = gonio_embree::dome::Facet::all(6);
    let whole: f64 = parts.map(|p| sampler.density(p.center()) * p.solid_angle()).sum();
    assert!((whole + 0.2 / sampler.albedo() - 1.0).abs() < 2e-3, "{whole}");
}

#[test]
fn a_black_sample_gives_no_direction() {
    let bsdf = result(1, &[(0.0, 0.0)], &NM, 0.0, |_, _, _| 0.0);
    let lookup = Lookup::new(&bsdf);
    let sampler = Sampler::new(&lookup, &at(0.0, 0.0), 0);
    assert!(sampler.draw([0.5; 3]).is_none() && sampler.density(DVec3::Z) == 0.0);
}

#[test]
fn turning_keeps_the_height() {
    let d = turned(DVec3::new(0.6, 0.0, 0.8), 90.0);
    assert!(d.distance(DVec3::new(0.0, 0.6, 0.8)) < 1e-15);
}
