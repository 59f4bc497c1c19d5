//! Scenes that cannot be seen.

use glam::DVec3;
use gonio_embree::intersect::choose::Backend;
use gonio_embree::light::{Light, Polarization};
use gonio_embree::optics::C64;
use gonio_embree::optics::field::{Field, Jones, Stokes};
use gonio_embree::plan::{Limits, Wanted};
use gonio_embree::sample::description::Fill;
use gonio_embree::sample::generate::packing::Packing;

use super::Case;
use crate::common::Mesh;
use crate::common::build::{Build, ball, cuboid, fibre, light, mesh};
use crate::common::listen::{Heard, coherent_sum, entries, listen};

pub fn all() -> Vec<Case> {
    let powers = [1.33, 1.33f64.next_up()].map(invisible_power);
    powers.into_iter().chain([invisible_phase(), crossing(), christiansen()]).collect()
}

const TREES: u32 = 1000;

/// Mean power of a tree that goes on in the direction of the light.
fn straight<F: Field>(heard: &Heard<F>, light: &Light) -> f64 {
    let straight = heard.exits.iter().filter(|e| e.dir.distance(light.incidences[0].propagation()) < 1e-9);
    straight.flat_map(|e| &e.fields).map(|f| f.1.power()).sum::<f64>() / f64::from(TREES)
}

/// Bodies of index `n` in a medium of 1.33.
fn bodies(n: f64) -> Build {
    Build::within(1.33)
        .patch(12.0, 10.0)
        .films(8.0, &[(n, 0.05), (1.33, 0.15), (n, 0.3)])
        .put(ball([-3.0, 3.0, 3.0], 2.0), n)
        .put(cuboid([2.0, 2.0, 0.0], [5.0, 4.5, 3.0]), n)
        .put(mesh(Mesh::ball(2).map(|p| 1.5 * p + DVec3::new(2.0, -0.5, 5.8))), n)
        .hollow(fibre([-5.0, -3.0, 1.0], [5.0, -3.0, 4.0], 1.0), n, 0.6, 1.33)
}

fn unseen(n: f64) -> (C64, f64) {
    let light = light(&[400.0], &[(45.0, 30.0)], Polarization::P);
    let sample = bodies(n).sample(&light);
    let heard = listen::<Jones>(&sample, &light, Backend::Auto, Limits::default(), Wanted::ALL, &entries(3, TREES));
    let sum = coherent_sum(&heard, &sample, &light, false, 1.33)[0];
    (sum / f64::from(TREES), straight(&heard, &light))
}

fn invisible_power(n: f64) -> Case {
    let (name, bound) =
        if n == 1.33 { ("all indices equal", 0.0) } else { ("indices one unit in the last place apart", 1e-9) };
    Case::new(name, "T straight on", 1.0, unseen(n).1, bound)
}

/// t of the mean of all trees, referred to light that met nothing.
fn invisible_phase() -> Case {
    Case::new("all indices equal", "phase, rad", 0.0, unseen(1.33).0.arg(), 1e-9)
}

/// A liquid and a glass, n = a + b/λ², that cross at 520 nm: 0.05 = (18000 − 4480)/520².
const LIQUID: (f64, f64) = (1.535, 18_000.0);
const GLASS: (f64, f64) = (1.585, 4480.0);

fn filter() -> Build {
    let packing = Packing { count: 200, radius: 0.75, size: DVec3::new(16.0, 16.0, 12.0), periodic: true, seed: 2 };
    let mut build = Build::within(1.0).patch(16.0, 16.0);
    let liquid = build.cauchy(LIQUID.0, LIQUID.1);
    (build.0.above, build.0.below) = (liquid.clone(), liquid);
    let glass = build.cauchy(GLASS.0, GLASS.1);
    let balls = packing.centers().unwrap().into_iter();
    balls.fold(build, |b, c| b.fill(ball(c, packing.radius), Fill::Medium(glass.clone())))
}

fn at_crossing() -> Light {
    light(&[520.0], &[(20.0, 0.0)], Polarization::Unpolarized)
}

fn crossing() -> Case {
    let sample = filter().sample(&at_crossing());
    let index = |at: usize| sample.media.get(at).map_or(sample.media[0].index[0].re, |m| m.index[0].re);
    let single = |(a, b): (f64, f64)| a as f32 + b as f32 / (520.0f32 * 520.0);
    Case::new("Christiansen filter where its indices cross", "n − n", 0.0, index(0) - index(1), 5e-16)
        .single((single(LIQUID) - single(GLASS)).into())
}

/// Of 200 spheres, none is seen.
fn christiansen() -> Case {
    let light = at_crossing();
    let heard = listen::<Stokes>(
        &filter().sample(&light),
        &light,
        Backend::Auto,
        Limits::default(),
        Wanted::AUTO,
        &entries(3, TREES),
    );
    Case::new("Christiansen filter where its indices cross", "T within 1e-9 rad", 1.0, straight(&heard, &light), 1e-12)
}
