//! Where power is absorbed, and how much: slabs, piles of plates, matt grounds under glass, mirrors, metals.
//!
//! Truth comes from closed forms, most of them in `tests/reference/closed_forms.json`. Estimates may be four standard errors
//! off, once in 2700 times; a test of so many comparisons fails a right program with the sum of that (but seeds are fixed).

use crate::common::collapse;
use std::f64::consts::PI;

use crate::common::Mesh;
use crate::common::build::{Build, ball, light, mesh};
use crate::common::listen::settings;
use crate::common::reference::{Case, Comparisons, closed_forms};
use glam::DVec3;
use gonio_embree::bsdf::{Bsdf, Scattering};
use gonio_embree::dome::{Estimate, Facet};
use gonio_embree::experiment::{Settings, measure};
use gonio_embree::light::{Light, Polarization, SourceMode};
use gonio_embree::optics::C64;
use gonio_embree::plan::{Limits, Options};
use gonio_embree::sample::description::{Fill, Shape};

const NM: f64 = 550.0;

/// Runs a sample; its ledgers add up, and what bodies absorb adds up to what is absorbed.
fn run(build: &Build, light: &Light, settings: &Settings) -> Bsdf {
    let bsdf = measure(&build.sample(light), light, settings, |_| {}).unwrap().bsdf;
    for s in &bsdf.incidences {
        for (i, sum) in s.ledger.sum().into_iter().enumerate() {
            assert!((sum - 1.0).abs() < 1e-9, "{sum} at {:?}", s.incidence);
            assert_eq!(s.ledger.lost()[i], 0.0, "{:?}", s.incidence);
            let bodies: f64 = s.absorbed_by.iter().map(|group| group[i].value).sum();
            assert!(
                (bodies - s.ledger.absorbed[i].value).abs() < 1e-9,
                "{bodies} at {:?}: {:?}",
                s.incidence,
                s.ledger
            );
        }
    }
    bsdf
}

/// What a body absorbs, at a wavelength.
fn absorbed_by(bsdf: &Bsdf, s: &Scattering, name: &str, i: usize) -> Estimate {
    let group = bsdf.groups.iter().position(|n| n == name).unwrap_or_else(|| panic!("{name}: {:?}", bsdf.groups));
    s.absorbed_by[group][i]
}

/// The angles of a table, each once.
fn angles(cases: &[Case], key: &str) -> Vec<(f64, f64)> {
    let mut all: Vec<(f64, f64)> = Vec::new();
    for angle in cases.iter().map(|c| c.number(key)) {
        if !all.contains(&(angle, 0.0)) {
            all.push((angle, 0.0));
        }
    }
    all
}

fn at(bsdf: &Bsdf, theta: f64) -> &Scattering {
    bsdf.incidences.iter().find(|s| s.incidence.theta_deg == theta).unwrap()
}

/// The cases for one polarization.
fn polarized(cases: &[Case], polarization: Polarization) -> impl Iterator<Item = &Case> {
    cases.iter().filter(move |c| c.word("pol") == polarization.to_string())
}

/// A slab from z = 0 down.
fn slab(n: impl Into<C64>, depth: f64) -> Build {
    let mut build = Build::within(1.0);
    let medium = build.medium(n);
    build.fill(Shape::Slab { top: 0.0, bottom: -depth }, Fill::Medium(medium))
}

#[test]
fn a_thick_slab_reflects_from_both_faces() {
    let cases = closed_forms("slab_incoherent");
    let mut comparisons = Comparisons::default();
    for polarization in [Polarization::S, Polarization::P] {
        let light = light(&[NM], &angles(&cases, "angle_deg"), polarization);
        let bsdf = run(&slab(1.5, 250.0), &light, &settings(100_000));
        for case in polarized(&cases, polarization) {
            let ledger = &at(&bsdf, case.number("angle_deg")).ledger;
            comparisons.add(&format!("R, {case:?}"), ledger.specular[0], case.number("R"));
            comparisons.add(&format!("T, {case:?}"), ledger.undeflected[0], case.number("T"));
            assert_eq!(ledger.absorbed[0].value, 0.0);
        }
    }
    comparisons.judge(1e-3);
}

