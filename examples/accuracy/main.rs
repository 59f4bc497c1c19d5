//! What accuracy costs, and what errors are worth: measures the figures of `docs/accuracy.md`, and writes it.
//!
//! ```text
//! cargo run --release --example accuracy -- [coverage] [targets] [ladders]
//! ```
//!
//! Each part (all of them, if none is named) leaves its numbers as CSV files in `docs/accuracy`; the page is made from what
//! is there. All together take two hours on two cores; what is there is not measured again.
#![allow(missing_docs, clippy::print_stdout, clippy::print_stderr)]

#[path = "../../tests/common/mod.rs"]
mod common;
mod ladders;
mod page;

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use common::errors::{coverage, specimens, targets};

/// Seeds of the coverage, and of the targets.
const SEEDS: [u64; 2] = [1000, 100];
/// The error that is asked for.
const TARGET: f64 = 0.01;

type Failed = Box<dyn std::error::Error>;

fn main() -> Result<(), Failed> {
    let parts: Vec<String> = std::env::args().skip(1).collect();
    let wanted = |part: &str| parts.is_empty() || parts.iter().any(|p| p == part);
    if let Some(unknown) = parts.iter().find(|p| !["coverage", "targets", "ladders", "page"].contains(&&p[..])) {
        return Err(format!("{unknown}: expected coverage, targets, ladders or page").into());
    }
    let out = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/accuracy");
    fs::create_dir_all(&out)?;
    if wanted("coverage") {
        fs::write(out.join("coverage.csv"), coverages(&kept(&out.join("coverage.csv"))))?;
    }
    if wanted("targets") {
        fs::write(out.join("targets.csv"), all_targets(&kept(&out.join("targets.csv"))))?;
    }
    if wanted("ladders") {
        ladders::draw(&out)?;
    }
    fs::write(out.with_extension("md"), page::page(&out)?)?;
    Ok(())
}

fn coverages(kept: &[String]) -> String {
    let mut csv = String::from("sample,what,intervals,held\n");
    for specimen in specimens() {
        let of_it = kept.iter().filter(|line| line.starts_with(specimen.name)).collect::<Vec<_>>();
        if !of_it.is_empty() {
            of_it.iter().for_each(|line| csv += &format!("{line}\n"));
            continue;
        }
        eprintln!("coverage of the {}", specimen.name);
        for (kind, held) in coverage(&specimen, &specimen.reference(1.0), SEEDS[0]) {
            let _ = writeln!(csv, "{},{kind},{},{}", specimen.name, held.all, held.held);
        }
    }
    csv
}

/// Lines of a run that was broken off; without the file, none.
fn kept(path: &Path) -> Vec<String> {
    fs::read_to_string(path).map_or(Vec::new(), |text| text.lines().map(String::from).collect())
}

fn all_targets(kept: &[String]) -> String {
    let mut csv = String::from("sample,seeds,met,trees,oracle,forecast_trees,forecast_worst,forecast_seconds\n");
    for specimen in specimens() {
        if let Some(line) = kept.iter().find(|line| line.starts_with(specimen.name)) {
            let _ = writeln!(csv, "{line}");
            continue;
        }
        eprintln!("targets of the {}", specimen.name);
        let r = targets(&specimen, &specimen.reference(1.0), TARGET, SEEDS[1]);
        let _ = writeln!(
            csv,
            "{},{},{},{:.0},{:.0},{:.3},{:.3},{:.3}",
            specimen.name, r.seeds, r.met, r.trees, r.oracle, r.forecast_trees, r.forecast_worst, r.forecast_seconds
        );
        println!("{csv}");
    }
    csv
}
