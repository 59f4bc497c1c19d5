//! Bodies under measured heights: what they do to light that closed forms tell, where they repeat and where they end.

use std::path::Path;

use crate::common::build::{Build, light, relief, rough};
use crate::common::listen::{entries, listen, settings};
use glam::DVec2;
use gonio_embree::bsdf::Ledger;
use gonio_embree::dome::Estimate;
use gonio_embree::experiment::measure;
use gonio_embree::intersect::choose::Backend;
use gonio_embree::light::Polarization;
use gonio_embree::optics::field::Stokes;
use gonio_embree::plan::{Limits, Wanted};
use gonio_embree::sample::Description;
use gonio_embree::sample::description::{Body, Shape};
use gonio_embree::sample::relief::HeightField;

const NM: [f64; 2] = [500.0, 520.0];
const FROM: [(f64, f64); 4] = [(0.0, 0.0), (30.0, 200.0), (60.0, 45.0), (85.0, 10.0)];

fn ledgers(build: &Build, trees: u64) -> Vec<Ledger> {
    let light = light(&NM, &FROM, Polarization::Unpolarized);
    let outcome = measure(&build.sample(&light), &light, &settings(trees), |_| {}).unwrap();
    outcome.bsdf.incidences.into_iter().map(|s| s.ledger).collect()
}

fn assert_equal(name: &str, a: &[Ledger], b: &[Ledger]) {
    let same = |x: &[Estimate], y: &[Estimate]| x.iter().zip(y).all(|(x, y)| (x.value - y.value).abs() < 1e-12);
    for (a, b) in a.iter().zip(b) {
        assert!(same(&a.reflected, &b.reflected) && same(&a.transmitted, &b.transmitted), "{name}: {a:?} {b:?}");
        assert!(same(&a.specular, &b.specular) && same(&a.undeflected, &b.undeflected), "{name}: {a:?} {b:?}");
    }
}

/// A flat relief is a film, or the face of what lies below.
#[test]
fn a_flat_relief_is_a_film_and_an_interface() {
    let around = || Build::within(1.0).patch(4.0, 3.0);
    let flat = |floor| relief([8, 4], [0.5, 0.75], floor, |_, _| 0.25);
    let film = around().films(0.25, &[(1.5, 0.5)]);
    assert_equal("film", &ledgers(&around().put(flat(-0.25), 1.5), 200), &ledgers(&film, 200));
    let face = around().films(0.25, &[(1.5, 0.25)]).below(1.5);
    assert_equal("face", &ledgers(&around().put(flat(-0.25), 1.5).below(1.5), 200), &ledgers(&face, 200));
    // Reaching into a slab it is another face of that.
    let slab = || Shape::Slab { top: 0.0, bottom: -40.0 };
    let higher = Shape::Slab { top: 0.25, bottom: -40.0 };
    let reaching = around().put(slab(), 1.5).put(flat(-3.0), 1.5);
    assert_equal("slab", &ledgers(&reaching, 200), &ledgers(&around().put(higher, 1.5), 200));
}

fn sum(l: &Ledger, i: usize) -> f64 {
    [&l.reflected, &l.transmitted, &l.absorbed, &l.side].into_iter().map(|entry| entry[i].value).sum()
}

/// No light gets lost at seams, walls, edges or the floor.
#[test]
fn rough_glass_loses_nothing() {
    let glass = |most: f64| relief([16, 12], [0.5, 0.75], -0.7, rough(most));
    let around = || Build::within(1.0).patch(8.0, 9.0);
    let samples = [
        ("repeating", around().put(glass(1.0), 1.5)),
        ("steep", around().put(glass(6.0), 1.5)),
        ("on glass", around().put(glass(2.0), 1.5).below(1.5)),
        ("in a slab", around().put(Shape::Slab { top: -0.3, bottom: -30.0 }, 1.5).put(glass(1.0), 1.7)),
        ("alone", around().put(glass(2.0), 1.5).open()),
    ];
    for (name, build) in samples {
        for ledger in ledgers(&build, 3000) {
            for i in 0..NM.len() {
                let lost = ledger.lost_medium[i].value + ledger.lost_depth[i].value + ledger.lost_numeric[i].value;
                assert!((sum(&ledger, i) + lost - 1.0).abs() < 1e-9 && ledger.absorbed[i].value == 0.0, "{name}");
                // Light that is caught in steep glass ends at the largest depth.
                assert_eq!((ledger.lost_medium[i].value, ledger.lost_numeric[i].value), (0.0, 0.0), "{name}");
                assert!(ledger.lost_depth[i].value < 1e-4, "{name}: {ledger:?}");
            }
        }
    }
}