#[test]
fn a_slab_absorbs_along_its_ways() {
    let (mu, depth) = (2.0e-3, 250.0);
    let ink = C64::new(1.5, mu * NM / 1e3 / (4.0 * PI));
    let cases = closed_forms("slab_absorbing");
    let mut comparisons = Comparisons::default();
    for polarization in [Polarization::S, Polarization::P] {
        let light = light(&[NM], &angles(&cases, "angle_deg"), polarization);
        let bsdf = run(&slab(ink, depth), &light, &settings(100_000));
        for case in polarized(&cases, polarization) {
            let s = at(&bsdf, case.number("angle_deg"));
            let absorbed = absorbed_by(&bsdf, s, "object 1", 0);
            for (name, e) in [("R", s.ledger.specular[0]), ("T", s.ledger.undeflected[0]), ("A", absorbed)] {
                // The formula has faces of a real index.
                comparisons.within(&format!("{name}, {case:?}"), e, case.number(name), ink.im * ink.im);
            }
        }
    }
    comparisons.judge(1e-3);
}

/// Samples without an end: rays may go as far aside as they like.
fn endless(trees: u64) -> Settings {
    let limits = Limits { walk: 1e9, ..Limits::default() };
    Settings { options: Options { limits, ..Options::default() }, ..settings(trees) }
}

/// Plates 20 µm thick with gaps of 50 µm: paths of at least 26 µm, under light that is coherent over less than 20 µm.
#[test]
fn piles_of_plates_add_up() {
    let cases = closed_forms("pile_of_plates");
    let mut comparisons = Comparisons::default();
    for plates in [1, 2, 3, 5, 10, 20] {
        let mut build = Build::within(1.0);
        let glass = build.medium(1.5);
        for top in (0..plates).map(|i| -70.0 * f64::from(i)) {
            build = build.fill(Shape::Slab { top, bottom: top - 20.0 }, Fill::Medium(glass.clone()));
        }
        for polarization in [Polarization::S, Polarization::P] {
            let light = light(&[NM], &angles(&cases, "angle_deg"), polarization);
            let bsdf = run(&build, &Light { source: SourceMode::Gaussian(10.0), ..light }, &endless(40_000));
            for case in polarized(&cases, polarization).filter(|c| c.number("plates") == f64::from(plates)) {
                let ledger = &at(&bsdf, case.number("angle_deg")).ledger;
                comparisons.add(&format!("R, {case:?}"), ledger.specular[0], case.number("R"));
                comparisons.add(&format!("T, {case:?}"), ledger.undeflected[0], case.number("T"));
            }
        }
    }
    comparisons.judge(5e-3);
}

/// A matt ground that reflects `share`, under glass.
fn matt_under_glass(share: f64) -> Build {
    slab(1.5, 50.0).fill(Shape::Slab { top: -50.0, bottom: -100.0 }, Fill::Diffuse(share))
}

/// Saunderson's correction: what the surface reflects is specular, the rest goes to and fro between it and the ground.
#[test]
fn a_matt_ground_shines_through_glass() {
    let cases = closed_forms("saunderson");
    let light = light(&[NM], &angles(&cases, "angle_deg"), Polarization::Unpolarized);
    let mut comparisons = Comparisons::default();
    for share in [0.2, 0.5, 0.9, 1.0] {
        let bsdf = run(&matt_under_glass(share), &light, &endless(100_000));
        for case in cases.iter().filter(|c| c.number("R_base") == share) {
            let s = at(&bsdf, case.number("angle_deg"));
            let (specular, total) = (case.number("R_specular"), case.number("R_total"));
            let Estimate { value, .. } = s.ledger.specular[0];
            assert!((value - specular).abs() < 1e-9, "{case:?}: {value}, the facets get none of it and give none");
            comparisons.add(&format!("{case:?}"), s.ledger.reflected[0], total);
            comparisons.add(&format!("ground, {case:?}"), absorbed_by(&bsdf, s, "object 2", 0), 1.0 - total);
            let white = share == 1.0;
            assert!(!white || (s.ledger.reflected[0].value - 1.0).abs() < 1e-9, "white furnace: {:?}", s.ledger);
        }
    }
    comparisons.judge(1e-3);
}

