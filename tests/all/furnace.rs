//! Energy: what enters a sample leaves it, is absorbed, or is counted as lost.

use crate::common::Mesh;
use crate::common::build::{Build, ball, cuboid, fibre, light, mesh};
use crate::common::listen::settings;
use glam::DVec3;
use gonio_embree::bsdf::{Ledger, Scattering};
use gonio_embree::experiment::{Settings, measure};
use gonio_embree::light::Polarization;
use gonio_embree::optics::C64;
use gonio_embree::plan::{Limits, Options};
use gonio_embree::sample::description::{Fibre, Fill, Shape};
use gonio_embree::sample::generate::bricks::Bricks;
use gonio_embree::sample::generate::packing::Packing;

const NM: [f64; 3] = [450.0, 550.0, 650.0];
const FROM: [(f64, f64); 4] = [(0.0, 0.0), (30.0, 200.0), (45.0, 90.0), (80.0, 10.0)];
const POLARIZATIONS: [Polarization; 3] = [Polarization::Unpolarized, Polarization::S, Polarization::P];

/// The ledger balances to this: sums of 2000 trees round by far less.
const ROUNDING: f64 = 1e-9;

/// Runs a sample at every incidence and polarization.
fn ledgers(build: &Build, settings: &Settings, mut check: impl FnMut(&Scattering, &Ledger)) {
    for polarization in POLARIZATIONS {
        let light = light(&NM, &FROM, polarization);
        let outcome = measure(&build.sample(&light), &light, settings, |_| {}).unwrap();
        outcome.bsdf.incidences.iter().for_each(|s| check(s, &s.ledger));
    }
}

/// reflected + transmitted + absorbed + side + lost, per wavelength.
fn sum(l: &Ledger, i: usize) -> f64 {
    [&l.reflected, &l.transmitted, &l.absorbed, &l.side, &l.lost_medium, &l.lost_depth, &l.lost_numeric]
        .into_iter()
        .map(|entry| entry[i].value)
        .sum()
}

fn lost(l: &Ledger, i: usize) -> f64 {
    l.lost_medium[i].value + l.lost_depth[i].value + l.lost_numeric[i].value
}

/// The ledger balances, nothing is absorbed, nothing is lost.
fn conserves(name: &str, build: &Build, trees: u64) {
    ledgers(build, &settings(trees), |s, l| {
        for (i, nm) in NM.iter().enumerate() {
            let at = format!("{name}, {:?}, {nm} nm: {l:?}", s.incidence);
            assert!((sum(l, i) - 1.0).abs() < ROUNDING, "{at}");
            assert_eq!(l.absorbed[i].value, 0.0, "{at}");
            assert_eq!(lost(l, i), 0.0, "{at}");
        }
    });
}

/// The ledger balances, something is absorbed at every incidence, nothing is lost.
fn balances(name: &str, build: &Build) {
    ledgers(build, &settings(1000), |s, l| {
        for (i, nm) in NM.iter().enumerate() {
            let at = format!("{name}, {:?}, {nm} nm: {l:?}", s.incidence);
            assert!((sum(l, i) - 1.0).abs() < ROUNDING, "{at}");
            assert!(l.absorbed[i].value > 1e-6, "{at}");
            assert_eq!(lost(l, i), 0.0, "{at}");
        }
    });
}

fn tilted() -> Fibre {
    fibre([-8.0, -2.0, 1.0], [7.0, 3.0, 6.0], 2.0)
}

fn flattened() -> Fibre {
    Fibre { flatten: Some((DVec3::new(0.2, 0.1, 1.0), 0.4)), ..tilted() }
}

/// One body of each kind, by name.
fn bodies() -> Vec<(&'static str, Build)> {
    let air = || Build::within(1.0);
    let endless = Fibre { caps: false, ..fibre([0.0, 0.0, 0.0], [1.0, 0.0, 0.0], 3.0) };
    vec![
        ("sphere", air().put(ball([0.0; 3], 5.0), 1.5)),
        ("bubble", Build::within(1.5).put(ball([0.0; 3], 5.0), 1.0)),
        ("hollow cylinder", air().hollow(tilted(), 1.53, 1.1, 1.0)),
        ("flattened cylinder", air().put(Shape::from(flattened()), 1.53)),
        ("flattened hollow cylinder", air().hollow(flattened(), 1.53, 1.2, 1.2)),
        ("capped tilted cylinder", air().put(Shape::from(tilted()), 1.53)),
        ("endless cylinder", air().patch(8.0, 8.0).hollow(endless, 1.53, 2.0, 1.0)),
        ("box", air().put(cuboid([-2.0, -3.0, 0.0], [2.0, 3.0, 5.0]), 1.5)),
        ("mesh ball", air().put(mesh(Mesh::ball(3).map(|p| 4.0 * p)), 1.5)),
    ]
}

