//! The order of work: plan, try what the plan leaves open, trace, evaluate.

pub mod accuracy;
mod apart;
mod course;
mod explain;
mod gather;
mod pilot;
mod provenance;
pub mod sealed;
mod splits;
mod state;

use std::fmt;
use std::ops::Range;
use std::sync::Arc;
use std::time::Instant;

use serde::{Deserialize, Serialize};

use crate::bsdf::{Arm, Bsdf, FacetValue, Scan};
use crate::dome::Rule;
use crate::intersect::Scene;
use crate::intersect::choose::{Backend, BackendError};
use crate::light::Light;
use crate::plan::{self, Plan};
use crate::sample::Sample;
use crate::trace::{Kernel, Stacks};
use course::Course;

pub use crate::dome::BATCHES;
pub use course::{Ending, Forecast, Goal, Target};
pub use explain::explain;
pub use provenance::Origin;
pub use state::{Mismatch, State};

/// What the user decides besides sample and light.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Trees per incidence; with a goal only those a pilot is measured by.
    pub trees: u64,
    /// When enough is traced, in place of a fixed number of trees.
    pub goal: Option<Goal>,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Threads.
    pub threads: usize,
    /// Who intersects.
    pub backend: Backend,
    /// Finest level of the dome.
    pub dome_level: u8,
    /// What is simulated.
    pub options: plan::Options,
    /// A detector on an arm, besides the dome.
    pub arm: Option<Arm>,
}

impl Default for Settings {
    /// Those of the command line.
    fn default() -> Self {
        Self {
            trees: 200_000,
            goal: None,
            seed: 1,
            threads: std::thread::available_parallelism().map_or(1, usize::from),
            backend: Backend::Auto,
            dome_level: plan::DOME_LEVEL,
            options: plan::Options::default(),
            arm: None,
        }
    }
}

/// What came out besides the BSDF.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The result.
    pub bsdf: Bsdf,
    /// The same in facets of 8°, as measured ([`Bsdf::grids`]).
    pub grids: Vec<Vec<FacetValue>>,
    /// What the detector on its arm has read, per incidence, if there was one.
    pub scans: Vec<Scan>,
    /// The plan it was made by.
    pub plan: Plan,
    /// Stacks of films met.
    pub stacks: Stacks,
    /// How it ended, if there was a goal.
    pub ending: Option<Ending>,
    /// Wall time, s.
    pub seconds: f64,
    /// Part of it spent on tracing, s.
    pub tracing_seconds: f64,
}

/// How far the work is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Progress {
    /// Trees traced, of all incidences.
    pub done: u64,
    /// Trees to trace; with a target as many as it is thought to take.
    pub total: u64,
    /// Incidences completed in this round.
    pub incidences: usize,
    /// Seconds since the start.
    pub seconds: f64,
    /// With a goal, the greatest error of all incidences after the last round.
    pub error: Option<f64>,
}

/// Why nothing is measured.
#[derive(Clone, Debug, PartialEq)]
pub enum Error {
    /// A direction of incidence is none.
    Incidence(String),
    /// Nobody can intersect.
    Backend(BackendError),
}

impl From<BackendError> for Error {
    fn from(e: BackendError) -> Self {
        Self::Backend(e)
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Incidence(why) => write!(f, "incidence: {why}"),
            Self::Backend(why) => why.fmt(f),
        }
    }
}

impl std::error::Error for Error {}

/// What all rays of an experiment need: the sample under its light, ready to be traced.
#[derive(Clone)]
struct Bench<'a> {
    sample: &'a Sample,
    light: &'a Light,
    settings: &'a Settings,
    scene: Arc<Scene>,
    pool: Arc<rayon::ThreadPool>,
}

impl<'a> Bench<'a> {
    fn new(sample: &'a Sample, light: &'a Light, settings: &'a Settings) -> Result<Self, Error> {
        light.incidences.iter().try_for_each(|i| i.check().map_err(Error::Incidence))?;
        let scene = Arc::new(Scene::new(sample.primitives.clone(), sample.domain, settings.backend)?);
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(settings.threads)
            .build()
            .map_err(|e| BackendError::Library(format!("cannot start {} threads: {e}", settings.threads)))?;
        Ok(Self { sample, light, settings, scene, pool: Arc::new(pool) })
    }

    /// The plan, with what pilots have found.
    fn plan(&self) -> Plan {
        let plan = self.pool.install(|| Plan::new(self.sample, self.light, &self.settings.options));
        splits::choose(self, pilot::decide(self, plan))
    }