/// Directions in a facet with their parts of its projected solid angle, sr: from its parts `levels` finer.
fn parts(facet: Facet, levels: u8) -> Vec<(DVec3, f64)> {
    let mut parts = vec![facet];
    for _ in 0..levels {
        parts = parts.into_iter().flat_map(Facet::children).collect();
    }
    parts.into_iter().map(|f| (f.center(), f.projected_solid_angle())).collect()
}

/// Reflectance of glass for unpolarized light from outside, at the cosine of an angle.
fn surface(cos: f64) -> f64 {
    let cos_inside = (1.0 - (1.0 - cos * cos) / 2.25).sqrt();
    let s = (cos - 1.5 * cos_inside) / (cos + 1.5 * cos_inside);
    let p = (1.5 * cos - cos_inside) / (1.5 * cos + cos_inside);
    0.5 * (s * s + p * p)
}

/// The BRDF of the ground under glass depends on the direction of exit as 1 − F does: over a facet its mean is the value of
/// the table at one angle, times what 1 − F is on the average to what it is there.
#[test]
fn a_matt_ground_under_glass_has_its_brdf_in_the_facets() {
    const WIDTH: f64 = 20.0;
    let cases = closed_forms("saunderson_brdf");
    let light = light(&[NM], &angles(&cases, "theta_i"), Polarization::Unpolarized);
    let mut comparisons = Comparisons::default();
    for share in [0.2, 0.5, 0.9, 1.0] {
        let bsdf = run(&matt_under_glass(share), &light, &Settings { dome_level: 4, ..endless(400_000) });
        for case in cases.iter().filter(|c| c.number("R_base") == share) {
            let (theta, brdf) = (case.number("theta_o"), case.number("brdf_per_sr"));
            let unit = brdf / (1.0 - surface(theta.to_radians().cos()));
            let (mut sum, mut variance, mut angle, mut truth) = (0.0, 0.0, 0.0, 0.0);
            for f in &at(&bsdf, case.number("theta_i")).facets {
                let center = f.facet.center().z.acos().to_degrees();
                if (center - theta).abs() < WIDTH && center < 90.0 {
                    let parts = parts(f.facet, 7 - f.facet.level);
                    let size: f64 = parts.iter().map(|p| p.1).sum();
                    sum += f.value[0].value * size;
                    variance += (f.value[0].se * size).powi(2);
                    truth += parts.iter().map(|(dir, part)| unit * (1.0 - surface(dir.z)) * part).sum::<f64>();
                    angle += size;
                }
            }
            let measured = Estimate { value: sum / angle, se: variance.sqrt() / angle };
            comparisons.add(&format!("{case:?}"), measured, truth / angle);
        }
    }
    comparisons.judge(3e-3);
}

/// Grooves along y with faces at 45°, mirrors of reflectance `share`.
fn grooves(share: f64) -> Build {
    let corners = [(-5.0, 0.0), (0.0, -5.0), (5.0, 0.0)];
    let vertices = corners.iter().flat_map(|&(x, z)| [-5.0, 5.0].map(|y| DVec3::new(x, y, z))).collect();
    let triangles = vec![[0, 1, 2], [1, 3, 2], [2, 3, 4], [3, 5, 4]];
    let mirrors = mesh(Mesh { vertices, triangles });
    Build::within(1.0).patch(10.0, 10.0).fill(mirrors, Fill::Mirror(share))
}

