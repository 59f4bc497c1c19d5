use super::super::super::description::{Description, Patch, Sides};
use super::super::super::flat::Sample;
use super::super::super::problem::Problems;
use super::super::common::heights;
use super::*;
use crate::light::{Coherence, Wavelengths};
use crate::sample::description::Shape;

fn web(deviation: Deviation, periodic: bool) -> Web {
    Web {
        layers: 4,
        fibres: 20,
        length: 200.0,
        radius: 10.0,
        lumen: None,
        flatten: 0.6,
        deviation,
        size: DVec2::new(260.0, 240.0),
        fill: Fill::Diffuse(1.0),
        common: Common { seed: 4, periodic, bottom: 3.0, priority: 0 },
    }
}

/// The search for overlaps knows nothing of how fibres are laid.
fn check(web: &Web, objects: Vec<Object>) -> Result<Sample, Problems> {
    let sides = if web.common.periodic { Sides::Periodic } else { Sides::Open };
    let patch = Some(Patch { size: web.size, center: DVec2::ZERO });
    let description = Description { patch, sides, objects, ..Description::default() };
    Sample::new(&description, &Wavelengths::from_nm(vec![500.0]).unwrap(), Coherence::Endless)
}

fn lowered(mut object: Object, by: f64) -> Object {
    let Body::Solid(Shape::Cylinder(fibre), _) = &mut object.body else { panic!("no fibre") };
    fibre.from.z -= by;
    fibre.to.z -= by;
    object
}

#[test]
fn fibres_rest_on_one_another_and_never_overlap() {
    for periodic in [true, false] {
        for mean in [1e-7, 0.01, 0.26] {
            for deviation in [Deviation::Mean(mean), Deviation::Random] {
                let web = web(deviation, periodic);
                let objects = web.objects(&Place::default()).unwrap();
                assert_eq!(web.axes(), web.axes(), "the same seed gives the same web");
                check(&web, objects.clone()).unwrap();
                assert_eq!(heights(&objects).unwrap()[0], 3.0, "the first lies on the floor");
                for (i, object) in objects.iter().enumerate().skip(1).step_by(7) {
                    let mut all = objects[..=i].to_vec();
                    all[i] = lowered(object.clone(), 1e-3);
                    let on_floor = heights(&all[i..]).unwrap()[0] < 3.0;
                    assert!(on_floor || check(&web, all).is_err(), "{deviation:?}: fibre {i} hovers");
                }
            }
        }
    }
}

#[test]
fn oriented_fibres_fill_their_layers() {
    let mut web = web(Deviation::Mean(0.0), true);
    (web.size, web.length) = (DVec2::new(100.0, 400.0), 100.0);
    let objects = web.objects(&Place::default()).unwrap();
    assert_eq!(heights(&objects), Some([3.0, 3.0 + 4.0 * 12.0]));
    let sample = check(&web, objects).unwrap();
    let endless = |i: u32| sample.primitives.bounds(crate::geometry::PrimId(i)).size().x.is_infinite();
    assert!((0..80).all(endless));
    web.length = 90.0;
    let sample = check(&web, web.objects(&Place::default()).unwrap()).unwrap();
    let ends = sample.primitives.bounds(crate::geometry::PrimId(0)).size().x;
    assert!((ends - 90.0).abs() < 1e-9);
    web.size.y = 399.0;
    assert!(web.check().is_err());
}

#[test]
fn fibres_that_would_meet_themselves_are_refused() {
    let mut web = web(Deviation::Random, true);
    web.size = DVec2::splat(199.0);
    web.layers = 100;
    let refused = web.axes().unwrap_err();
    assert!(refused.contains("both edges of `size` 220 µm or more"), "{refused}");
    web.size = DVec2::splat(201.0);
    assert!(web.axes().is_ok());
    web.common.periodic = false;
    web.size = DVec2::splat(20.0);
    assert!(web.axes().is_ok());
}

/// 400 fibres each: a mean off by more than 4 standard errors is a false alarm in 6 of 100,000 tests.
#[test]
fn laid_fibres_deviate_as_asked() {
    for (deviation, mean) in [(Deviation::Mean(0.26), 0.26), (Deviation::Random, std::f64::consts::FRAC_PI_4)] {
        let mut web = web(deviation, false);
        web.layers = 20;
        let angle = |[a, b]: &[DVec3; 2]| ((b - a).y / (b - a).x).atan().abs();
        let all: Vec<f64> = web.axes().unwrap().iter().map(angle).collect();
        let n = all.len() as f64;
        let found = all.iter().sum::<f64>() / n;
        let variance = all.iter().map(|a| (a - found).powi(2)).sum::<f64>() / n;
        assert!((found - mean).abs() < 4.0 * (variance / n).sqrt(), "{found}");
    }
}