    fn kernel<'b>(&'b self, plan: &'b Plan) -> Kernel<'b> {
        Kernel::new(self.sample, &self.scene, plan, self.light)
    }
}

/// A measurement that is planned.
pub struct Experiment<'a> {
    bench: Bench<'a>,
    plan: Plan,
    /// Spent on planning, s.
    seconds: f64,
}

impl<'a> Experiment<'a> {
    /// Plans how `sample` is measured under `light`.
    ///
    /// # Errors
    /// When the light comes from nowhere, or the backend cannot work.
    pub fn new(sample: &'a Sample, light: &'a Light, settings: &'a Settings) -> Result<Self, Error> {
        let start = Instant::now();
        let bench = Bench::new(sample, light, settings)?;
        let plan = bench.plan();
        Ok(Self { bench, plan, seconds: start.elapsed().as_secs_f64() })
    }

    /// Nothing is traced yet.
    pub fn start(&self) -> State {
        self.state(None)
    }

    /// Nothing is traced yet, and only these batches will be ([`State::batches`]).
    pub fn start_part(&self, batches: Range<u32>) -> State {
        self.state(Some(batches))
    }

    fn state(&self, part: Option<Range<u32>>) -> State {
        let Bench { settings, light, .. } = &self.bench;
        let goal = settings.goal.filter(|_| part.is_none());
        State::new(Course::new(goal, settings.trees, light.incidences.len()), part, self.seconds, 0)
    }

    /// Traces what is still to be traced of `state`, until all is done or `watch` says `false`.
    pub fn advance(&self, state: &mut State, watch: impl FnMut(Progress, &State) -> bool) {
        state.aim(self.bench.settings.goal);
        gather::advance(&self.bench, &self.plan, state, watch);
    }

    /// What came out, of a state in which all is traced: of these incidences, if there are not all
    /// ([`State::join`]).
    pub fn outcome(self, state: &State, incidences: Option<&[usize]>) -> Outcome {
        let Bench { sample, light, settings, .. } = self.bench;
        let light = &incidences.map_or_else(|| light.clone(), |some| light.only(some));
        let (plan, measurements, [seconds, tracing_seconds]) = (self.plan, state.measurements(), state.times());
        let (stacks, ending) = (state.stacks().clone(), state.ending());
        let straight = |i| apart::straight_deg(sample, &plan, i);
        let straight: Vec<Vec<f64>> = light.incidences.iter().map(straight).collect();
        let bsdf = Bsdf::new(light, measurements, &straight, &plan, &sample.groups.names, &Rule::default());
        let scans = settings.arm.iter().flat_map(|arm| bsdf.scans(arm, measurements, &plan)).collect();
        let grids = Bsdf::grids(measurements, &plan);
        Outcome { bsdf, grids, scans, plan, stacks, ending, seconds, tracing_seconds }
    }
}

/// Measures `sample` under `light`; `watch` is told how far the work is.
///
/// # Errors
/// When the light comes from nowhere, or the backend cannot work.
pub fn measure(
    sample: &Sample,
    light: &Light,
    settings: &Settings,
    mut watch: impl FnMut(Progress),
) -> Result<Outcome, Error> {
    let start = Instant::now();
    let experiment = Experiment::new(sample, light, settings)?;
    let mut state = experiment.start();
    experiment.advance(&mut state, |progress, _| {
        watch(progress);
        true
    });
    let outcome = experiment.outcome(&state, None);
    Ok(Outcome { seconds: start.elapsed().as_secs_f64(), ..outcome })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light::{Incidence, Polarization, SourceMode, Wavelengths};
    use crate::sample::Description;

    /// An accelerator may abort the program on a direction that is none.
    #[test]
    fn light_from_nowhere_is_refused() {
        let mut light = Light {
            wavelengths: Wavelengths::from_nm(vec![550.0]).unwrap(),
            incidences: vec![Incidence { theta_deg: 0.0, phi_deg: 0.0 }],
            polarization: Polarization::Unpolarized,
            source: SourceMode::Band,
        };
        let description = Description::from_toml("tests/samples/good/spheres.toml".as_ref()).unwrap();
        let sample = Sample::new(&description, &light.wavelengths, light.coherence()).unwrap();
        for (theta_deg, phi_deg) in [(f64::NAN, 0.0), (90.0, 0.0), (-1.0, 0.0), (10.0, f64::INFINITY)] {
            light.incidences[0] = Incidence { theta_deg, phi_deg };
            let refused = measure(&sample, &light, &Settings::default(), |_| {});
            assert!(matches!(refused, Err(Error::Incidence(_))), "{theta_deg} {phi_deg}");
        }
    }
}
