//! Which effects a sample and a light call for: printable, made before any ray is cast, and only ever changed by what a
//! pilot finds.

mod effects;
mod face;
pub mod features;
pub mod films;
mod limits;
mod neighbours;
pub mod stacks;
mod wanted;

use crate::light::{Light, Polarization};
use crate::optics::C64;
use crate::sample::{MediumTable, Sample};
pub use effects::{Effect, Name};
pub use face::PARALLEL;
use features::Features;
pub use films::{Edges, FilmRules, Probe};
pub use limits::{DOME_LEVEL, Limits};
use stacks::Marks;
pub use wanted::Wanted;

/// What the user decides about the simulation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Options {
    /// How far rays are followed.
    pub limits: Limits,
    /// Which effects are simulated.
    pub wanted: Wanted,
    /// Along what films are searched.
    pub probe: Probe,
    /// What is done at their edges.
    pub edges: Edges,
    /// Relative error of the reflected and the transmitted light that the user can bear; what is left out may make a fifth
    /// of it per effect.
    pub error: f64,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            limits: Limits::default(),
            wanted: Wanted::AUTO,
            probe: Probe::default(),
            edges: Edges::default(),
            error: 0.01,
        }
    }
}

/// Different curved faces of films for which tables are worth their while.
const MOST_CURVED: usize = 64;

/// What rays carry per wavelength.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum State {
    /// Power alone.
    Power,
    /// Stokes vectors: all that intensities need.
    Stokes,
    /// Mueller matrices: what becomes of light of any polarization.
    Mueller,
    /// Jones matrices: fields with their phase.
    Jones,
}

/// Which kernel traces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct KernelChoice {
    /// What rays carry.
    pub state: State,
    /// Whether faces are searched for films.
    pub films: bool,
    /// Whether anything absorbs.
    pub absorbs: bool,
    /// Whether refraction may part the lanes of a ray.
    pub parts: bool,
}

/// What is simulated.
#[derive(Clone, Debug)]
pub struct Plan {
    /// The effects, in a fixed order.
    pub effects: Vec<Effect>,
    /// The kernel that follows from them.
    pub kernel: KernelChoice,
    /// The media of the sample as they are simulated: without what is left out.
    pub media: Vec<MediumTable>,
    /// Wavelengths that are traced: a number in the grid each. Others are equal to one of them.
    pub lanes: Vec<usize>,
    /// For each wavelength of the grid, its lane.
    pub lane_of: Vec<usize>,
    /// Faces where films may begin.
    pub marks: Marks,
    /// Faces so narrow that ray optics is in doubt.
    pub features: Features,
    /// How films are found.
    pub films: FilmRules,
    /// How far rays are followed.
    pub limits: Limits,
    /// Whether every effect is wanted, needed or not.
    all: bool,
}

impl Plan {
    /// Plans the simulation of `sample` under `light`. What cannot be judged without a ray is left open, and simulated.
    pub fn new(sample: &Sample, light: &Light, options: &Options) -> Self {
        let Options { limits, wanted, probe, edges, .. } = *options;
        let shortest = light.wavelengths.nm()[0] / 1e3;
        let longest = light.wavelengths.nm()[light.wavelengths.len() - 1] / 1e3;
        let features = Features::new(&sample.primitives, longest);
        let marks = Marks::new(&sample.primitives, sample.cell.reach, shortest);
        let films = FilmRules { probe, edges, coherence: light.coherence(), tables: marks.curved() <= MOST_CURVED };
        let effects = effects::judge(sample, light, &marks, &wanted);
        let kernel = KernelChoice { state: State::Stokes, films: true, absorbs: true, parts: true };
        let (media, lanes, lane_of, all) = (Vec::new(), Vec::new(), Vec::new(), wanted.all());
        let mut plan = Self { effects, kernel, media, lanes, lane_of, marks, features, films, limits, all };
        plan.derive(sample, light);
        plan
    }

    /// Whether an effect is simulated.
    pub fn has(&self, name: Name) -> bool {
        self.effects[name as usize].on
    }

    /// Closes an open effect with what a pilot has found.
    pub fn settle(&mut self, name: Name, verdict: Verdict, sample: &Sample, light: &Light) {
        let effect = &mut self.effects[name as usize];
        (effect.on, effect.bound, effect.open) = (verdict.on, verdict.bound, false);
        effect.reason = format!("{}; {}", effect.reason, verdict.reason);
        self.derive(sample, light);
    }

    /// The same without an effect that is on, or with one that is off.
    #[must_use]
    pub fn switched(&self, name: Name, sample: &Sample, light: &Light) -> Self {
        let mut plan = self.clone();
        let effect = &mut plan.effects[name as usize];
        effect.on = !effect.on;
        plan.derive(sample, light);
        plan
    }

    /// What follows from the effects.
    fn derive(&mut self, sample: &Sample, light: &Light) {
        self.effects[Name::Finder as usize].on &= self.has(Name::Interference);
        self.media = sample.media.iter().map(|m| self.simulated(m)).collect();
        let count = light.wavelengths.len();
        let films = self.has(Name::Interference) && (self.marks.any() || self.all);
        let (lanes, lane_of) = if films || self.all || self.media.iter().any(differs) {
            ((0..count).collect(), (0..count).collect())
        } else {
            // Where nothing depends on the wavelength, one stands for all.
            (vec![0], vec![0; count])
        };
        let state = match light.polarization {
            Polarization::Mueller => State::Mueller,
            _ if self.has(Name::Phase) => State::Jones,
            _ if self.has(Name::Polarization) => State::Stokes,
            _ => State::Power,
        };
        let absorbs = self.has(Name::Absorption) || sample.has_opaque();
        // Also metals: what they reflect depends on the wavelength.
        let parts = self.all || self.media.iter().any(|m| m.index.iter().any(|n| *n != m.index[0]));
        self.kernel = KernelChoice { state, films, absorbs, parts };
        (self.lanes, self.lane_of) = (lanes, lane_of);
    }

    /// A medium without the effects that are off. What is opaque stays as it is.
    fn simulated(&self, medium: &MediumTable) -> MediumTable {
        if medium.is_opaque() {
            return medium.clone();
        }
        let middle = medium.index[medium.index.len() / 2].re;
        let index = |n: &C64| {
            let re = if self.has(Name::Dispersion) { n.re } else { middle };
            C64::new(re, if self.has(Name::Absorption) { n.im } else { 0.0 })
        };
        MediumTable { name: medium.name.clone(), index: medium.index.iter().map(index).collect() }
    }
}

/// What a pilot has found about an effect.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// Whether it matters.
    pub on: bool,
    /// What it has seen.
    pub reason: String,
    /// Bound of what leaving the effect out changes.
    pub bound: f64,
}

/// Whether light of different wavelengths fares differently in a medium: absorption goes with the wavelength even where
/// the index does not.
fn differs(medium: &MediumTable) -> bool {
    let (n, opaque) = (&medium.index, medium.is_opaque());
    n.iter().any(|x| *x != n[0]) || (!opaque && n.iter().any(|x| x.im > 0.0))
}