/// Roofs of a constant slope, that goes on over the seam: all light that is refracted once leaves at the angle of Snell.
#[test]
fn a_sawtooth_refracts_by_snells_law() {
    let slope: f64 = 0.125;
    let roof = |c: usize, _: usize| slope * 0.5 * (4.0 - (c as f64 - 4.0).abs());
    let teeth = Build::within(1.0).put(relief([8, 3], [0.5, 1.0], -1.0, roof), 1.5).below(1.5);
    let light = light(&NM[..1], &[(0.0, 0.0)], Polarization::Unpolarized);
    let sample = teeth.sample(&light);
    assert_eq!(sample.cell.size, DVec2::new(4.0, 3.0));
    let heard = listen::<Stokes>(&sample, &light, Backend::Auto, Limits::default(), Wanted::ALL, &entries(3, 2000));
    let tilt = slope.atan();
    let aside = (tilt - (tilt.sin() / 1.5).asin()).sin();
    let (mut left, mut right) = (0_i32, 0_i32);
    for leaving in heard.exits.iter().filter(|l| l.dir.z < -0.9) {
        assert!((leaving.dir.x.abs() - aside).abs() < 1e-12 && leaving.dir.y.abs() < 1e-12, "{leaving:?}");
        *if leaving.dir.x < 0.0 { &mut left } else { &mut right } += 1;
    }
    // One in 1e9 seeds would differ by more than six standard deviations.
    assert!(left + right == 2000 && (left - right).abs() < 268, "{left} {right}");
    assert_eq!(heard.lost, 0.0);
}

fn reliefs(description: &Description) -> Vec<&HeightField> {
    description
        .objects
        .iter()
        .filter_map(|o| if let Body::Solid(Shape::Relief(r), _) = &o.body { Some(&r.field) } else { None })
        .collect()
}

fn good(name: &str) -> Description {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/samples/good").join(name);
    Description::from_toml(&file).unwrap_or_else(|e| panic!("{e}"))
}

/// Written independently in nine forms: the same heights, to the precision of single-precision metres.
#[test]
fn all_formats_hold_the_same_heights() {
    let nm = [0.0, 60.0, 255.0, 120.0, 30.0, 90.0, 200.0, 45.0, 10.0, 75.0, 150.0, 90.0];
    let description = good("reliefs.toml");
    let fields = reliefs(&description);
    assert_eq!(fields.len(), 9);
    for (i, field) in fields.into_iter().enumerate() {
        assert_eq!((field.columns, field.rows), (4, 3), "{i}");
        assert!(field.pixel.distance(DVec2::new(0.5, 0.25)) < 1e-12, "{i}: {:?}", field.pixel);
        for (z, nm) in field.heights.iter().zip(nm) {
            assert!((z + 2.0 * i as f64 - 1e-3 * nm).abs() < 1e-7, "{i}: {:?}", field.heights);
        }
    }
}

/// Row 0 is the +y edge, column 0 the -x edge.
#[test]
fn gaps_are_filled_and_hills_turned_into_valleys() {
    let description = good("relief_alone.toml");
    let field = reliefs(&description)[0];
    let turned = [1.0, 0.9, 0.9, 0.8, 0.9, 0.9, 0.9, 1.0, 0.9, 1.0, 0.9, 1.0];
    assert!(field.heights.iter().zip(turned).all(|(z, t)| (z - t).abs() < 1e-15), "{:?}", field.heights);
    assert!(description.remarks().is_empty());
}

#[test]
fn a_seam_that_shows_is_told() {
    let ramp = |c: usize, _: usize| 0.1 * c as f64;
    let build = Build::within(1.0).put(relief([16, 3], [1.0, 1.0], -1.0, ramp), 1.5);
    let [remark] = &build.0.remarks()[..] else { panic!("{:?}", build.0.remarks()) };
    let told = "differ by 1.5 µm (rms), neighbours by 100 nm";
    assert!(remark.message.contains("its columns") && remark.message.contains(told), "{}", remark.message);
    assert!(build.open().0.remarks().is_empty());
}
