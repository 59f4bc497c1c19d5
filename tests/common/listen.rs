//! Listeners to the tracer: every tree by itself, or directions counted in bins.

use glam::DVec3;
use gonio_embree::experiment::Settings;
use gonio_embree::intersect::Scene;
use gonio_embree::intersect::choose::Backend;
use gonio_embree::light::{Light, Polarization};
use gonio_embree::optics::C64;
use gonio_embree::optics::field::{Field, Jones, Stokes};
use gonio_embree::plan::{Limits, Options, Plan, Wanted};
use gonio_embree::sample::Sample;
use gonio_embree::trace::{
    All, Batch, Detect, Effects, Exit, Kernel, Loss, Recorder, Tracer, TreeKey, TreeNumbers, Unit, run,
};

/// Usual settings.
pub fn settings(trees: u64) -> Settings {
    Settings { trees, seed: 1, threads: 2, dome_level: 3, ..Settings::default() }
}

/// A ray that left.
#[derive(Clone, Debug, PartialEq)]
pub struct Leaving<F> {
    pub tree: u32,
    pub dir: DVec3,
    pub frame: DVec3,
    pub position: DVec3,
    pub anchor: DVec3,
    pub lengths: Vec<f64>,
    pub fields: Vec<(u16, F)>,
}

/// Everything that was heard; powers are summed over lanes.
#[derive(Clone, Debug, PartialEq)]
pub struct Heard<F> {
    pub exits: Vec<Leaving<F>>,
    pub side: f64,
    pub absorbed: f64,
    pub lost: f64,
}

impl<F: Field> Recorder<F> for Heard<F> {
    fn exit(&mut self, exit: &Exit<'_, F>) {
        self.exits.push(Leaving {
            tree: exit.tree,
            dir: exit.dir,
            frame: exit.frame,
            position: exit.position,
            anchor: exit.anchor,
            lengths: exit.lengths().to_vec(),
            fields: exit.loads().collect(),
        });
    }

    fn side(&mut self, _: u16, power: f64) {
        self.side += power;
    }

    fn absorb(&mut self, _: u16, _: u16, power: f64) {
        self.absorbed += power;
    }

    fn lose(&mut self, _: Loss, _: u16, power: f64) {
        self.lost += power;
    }
}

/// Where trees enter, and their random numbers.
pub type Entries = Vec<([f64; 2], TreeKey)>;

/// Entries of the first `n` trees of a seed.
pub fn entries(seed: u64, n: u32) -> Entries {
    let batch = Batch { seed, incidence: 0, scramble: 0 };
    let numbers = (0..n).map(|tree| TreeNumbers::new(batch, tree));
    numbers.map(|n| (n.entry, TreeKey { key: n.key(), first: n.first() })).collect()
}

/// Traces one tree per entry under the first incidence of the light, and tells where every ray went, tree by tree.
/// Lengths are followed if the effects are `All`.
pub fn listen<F: Field>(
    sample: &Sample,
    light: &Light,
    backend: Backend,
    limits: Limits,
    effects: Wanted,
    entries: &Entries,
) -> Heard<F> {
    let plan = Plan::new(sample, light, &Options { limits, wanted: effects, ..Options::default() });
    listen_to(&plan, sample, light, backend, entries)
}

/// The same for any plan.
pub fn listen_to<F: Field>(
    plan: &Plan,
    sample: &Sample,
    light: &Light,
    backend: Backend,
    entries: &Entries,
) -> Heard<F> {
    listen_with::<F, All>(plan, sample, light, backend, entries)
}

/// The same with any choice of effects.
pub fn listen_with<F: Field, E: Effects>(
    plan: &Plan,
    sample: &Sample,
    light: &Light,
    backend: Backend,
    entries: &Entries,
) -> Heard<F> {
    let scene = Scene::new(sample.primitives.clone(), sample.domain, backend).unwrap();
    let kernel = Kernel::new(sample, &scene, plan, light);
    let mut tracer = Tracer::<F, E>::new(&kernel);
    let mut heard = Heard { exits: Vec::new(), side: 0.0, absorbed: 0.0, lost: 0.0 };
    for (i, part) in entries.chunks(256).enumerate() {
        let incidence = &light.incidences[0];
        tracer.trace(incidence, light.polarization, 256 * i as u32, part.iter().copied(), &mut heard);
    }
    heard.exits.sort_by_key(|e| e.tree);
    heard
}