/// Light that meets both faces goes back to the source, the rest leaves with sine and cosine of its angle changed.
#[test]
fn grooves_send_light_back() {
    let mut comparisons = Comparisons::default();
    let cases = closed_forms("v_groove_90");
    let light = light(&[NM], &angles(&cases, "angle_deg"), Polarization::S);
    for share in [1.0, 0.8] {
        let bsdf = run(&grooves(share), &light, &Settings { dome_level: 5, ..settings(50_000) });
        for case in &cases {
            let s = at(&bsdf, case.number("angle_deg"));
            let (sin, cos) = s.incidence.theta_deg.to_radians().sin_cos();
            let (retro, single) = (share * share * case.number("retro"), share * case.number("single_bounce"));
            comparisons.add(&format!("absorbed, {share}, {case:?}"), s.ledger.absorbed[0], 1.0 - retro - single);
            if s.incidence.theta_deg == 0.0 {
                comparisons.add(&format!("{share}, {case:?}"), s.ledger.specular[0], retro);
                continue;
            }
            let mut beams =
                [(DVec3::new(sin, 0.0, cos), retro, 0.0, 0.0), (DVec3::new(cos, 0.0, sin), single, 0.0, 0.0)];
            for f in s.facets.iter().filter(|f| f.value[0].value > 0.0) {
                let near = |beam: &&mut (DVec3, f64, f64, f64)| beam.0.angle_between(f.facet.center()) < 0.05;
                let (_, _, sum, variance) = beams.iter_mut().find(near).unwrap_or_else(|| panic!("{f:?}, {case:?}"));
                let size = f.facet.projected_solid_angle();
                *sum += f.value[0].value * size;
                *variance += (f.value[0].se * size).powi(2);
            }
            if s.incidence.theta_deg == 45.0 {
                // Both are one beam.
                beams[0].1 += single;
                beams[1].1 = 0.0;
            }
            for (_, truth, value, variance) in beams {
                comparisons.add(&format!("{share}, {case:?}"), Estimate { value, se: variance.sqrt() }, truth);
            }
        }
    }
    comparisons.judge(2e-3);
}

/// Indices of silver and aluminium where they were measured: nm, n, k (Choi et al. 2020, Cheng et al. 2016).
const SILVER: [(f64, f64, f64); 3] = [(450.9, 0.04, 2.657), (548.6, 0.06, 3.586), (659.5, 0.05, 4.483)];
const ALUMINIUM: [(f64, f64, f64); 3] = [(442.8, 0.6079, 5.3676), (516.6, 0.8734, 6.2418), (563.57, 1.0728, 6.7839)];

/// Reflectances of a plane face for s and p, by the film formula without films.
fn metal(n: C64, cos: f64, nm: f64) -> [f64; 2] {
    let both = collapse::collapse(1.0, cos, &[], n, nm / 1e3);
    [both.s, both.p].map(|(r, _)| r.norm_sqr())
}

#[test]
fn metals_absorb_what_they_do_not_reflect() {
    const FROM: [(f64, f64); 4] = [(0.0, 0.0), (30.0, 10.0), (60.0, 200.0), (85.0, 90.0)];
    for (name, table) in [("silver", SILVER), ("Al", ALUMINIUM)] {
        let build = Build::within(1.0).made_of(Shape::Slab { top: 0.0, bottom: -10.0 }, name);
        for polarization in [Polarization::S, Polarization::P, Polarization::Unpolarized] {
            let light = light(&table.map(|row| row.0), &FROM, polarization);
            let bsdf = run(&build, &light, &settings(64));
            for s in &bsdf.incidences {
                for (i, &(nm, n, k)) in table.iter().enumerate() {
                    let [r_s, r_p] = metal(C64::new(n, k), s.incidence.theta_deg.to_radians().cos(), nm);
                    let [share_s, share_p] = polarization.shares();
                    let absorbed = 1.0 - share_s * r_s - share_p * r_p;
                    let measured = absorbed_by(&bsdf, s, "object 1", i);
                    let at = format!("{name}, {nm} nm, {polarization}, {:?}", s.incidence);
                    assert!((measured.value - absorbed).abs() < 1e-9, "{at}: {measured:?} for {absorbed}");
                    assert_eq!(s.ledger.specular[i], s.ledger.reflected[i]);
                }
            }
        }
    }
}

