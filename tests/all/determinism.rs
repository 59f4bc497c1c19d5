//! A result is a function of sample, light, trees and seed: not of the number of threads, nor of who intersects.

use crate::common::Mesh;
use crate::common::build::{Build, ball, cuboid, fibre, light, mesh};
use crate::common::listen::{entries, listen, settings};
use glam::DVec3;
use gonio_embree::experiment::{Outcome, Settings, measure};
use gonio_embree::intersect::choose::Backend;
use gonio_embree::light::{Light, Polarization};
use gonio_embree::optics::field::Stokes;
use gonio_embree::plan::{Limits, Wanted};
use gonio_embree::sample::description::{Fibre, Shape};
use gonio_embree::sample::generate::bricks::Bricks;

/// Every kind of body under films, some wavelengths apart.
fn mixed() -> Build {
    let rod = fibre([-8.0, -2.0, 1.0], [7.0, 3.0, 6.0], 1.5);
    let flat = Fibre { flatten: Some((DVec3::Z, 0.4)), ..fibre([-8.0, 8.0, 2.0], [8.0, 7.0, 3.0], 1.5) };
    Build::within(1.0)
        .below(1.5)
        .patch(20.0, 20.0)
        .films(12.0, &[(1.8, 0.1), (1.4, 0.12), (1.8, 0.1)])
        .put(ball([5.0, -5.0, 5.0], 3.0), 1.45)
        .put(ball([-6.0, -6.0, 3.0], 2.5), 1.7)
        .hollow(rod, 1.53, 0.8, 1.33)
        .put(Shape::from(flat), 1.6)
        .put(cuboid([-9.0, 3.0, 0.0], [-5.0, 6.0, 0.3]), 2.0)
        .put(mesh(Mesh::ball(2).map(|p| 2.0 * p + DVec3::new(3.0, 3.0, 9.0))), 1.5)
}

fn samples() -> [(&'static str, Build); 2] {
    [("mixed", mixed()), ("bricks", Build::within(1.0).bricks(&Bricks::default(), 2.0, 1.5))]
}

fn usual_light() -> Light {
    light(&[500.0, 520.0, 540.0], &[(10.0, 20.0), (60.0, 100.0)], Polarization::Unpolarized)
}

fn outcome(build: &Build, settings: &Settings) -> Outcome {
    let light = usual_light();
    measure(&build.sample(&light), &light, settings, |_| {}).unwrap()
}

/// Bit by bit, for any number of threads. There are more units of work than threads, and batches of several units.
#[test]
fn threads_do_not_matter() {
    for (name, build) in samples() {
        // 9000 trees a batch are two units; few are less than one.
        let trees = if name == "mixed" { 290_000 } else { 10_000 };
        let settings = |threads| Settings { threads, ..settings(trees) };
        let one = outcome(&build, &settings(1));
        for threads in [2, 7] {
            let many = outcome(&build, &settings(threads));
            assert!(one.bsdf == many.bsdf, "{name}: {threads} threads");
            assert_eq!(one.stacks, many.stacks, "{name}: {threads} threads");
        }
    }
}

#[test]
fn another_seed_is_another_result() {
    for (name, build) in samples() {
        let one = outcome(&build, &settings(5000));
        assert!(one.bsdf == outcome(&build, &settings(5000)).bsdf, "{name}");
        assert!(one.bsdf != outcome(&build, &Settings { seed: 2, ..settings(5000) }).bsdf, "{name}");
    }
}

/// Bit by bit, every ray of every tree: direction, place, fields.
#[test]
fn backends_do_not_matter() {
    for (name, build) in samples() {
        let light = usual_light();
        let sample = build.sample(&light);
        let hear =
            |backend| listen::<Stokes>(&sample, &light, backend, Limits::default(), Wanted::AUTO, &entries(4, 5000));
        let brute = hear(Backend::Brute);
        assert!(brute.exits.len() > 5000 && brute.lost == 0.0, "{name}");
        for backend in Backend::available() {
            assert!(hear(backend) == brute, "{name}: {backend}");
        }
    }
}