/// Sum of the fields that leave upwards, or downwards, into a medium of index `outside`, along the polarization of the
/// light (s or p), each referred to the wavefront through its point of entry; per wavelength. Phases must be followed.
pub fn coherent_sum(heard: &Heard<Jones>, sample: &Sample, light: &Light, up: bool, outside: f64) -> Vec<C64> {
    let s = light.incidences[0].s_direction();
    let um: Vec<f64> = light.wavelengths.um().collect();
    let mut out = vec![C64::ZERO; um.len()];
    for exit in heard.exits.iter().filter(|e| (e.dir.z > 0.0) == up) {
        let along = if light.polarization == Polarization::S { s } else { s.cross(exit.dir) };
        let (x, y) = (exit.frame.dot(along), exit.dir.cross(exit.frame).dot(along));
        let optical: f64 = exit.lengths.iter().zip(&sample.media).map(|(l, m)| l * m.index[0].re).sum();
        let path = optical - outside * exit.dir.dot(exit.position - exit.anchor);
        for &(lane, field) in &exit.fields {
            let lane = usize::from(lane);
            out[lane] += (field.x[0] * x + field.y[0] * y) * C64::cis(std::f64::consts::TAU * path / um[lane]);
        }
    }
    out
}

/// Adds up power by direction; the last entry is for what does not leave by a direction.
struct Histogram<'a, B> {
    bin: &'a B,
    power: Vec<f64>,
}

impl<B> Histogram<'_, B> {
    fn elsewhere(&mut self, power: f64) {
        *self.power.last_mut().unwrap() += power;
    }
}

impl<F: Field, B: Fn(DVec3) -> Option<usize>> Recorder<F> for Histogram<'_, B> {
    fn exit(&mut self, exit: &Exit<'_, F>) {
        if let Some(bin) = (self.bin)(exit.dir) {
            self.power[bin] += exit.loads().map(|(_, field)| field.power()).sum::<f64>();
        }
    }

    fn side(&mut self, _: u16, power: f64) {
        self.elsewhere(power);
    }

    fn absorb(&mut self, _: u16, _: u16, power: f64) {
        self.elsewhere(power);
    }

    fn lose(&mut self, _: Loss, _: u16, power: f64) {
        self.elsewhere(power);
    }
}

impl<F: Field, B: Fn(DVec3) -> Option<usize>> Detect<F> for Histogram<'_, B> {
    type Part = Vec<f64>;

    fn begin(&mut self, _: usize) {}

    fn finish(&mut self, _: u64) -> Vec<f64> {
        let empty = vec![0.0; self.power.len()];
        std::mem::replace(&mut self.power, empty)
    }
}

/// Mean power of a tree in each of `bins` bins of direction, and what left by no direction (guided sideways, absorbed,
/// lost): a row per batch of `trees` trees.
pub fn histogram(
    sample: &Sample,
    light: &Light,
    batches: &[Batch],
    trees: u32,
    bins: usize,
    bin: impl Fn(DVec3) -> Option<usize> + Sync,
) -> Vec<Vec<f64>> {
    let scene = Scene::new(sample.primitives.clone(), sample.domain, Backend::Auto).unwrap();
    let plan = Plan::new(sample, light, &Options::default());
    let kernel = Kernel::new(sample, &scene, &plan, light);
    let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
    let units: Vec<Unit> = batches.iter().flat_map(|&b| Unit::cut(b, trees)).collect();
    let mut rows: Vec<Vec<f64>> = Vec::with_capacity(batches.len());
    let make = || Histogram { bin: &bin, power: vec![0.0; bins + 1] };
    run::<Stokes, All, _>(&kernel, light, &units, &pool, make, |unit, part, _| {
        if unit.first == 0 {
            rows.push(vec![0.0; bins + 1]);
        }
        let row = rows.last_mut().unwrap();
        row.iter_mut().zip(part).for_each(|(sum, power)| *sum += power / f64::from(trees));
        true
    });
    rows
}

/// Independent scrambles under the first incidence.
pub fn scrambles(seed: u64, count: u32) -> Vec<Batch> {
    (0..count).map(|scramble| Batch { seed, incidence: 0, scramble }).collect()
}