/// A ball of metal under a patch that just holds its shadow: every part of that at its own angle, whatever the light's
/// polarization.
#[test]
fn a_ball_of_metal_absorbs_at_all_angles() {
    const STEPS: u32 = 2000;
    let build = Build::within(1.0).open().patch(20.0, 20.0).made_of(ball([0.0; 3], 10.0), "Al");
    let mut comparisons = Comparisons::default();
    for polarization in [Polarization::S, Polarization::Unpolarized] {
        let light = light(&ALUMINIUM.map(|row| row.0), &[(0.0, 30.0)], polarization);
        let bsdf = run(&build, &light, &settings(20_000));
        for (i, (nm, n, k)) in ALUMINIUM.into_iter().enumerate() {
            // Shadow is evenly spread over cos².
            let at = |step: u32| ((f64::from(step) + 0.5) / f64::from(STEPS)).sqrt();
            let absorbed = |step| 1.0 - 0.5 * metal(C64::new(n, k), at(step), nm).iter().sum::<f64>();
            let mean = (0..STEPS).map(absorbed).sum::<f64>() / f64::from(STEPS);
            let measured = absorbed_by(&bsdf, &bsdf.incidences[0], "object 1", i);
            comparisons.add(&format!("{nm} nm, {polarization}"), measured, mean * PI / 4.0);
        }
    }
    comparisons.judge(1e-3);
}

/// A ball of ink in a slab of grey glass, all of one index, so that light goes straight: exponentials along chords.
#[test]
fn a_body_in_another_takes_its_own_part() {
    const STEPS: u32 = 4000;
    let (glass, ink, radius, half) = (0.02, 0.2, 5.0, 10.0);
    let index = |mu: f64| C64::new(1.5, mu * NM / 1e3 / (4.0 * PI));
    let mut build = Build::within(1.5).patch(12.0, 12.0);
    let medium = build.medium(index(glass));
    let build = build
        .fill(Shape::Slab { top: half, bottom: -half }, Fill::Medium(medium))
        .put(ball([0.0; 3], radius), index(ink));
    // Light at the distance b from the axis goes through c of the ball, and as much glass in front of it as behind.
    let mut takes = [0.0, 0.0];
    for step in 0..STEPS {
        let b2 = radius * radius * (f64::from(step) + 0.5) / f64::from(STEPS);
        let c = 2.0 * (radius * radius - b2).sqrt();
        let [before, within] = [(-glass * (half - 0.5 * c)).exp(), (-ink * c).exp()];
        takes[0] += (1.0 - before) * (1.0 + before * within) / f64::from(STEPS);
        takes[1] += before * (1.0 - within) / f64::from(STEPS);
    }
    let shadow = PI * radius * radius / 144.0;
    let beside = 1.0 - (-2.0 * glass * half).exp();
    let truth = [shadow * takes[0] + (1.0 - shadow) * beside, shadow * takes[1]];
    let light = light(&[NM], &[(0.0, 0.0)], Polarization::Unpolarized);
    let bsdf = run(&build, &light, &settings(50_000));
    let mut comparisons = Comparisons::default();
    for (name, truth) in ["object 1", "object 2"].into_iter().zip(truth) {
        comparisons.add(name, absorbed_by(&bsdf, &bsdf.incidences[0], name, 0), truth);
    }
    comparisons.judge(1e-3);
}

