//! The matrices of the facets, from end to end: the same trees, followed by an independent tracer and added up by hand.

use crate::common::build::{Build, ball, light};
use crate::common::listen::settings;
use crate::common::matrices;
use crate::common::oracle;
use crate::common::oracle::{C64, Form, Solid, World, along, apply, field};
use glam::{DQuat, DVec3};
use gonio_embree::bsdf::Scattering;
use gonio_embree::dome::Facet;
use gonio_embree::experiment::{BATCHES, measure};
use gonio_embree::light::Polarization;
use gonio_embree::plan::Limits;
use gonio_embree::sample::description::Fill;
use gonio_embree::trace::{Batch, TreeNumbers};
use matrices::Mueller;

const NM: [f64; 2] = [450.0, 650.0];
/// Cauchy's index.
const GLASS: (f64, f64) = (1.5, 2e4);
const BALLS: [([f64; 3], f64); 3] = [([0.0, 0.0, 3.0], 2.0), ([3.0, 0.0, 3.0], 1.0), ([-1.0, 1.0, -2.5], 3.0)];
const PATCH: f64 = 10.0;
/// Trees of each batch.
const TREES: u32 = 40;
const SEED: u64 = 5;
/// Branches of less power are not followed.
const FAINTEST: f64 = 1e-6;

fn world(nm: f64) -> World {
    let solid = |(center, radius): ([f64; 3], f64)| Solid {
        form: Form::Ball { center: DVec3::from_array(center), radius },
        index: GLASS.0 + GLASS.1 / (nm * nm),
        priority: 0,
    };
    World { around: 1.0, solids: BALLS.map(solid).into() }
}

fn build() -> Build {
    let mut build = Build::within(1.0).open().patch(PATCH, PATCH);
    let glass = build.cauchy(GLASS.0, GLASS.1);
    BALLS.into_iter().fold(build, |b, (center, radius)| b.fill(ball(center, radius), Fill::Medium(glass.clone())))
}

/// What is measured, with both ways followed at every interface and no ray shared by wavelengths.
fn measured(from: (f64, f64)) -> Scattering {
    let light = light(&NM, &[from], Polarization::Mueller);
    let mut settings = settings(u64::from(TREES * BATCHES));
    (settings.seed, settings.dome_level) = (SEED, 1);
    settings.options.limits = Limits { depth: oracle::DEEPEST, spread: 0.0, ..Limits::whole_trees(FAINTEST) };
    measure(&build().sample(&light), &light, &settings, |_| {}).unwrap().bsdf.incidences.swap_remove(0)
}

/// x̂ and ŷ of light that leaves along `dir`, of a facet around `center`: of the pole, brought to `dir` by the shortest
/// turn, and turned by the angle that makes it θ̂ if that is done at the centre.
fn frame(dir: DVec3, center: DVec3) -> [DVec3; 2] {
    let pole = DVec3::new(0.0, 0.0, center.z.signum());
    let brought = |to: DVec3| DQuat::from_rotation_arc(pole, to) * DVec3::X;
    let theta = DVec3::new(center.x * center.z, center.y * center.z, center.z * center.z - 1.0).normalize();
    let x = brought(center);
    let (sin, cos) = (center.cross(x).dot(theta), x.dot(theta));
    let (x, y) = (brought(dir), dir.cross(brought(dir)));
    [cos * x + sin * y, cos * y - sin * x]
}

fn contains(facet: Facet, dir: DVec3) -> bool {
    let [a, b, c] = facet.corners();
    [(a, b), (b, c), (c, a)].into_iter().all(|(p, q)| p.cross(q).dot(dir) >= 0.0)
}

/// s and p of an incidence in degrees, and the direction of propagation.
fn incident((theta, phi): (f64, f64)) -> (DVec3, [DVec3; 2]) {
    let ((sin, cos), (sin_phi, cos_phi)) = (theta.to_radians().sin_cos(), phi.to_radians().sin_cos());
    let k = -DVec3::new(sin * cos_phi, sin * sin_phi, cos);
    let s = DVec3::new(-sin_phi, cos_phi, 0.0);
    (k, [s.cross(k), s])
}

/// Where all trees enter: the upper end of the sample.
fn entries() -> impl Iterator<Item = DVec3> {
    let top = BALLS.iter().map(|(center, radius)| center[2] + radius).fold(f64::MIN, f64::max);
    let numbers = (0..BATCHES).flat_map(|scramble| {
        (0..TREES).map(move |tree| TreeNumbers::new(Batch { seed: SEED, incidence: 0, scramble }, tree))
    });
    numbers.map(move |n| DVec3::new(PATCH * (n.entry[0] - 0.5), PATCH * (n.entry[1] - 0.5), top))
}

/// The matrix of each facet, 1/sr, as the mean over all trees.
fn expected(from: (f64, f64), nm: f64, facets: &[Facet]) -> Vec<Mueller> {
    let (world, (k, inputs)) = (world(nm), incident(from));
    let inputs = inputs.map(|e| field(C64::ONE, e, C64::ZERO, e));
    let half = inputs.map(|e| e.map(|x| x * 0.5f64.sqrt()));
    let mut sums = vec![[0.0; 16]; facets.len()];
    for exit in entries().flat_map(|entry| world.tree(entry, k, &half, FAINTEST)).filter(|e| e.depth > 0) {
        let at = facets.iter().position(|&f| contains(f, exit.dir)).unwrap();
        let axes = frame(exit.dir, facets[at].center());
        let outputs = inputs.map(|e| apply(&exit.matrix, &e));
        let m = matrices::of_jones(&axes.map(|axis| [0, 1].map(|i| along(&outputs[i], axis))));
        let share = f64::from(TREES * BATCHES) * facets[at].projected_solid_angle();
        sums[at].iter_mut().zip(m).for_each(|(sum, x)| *sum += x / share);
    }
    sums
}

#[test]
fn facets_are_what_the_oracle_finds() {
    for from in [(0.0, 0.0), (0.0, 70.0), (50.0, 160.0)] {
        let measured = measured(from);
        let facets: Vec<Facet> = measured.facets.iter().map(|f| f.facet).collect();
        assert_eq!(facets.len(), 80);
        for (lane, &nm) in NM.iter().enumerate() {
            for (f, expected) in measured.facets.iter().zip(expected(from, nm, &facets)) {
                let off = matrices::distance(&f.mueller[lane].map(|e| e.value), &expected);
                assert!(off < 1e-9, "{from:?}, {nm} nm, {:?}: {off:e}\n{:?}\n{expected:?}", f.facet, f.mueller[lane]);
            }
        }
    }
}
