//! What errors are worth: five samples of different kind, each measured with many seeds and compared with the truth.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};
use gonio_embree::bsdf::Arm;
use gonio_embree::dome::{BATCHES, Estimate, critical};
use gonio_embree::experiment::accuracy::Values;
use gonio_embree::experiment::{Goal, Outcome, Settings, Target, measure};
use gonio_embree::light::{Incidence, Light, Polarization, SourceMode, Wavelengths};
use gonio_embree::sample::description::{Fill, Patch, Shape};
use gonio_embree::sample::generate::bricks::Bricks;
use gonio_embree::sample::generate::packing::{Packing, SpherePacking};
use gonio_embree::sample::problem::Place;
use gonio_embree::sample::{Description, Sample};

use super::build::{Build, fibre};

/// A sample with its light.
pub struct Specimen {
    pub name: &'static str,
    pub sample: Sample,
    pub light: Light,
    /// Trees of a measurement whose errors are looked at.
    pub trees: u64,
    /// Trees of the measurement that counts as the truth: far more than any other has.
    pub reference: u64,
}

/// Level of the dome: facets 16° wide, so that 1 % is reached in seconds.
const LEVEL: u8 = 2;
/// Facets that fewer trees have hit are not judged.
const FEWEST_TREES: u64 = 100;
/// Seed of the references.
const REFERENCE_SEED: u64 = 1 << 40;

fn light(theta_deg: f64) -> Light {
    Light {
        wavelengths: Wavelengths::from_nm((0..8).map(|i| 400.0 + 40.0 * f64::from(i)).collect()).unwrap(),
        incidences: vec![Incidence { theta_deg, phi_deg: 0.0 }],
        polarization: Polarization::Unpolarized,
        source: SourceMode::Band,
    }
}

fn specimen(name: &'static str, description: &Description, theta: f64, trees: u64, reference: u64) -> Specimen {
    let light = light(theta);
    let sample = Sample::new(description, &light.wavelengths, light.coherence()).unwrap();
    Specimen { name, sample, light, trees, reference }
}

/// A glass sphere under a square beam as wide as it.
fn sphere() -> Description {
    let ball = Shape::Sphere { center: DVec3::ZERO, radius: 10.0 };
    Build::within(1.0).patch(20.0, 20.0).open().put(ball, 1.5).0
}

/// Spheres in a liquid whose index crosses theirs at 520 nm.
fn christiansen() -> Description {
    let mut build = Build::within(1.0);
    let (glass, liquid) = (build.cauchy(1.585, 4480.0), build.cauchy(1.535, 18_000.0));
    (build.0.above, build.0.below) = (liquid.clone(), liquid);
    let packing = Packing { count: 300, radius: 5.0, size: DVec3::new(50.0, 50.0, 210.0), periodic: true, seed: 1 };
    let spheres = SpherePacking::equal(packing, Fill::Medium(glass)).objects(&Place::default()).unwrap();
    build.0.patch = Some(Patch { size: DVec2::splat(50.0), center: DVec2::ZERO });
    build.0.objects = spheres;
    build.0
}

/// Two layers of parallel fibres of cellulose.
fn web() -> Description {
    let mut build = Build::within(1.0).patch(50.0, 60.0);
    for (z, shift) in [(0.0, 0.0), (-14.0, 7.0)] {
        for y in [-20.0, 0.0, 20.0].map(|y| y + shift) {
            build = build.put(Shape::from(fibre([-25.0, y, z], [25.0, y, z], 6.5)), 1.53);
        }
    }
    build.0
}

/// The five.
pub fn specimens() -> Vec<Specimen> {
    let feather = Build::within(1.0).bricks(&Bricks::default(), 2.0, 1.5).0;
    let film = Description::from_toml("assets/samples/morpho.toml".as_ref()).unwrap();
    vec![
        specimen("glass sphere", &sphere(), 30.0, 16_384, 30_000_000),
        specimen("feather", &feather, 30.0, 8192, 3_000_000),
        specimen("Christiansen slab", &christiansen(), 30.0, 8192, 1_000_000),
        specimen("oriented web", &web(), 45.0, 8192, 6_000_000),
        specimen("Morpho film", &film, 20.0, 8192, 3_000_000),
    ]
}

impl Specimen {
    fn settings(&self, seed: u64) -> Settings {
        Settings { trees: self.trees, seed, dome_level: LEVEL, ..Settings::default() }
    }

    fn measured(&self, settings: &Settings) -> Outcome {
        measure(&self.sample, &self.light, settings, |_| {}).unwrap()
    }

    /// What counts as the truth, with `share` of its trees.
    pub fn reference(&self, share: f64) -> Outcome {
        let trees = (share * self.reference as f64) as u64;
        self.measured(&Settings { trees, arm: Some(arm()), ..self.settings(REFERENCE_SEED) })
    }
}

/// A detector 10° wide, in ten places.
fn arm() -> Arm {
    let angles_deg = (-4..=5).map(|i| 15.0 * f64::from(i)).collect();
    Arm { angles_deg, aperture_deg: 10.0, below: false, turn_deg: 0.0 }
}

/// How many intervals there were, and how many of them held the true value.
#[derive(Clone, Copy, Debug, Default)]
pub struct Held {
    pub held: u64,
    pub all: u64,
}

