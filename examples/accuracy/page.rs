//! The page.

use std::fmt::Write as _;
use std::fs;
use std::path::Path;

use super::ladders::SAMPLES;
use super::{Failed, TARGET};

const HEAD: &str = "\
# What accuracy costs

This page and the files beside it are made by `cargo run --release --example accuracy` (an hour on two cores).
How numbers hold in extreme cases is told in [hard-cases.md](hard-cases.md).

## What an error is

A measurement is made of 32 independent scrambles of the same low-discrepancy points; the spread of what they give is the
standard error of every number, and an interval of ± 2.04 of it holds the true value 95 times in 100. Rounds of a measurement
with a target are independent; their variances add up. Ratios and colours have theirs by the jackknife: one scramble after the
other is left out. A facet that fewer than 20 trees have hit is *unresolved* (`facet_resolved` in the result): its standard error
means nothing, and the only interval is from 0 to what chance may have missed.

The *error of the whole* (`errors (95 %)` in the table, `error_…` in the result) is relative, and such that 95 of 100
measurements do not exceed it:

- of the BRDF and of the BTDF: the root of the integral over the dome of the squared error, over that of the squared BSDF
  (both over the solid angle), all wavelengths together, in facets 8° wide. Finer facets have greater errors of the same light;
  coarser ones smaller ones;
- of all reflected and of all transmitted light, all wavelengths together;
- of the worst facet of 8° by itself that has at least a hundredth of the brightest.

All light on one side that is less than 1 % of what comes in counts as 1 %; what is spread over the dome on that side (without
the mirror direction and the straight one) does not count if it is less.

`--target-error 1%` traces until the first four are below 1 %, `--target-error facet:5%` until the worst facet is below 5 %.
The work doubles from round to round, goes to the incidences that need it most, near the target is only as much as it takes, and
ends when the target is seen twice. What is decided between rounds follows from the statistics alone, so that the same command
gives the same bytes; a run that `--max-time` has ended tells in its own command how many `--max-rounds` it was.
";

/// The page, from what is in `out`.
pub fn page(out: &Path) -> Result<String, Failed> {
    let mut page = String::from(HEAD);
    if let Some(rows) = rows(out, "coverage.csv") {
        page += "\n## How often intervals hold the truth\n\n";
        page += "Shares of the 95 % intervals of 1000 seeds that hold the true value: that of a measurement hundreds of times \
                 as long. Ledger: R, T and their delta parts, if at least 100 trees' worth, and ratio: the specular part of R; \
                 colour: L*, a* and b*; scan: a detector 10° wide in ten places; facets of 16°; of both what at least 100 trees \
                 have hit. What does not vary has no interval.\n\n";
        page += "| sample | what | intervals | held |\n|---|---|--:|--:|\n";
        for r in rows.into_iter().filter(|r| r[2] != "0") {
            let share = 100.0 * r[3].parse::<f64>()? / r[2].parse::<f64>()?;
            let _ = writeln!(page, "| {} | {} | {} | {share:.1} % |", r[0], r[1], r[2]);
        }
    }
    if let Some(rows) = rows(out, "targets.csv") {
        let _ = write!(
            page,
            "\n## Whether a target is reached\n\nMeasurements with `--target-error {}%` (facets of 16°), 100 seeds each, compared \
             with a measurement many times as long. *Met*: how many are as good as they say. *Oracle*: the trees with which \
             95 of 100 are, for somebody who knows the truth. *Forecast*: what was told after 131,072 trees or a quarter of the work, over what it took: \
             the mean, and how far from 1 the trees are that 90 of 100 do not exceed.\n\n",
            100.0 * TARGET
        );
        page += "| sample | met | trees | oracle | ratio | forecast of trees | 90 of 100 within | forecast of time |\n";
        page += "|---|--:|--:|--:|--:|--:|--:|--:|\n";
        for r in rows {
            let ratio = r[3].parse::<f64>()? / r[4].parse::<f64>()?;
            let within = 100.0 * r[6].parse::<f64>()?;
            let _ = writeln!(
                page,
                "| {} | {} of {} | {} | {} | {ratio:.2} | {} | ±{within:.0} % | {} |",
                r[0], r[2], r[1], r[3], r[4], r[5], r[7]
            );
        }
    }
    page += "\n## What each setting costs and buys\n\n";
    page += "Each setting is measured with ten seeds and compared with 30 times the trees of another seed (the Morpho film with \
             its formula). Errors here are root mean squares, half of what 95 of 100 do not exceed.\n";
    for sample in &SAMPLES {
        let Ok(text) = fs::read_to_string(out.join(format!("{}.txt", sample.stem))) else { continue };
        let _ = write!(
            page,
            "\n### {}\n\n`{}`\n\n![{}](accuracy/{}.svg)\n\n```text\n{text}```\n",
            sample.title,
            sample.command(),
            sample.title,
            sample.stem
        );
    }
    Ok(page)
}

/// Rows of a CSV file, if it is there.
fn rows(out: &Path, file: &str) -> Option<Vec<Vec<String>>> {
    let text = fs::read_to_string(out.join(file)).ok()?;
    Some(text.lines().skip(1).map(|line| line.split(',').map(String::from).collect()).collect())
}
