//! `gonio-embree plan`: a job file with all it depends on, cut into shards.

use std::path::{Path, PathBuf};

use clap::Args;
use gonio_embree::experiment::State;
use gonio_embree::jobs::plan::{Plan, Planned};

use super::forecast::Forecast;
use super::prepared::{named_after, prepare};
use crate::cli::progress::{Line, duration};
use crate::cli::setup::all_threads;
use crate::cli::{Failure, answer, write};

/// Options of a plan.
#[derive(Debug, Args)]
pub struct Options {
    /// What is to be measured, as for `batch`
    #[arg(value_name = "JOBS.toml")]
    jobs: PathBuf,
    /// Shards of about equal work; good are those that take 5 to 30 minutes
    #[arg(long, value_name = "N")]
    shards: usize,
    /// The plan [default: JOBS.plan.json]
    #[arg(short, long, value_name = "PLAN.json")]
    output: Option<PathBuf>,
    /// Show no progress
    #[arg(long)]
    quiet: bool,
}

/// Makes a plan.
pub fn run(options: &Options) -> Result<(), Failure> {
    let output = options.output.clone().unwrap_or_else(|| named_after(&options.jobs, ".plan.json"));
    let absolute = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.into());
    let (output, jobs) = (absolute(&output), absolute(&options.jobs));
    let wanted = prepare(&options.jobs)?;
    let mut line = Line::new(options.quiet);
    let (mut planned, mut work, mut seconds) = (Vec::new(), Vec::new(), 0.0);
    for (number, job) in wanted.iter().enumerate() {
        line.put(|| format!("looking at measurement {} of {}: {}", number + 1, wanted.len(), job.name));
        let measurement = job.work(all_threads()).map_err(|e| name(&job.name, e))?;
        let forecast = Forecast::new(&measurement).map_err(|e| name(&job.name, e))?;
        seconds += forecast.tracing;
        let settings = &measurement.settings;
        let incidences = measurement.scene.light.incidences.len();
        let batches = settings.goal.is_none().then(|| State::batches(settings.trees, incidences));
        let each = batches.map_or(1, |n| n as usize / incidences);
        let of_batches = |segments: &f64| vec![segments / each as f64; each];
        work.push(forecast.segments.iter().flat_map(of_batches).collect::<Vec<f64>>());
        planned.push(Planned {
            name: job.name.clone(),
            arguments: job.arguments.clone(),
            varied: job.varied.clone(),
            sample_sha256: measurement.origin.sha256.clone(),
            batches,
            work: forecast.segments.iter().sum(),
        });
    }
    line.clear();
    // Beside its job file a plan may be moved with it.
    let directory = jobs.parent().unwrap_or(Path::new("."));
    let directory = if output.parent() == Some(directory) { Path::new(".") } else { directory };
    let plan = Plan::new(directory.display().to_string(), planned, &work, options.shards)
        .map_err(|e| Failure::Input(format!("--shards {e}")))?;
    write(&output, plan.to_json().as_bytes())?;
    let each = duration(seconds / plan.shards.len() as f64);
    answer(&format!(
        "{}: {} measurements in {} shards of about {each} of tracing on this machine\n",
        output.display(),
        plan.measurements.len(),
        plan.shards.len()
    ))
}

fn name(name: &str, failure: Failure) -> Failure {
    match failure {
        Failure::Cannot(why) => Failure::Cannot(format!("{name}: {why}")),
        other => Failure::Input(format!("{name}: {other}")),
    }
}
