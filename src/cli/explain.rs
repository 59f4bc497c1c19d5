//! `explain`: the plan of a measurement, before it is made.

use clap::Args;
use gonio_embree::experiment::explain;
use gonio_embree::output::plan;

use super::progress::{SETTING_UP, Waiting};
use super::setup::{Scene, Setup};
use super::{Failure, answer};

/// Options of `explain`.
#[derive(Debug, Args)]
pub struct Options {
    #[command(flatten)]
    setup: Setup,
    /// Print one JSON document (schema gonio-plan-1)
    #[arg(long, help_heading = "Output")]
    json: bool,
}

/// Plans, times some trees, and prints what came out.
pub fn run(options: &Options) -> Result<(), Failure> {
    let waiting = Waiting::new(SETTING_UP, false);
    let Scene { light, sample, .. } = options.setup.scene()?;
    let settings = options.setup.settings()?;
    let explanation = explain(&sample, &light, &settings).map_err(|e| Failure::Cannot(e.to_string()))?;
    drop(waiting);
    answer(&if options.json { plan::json(&explanation) + "\n" } else { plan::text(&explanation) })
}
