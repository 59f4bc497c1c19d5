//! `compare`: whether two results differ by more than chance.

use std::path::PathBuf;

use clap::Args;
use gonio_embree::bsdf::compare::compare;
use gonio_embree::output::compare as output;

use super::{Failure, answer, stored};

/// Options of `compare`.
#[derive(Debug, Args)]
#[command(
    after_help = "Facets of both domes are compared where at least 100 trees have hit them, in the coarser facet of each \
    place; the exit code is 1 if the results differ. They must be independent: of different seeds, or of different samples.\n  \
    gonio-embree compare embree.nc obvhs.nc"
)]
pub struct Options {
    /// A result
    #[arg(value_name = "A.nc")]
    a: PathBuf,
    /// Another
    #[arg(value_name = "B.nc")]
    b: PathBuf,
    /// Print one JSON document instead of the table
    #[arg(long)]
    json: bool,
}

/// Compares.
pub fn run(options: &Options) -> Result<(), Failure> {
    let (a, b) = (stored(&options.a)?.bsdf, stored(&options.b)?.bsdf);
    let named = |e| Failure::Input(format!("{} and {}: {e}", options.a.display(), options.b.display()));
    let comparison = compare(&a, &b).map_err(named)?;
    let colours = output::colours(&a, &b);
    answer(&if options.json {
        output::json(&comparison, &colours) + "\n"
    } else {
        output::text(&comparison, &colours)
    })?;
    if comparison.agrees() { Ok(()) } else { Err(Failure::Quality("the results differ by more than chance".into())) }
}
