//! A sample whose media all have the index of their surroundings, or as good as, cannot be seen: no light is
//! deflected, and no wave is early or late.

use crate::common::Mesh;
use crate::common::build::{Build, ball, cuboid, fibre, light, mesh, mesh_box, relief, rough};
use crate::common::listen::{Leaving, entries, listen};
use glam::DVec3;
use gonio_embree::intersect::choose::Backend;
use gonio_embree::light::{Light, Polarization};
use gonio_embree::optics::C64;
use gonio_embree::optics::field::Jones;
use gonio_embree::plan::{Limits, Wanted};
use gonio_embree::sample::description::Fibre;
use gonio_embree::sample::generate::bricks::Bricks;
use gonio_embree::sample::generate::packing::Packing;

const N: f64 = 1.33;
/// Close together, so that waves are coherent over 16 µm and all films are solved as stacks.
const NM: [f64; 2] = [400.0, 410.0];
const TREES: u32 = 2000;

/// Samples of three media.
fn samples(n: [f64; 3]) -> Vec<(&'static str, Build)> {
    let around = || Build::within(N).patch(12.0, 10.0);
    let rod = || fibre([-4.0, -2.0, 1.0], [4.0, 3.0, 4.0], 1.2);
    let flat = || Fibre { flatten: Some((DVec3::Z, 0.5)), ..rod() };
    let packing = Packing { count: 200, radius: 0.8, size: DVec3::new(12.0, 10.0, 15.0), periodic: true, seed: 5 };
    let layers = [(n[0], 0.05), (n[1], 0.15), (n[2], 0.3), (n[0], 0.0), (n[1], 2.0)];
    vec![
        ("sphere", around().put(ball([0.0, 1.0, 3.0], 3.0), n[0])),
        ("shells", around().put(ball([0.0; 3], 3.0), n[0]).put(ball([0.0; 3], 2.9), n[1]).priority(1)),
        ("box", around().put(cuboid([-2.0, -2.0, 0.0], [3.0, 1.0, 0.4]), n[1])),
        ("mesh", around().put(mesh(Mesh::ball(3).map(|p| 3.0 * p)), n[2])),
        ("fibre", around().hollow(rod(), n[0], 0.7, n[1])),
        ("flattened fibre", around().hollow(flat(), n[2], 0.7, n[0])),
        ("packing", Build::within(N).packing(&packing, n[0])),
        ("films", around().films(1.0, &layers)),
        (
            "everything",
            around()
                .films(8.0, &layers)
                .put(ball([-3.0, 3.0, 3.0], 2.0), n[0])
                .put(mesh_box([2.0, 2.0, 0.0], [5.0, 4.5, 3.0]), n[1])
                .hollow(fibre([-5.0, -3.0, 1.0], [5.0, -3.0, 4.0], 1.0), n[2], 0.6, n[0]),
        ),
        ("relief", around().put(relief([12, 8], [1.0, 1.25], -1.0, rough(2.0)), n[1])),
        ("bricks", Build::within(N).bricks(&Bricks::default(), n[1], n[2])),
    ]
}

/// How far a wave is ahead of one that went straight through, µm; whole wavelengths do not count.
fn advance(leaving: &Leaving<Jones>, index: &[f64], um: f64, field: &Jones, light: &Light) -> f64 {
    let path: f64 = leaving.lengths.iter().zip(index).map(|(l, n)| l * n).sum();
    let straight = N * light.incidences[0].propagation().dot(leaving.position - leaving.anchor);
    let late = (path - straight) / um + amplitude(leaving, field, light).arg() / std::f64::consts::TAU;
    (late - late.round()) * um
}

/// The part of the field along that of the incident light.
fn amplitude(leaving: &Leaving<Jones>, field: &Jones, light: &Light) -> C64 {
    let incidence = &light.incidences[0];
    let e = if light.polarization == Polarization::P { incidence.p_direction() } else { incidence.s_direction() };
    let (x, y) = (leaving.frame, leaving.dir.cross(leaving.frame));
    (field.x[0] + field.x[1]) * x.dot(e) + (field.y[0] + field.y[1]) * y.dot(e)
}

/// Every tree leaves straight on with all its power, in the state and phase of light that met nothing.
fn check(name: &str, build: &Build, light: &Light) {
    let sample = build.sample(light);
    let heard = listen::<Jones>(&sample, light, Backend::Auto, Limits::default(), Wanted::ALL, &entries(3, TREES));
    let at = format!("{name}, {:?}", light.incidences[0]);
    assert_eq!((heard.side, heard.absorbed, heard.lost), (0.0, 0.0, 0.0), "{at}");
    let index: Vec<f64> = sample.media.iter().map(|m| m.index[0].re).collect();
    let dir = light.incidences[0].propagation();
    let wavelengths: Vec<f64> = light.wavelengths.um().collect();
    let mut power = 0.0;
    for leaving in &heard.exits {
        assert!(leaving.dir.distance(dir) < 1e-9, "{at}: {leaving:?}");
        for (lane, field) in &leaving.fields {
            let um = wavelengths[usize::from(*lane)];
            power += amplitude(leaving, field, light).norm_sqr();
            let advance = advance(leaving, &index, um, field, light);
            assert!(advance.abs() < 1e-9, "{at}: {advance} µm: {leaving:?}");
        }
    }
    let share = power / f64::from(TREES) / NM.len() as f64;
    assert!((share - 1.0).abs() < 1e-9, "{at}: {share}");
}

fn check_all(n: [f64; 3]) {
    for (name, build) in samples(n) {
        for from in [(0.0, 0.0), (45.0, 30.0), (80.0, 250.0)] {
            for polarization in [Polarization::S, Polarization::P] {
                check(name, &build, &light(&NM, &[from], polarization));
            }
        }
        check(name, &build.open(), &light(&NM, &[(20.0, 100.0)], Polarization::P));
    }
}

/// Media of bit-equal index are one medium.
#[test]
fn equal_media_are_invisible() {
    let build = &samples([N; 3])[8].1;
    assert_eq!(build.sample(&light(&NM, &[(0.0, 0.0)], Polarization::S)).media.len(), 1);
    check_all([N; 3]);
}

/// Indices one rounding apart: every face is an interface.
#[test]
fn media_a_rounding_apart_are_invisible() {
    let n = [N.next_up(), N.next_down(), N.next_up().next_up()];
    let build = &samples(n)[8].1;
    assert_eq!(build.sample(&light(&NM, &[(0.0, 0.0)], Polarization::S)).media.len(), 4);
    check_all(n);
}

/// Indices 1e-13 apart: a path of 100 µm is 1e-11 µm longer, a ray turns by 1e-13 times its tangent.
#[test]
fn nearly_equal_media_are_invisible() {
    check_all([N + 1e-13, N - 1e-13, N + 2e-13]);
}