impl Held {
    pub fn share(&self) -> f64 {
        self.held as f64 / self.all as f64
    }

    fn add(&mut self, measured: Estimate, truth: Estimate) {
        // What does not vary but by rounding has no interval.
        if measured.se > 1e-12 * measured.value.abs() {
            self.all += 1;
            let half = critical(0.05, BATCHES as usize) * measured.se.hypot(truth.se);
            self.held += u64::from((measured.value - truth.value).abs() <= half);
        }
    }
}

/// Intervals of 95 % of `seeds` measurements that hold the true value: of the ledger, of colours, of scans and of facets that
/// at least 100 trees have hit.
pub fn coverage(specimen: &Specimen, reference: &Outcome, seeds: u64) -> BTreeMap<&'static str, Held> {
    let mut all: BTreeMap<&'static str, Held> = BTreeMap::new();
    for seed in 1..=seeds {
        let outcome = specimen.measured(&Settings { arm: Some(arm()), ..specimen.settings(seed) });
        let (s, truth) = (&outcome.bsdf.incidences[0], &reference.bsdf.incidences[0]);
        let mut add = |name, measured, truth| all.entry(name).or_default().add(measured, truth);
        // What few trees decide has no interval in most measurements, and in the others one that says little.
        let worth = |e: &Estimate| e.value.min(1.0 - e.value) * s.trees as f64 >= FEWEST_TREES as f64;
        // Reflected and transmitted light, and what of them is in one direction.
        for (i, (_, entry)) in s.ledger.entries().into_iter().enumerate().filter(|(i, _)| [0, 1, 4, 5].contains(i)) {
            let known = entry.iter().zip(truth.ledger.entries()[i].1).filter(|(_, truth)| worth(truth));
            known.for_each(|(&a, &b)| add("ledger", a, b));
        }
        let labs =
            |d: &gonio_embree::bsdf::Derived| [d.reflected_lab, d.transmitted_lab].into_iter().flatten().flatten();
        labs(&s.derived).zip(labs(&truth.derived)).for_each(|(a, b)| add("colour", a, b));
        for (w, (&a, &b)) in s.derived.specular_share.iter().zip(&truth.derived.specular_share).enumerate() {
            // The rarer part of the light that is reflected.
            let part = truth.ledger.reflected[w].value * b.value.min(1.0 - b.value);
            if worth(&Estimate { value: part, se: 0.0 }) {
                add("ratio", a, b);
            }
        }
        let scans = outcome.scans[0].readings.iter().zip(&reference.scans[0].readings);
        for (a, b) in scans.filter(|(a, _)| a.trees >= FEWEST_TREES) {
            a.value.iter().zip(&b.value).for_each(|(&a, &b)| add("scan", a, b));
        }
        for (a, b) in outcome.grids[0].iter().zip(&reference.grids[0]).filter(|(a, _)| a.trees >= FEWEST_TREES) {
            a.value.iter().zip(&b.value).for_each(|(&a, &b)| add("facet", a, b));
        }
    }
    all
}

/// What measurements until a stated error were worth.
#[derive(Clone, Debug, Default)]
pub struct Reached {
    pub seeds: u64,
    /// How many were as good as they said.
    pub met: u64,
    /// Mean number of trees.
    pub trees: f64,
    /// Trees with which 95 of 100 would have been as good, had one known how many that are.
    pub oracle: f64,
    /// Trees and seconds that were forecast, over those it took: the means, and the worst deviation of
    /// the trees that 90 of 100 do not exceed.
    pub forecast_trees: f64,
    pub forecast_seconds: f64,
    pub forecast_worst: f64,
}

/// Measures with `seeds` seeds until the error is `target`, and compares with the truth.
pub fn targets(specimen: &Specimen, reference: &Outcome, target: f64, seeds: u64) -> Reached {
    let nm = specimen.light.wavelengths.nm();
    let truth = Values::measured(reference, nm);
    let mut reached = Reached { seeds, ..Reached::default() };
    let (mut needed, mut deviations) = (Vec::new(), Vec::new());
    for seed in 1..=seeds {
        let goal = Goal { target: Some(Target::Whole(target)), ..Goal::default() };
        let outcome = specimen.measured(&Settings { goal: Some(goal), ..specimen.settings(seed) });
        let error = truth.distance(Values::measured(&outcome, nm).squares(&truth)).whole;
        let (trees, ending) = (outcome.bsdf.incidences[0].trees as f64, outcome.ending.unwrap());
        assert!(ending.reached);
        reached.met += u64::from(error <= target);
        reached.trees += trees / seeds as f64;
        needed.push(trees * (error / target).powi(2));
        let (told, pilot_seconds) = ending.forecast.unwrap();
        let forecast = told.trees as f64 / trees;
        deviations.push((forecast - 1.0).abs());
        reached.forecast_trees += forecast / seeds as f64;
        reached.forecast_seconds += (told.seconds + pilot_seconds) / outcome.tracing_seconds / seeds as f64;
    }
    let at = |mut all: Vec<f64>, share: f64| {
        all.sort_by(f64::total_cmp);
        all[((share * all.len() as f64).ceil() as usize).clamp(1, all.len()) - 1]
    };
    reached.oracle = at(needed, 0.95);
    reached.forecast_worst = at(deviations, 0.9);
    reached
}
