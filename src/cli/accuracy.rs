//! `accuracy`: what accuracy costs in time.

use std::path::PathBuf;

use clap::Args;
use gonio_embree::experiment::accuracy::{Climbed, Effort, LadderError, climb};
use gonio_embree::output::{accuracy as output, atomic};
use gonio_embree::plot;

use super::progress::Line;
use super::setup::Setup;
use super::{Failure, answer, draw, tell, write};

/// Options of `accuracy`.
#[derive(Debug, Args)]
#[command(
    after_help = "The sample is measured as given, and again with one knob at a time turned to other settings; each is compared \
    with a formula where there is one, else with a measurement of 30 times the trees and another seed. What comes out: the error \
    of each, what of it stays however many trees are traced, what it costs, and what to do for an error of 1 %.\n  \
    gonio-embree accuracy assets/samples/web-oriented.toml --incident 45 --quick"
)]
pub struct Options {
    /// A sample, in place of --sample or --mesh
    #[arg(value_name = "SAMPLE", conflicts_with_all = ["mesh", "sample"])]
    given: Option<PathBuf>,
    #[command(flatten)]
    setup: Setup,
    /// Fewer trees and seeds: two minutes
    #[arg(long, help_heading = "Work", conflicts_with = "seeds")]
    quick: bool,
    /// Measurements of each setting
    #[arg(long, default_value_t = 10, value_name = "N", help_heading = "Work", value_parser = clap::value_parser!(u64).range(2..=1000))]
    seeds: u64,
    /// The picture, SVG or PNG by its name; the table as .csv beside it [default: name of the sample, -accuracy.svg]
    #[arg(short, long, value_name = "FILE.svg|FILE.png", help_heading = "Output")]
    output: Option<PathBuf>,
    /// Show no progress
    #[arg(long, help_heading = "Output")]
    quiet: bool,
}

/// Climbs, and writes what came out.
pub fn run(options: &Options) -> Result<(), Failure> {
    let setup = options.given.as_ref().map_or_else(|| options.setup.clone(), |path| options.setup.of(path));
    let (light, description) = (setup.light()?, setup.description()?);
    let picture = options.output.clone().unwrap_or_else(|| {
        let stem = setup.input().file_stem().unwrap_or_default().to_string_lossy().into_owned();
        PathBuf::from(format!("{stem}-accuracy.svg"))
    });
    let table = picture.with_extension("csv");
    for path in [&picture, &table] {
        atomic::check(path)
            .map_err(|e| Failure::Input(format!("--output {}: cannot be written: {e}", path.display())))?;
    }
    let settings = setup.settings()?;
    if settings.goal.is_some() {
        return Err(Failure::Input(
            "accuracy compares numbers of trees: give --trees in place of --target-error, --max-time and --max-rounds"
                .into(),
        ));
    }
    let effort = if options.quick { Effort::QUICK } else { Effort { seeds: options.seeds, ..Effort::FULL } };
    let mut line = Line::new(options.quiet);
    let ladder = climb(&description, &light, &settings, &effort, |at: Climbed| line.tell(&at));
    line.clear();
    let ladder = ladder.map_err(|e| match e {
        LadderError::Sample(_) => Failure::Input(e.to_string()),
        LadderError::Measure(_) => Failure::Cannot(e.to_string()),
    })?;
    let name = setup.input().file_name().unwrap_or_default().to_string_lossy().into_owned();
    draw(&picture, &plot::accuracy(&ladder, &format!("{name}: error against time")))?;
    write(&table, output::csv(&ladder).as_bytes())?;
    answer(&output::text(&ladder))?;
    if !options.quiet {
        tell(&format!("wrote {} and {}", picture.display(), table.display()));
    }
    Ok(())
}
