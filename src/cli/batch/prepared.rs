//! Measurements of a job file or a plan, understood as if they had been typed.

use std::env;
use std::path::{Path, PathBuf};

use clap::Parser;
use gonio_embree::jobs::Job;
use gonio_embree::output::{Measured, netcdf};

use crate::cli::Failure;
use crate::cli::work::{Order, Work};

/// What stands behind `gonio-embree`.
#[derive(Debug, Parser)]
#[command(name = "gonio-embree", no_binary_name = true)]
struct Typed {
    #[command(flatten)]
    work: Order,
}

/// A measurement that is asked for.
#[derive(Clone, Debug)]
pub struct Wanted {
    pub name: String,
    pub arguments: Vec<String>,
    pub varied: Vec<(String, String)>,
    pub options: Order,
}

/// The measurements of a job file. From now on the program is in its directory, to which all paths belong.
pub fn prepare(path: &Path) -> Result<Vec<Wanted>, Failure> {
    let jobs = gonio_embree::jobs::read(path).map_err(|e| Failure::Input(e.to_string()))?;
    let understood: Vec<Result<Wanted, String>> = jobs.into_iter().map(understand).collect();
    let wrong: Vec<&str> = understood.iter().filter_map(|u| u.as_ref().err().map(String::as_str)).collect();
    if !wrong.is_empty() {
        return Err(Failure::Input(shortened(&wrong)));
    }
    enter(path.parent().unwrap_or(Path::new("")))?;
    Ok(understood.into_iter().flatten().collect())
}

/// Makes a directory the one the program is in.
pub fn enter(directory: &Path) -> Result<(), Failure> {
    if directory.as_os_str().is_empty() {
        return Ok(());
    }
    env::set_current_dir(directory).map_err(|e| Failure::Cannot(format!("{}: {e}", directory.display())))
}

fn understand(job: Job) -> Result<Wanted, String> {
    let options =
        options(&job.arguments).map_err(|e| format!("{}: {e}", job.place.problem(format!("`{}`", job.name))))?;
    Ok(Wanted { name: job.name, arguments: job.arguments, varied: job.varied, options })
}

/// Options as they would be typed.
pub fn options(arguments: &[String]) -> Result<Order, String> {
    Typed::try_parse_from(arguments).map(|typed| typed.work).map_err(|e| {
        let text = e.to_string();
        let told = text.split("\n\nUsage:").next().unwrap_or_default();
        let told = told.split("\n\nFor more information").next().unwrap_or_default();
        let words: Vec<&str> = told.trim_start_matches("error: ").split_whitespace().collect();
        words.join(" ")
    })
}

/// Most problems of one kind that are told.
const MOST_TOLD: usize = 20;

fn shortened(all: &[&str]) -> String {
    let mut text = all[..all.len().min(MOST_TOLD)].join("\n");
    if all.len() > MOST_TOLD {
        text += &format!("\n... and {} more", all.len() - MOST_TOLD);
    }
    text
}

impl Wanted {
    /// The measurement, on so many threads if it does not say itself; directories of its result are made.
    pub fn work(&self, threads: usize) -> Result<Work, Failure> {
        let mut options = self.options.clone();
        options.setup.use_threads(threads);
        let output = options.output();
        if let Some(parent) = output.parent().filter(|p| !p.as_os_str().is_empty()) {
            std::fs::create_dir_all(parent).map_err(|e| Failure::Cannot(format!("{}: {e}", parent.display())))?;
        }
        Work::new(&options)
    }

    /// Its result.
    pub fn output(&self) -> PathBuf {
        self.options.output()
    }
}

/// The result of a measurement, if it has been written, and is of this very measurement.
pub fn earlier(work: &Work) -> Option<Measured> {
    let bytes = std::fs::read(&work.output).ok()?;
    let measured = netcdf::from_bytes(&bytes).ok()?;
    let (p, command) = (&measured.provenance, &work.origin.command);
    let backend = work.settings.backend;
    // One that ran out of time, or of rounds, says how far it came.
    let rest = p.command.strip_prefix(command.as_str())?;
    let rounds = rest.strip_prefix(" --max-rounds ").and_then(|n| n.parse::<f64>().ok());
    let asked = work.settings.goal.and_then(|g| g.max_rounds);
    let same = (rest.is_empty() || rounds.is_some_and(|n| asked.is_none_or(|asked| n == asked)))
        && p.version == env!("CARGO_PKG_VERSION")
        && p.sample_sha256 == work.origin.sha256
        && (p.backend.name.as_str(), p.backend.version.as_str()) == (backend.name(), backend.version().as_str())
        && p.incomplete.is_none();
    same.then_some(measured)
}

/// Name of a file beside another: `night.toml` gives `night-table.csv`.
pub fn named_after(path: &Path, suffix: &str) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    path.with_file_name(format!("{stem}{suffix}"))
}
