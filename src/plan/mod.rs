//! Which effects a sample and a light call for: immutable, printable, made before any ray is cast.

pub mod features;
pub mod films;
pub mod stacks;

use crate::light::Light;
use crate::sample::{Matter, MediumId, Sample};
use crate::text::words;
use features::Features;
pub use films::{Edges, FilmRules, Probe};
use stacks::Marks;

/// An effect with the reason why it is simulated, or not.
#[derive(Clone, Debug, PartialEq)]
pub struct Effect {
    /// Name in results.
    pub name: &'static str,
    /// Whether it is simulated.
    pub on: bool,
    /// Why.
    pub reason: String,
    /// Bound of what leaving it out would change; 0 is a proof that it changes nothing.
    pub bound: f64,
}

/// How far rays are followed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Interfaces a ray may meet; beyond, its power counts as lost.
    pub depth: u32,
    /// Footprints (or heights of the sample, if it is higher than wide) a ray may walk sideways; beyond, its power has
    /// left through the side.
    pub walk: f64,
    /// At how many interfaces of a tree both branches are followed.
    pub splits: u32,
    /// A branch of less power than this is not followed after a split; its power counts as lost beyond the depth.
    pub faintest: f64,
}

impl Default for Limits {
    fn default() -> Self {
        Self { depth: 10_000, walk: 100.0, splits: 1, faintest: 0.0 }
    }
}

/// What the user decides about the simulation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Options {
    /// How far rays are followed.
    pub limits: Limits,
    /// Which effects are simulated.
    pub wanted: Wanted,
    /// Along what films are searched.
    pub probe: Probe,
    /// What is done at their edges.
    pub edges: Edges,
}

/// Different curved faces of films for which tables are worth their while.
const MOST_CURVED: usize = 64;

/// Who decides which effects are simulated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wanted {
    /// Those that can matter.
    #[default]
    Auto,
    /// Every one.
    All,
}

words!(Wanted { Auto = "auto", All = "all" });

/// What rays carry per wavelength.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// Stokes vectors: all that intensities need.
    Stokes,
    /// Jones matrices: fields with their phase.
    Jones,
}

/// What is simulated.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The effects, in a fixed order.
    pub effects: Vec<Effect>,
    /// Wavelengths that are traced: a number in the grid each. Others are equal to one of them.
    pub lanes: Vec<usize>,
    /// For each wavelength of the grid, its lane.
    pub lane_of: Vec<usize>,
    /// Lanes that start together on one ray.
    pub bundles: Vec<Vec<u16>>,
    /// Faces where films may begin.
    pub marks: Marks,
    /// Faces so narrow that ray optics is in doubt.
    pub features: Features,
    /// What rays carry.
    pub state: State,
    /// How films are found.
    pub films: FilmRules,
    /// How far rays are followed.
    pub limits: Limits,
}

impl Plan {
    /// Plans the simulation of `sample` under `light`.
    pub fn new(sample: &Sample, light: &Light, options: &Options) -> Self {
        let Options { limits, wanted, probe, edges } = *options;
        let shortest = light.wavelengths.nm()[0] / 1e3;
        let longest = light.wavelengths.nm()[light.wavelengths.len() - 1] / 1e3;
        let features = Features::new(&sample.primitives, longest);
        let marks = Marks::new(&sample.primitives, sample.cell.reach, shortest);
        let films = FilmRules { probe, edges, coherence: light.coherence(), tables: marks.curved() <= MOST_CURVED };
        let count = light.wavelengths.len();
        let all = wanted == Wanted::All;
        let dispersion = dispersion(sample, all);
        let interference = interference(&marks, all);
        let absorption = absorption(sample, all);
        let differ = dispersion.on || interference.on || absorption.on;
        // Where nothing depends on the wavelength, one stands for all.
        let (lanes, lane_of) =
            if differ { ((0..count).collect(), (0..count).collect()) } else { (vec![0], vec![0; count]) };
        let together: Vec<u16> = (0..lanes.len() as u16).collect();
        let bundles = if dispersion.on { together.iter().map(|&l| vec![l]).collect() } else { vec![together] };
        let phase = phase(all);
        let state = if phase.on { State::Jones } else { State::Stokes };
        let effects = vec![interference, polarization(), phase, dispersion, absorption];
        Self { effects, lanes, lane_of, bundles, marks, features, state, films, limits }
    }
}

fn interference(marks: &Marks, all: bool) -> Effect {
    let (on, reason, bound) = if marks.any() {
        (true, "some faces have a parallel neighbour within the coherence length", 1.0)
    } else {
        (all, "no two faces are parallel within the coherence length", 0.0)
    };
    Effect { name: "interference", on, reason: reason.into(), bound }
}

fn polarization() -> Effect {
    let reason = "every ray carries its state of polarization".into();
    Effect { name: "polarization", on: true, reason, bound: 1.0 }
}

fn phase(all: bool) -> Effect {
    let reason = "films are solved with their phases; rays are summed as intensities and need none".into();
    Effect { name: "phase", on: all, reason, bound: 0.0 }
}

/// Media in which light travels (not only as films; a film too thick for one is a body).
fn travelled(sample: &Sample) -> impl Iterator<Item = MediumId> + '_ {
    let of_solids = sample.solids.iter().filter_map(|s| match s.matter {
        Matter::Medium(id) => Some(id),
        _ => None,
    });
    of_solids.chain([sample.above, sample.below])
}

fn dispersion(sample: &Sample, all: bool) -> Effect {
    let table = |id: MediumId| &sample.media[usize::from(id.0)];
    let spread = |id: MediumId| {
        let n = table(id).index.iter().map(|n| n.re);
        n.clone().fold(f64::MIN, f64::max) - n.fold(f64::MAX, f64::min)
    };
    let worst = travelled(sample).map(|id| (spread(id), id)).max_by(|a, b| a.0.total_cmp(&b.0));
    match worst {
        Some((spread, id)) if spread > 0.0 => {
            let reason = format!("the index of `{}` varies by {spread:.4}; one ray per wavelength", table(id).name);
            Effect { name: "dispersion", on: true, reason, bound: spread }
        }
        _ => Effect { name: "dispersion", on: all, reason: "no index depends on the wavelength".into(), bound: 0.0 },
    }
}

fn absorption(sample: &Sample, all: bool) -> Effect {
    let largest =
        travelled(sample).flat_map(|id| sample.media[usize::from(id.0)].index.iter().map(|n| n.im)).fold(0.0, f64::max);
    let opaque = sample.solids.iter().any(|s| !matches!(s.matter, Matter::Medium(_)));
    let (on, reason) = match (largest > 0.0, opaque) {
        (true, _) => (true, format!("k is up to {largest}")),
        (false, true) => (true, "opaque surfaces absorb what they do not reflect".into()),
        (false, false) => (all, "no medium absorbs".into()),
    };
    Effect { name: "absorption", on, reason, bound: if largest > 0.0 || opaque { 1.0 } else { 0.0 } }
}
