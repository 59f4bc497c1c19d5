//! `gonio-embree generate rough`: a random rough surface as a file of heights.

use std::path::PathBuf;

use clap::Args;
use glam::DVec2;
use gonio_embree::output::atomic;
use gonio_embree::sample::generate::rough::Rough;
use gonio_embree::units::{self, LengthUnit};

use super::{Failure, tell};

/// Options of `generate rough`.
#[derive(Debug, Args)]
pub struct Options {
    /// The file of heights to write (Gwyddion Simple Field); a sample takes it as shape = "height_field"
    #[arg(short, long, value_name = "FILE.gsf")]
    output: PathBuf,
    /// Standard deviation of the heights, µm or with its unit
    #[arg(long, default_value = "100nm", value_name = "Z", value_parser = length)]
    rms: f64,
    /// Distance at which the correlation of heights has fallen to 1/e
    #[arg(long, default_value = "2um", value_name = "L", value_parser = length)]
    length: f64,
    /// Edge lengths of the patch, which repeats
    #[arg(long, default_value = "40um,40um", value_name = "X,Y", value_parser = pair::<f64>(length))]
    size: [f64; 2],
    /// Heights along x and y
    #[arg(long, default_value = "256,256", value_name = "NX,NY", value_parser = pair::<usize>(count))]
    points: [usize; 2],
    /// The same seed gives the same surface
    #[arg(long, default_value_t = 1)]
    seed: u64,
}

fn length(text: &str) -> Result<f64, String> {
    match units::length(text, LengthUnit::Micrometre) {
        Ok(um) if um > 0.0 && um.is_finite() => Ok(um),
        Ok(_) => Err("expected a length greater than 0".into()),
        Err(e) => Err(e.to_string()),
    }
}

fn count(text: &str) -> Result<usize, String> {
    text.trim().parse().ok().filter(|&n| n >= 2).ok_or_else(|| "expected a whole number from 2 on".into())
}

/// Reads one value for both axes, or two.
fn pair<T: Copy>(one: fn(&str) -> Result<T, String>) -> impl Fn(&str) -> Result<[T; 2], String> + Clone {
    move |text| {
        let all = text.split(',').map(one).collect::<Result<Vec<T>, String>>()?;
        match all[..] {
            [a] => Ok([a; 2]),
            [a, b] => Ok([a, b]),
            _ => Err("expected one value, or two with a comma between".into()),
        }
    }
}

/// Makes it.
pub fn run(options: &Options) -> Result<(), Failure> {
    let Options { output, rms, length, size, points, seed } = options;
    let rough = Rough { rms: *rms, length: *length, size: DVec2::from_array(*size), points: *points, seed: *seed };
    let field = rough.field().map_err(Failure::Input)?;
    atomic::write(output, &field.to_gsf())
        .map_err(|e| Failure::Cannot(format!("{}: cannot be written: {e}", output.display())))?;
    tell(&format!("wrote {}", output.display()));
    Ok(())
}
