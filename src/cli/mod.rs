//! The command line: what the user typed becomes a measurement, and the outcome an exit code.

mod accuracy;
mod batch;
mod compare;
mod explain;
mod export;
mod film;
mod generate;
mod incident;
mod keep;
mod materials;
mod measure;
mod medium;
mod numbers;
mod picture;
mod progress;
mod report;
mod scan;
mod setup;
mod stop;
mod work;

use std::fmt;
use std::io::{self, Write as _};
use std::path::Path;
use std::process::ExitCode;
use std::sync::OnceLock;

use clap::{Parser, Subcommand};
use gonio_embree::intersect::choose::Backend;
use gonio_embree::output::{Measured, atomic, netcdf};
use gonio_embree::plot;

/// A virtual goniospectrophotometer: the spectral BRDF and BTDF of a sample from its microgeometry, with error bars.
#[derive(Debug, Parser)]
#[command(
    version = version(),
    arg_required_else_help = true,
    args_conflicts_with_subcommands = true,
    subcommand_negates_reqs = true,
    after_help = "Exit codes: 0 done; 1 ran, but energy was lost, results differ or an error was not reached; 2 bad input or usage; 3 cannot run; 65 incomplete or mixed data; 75 stopped, run it again to go on."
)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    measure: measure::Options,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Write a sample made by rule
    #[command(subcommand)]
    Generate(generate::Kind),
    /// Reflectance, transmittance and colour of a stack of films
    Film(film::Options),
    /// Which effects a measurement will simulate, why, and what each costs
    Explain(explain::Options),
    /// What accuracy costs in time: each setting against the truth
    Accuracy(accuracy::Options),
    /// Measure everything that a job file asks for, on this machine
    Batch(batch::run::Options),
    /// Cut a job file into shards, to be traced on several machines
    Plan(batch::plan::Options),
    /// Trace one shard of a plan
    Run(batch::shard::Options),
    /// Which shards of a plan are done, running or missing
    Status(batch::status::Options),
    /// Put the shards of a plan together: the same files as if one machine had measured all
    Merge(batch::merge::Options),
    /// Scripts that run a plan under Slurm: the shards as an array, then the merge
    SlurmScript(batch::slurm::Options),
    /// What a detector reads that goes through the plane of incidence, from a result or from the sample itself
    Scan(scan::Options),
    /// Whether two results differ by more than chance
    Compare(compare::Options),
    /// Pictures of a result
    Plot(picture::Options),
    /// A result in the format of another program
    Export(export::Options),
    /// A result as one page of HTML: lobe, map, scans, spectra and colours, and how they came about
    Report(report::Options),
    /// Built-in media, or a file of one: where its numbers come from, and what they are
    Materials(materials::Options),
}

/// The version with that of every backend.
fn version() -> &'static str {
    static TEXT: OnceLock<String> = OnceLock::new();
    TEXT.get_or_init(|| {
        let named = |b: &Backend| format!("{b} {}", b.version());
        let libraries = Backend::available().into_iter().filter(|&b| b != Backend::Brute);
        let libraries: Vec<String> = libraries.map(|b| named(&b)).collect();
        format!("{} (intersection: {})", env!("CARGO_PKG_VERSION"), libraries.join(", "))
    })
}

/// Why the program ends without having done all that was asked.
#[derive(Debug)]
pub enum Failure {
    /// It ran, but a gate of quality did not hold.
    Quality(String),
    /// Something is wrong with what the user gave.
    Input(String),
    /// It cannot run here.
    Cannot(String),
    /// Data are incomplete, or do not belong together.
    Mixed(String),
    /// It was stopped and goes on when it is run again.
    Stopped(String),
}

/// Exit code of what was stopped.
const STOPPED: u8 = 75;

impl Failure {
    fn code(&self) -> u8 {
        match self {
            Self::Quality(_) => 1,
            Self::Input(_) => 2,
            Self::Cannot(_) => 3,
            Self::Mixed(_) => 65,
            Self::Stopped(_) => STOPPED,
        }
    }
}

impl fmt::Display for Failure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Quality(why) | Self::Input(why) | Self::Cannot(why) | Self::Mixed(why) | Self::Stopped(why) => {
                f.write_str(why)
            }
        }
    }
}

/// Runs the command the user typed.
pub fn run() -> ExitCode {
    let cli = Cli::parse();
    let done = match &cli.command {
        Some(Command::Generate(kind)) => generate::run(kind),
        Some(Command::Film(options)) => film::run(options),
        Some(Command::Explain(options)) => explain::run(options),
        Some(Command::Accuracy(options)) => accuracy::run(options),
        Some(Command::Batch(options)) => batch::run::run(options),
        Some(Command::Plan(options)) => batch::plan::run(options),
        Some(Command::Run(options)) => batch::shard::run(options),
        Some(Command::Status(options)) => batch::status::run(options),
        Some(Command::Merge(options)) => batch::merge::run(options),
        Some(Command::SlurmScript(options)) => batch::slurm::run(options),
        Some(Command::Scan(options)) => scan::run(options),
        Some(Command::Compare(options)) => compare::run(options),
        Some(Command::Plot(options)) => picture::run(options),
        Some(Command::Export(options)) => export::run(options),
        Some(Command::Report(options)) => report::run(options),
        Some(Command::Materials(options)) => materials::run(options),
        None => measure::run(&cli.measure),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            let kind = if matches!(failure, Failure::Stopped(_)) { "" } else { "error: " };
            tell(&format!("{kind}{failure}"));
            ExitCode::from(failure.code())
        }
    }
}

/// A message for people.
fn tell(text: &str) {
    // Nobody is left to complain to if this fails.
    let _ = writeln!(io::stderr(), "{text}");
}

/// A result that was stored.
fn stored(path: &Path) -> Result<Measured, Failure> {
    let named = |e: &dyn fmt::Display| Failure::Input(format!("{}: {e}", path.display()));
    let bytes = std::fs::read(path).map_err(|e| named(&format!("cannot be read: {e}")))?;
    netcdf::from_bytes(&bytes).map_err(|e| named(&e))
}

/// Writes a file, whole or not at all.
fn write(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    atomic::write(path, bytes).map_err(|e| Failure::Cannot(format!("{}: cannot be written: {e}", path.display())))
}

/// Writes a picture, as PNG if that is what its file is called after.
fn draw(path: &Path, svg: &str) -> Result<(), Failure> {
    if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("png")) {
        let pixels = plot::png(svg).map_err(|e| Failure::Cannot(format!("{}: {e}", path.display())))?;
        return write(path, &pixels);
    }
    write(path, svg.as_bytes())
}

/// What was asked for. A reader that has gone away is no error.
fn answer(text: &str) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(e) if e.kind() != io::ErrorKind::BrokenPipe => {
            Err(Failure::Cannot(format!("standard output cannot be written: {e}")))
        }
        _ => Ok(()),
    }
}
