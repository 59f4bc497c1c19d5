//! `plot`: pictures of a result.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use gonio_embree::bsdf::Arm;
use gonio_embree::output::Measured;
use gonio_embree::plot;

use super::{Failure, draw, stored, tell};

/// What is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum What {
    /// Spectra of all incidences, and the domes of some
    Overview,
    /// Scans in the plane of each incidence, at the middle wavelength
    Scan,
    /// Colours of reflected daylight against the exit angle
    Colours,
}

/// Options of `plot`.
#[derive(Debug, Args)]
#[command(after_help = "  gonio-embree plot feather.nc -o feather.png\n  \
    gonio-embree plot feather.nc --what colours -o colours.svg")]
pub struct Options {
    /// The result
    #[arg(value_name = "FILE.nc")]
    result: PathBuf,
    /// The picture, SVG or PNG by its name
    #[arg(short, long, value_name = "FILE.svg|FILE.png")]
    output: PathBuf,
    /// What is drawn
    #[arg(long, value_enum, default_value_t = What::Overview)]
    what: What,
    /// Say nothing
    #[arg(long)]
    quiet: bool,
}

/// Full width of the detector's aperture, degrees.
const APERTURE_DEG: f64 = 2.0;

/// Draws.
pub fn run(options: &Options) -> Result<(), Failure> {
    let known =
        options.output.extension().is_some_and(|e| e.eq_ignore_ascii_case("svg") || e.eq_ignore_ascii_case("png"));
    if !known {
        return Err(Failure::Input(format!(
            "--output {}: expected a name that ends in .svg or .png",
            options.output.display()
        )));
    }
    let measured = stored(&options.result)?;
    draw(&options.output, &picture(options.what, &measured))?;
    if !options.quiet {
        tell(&format!("wrote {}", options.output.display()));
    }
    Ok(())
}

fn picture(what: What, measured: &Measured) -> String {
    // Between whole degrees, so that a mirror direction at one is seen by two apertures, whatever the rounding.
    let angles_deg = (-90..90).map(|a| f64::from(a) + 0.5).collect();
    let arm = Arm { angles_deg, aperture_deg: APERTURE_DEG, below: false, turn_deg: 0.0 };
    let scans = || (0..measured.bsdf.incidences.len()).map(|i| measured.bsdf.scan(&arm, i));
    let nm = &measured.bsdf.wavelength_nm;
    let middle: Vec<f64> = nm.iter().skip(nm.len() / 2).take(1).copied().collect();
    match what {
        What::Overview => plot::measurement(measured),
        What::Scan => plot::scans(&scans().map(|s| s.only(&middle)).collect::<Vec<_>>(), false),
        What::Colours => plot::colours(&measured.bsdf, &scans().collect::<Vec<_>>()),
    }
}
