//! The figures of Schramm, Gondek and Meyer 1997, drawn from measurements of the samples in `assets/samples`, beside what the
//! paper says of them:
//!
//! ```text
//! cargo run --release --example figures -- [3 4 5 6 7 10 11] [--quick] [--out DIR]
//! ```
//!
//! Each figure is an SVG, a PNG and a CSV file; when all are drawn in full, `docs/figures.md` says for each what the paper
//! says, what comes out here, and whether the two agree. `--quick` takes a minute and writes to `target/figures`.
#![allow(clippy::print_stdout, clippy::print_stderr)]

mod christiansen;
mod feather;
mod figure;
mod morpho;
mod page;
mod paper;

use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

use figure::{Effort, Figure, Result};

/// Draws a figure.
type Draw = fn(Effort) -> Result<Figure>;

const FIGURES: [(&str, Draw); 7] = [
    ("3", morpho::colours),
    ("4", christiansen::indices),
    ("5", christiansen::filter),
    ("6", feather::films_and_plates),
    ("7", feather::bricks),
    ("10", paper::webs),
    ("11", paper::coating),
];

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(e) => {
            eprintln!("error: {e}");
            ExitCode::from(2)
        }
    }
}

fn run() -> Result<()> {
    let (mut wanted, mut effort, mut out) = (Vec::new(), Effort::Full, None);
    let mut args = std::env::args().skip(1);
    while let Some(arg) = args.next() {
        match &arg[..] {
            "--quick" => effort = Effort::Quick,
            "--out" => out = Some(PathBuf::from(args.next().ok_or("--out needs a directory")?)),
            number => wanted.push(known(number)?),
        }
    }
    let all = wanted.is_empty() || wanted.len() == FIGURES.len();
    let chosen: Vec<_> = if all { FIGURES.to_vec() } else { wanted };
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let page = all && effort == Effort::Full && out.is_none();
    let default = if effort == Effort::Full { "docs/figures" } else { "target/figures" };
    let out = out.unwrap_or_else(|| root.join(default));
    std::fs::create_dir_all(&out).map_err(|e| format!("{}: {e}", out.display()))?;
    let mut drawn = Vec::new();
    for (number, draw) in chosen {
        let start = Instant::now();
        let figure = draw(effort)?;
        figure.write(number, &out)?;
        println!("figure {number}: {} ({:.0} s)", figure.title, start.elapsed().as_secs_f64());
        figure.finds.iter().for_each(|line| println!("  - {line}"));
        figure
            .claims
            .iter()
            .for_each(|c| println!("  {} {}", if c.holds { "holds:" } else { "DOES NOT HOLD:" }, c.what));
        drawn.push((number, figure));
    }
    println!("written to {}", out.display());
    if page {
        page::write(&root.join("docs/figures.md"), &drawn)?;
        println!("written: docs/figures.md");
    }
    Ok(())
}

fn known(number: &str) -> Result<(&'static str, Draw)> {
    let found = FIGURES.into_iter().find(|(n, _)| *n == number);
    let all = FIGURES.map(|(n, _)| n).join(" ");
    found.ok_or_else(|| format!("there is no figure `{number}`; expected some of {all}, --quick, --out DIR").into())
}
