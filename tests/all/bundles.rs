//! Wavelengths that share a ray are told apart where it matters: flat dispersive samples send their light exactly in the
//! mirror direction and straight on, whether wavelengths share rays or not.

use crate::common::build::{Build, ball, cuboid, light};
use crate::common::listen::settings;
use crate::common::reference::Comparisons;
use gonio_embree::bsdf::Ledger;
use gonio_embree::dome::Estimate;
use gonio_embree::experiment::{Settings, measure};
use gonio_embree::light::{Light, Polarization};
use gonio_embree::optics::Pair;
use gonio_embree::optics::fresnel::{dielectric, other_leg};
use gonio_embree::plan::{Limits, Options};
use gonio_embree::sample::description::{Fill, Shape};

/// Cauchy's coefficients of a glass, λ in nm.
const GLASS: (f64, f64) = (1.5, 6000.0);

fn grid() -> Vec<f64> {
    (0..16).map(|i| 400.0 + 20.0 * f64::from(i)).collect()
}

/// Reflectance of the surface of the glass for s and p light.
fn surface(nm: f64, theta_deg: f64) -> Pair<f64> {
    let cos = theta_deg.to_radians().cos();
    dielectric(1.0, GLASS.0 + GLASS.1 / (nm * nm), cos, other_leg(cos)).r().map(|r| r.norm_sqr())
}

fn slab() -> (Build, Shape, Fill) {
    let mut build = Build::within(1.0);
    let glass = build.cauchy(GLASS.0, GLASS.1);
    (build, Shape::Slab { top: 0.0, bottom: -200.0 }, Fill::Medium(glass))
}

fn run(build: &Build, light: &Light, settings: &Settings) -> Vec<(f64, Ledger, u64)> {
    let outcome = measure(&build.sample(light), light, settings, |_| {}).unwrap();
    let hits = |s: &gonio_embree::bsdf::Scattering| s.facets.iter().map(|f| f.trees).sum();
    outcome.bsdf.incidences.iter().map(|s| (s.incidence.theta_deg, s.ledger.clone(), hits(s))).collect()
}

const ANGLES: [(f64, f64); 4] = [(0.0, 0.0), (30.0, 20.0), (60.0, 100.0), (80.0, 250.0)];

/// All of the light: none goes to the facets.
#[test]
fn a_dispersive_slab_reflects_and_transmits_along_exact_directions() {
    let (build, shape, fill) = slab();
    let build = build.fill(shape, fill);
    let mut comparisons = Comparisons::default();
    for polarization in [Polarization::S, Polarization::P] {
        let light = light(&grid(), &ANGLES, polarization);
        for (theta, ledger, facets) in run(&build, &light, &settings(50_000)) {
            let at = format!("{theta}° {polarization}");
            assert_eq!(facets, 0, "{at}: trees that hit facets");
            for (i, nm) in grid().into_iter().enumerate() {
                let rho = surface(nm, theta);
                let rho = if polarization == Polarization::S { rho.s } else { rho.p };
                comparisons.add(&format!("{at}, {nm} nm"), ledger.specular[i], 2.0 * rho / (1.0 + rho));
                assert_eq!(ledger.specular[i], ledger.reflected[i], "{at}");
                assert_eq!(ledger.undeflected[i], ledger.transmitted[i], "{at}");
            }
        }
    }
    comparisons.judge(2e-3);
}

/// The straight direction in a dispersive medium is not the same for all wavelengths.
#[test]
fn light_goes_straight_into_a_dispersive_ground() {
    let (mut build, shape, fill) = slab();
    let Fill::Medium(glass) = &fill else { unreachable!() };
    build.0.below = glass.clone();
    let light = light(&grid(), &ANGLES, Polarization::Unpolarized);
    for (theta, ledger, facets) in run(&build.fill(shape, fill), &light, &settings(64)) {
        assert_eq!(facets, 0, "{theta}°: trees that hit facets");
        for (i, nm) in grid().into_iter().enumerate() {
            let rho = surface(nm, theta);
            let expected = 0.5 * (rho.s + rho.p);
            assert!((ledger.specular[i].value - expected).abs() < 1e-9, "{theta}°, {nm} nm: {ledger:?}");
            assert!((ledger.undeflected[i].value - (1.0 - expected)).abs() < 1e-9, "{theta}°, {nm} nm: {ledger:?}");
        }
    }
}

