//! One table of all results that are there.

use std::path::{Path, PathBuf};

use gonio_embree::output::netcdf;
use gonio_embree::output::sweep::Sweep;
use gonio_embree::plot;

use super::prepared::{Wanted, named_after};
use crate::cli::{self, Failure};

/// Where the table of a job file or a plan goes, if nobody says.
pub fn beside(jobs: &Path) -> PathBuf {
    named_after(jobs, "-table.csv")
}

/// Writes the table as CSV, as NetCDF and as a picture, and tells what was written.
pub fn write(table: &Path, jobs: &Path, wanted: &[Wanted]) -> Result<String, Failure> {
    let mut sweep = Sweep::default();
    for job in wanted {
        let read = std::fs::read(job.output()).ok().and_then(|bytes| netcdf::from_bytes(&bytes).ok());
        read.iter().for_each(|measured| sweep.add(&job.name, &job.varied, measured));
    }
    if sweep.rows.is_empty() {
        return Ok("there is no result for a table".into());
    }
    let stem = jobs.file_stem().unwrap_or_default().to_string_lossy();
    let bytes = sweep.netcdf().map_err(|e| Failure::Cannot(e.to_string()))?;
    cli::write(table, sweep.csv().as_bytes())?;
    cli::write(&table.with_extension("nc"), &bytes)?;
    cli::write(&table.with_extension("svg"), plot::sweep(&stem, &sweep).as_bytes())?;
    Ok(format!("table: {} (.nc, .svg)", table.display()))
}
