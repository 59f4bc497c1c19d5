//! `report`: a result as a page.

use std::path::{Path, PathBuf};

use clap::Args;
use gonio_embree::output::report;

use super::{Failure, stored, tell, write};

/// Options of `report`.
#[derive(Debug, Args)]
#[command(
    after_help = "The page is one file that needs no network: lobe, map, scans, spectra, colours, and how they came about.\n  \
    gonio-embree report feather.nc -o feather.html"
)]
pub struct Options {
    /// The result
    #[arg(value_name = "FILE.nc")]
    result: PathBuf,
    /// The page [default: name of the result, .html]
    #[arg(short, long, value_name = "FILE.html")]
    output: Option<PathBuf>,
    /// Say nothing
    #[arg(long)]
    quiet: bool,
}

/// Writes the page.
pub fn run(options: &Options) -> Result<(), Failure> {
    let output = options.output.clone().unwrap_or_else(|| options.result.with_extension("html"));
    if same(&output, &options.result) {
        return Err(Failure::Input(format!("-o {}: this is the result itself; name another file", output.display())));
    }
    let page = report::html(&stored(&options.result)?);
    write(&output, page.as_bytes())?;
    if !options.quiet {
        tell(&format!("wrote {} ({} kB)", output.display(), page.len().div_ceil(1000)));
    }
    Ok(())
}

/// Whether both are one file.
fn same(a: &Path, b: &Path) -> bool {
    matches!((a.canonicalize(), b.canonicalize()), (Ok(a), Ok(b)) if a == b)
}