/// Default options, and such that every wavelength has rays of its own.
fn shared_and_alone() -> [Options; 2] {
    let limits = Limits { spread: 0.0, ..Limits::default() };
    [Options::default(), Options { limits, ..Options::default() }]
}

/// Where a ball scatters some of the light, the exact directions get as much of it whether wavelengths share rays or not.
#[test]
fn what_scatters_is_told_from_what_does_not() {
    let (build, shape, fill) = slab();
    let pane = cuboid([-9.0, -15.0, 30.0], [3.0, 15.0, 60.0]);
    let build = build.patch(40.0, 40.0).fill(shape, fill.clone()).fill(pane, fill.clone());
    let build = build.fill(ball([15.0, 0.0, 20.0], 4.0), fill);
    let light = light(&grid(), &[(0.0, 0.0), (40.0, 0.0)], Polarization::Unpolarized);
    let [shared, alone] =
        shared_and_alone().map(|options| run(&build, &light, &Settings { options, ..settings(8000) }));
    let mut comparisons = Comparisons::default();
    for ((theta, shared, facets), (_, alone, _)) in shared.iter().zip(&alone) {
        assert!(*facets > 0);
        for (name, a, b) in [
            ("specular", &shared.specular, &alone.specular),
            ("undeflected", &shared.undeflected, &alone.undeflected),
            ("reflected", &shared.reflected, &alone.reflected),
        ] {
            for (i, nm) in grid().iter().enumerate() {
                assert!(b[i].value > 0.01, "{theta}°, {name}: {:?}", b[i]);
                let both = Estimate { value: a[i].value, se: a[i].se.hypot(b[i].se) };
                comparisons.add(&format!("{theta}°, {name}, {nm} nm"), both, b[i].value);
            }
        }
    }
    comparisons.judge(5e-3);
}

/// A liquid matches balls at one of the wavelengths, to within rounding. That one goes straight on, whoever shares its rays
/// before.
#[test]
fn light_that_sees_nothing_goes_straight_on() {
    let mut build = Build::within(1.0);
    let (glass, liquid) = (build.cauchy(1.585, 4480.0), build.cauchy(1.535, 18_000.0));
    (build.0.above, build.0.below) = (liquid.clone(), liquid);
    let balls = (0..20).map(|i| ball([f64::from(i % 5 - 2) * 4.1, 0.0, 4.5 * f64::from(i / 5)], 2.0));
    let build = balls.fold(build.open().patch(20.0, 4.0), |b, ball| b.fill(ball, Fill::Medium(glass.clone())));
    let nm: Vec<f64> = (0..20).map(|i| 400.0 + 15.0 * f64::from(i)).collect();
    let light = light(&nm, &[(0.0, 0.0), (50.0, 40.0)], Polarization::Unpolarized);
    for (theta, ledger, _) in run(&build, &light, &settings(5000)) {
        for (i, nm) in nm.iter().enumerate() {
            let straight = ledger.undeflected[i].value;
            if *nm == 520.0 {
                assert!((straight - 1.0).abs() < 1e-9, "{theta}°: {straight}");
            } else {
                assert!(straight < 0.9, "{theta}°, {nm} nm: {straight}");
            }
        }
    }
}

/// Light that enters a ball near its rim leaves it nearly at grazing angles. No wavelength may be led beyond the critical
/// angle there by others: it would go round for ever.
#[test]
fn no_wavelength_is_caught_in_a_ball() {
    let (build, _, fill) = slab();
    let build = build.open().patch(10.0, 10.0).fill(ball([0.0; 3], 5.0), fill);
    let light = light(&grid(), &[(0.0, 0.0)], Polarization::Unpolarized);
    let [shared, alone] =
        shared_and_alone().map(|options| run(&build, &light, &Settings { options, ..settings(64_000) }));
    let mut comparisons = Comparisons::default();
    for (i, nm) in grid().iter().enumerate() {
        let (a, b) = (&shared[0].1, &alone[0].1);
        assert_eq!(a.lost_depth[i].value, 0.0, "{nm} nm");
        let se = a.reflected[i].se.hypot(b.reflected[i].se);
        comparisons.add(&format!("{nm} nm"), Estimate { value: a.reflected[i].value, se }, b.reflected[i].value);
    }
    comparisons.judge(1e-3);
}
