//! `gonio-embree generate`: samples made by rule.

use std::path::{Path, PathBuf};
use std::str::FromStr;

use clap::{Args, Subcommand};
use glam::DVec3;
use gonio_embree::output::atomic;
use gonio_embree::sample::generate::bricks::Bricks;
use gonio_embree::units::{self, LengthUnit};

use super::{Failure, tell};

/// What to make.
#[derive(Debug, Subcommand)]
pub enum Kind {
    /// Interlocking bricks with cores, as a mesh: the platelets of a hummingbird's feather
    Bricks(BricksOptions),
    /// A random rough surface, as a file of heights
    Rough(super::rough::Options),
}

/// Options of `generate bricks`.
#[derive(Debug, Args)]
pub struct BricksOptions {
    /// The OBJ file to write; the materials go to an .mtl file beside it
    #[arg(short, long, value_name = "FILE.obj")]
    output: PathBuf,
    /// Number of layers
    #[arg(long, default_value_t = 7, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    layers: u32,
    /// Bricks along x and y in a patch
    #[arg(long, default_value = "4,3", value_name = "NX,NY")]
    count: Pair,
    /// Edge lengths of a brick, µm or with their unit
    #[arg(long, default_value = "1500nm,2000nm,172nm", value_name = "X,Y,Z")]
    size: Triple,
    /// Thickness of the shell around the core
    #[arg(long, default_value = "37nm,37nm,37nm", value_name = "X,Y,Z")]
    shell: Triple,
    /// Refractive index of the shell
    #[arg(long, default_value_t = 2.0, value_name = "N")]
    index: f64,
    /// Refractive index of the core
    #[arg(long, default_value_t = 1.5, value_name = "N")]
    core_index: f64,
}

/// Two counts.
#[derive(Clone, Copy, Debug)]
struct Pair([usize; 2]);

impl FromStr for Pair {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let all: Option<Vec<usize>> = text.split(',').map(|n| n.trim().parse().ok().filter(|&n| n > 0)).collect();
        all.and_then(|v| v.try_into().ok()).map(Self).ok_or_else(|| "expected two counts such as 4,3".into())
    }
}

/// Three lengths, µm.
#[derive(Clone, Copy, Debug)]
struct Triple(DVec3);

impl FromStr for Triple {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let all: Result<Vec<f64>, _> = text.split(',').map(|x| units::length(x, LengthUnit::Micrometre)).collect();
        let all: Option<[f64; 3]> = all.map_err(|e| e.to_string())?.try_into().ok();
        all.map(|v| Self(v.into())).ok_or_else(|| "expected three lengths such as 1500nm,2000nm,172nm".into())
    }
}

/// Makes it.
pub fn run(kind: &Kind) -> Result<(), Failure> {
    match kind {
        Kind::Bricks(options) => bricks(options),
        Kind::Rough(options) => super::rough::run(options),
    }
}

fn bricks(options: &BricksOptions) -> Result<(), Failure> {
    let bricks = Bricks {
        layers: options.layers as usize,
        count: options.count.0,
        size: options.size.0,
        shell: options.shell.0,
        ..Bricks::default()
    };
    bricks.check().map_err(Failure::Input)?;
    let library = options.output.with_extension("mtl");
    if library == options.output {
        return Err(Failure::Input("--output: the .mtl file is for the materials; name the mesh FILE.obj".into()));
    }
    let name = library.file_name().unwrap_or_default().to_string_lossy();
    write(&library, &bricks.to_mtl(options.index, options.core_index))?;
    write(&options.output, &bricks.to_obj(&name))?;
    tell(&format!("wrote {} and {}", options.output.display(), library.display()));
    Ok(())
}

fn write(path: &Path, text: &str) -> Result<(), Failure> {
    atomic::write(path, text.as_bytes())
        .map_err(|e| Failure::Cannot(format!("{}: cannot be written: {e}", path.display())))
}