/// What layers absorb, and what is behind them: differences of Poynting's vector between their faces, from the fields,
/// which Abelès' matrices carry upwards.
fn poynting(theta_deg: f64, layers: &[(C64, f64)], last: C64, nm: f64, p: bool) -> Vec<f64> {
    let (sin, cos) = theta_deg.to_radians().sin_cos();
    let kz = |n: C64| {
        let root = (n * n - sin * sin).sqrt();
        if root.im < 0.0 { -root } else { root }
    };
    let admittance = |n: C64| if p { n * n / kz(n) } else { kz(n) };
    let mut field = [C64::ONE, admittance(last)];
    let flux = |[e, h]: [C64; 2]| (e * h.conj()).re;
    let mut fluxes = vec![flux(field)];
    for &(n, d) in layers.iter().rev() {
        let (eta, phase) = (admittance(n), kz(n) * (2.0e3 * PI * d / nm));
        let ([e, h], sin, cos) = (field, phase.sin(), phase.cos());
        field = [cos * e - C64::I * sin / eta * h, cos * h - C64::I * eta * sin * e];
        fluxes.push(flux(field));
    }
    let outside = if p { 1.0 / cos } else { cos };
    let incident = 0.25 * (field[0] + field[1] / outside).norm_sqr() * outside;
    let shares: Vec<f64> = fluxes.iter().map(|f| f / incident).collect();
    let layers = shares.windows(2).rev().map(|w| w[1] - w[0]);
    layers.chain([shares[0]]).collect()
}

#[test]
fn films_absorb_layer_by_layer() {
    let last = C64::new(0.6, 5.4);
    let layers = [(C64::new(1.7, 0.05), 0.12), (C64::new(2.2, 0.1), 0.07), (C64::new(1.4, 0.0), 0.2)];
    let mut build = Build::within(1.0).below(last);
    let mut top = 0.0;
    for (n, d) in layers {
        let medium = build.medium(n);
        build = build.fill(Shape::Slab { top, bottom: top - d }, Fill::Medium(medium));
        top -= d;
    }
    const ALL_NM: [f64; 2] = [450.0, 620.0];
    for polarization in [Polarization::S, Polarization::P] {
        let light = light(&ALL_NM, &[(0.0, 0.0), (40.0, 20.0), (75.0, 300.0)], polarization);
        let bsdf = run(&build, &Light { source: SourceMode::Line, ..light }, &settings(64));
        for s in &bsdf.incidences {
            for (i, nm) in ALL_NM.into_iter().enumerate() {
                let truth = poynting(s.incidence.theta_deg, &layers, last, nm, polarization == Polarization::P);
                let bodies = ["object 1", "object 2", "object 3", "below"];
                assert_eq!(truth.len(), bodies.len());
                for (body, truth) in bodies.into_iter().zip(truth) {
                    let measured = absorbed_by(&bsdf, s, body, i);
                    let at = format!("{body}, {polarization}, {:?}, {nm} nm", s.incidence);
                    assert!((measured.value - truth).abs() < 1e-9, "{at}: {measured:?} for {truth}");
                    assert!(body == "object 3" || truth > 1e-3, "{at}: {truth}");
                }
            }
        }
    }
}

/// One face reflects I (R_s + R_p)/2 + Q (R_p − R_s)/2, whatever U and V.
#[test]
fn of_stokes_vectors_two_numbers_matter_to_reflectance() {
    let build = slab(1.5, 1000.0).below(1.5);
    for q in [-1.0, -0.4, 0.0, 0.7, 1.0f64] {
        let rest = (1.0 - q * q).sqrt();
        for (u, v) in [(0.0, 0.0), (rest, 0.0), (-0.5 * rest, 0.5 * rest), (0.0, -rest)] {
            let light = light(&[NM], &[(20.0, 30.0), (70.0, 100.0)], Polarization::Stokes([1.0, q, u, v]));
            let bsdf = run(&build, &light, &settings(64));
            for s in &bsdf.incidences {
                let [r_s, r_p] = metal(C64::from(1.5), s.incidence.theta_deg.to_radians().cos(), NM);
                let truth = 0.5 * (1.0 - q) * r_s + 0.5 * (1.0 + q) * r_p;
                let Estimate { value, .. } = s.ledger.specular[0];
                assert!((value - truth).abs() < 1e-12, "Q {q}, U {u}, V {v}: {value} for {truth}");
            }
        }
    }
}
