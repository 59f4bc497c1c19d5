use std::f64::consts::TAU;

use glam::DMat3;

use super::super::super::description::{Description, Patch};
use super::super::super::flat::Sample;
use super::super::common::heights;
use super::*;
use crate::light::{Coherence, Wavelengths};

fn flakes(tilt: Tilt, sides: usize) -> Flakes {
    let count = if tilt == Tilt::Random { 20 } else { 40 };
    Flakes {
        slab: Slab { size: DVec3::new(30.0, 26.0, 13.0), periodic: true },
        diameters: Sizes::spread(8.0, 0.2).draw(count, 2),
        thickness: 0.4,
        sides,
        tilt,
        fill: Fill::Diffuse(1.0),
        core: Some((0.06, Named { name: "water".into(), place: Place::default() })),
        common: Common { bottom: 2.0, seed: 8, ..Common::default() },
    }
}

/// The search for overlaps of meshes knows nothing of separating axes.
#[test]
fn flakes_never_overlap() {
    for (tilt, sides) in [(Tilt::Mean(0.0), 6), (Tilt::Mean(0.2), 6), (Tilt::Random, 5), (Tilt::Random, 3)] {
        let flakes = flakes(tilt, sides);
        let objects = flakes.objects(&Place::default()).unwrap();
        let places = || flakes.places().unwrap().into_iter().map(|(_, p)| p).collect::<Vec<DVec3>>();
        assert_eq!(places(), places(), "the same seed gives the same flakes");
        let [low, high] = heights(&objects).unwrap();
        assert!(low >= 2.0 - 1e-9 && high <= 15.0 + 1e-9, "{low} {high}");
        assert_eq!(objects.len(), 2 * flakes.diameters.len());
        let patch = Some(Patch { size: flakes.slab.size.truncate(), center: glam::DVec2::ZERO });
        let description = Description { patch, objects, ..Description::default() };
        let light = Wavelengths::from_nm(vec![500.0]).unwrap();
        Sample::new(&description, &light, Coherence::Endless).unwrap();
    }
}

/// Flakes that are apart have a plane between them, flakes with a common point have none.
#[test]
fn separating_axes_tell_what_a_raster_tells() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(3);
    let mut counts = [0, 0];
    for case in 0..400 {
        let form = Form { sides: 3 + case % 5, radius: 3.0, half: 0.6 };
        let [a, b] = [0, 1].map(|_| Turned::new(form, Tilt::Random.draw(&mut rng)));
        let by = DVec3::new(rng.random(), rng.random(), rng.random()) * 4.0;
        let inside = |t: &Turned, p: DVec3| {
            let local = t.turn.transpose() * p;
            let apothem = 3.0 * (0.5 * TAU / form.sides as f64).cos();
            let side = |i: usize| TAU * (i as f64 + 0.5) / form.sides as f64;
            local.z.abs() < 0.6 && (0..form.sides).all(|i| local.x * side(i).cos() + local.y * side(i).sin() < apothem)
        };
        let steps = || (-15..=15).map(|i| f64::from(i) / 5.0);
        let slices = || (-5..=5).map(|i| f64::from(i) * 0.119);
        let common = steps().any(|x| {
            steps().any(|y| {
                slices().any(|z| {
                    let p = a.turn * DVec3::new(x, y, z);
                    inside(&a, p) && inside(&b, p - by)
                })
            })
        });
        let apart = a.is_apart(&b, by);
        assert!(!(common && apart), "case {case}");
        counts[usize::from(apart)] += 1;
        // What a raster misses of an overlap is small.
        assert!(apart || common || by.length() > 0.5, "case {case}");
    }
    assert!(counts[0] > 50 && counts[1] > 50, "{counts:?}");
}

/// 4000 flakes: 4.5 standard errors are a false alarm in 7 of a million tests.
#[test]
fn tilts_are_as_asked() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
    for (tilt, mean) in [(Tilt::Mean(0.1), 0.1), (Tilt::Mean(0.34), 0.34), (Tilt::Random, 1.0)] {
        let all: Vec<f64> = (0..4000).map(|_| tilt.draw(&mut rng).z_axis.z.acos()).collect();
        let found = all.iter().sum::<f64>() / 4000.0;
        let variance = all.iter().map(|x| (x - found).powi(2)).sum::<f64>() / 4000.0;
        assert!((found - mean).abs() < 4.5 * (variance / 4000.0).sqrt(), "{tilt:?}: {found}");
    }
}

#[test]
fn the_skin_is_as_thick_everywhere() {
    let (inside, skin) = (Form { sides: 6, radius: 5.0, half: 0.2 }, 0.06);
    let outside = inside.within(skin);
    let apothem = |f: Form| f.radius * (0.5 * TAU / 6.0).cos();
    assert!((apothem(outside) - apothem(inside) - skin).abs() < 1e-12);
    assert!((outside.half - inside.half - skin).abs() < 1e-12);
    assert!((outside.mesh(DMat3::IDENTITY).volume() - outside.volume()).abs() < 1e-9);
}
