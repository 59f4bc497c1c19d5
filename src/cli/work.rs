//! A measurement from what the user typed to the files it leaves.

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use gonio_embree::bsdf::Bsdf;
use gonio_embree::experiment::sealed::Key;
use gonio_embree::experiment::{Ending, Experiment, Goal, Origin, Outcome, Progress, Settings, State, Target};
use gonio_embree::output::{Measured, atomic, netcdf, summary};
use gonio_embree::plot;
use gonio_embree::units::{self, significant};

use super::keep::Checkpoint;
use super::progress::duration;
use super::setup::{Scene, Setup};
use super::stop::Stop;
use super::{Failure, write};

/// A measurement and its result.
#[derive(Clone, Debug, Args)]
pub struct Order {
    #[command(flatten)]
    pub setup: Setup,
    /// Largest share of the light that may be lost before the exit code is 1
    #[arg(long, default_value_t = 1e-4, value_name = "SHARE", help_heading = "Work")]
    max_lost: f64,
    /// Keep what is traced beside the result as often as this: whatever ends the program, the same command goes on from there
    #[arg(long, default_value = "60s", value_name = "TIME|off", help_heading = "Work")]
    checkpoint: Interval,
    /// The result; a picture goes beside it [default: name of the input, .nc]
    #[arg(short, long, value_name = "FILE.nc", help_heading = "Output")]
    output: Option<PathBuf>,
}

/// A time between two deeds, or none.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval(pub Option<Duration>);

impl std::str::FromStr for Interval {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "off" {
            return Ok(Self(None));
        }
        let seconds = units::seconds(text).map_err(|e| e.to_string())?;
        Ok(Self(Some(Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX))))
    }
}

impl Order {
    /// The result.
    pub fn output(&self) -> PathBuf {
        let stem = || PathBuf::from(self.setup.input().file_stem().unwrap_or_default()).with_extension("nc");
        self.output.clone().unwrap_or_else(stem)
    }

    /// How often work is kept.
    pub fn every(&self) -> Option<Duration> {
        self.checkpoint.0
    }
}

/// A measurement that is ready to be made.
pub struct Work {
    pub scene: Scene,
    pub settings: Settings,
    pub origin: Origin,
    pub output: PathBuf,
    max_lost: f64,
}

/// What a measurement has left.
pub struct Done {
    pub measured: Measured,
    pub run: summary::Run,
    /// Time spent on tracing, s.
    pub tracing_seconds: f64,
    pub picture: PathBuf,
}

impl Work {
    /// Reads the sample, and looks whether the result can be written.
    pub fn new(options: &Order) -> Result<Self, Failure> {
        let mut scene = options.setup.scene()?;
        let origin = options.setup.origin(std::mem::take(&mut scene.files))?;
        let (output, max_lost) = (options.output(), options.max_lost);
        let mut settings = options.setup.settings()?;
        settings.backend = settings.backend.fit(&scene.sample.primitives, scene.sample.domain);
        let work = Self { scene, settings, origin, output, max_lost };
        if work.picture() == work.output {
            return Err(Failure::Input("--output: the .svg file is for the picture; name the result FILE.nc".into()));
        }
        for path in [&work.output, &work.picture()] {
            atomic::check(path)
                .map_err(|e| Failure::Input(format!("--output {}: cannot be written: {e}", path.display())))?;
        }
        Ok(work)
    }

    /// What the result depends on.
    pub fn key(&self) -> Key {
        self.origin.key(self.settings.backend)
    }

    fn picture(&self) -> PathBuf {
        self.output.with_extension("svg")
    }