fn thousand_spheres(periodic: bool) -> Build {
    let size = DVec3::new(40.0, 40.0, 25.0);
    let packing = Packing { count: 1000, radius: 1.2, size, periodic, seed: 1 };
    Build::within(1.0).packing(&packing, 1.5)
}

/// A sphere, a fibre and a box in a slab under films, of media whose index depends on the wavelength.
fn everything() -> Build {
    let mut build = Build::within(1.0).below(1.4).patch(20.0, 20.0);
    let medium = build.cauchy(1.5, 6000.0);
    build
        .films(12.0, &[(2.0, 0.08), (1.4, 0.11), (2.0, 0.08)])
        .fill(Shape::Slab { top: 12.0 - 0.27, bottom: -2.0 }, Fill::Medium(medium))
        .put(ball([5.0, -5.0, 5.0], 3.0), 1.0)
        .hollow(tilted(), 1.7, 1.0, 1.33)
        .put(cuboid([-8.0, 4.0, 0.0], [-4.0, 8.0, 0.3]), 1.0)
}

#[test]
fn lossless_bodies_alone_conserve_energy() {
    for (name, build) in bodies() {
        conserves(name, &build.open(), 8000);
    }
}

#[test]
fn lossless_bodies_repeated_conserve_energy() {
    for (name, build) in bodies() {
        conserves(name, &build.patch(20.0, 12.0), 8000);
    }
}

#[test]
fn packings_conserve_energy() {
    for (name, build) in
        [("periodic packing", thousand_spheres(true)), ("open packing", thousand_spheres(false).open())]
    {
        conserves(name, &build, 2000);
    }
}

#[test]
fn films_and_mixtures_conserve_energy() {
    conserves("bricks", &Build::within(1.0).bricks(&Bricks::default(), 2.0, 1.5), 1000);
    conserves("everything", &everything(), 1000);
}

/// Light that is guided far away counts as gone through the side; none of it is lost, and there is some.
#[test]
fn guided_light_leaves_through_the_side() {
    let limits = Limits { walk: 3.0, ..Limits::default() };
    let mut side: f64 = 0.0;
    ledgers(
        &everything(),
        &Settings { options: Options { limits, ..Options::default() }, ..settings(1000) },
        |_, l| {
            for i in 0..NM.len() {
                assert!((sum(l, i) - 1.0).abs() < ROUNDING && lost(l, i) == 0.0, "{l:?}");
                side = side.max(l.side[i].value);
            }
        },
    );
    assert!(side > 0.01, "{side}");
}

/// What the depth limit cuts off is in the ledger.
#[test]
fn light_cut_off_is_counted() {
    let limits = Limits { depth: 2, ..Limits::default() };
    let mut cut: f64 = 0.0;
    ledgers(&everything(), &Settings { options: Options { limits, ..Options::default() }, ..settings(500) }, |_, l| {
        for i in 0..NM.len() {
            assert!((sum(l, i) - 1.0).abs() < ROUNDING, "{l:?}");
            cut = cut.max(l.lost_depth[i].value);
        }
    });
    assert!(cut > 0.1, "{cut}");
}

#[test]
fn absorbing_samples_balance() {
    let air = || Build::within(1.0).patch(20.0, 12.0);
    let weak = C64::new(1.5, 2e-3);
    let gold = C64::new(0.3, 2.9);
    let rod = || Shape::from(tilted());
    let samples = [
        ("absorbing sphere", air().put(ball([0.0; 3], 5.0), weak)),
        ("absorbing fibre with lumen", air().hollow(tilted(), weak, 1.1, 1.0)),
        ("absorbing mesh", air().put(mesh(Mesh::ball(2).map(|p| 4.0 * p)), weak)),
        ("metal sphere", air().put(ball([0.0; 3], 5.0), gold)),
        ("black", air().fill(ball([0.0; 3], 5.0), Fill::Diffuse(0.0))),
        ("diffuse", air().fill(rod(), Fill::Diffuse(0.8))),
        ("mirror", air().fill(rod(), Fill::Mirror(0.9))),
        (
            "diffuse in glass",
            air().put(ball([0.0; 3], 5.0), 1.5).fill(ball([1.0, 0.0, 0.0], 2.0), Fill::Diffuse(0.5)).priority(1),
        ),
        ("absorbing films", air().films(0.0, &[(C64::new(1.7, 0.02), 0.1), (gold, 0.02)])),
        ("films on metal", air().below(gold).films(0.0, &[(1.4, 0.1), (2.2, 0.06)])),
        ("absorbing ground", air().below(weak).films(0.0, &[(C64::new(1.4, 0.01), 0.1)])),
    ];
    for (name, build) in samples {
        balances(name, &build);
        if !matches!(name, "absorbing films" | "films on metal" | "absorbing ground") {
            balances(name, &build.open());
        }
    }
}
