//! The default command: measure a sample.

use std::io::IsTerminal as _;

use clap::Args;
use gonio_embree::output::{summary, table};

use super::progress::{Line, SETTING_UP, Waiting, duration};
use super::stop::Stop;
use super::work::{Done, Order, Work};
use super::{Failure, answer, tell};

/// Options of a measurement, and what is shown of it.
#[derive(Debug, Args)]
pub struct Options {
    #[command(flatten)]
    work: Order,
    /// Print one JSON document instead of the table
    #[arg(long, help_heading = "Output")]
    json: bool,
    /// Show no progress
    #[arg(long, help_heading = "Output")]
    quiet: bool,
}

/// Measures, and writes what came out.
pub fn run(options: &Options) -> Result<(), Failure> {
    let mut waiting = Some(Waiting::new(SETTING_UP, options.quiet));
    let work = Work::new(&options.work)?;
    let stop = Stop::listen();
    let mut line = Line::new(options.quiet);
    let incidences = work.scene.light.incidences.len();
    let done = work.run(options.work.every(), &stop, &mut |p| {
        waiting = None;
        line.show(p, incidences);
    });
    drop(waiting);
    line.clear();
    let done = done?;
    let measured = &done.measured;
    answer(&if options.json { summary::json(measured, &done.run) + "\n" } else { table::text(measured, chips()) })?;
    if !options.quiet {
        let (result, picture) = (work.output.display(), done.picture.display());
        tell(&format!("wrote {result} and {picture}; {}", times(&done)));
    }
    work.judge(&done)
}

/// Whether standard output is a terminal that shows any colour, and the user has not asked for none (no-color.org).
fn chips() -> bool {
    let set = |name| std::env::var_os(name).is_some_and(|v: std::ffi::OsString| !v.is_empty());
    let colours = std::env::var("COLORTERM").is_ok_and(|v| v == "truecolor" || v == "24bit");
    std::io::stdout().is_terminal() && colours && !set("NO_COLOR")
}

fn times(done: &Done) -> String {
    let trees: u64 = done.measured.bsdf.incidences.iter().map(|s| s.trees).sum();
    let rate = trees as f64 / done.tracing_seconds / 1e6;
    let (all, tracing) = (duration(done.run.seconds), duration(done.tracing_seconds));
    format!("{all} in all, {tracing} of it tracing ({rate:.3} M trees/s){}", price(done).unwrap_or_default())
}

/// What an error of 1 % would take, if this is far from it and was not asked for.
fn price(done: &Done) -> Option<String> {
    let worst = done.measured.bsdf.incidences.iter().map(|s| s.derived.precision.whole).fold(0.0, f64::max);
    let times = (worst / 0.01).powi(2);
    let told = done.run.goal.is_none() && times > 2.0 && times.is_finite();
    told.then(|| format!("; errors of 1 % take about {} (--target-error 1%)", duration(times * done.tracing_seconds)))
}