    /// Plans it.
    pub fn experiment(&self) -> Result<Experiment<'_>, Failure> {
        Experiment::new(&self.scene.sample, &self.scene.light, &self.settings)
            .map_err(|e| Failure::Cannot(e.to_string()))
    }

    /// Measures, from where an earlier attempt was if it has left something, and writes the result.
    pub fn run(&self, every: Option<Duration>, stop: &Stop, watch: &mut dyn FnMut(&Progress)) -> Result<Done, Failure> {
        let mut checkpoint = Checkpoint::beside(&self.output, self.key(), every);
        let kept = checkpoint.read::<State>();
        let experiment = self.experiment()?;
        let mut state = kept.unwrap_or_else(|| experiment.start());
        trace(&experiment, &mut state, stop, watch, |state| checkpoint.keep_now_and_then(state));
        if !state.is_finished() {
            return checkpoint.stop(&state);
        }
        let done = self.done(experiment.outcome(&state, None), None);
        self.write(&done).map_err(|e| self.rescue(&e, &checkpoint, &state, &done))?;
        checkpoint.remove();
        Ok(done)
    }

    /// The result of what came out; `note` tells what it lacks.
    pub fn done(&self, outcome: Outcome, note: Option<String>) -> Done {
        let mut origin = self.origin.clone();
        if let Some(ending) = outcome.ending.filter(|e| e.out_of_time) {
            origin.command += &format!(" --max-rounds {}", ending.rounds);
        }
        let goal = self.settings.goal.zip(outcome.ending);
        let run = summary::Run { seconds: outcome.seconds, threads: self.settings.threads, goal };
        let tracing_seconds = outcome.tracing_seconds;
        let mut measured = outcome.into_measured(&self.scene.sample, &self.scene.light, &self.settings, origin);
        measured.provenance.incomplete = note;
        Done { measured, run, tracing_seconds, picture: self.picture() }
    }

    /// Writes the result and its picture.
    pub fn write(&self, done: &Done) -> Result<(), Failure> {
        let bytes = netcdf::to_bytes(&done.measured).map_err(|e| Failure::Cannot(e.to_string()))?;
        write(&self.output, &bytes)?;
        write(&done.picture, plot::measurement(&done.measured).as_bytes())
    }

    /// What has taken so long to measure is not lost because a disk is full: it is kept beside the result, or else where there
    /// is room.
    fn rescue(&self, why: &Failure, checkpoint: &Checkpoint, state: &State, done: &Done) -> Failure {
        if let Err(Failure::Stopped(_)) = checkpoint.stop::<()>(state) {
            let told = "what is traced is kept, and the same command will write it";
            return Failure::Cannot(format!("{why}; {told}"));
        }
        let name = self.output.file_name().unwrap_or_default().to_string_lossy();
        let elsewhere = std::env::temp_dir().join(format!("rescued-{}-{name}", std::process::id()));
        let bytes = netcdf::to_bytes(&done.measured).unwrap_or_default();
        match write(&elsewhere, &bytes) {
            Ok(()) => Failure::Cannot(format!("{why}; the result is in {}", elsewhere.display())),
            Err(_) => Failure::Cannot(why.to_string()),
        }
    }

    /// Whether a result is as good as it has to be.
    pub fn judge(&self, done: &Done) -> Result<(), Failure> {
        self.gate(&done.measured)?;
        done.run.goal.map_or(Ok(()), |(goal, ending)| reached(&goal, &ending, &done.measured.bsdf, done.run.seconds))
    }

    /// Whether a result that was there before has the error that is asked for.
    pub fn has_reached(&self, measured: &Measured) -> bool {
        let target = self.settings.goal.and_then(|g| g.target);
        let reached = |t: Target| measured.bsdf.incidences.iter().all(|s| t.of(&s.derived.precision) <= t.error());
        target.is_none_or(reached)
    }

    /// Draws the picture of a result that was there before, if it has none.
    pub fn draw_if_missing(&self, measured: &Measured) -> Result<(), Failure> {
        let picture = self.picture();
        if picture.exists() { Ok(()) } else { write(&picture, plot::measurement(measured).as_bytes()) }
    }

    /// Whether not too much light was lost.
    pub fn gate(&self, measured: &Measured) -> Result<(), Failure> {
        let lost = measured.bsdf.largest_loss();
        if lost <= self.max_lost {
            return Ok(());
        }
        Err(Failure::Quality(format!(
            "{lost:.2e} of the light was lost, more than --max-lost {:e}; the table says to what: a greater --depth \
             helps against lost_depth, a mended mesh against lost_medium",
            self.max_lost
        )))
    }
}

/// Traces what is to be traced of `state`, until `stop` is asked for; `keep` is handed what there is again and again.
pub fn trace(
    experiment: &Experiment<'_>,
    state: &mut State,
    stop: &Stop,
    watch: &mut dyn FnMut(&Progress),
    mut keep: impl FnMut(&State),
) {
    experiment.advance(state, |progress, state| {
        watch(&progress);
        keep(state);
        !stop.is_asked()
    });
}

/// Whether a target, if there was one, is reached.
pub fn reached(goal: &Goal, ending: &Ending, bsdf: &Bsdf, seconds: f64) -> Result<(), Failure> {
    let Some(target) = goal.target.filter(|_| !ending.reached) else { return Ok(()) };
    let error = bsdf.incidences.iter().map(|s| target.of(&s.derived.precision)).fold(0.0, f64::max);
    let cause =
        if ending.out_of_time && goal.max_seconds.is_some() { "--max-time is over" } else { "--max-rounds are over" };
    // A tenth more to see it twice.
    let needed = 1.2 * seconds * (error / target.error()).powi(2).max(1.0);
    let advice = if needed.is_finite() { format!("; it takes about {}", duration(needed)) } else { String::new() };
    Err(Failure::Quality(format!(
        "--target-error {target} was not reached: {cause} at {} %{advice}",
        significant(100.0 * error, 2)
    )))
}
