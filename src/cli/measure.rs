//! The default command: measure a sample.

use std::io::IsTerminal as _;
use std::path::PathBuf;

use clap::Args;
use gonio_embree::bsdf::Bsdf;
use gonio_embree::experiment::{Ending, Goal, Outcome, measure};
use gonio_embree::output::{Measured, atomic, netcdf, summary, table};
use gonio_embree::plot;
use gonio_embree::units::significant;

use super::progress::{Line, duration};
use super::setup::{Scene, Setup};
use super::{Failure, answer, tell, write};

/// Options of a measurement.
#[derive(Debug, Args)]
pub struct Options {
    #[command(flatten)]
    setup: Setup,
    /// Largest share of the light that may be lost before the exit code is 1
    #[arg(long, default_value_t = 1e-4, value_name = "SHARE", help_heading = "Work")]
    max_lost: f64,

    /// The result; a picture goes beside it [default: name of the input, .nc]
    #[arg(short, long, value_name = "FILE.nc", help_heading = "Output")]
    output: Option<PathBuf>,
    /// Print one JSON document instead of the table
    #[arg(long, help_heading = "Output")]
    json: bool,
    /// Show no progress
    #[arg(long, help_heading = "Output")]
    quiet: bool,
}

/// Measures, and writes what came out.
pub fn run(options: &Options) -> Result<(), Failure> {
    let Scene { light, sample, files } = options.setup.scene()?;
    let mut origin = options.setup.origin(files)?;
    let output = options.output_path();
    let picture = output.with_extension("svg");
    if picture == output {
        return Err(Failure::Input("--output: the .svg file is for the picture; name the result FILE.nc".into()));
    }
    for path in [&output, &picture] {
        atomic::check(path)
            .map_err(|e| Failure::Input(format!("--output {}: cannot be written: {e}", path.display())))?;
    }
    let settings = options.setup.settings()?;
    let mut line = Line::new(options.quiet);
    let outcome = measure(&sample, &light, &settings, |p| line.show(&p, light.incidences.len()));
    line.clear();
    let outcome = outcome.map_err(|e| Failure::Cannot(e.to_string()))?;
    let times = times(&outcome);
    let goal = settings.goal.zip(outcome.ending);
    if let Some(ending) = outcome.ending.filter(|e| e.out_of_time) {
        origin.command += &format!(" --max-rounds {}", ending.rounds);
    }
    let run = summary::Run { seconds: outcome.seconds, threads: settings.threads, goal };
    let measured = outcome.into_measured(&sample, &light, &settings, origin);
    let bytes = netcdf::to_bytes(&measured).map_err(|e| Failure::Cannot(e.to_string()))?;
    write(&output, &bytes)?;
    write(&picture, plot::measurement(&measured).as_bytes())?;
    answer(&if options.json { summary::json(&measured, &run) + "\n" } else { table::text(&measured, chips()) })?;
    if !options.quiet {
        tell(&format!("wrote {} and {}; {times}", output.display(), picture.display()));
    }
    options.gate(&measured)?;
    goal.map_or(Ok(()), |(goal, ending)| reached(&goal, &ending, &measured.bsdf, run.seconds))
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

/// Whether standard output is a terminal that shows any colour, and the user has not asked for none (no-color.org).
fn chips() -> bool {
    let set = |name| std::env::var_os(name).is_some_and(|v: std::ffi::OsString| !v.is_empty());
    let colours = std::env::var("COLORTERM").is_ok_and(|v| v == "truecolor" || v == "24bit");
    std::io::stdout().is_terminal() && colours && !set("NO_COLOR")
}

fn times(outcome: &Outcome) -> String {
    let trees: u64 = outcome.bsdf.incidences.iter().map(|s| s.trees).sum();
    let rate = trees as f64 / outcome.tracing_seconds / 1e6;
    let (all, tracing) = (duration(outcome.seconds), duration(outcome.tracing_seconds));
    format!("{all} in all, {tracing} of it tracing ({rate:.3} M trees/s){}", price(outcome).unwrap_or_default())
}

/// What an error of 1 % would take, if this is far from it and was not asked for.
fn price(outcome: &Outcome) -> Option<String> {
    let worst = outcome.bsdf.incidences.iter().map(|s| s.derived.precision.whole).fold(0.0, f64::max);
    let times = (worst / 0.01).powi(2);
    let told = outcome.ending.is_none() && times > 2.0 && times.is_finite();
    told.then(|| {
        format!("; errors of 1 % take about {} (--target-error 1%)", duration(times * outcome.tracing_seconds))
    })
}

impl Options {
    fn output_path(&self) -> PathBuf {
        let stem = || PathBuf::from(self.setup.input().file_stem().unwrap_or_default()).with_extension("nc");
        self.output.clone().unwrap_or_else(stem)
    }

    fn gate(&self, measured: &Measured) -> Result<(), Failure> {
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
