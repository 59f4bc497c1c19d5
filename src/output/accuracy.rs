//! What accuracy costs, as a table, as CSV, and as advice.

use std::fmt::Write as _;

use crate::experiment::accuracy::{BASE, Ladder, Point, Reference, TREES};
use crate::units::significant;

/// Errors for which it is told what they take.
const TARGETS: [f64; 3] = [0.01, 0.003, 0.001];
/// A setting that takes so many times as long for the same error is a waste.
const WASTE: f64 = 1.25;

/// The table, and what follows from it.
pub fn text(ladder: &Ladder) -> String {
    let mut out = String::new();
    let _ = writeln!(out, "{}\n", compared(ladder));
    let _ = writeln!(
        out,
        "{:<13} {:<30} {:>17} {:>8} {:>8} {:>8} {:>8} {:>7} {:>10}",
        "knob", "setting", "error / %", "floor/%", "R, T/%", "time/s", "CPU/s", "MiB", "efficiency"
    );
    for p in &ladder.points {
        let _ = writeln!(
            out,
            "{:<13} {:<30} {:>17} {:>8} {:>8} {:>8} {:>8} {:>7} {:>10}",
            p.knob,
            p.setting,
            format!("{} ±{}", percent(p.error.whole), percent(p.spread)),
            if p.floor > ROUNDING { percent(p.floor) } else { "-".into() },
            percent(p.error.reflected.max(p.error.transmitted)),
            significant(p.cost.seconds, 3),
            significant(p.cost.cpu_seconds, 3),
            p.cost.memory.map_or("-".into(), |bytes| (bytes >> 20).to_string()),
            efficiency(ladder, p).map_or("-".into(), |e| significant(e, 2)),
        );
    }
    let _ = writeln!(
        out,
        "\nerror: root of the mean square over all seeds, of the BRDF or the BTDF over the dome (facets of 8 degrees) or of all \
         reflected or transmitted light, whichever is greatest; ± its standard deviation from seed to seed\n\
         floor: what of it stays however many trees are traced\n\
         efficiency: 1/(noise² · time), of the measurement as given 1; below 1 the setting loses\n"
    );
    advice(ladder).iter().for_each(|line| {
        let _ = writeln!(out, "{line}");
    });
    out
}

/// A line per setting, SI units, shares as fractions.
pub fn csv(ladder: &Ladder) -> String {
    let mut out = format!("# {}\n", compared(ladder));
    out += "knob,setting,trees,error,spread,floor,brdf,btdf,reflected,transmitted,lost,seconds,cpu_seconds,memory_bytes,pareto\n";
    for p in &ladder.points {
        let e = &p.error;
        let _ = writeln!(
            out,
            "{},\"{}\",{},{:e},{:e},{:e},{:e},{:e},{:e},{:e},{:e},{:e},{:e},{},{}",
            p.knob,
            p.setting,
            p.trees,
            e.whole,
            p.spread,
            p.floor,
            e.above,
            e.below,
            e.reflected,
            e.transmitted,
            p.lost,
            p.cost.seconds,
            p.cost.cpu_seconds,
            p.cost.memory.map_or(String::new(), |bytes| bytes.to_string()),
            u8::from(ladder.is_on_front(p))
        );
    }
    out
}

fn compared(ladder: &Ladder) -> String {
    let threads = ladder.threads;
    let how = format!("{} seeds per setting, {threads} thread{}", ladder.seeds, if threads == 1 { "" } else { "s" });
    match ladder.reference {
        Reference::Formula => format!("{how}; compared with the formula of the films"),
        Reference::Longer(trees, error) => format!(
            "{how}; compared with {trees} trees of another seed, whose own error (up to {} %) is taken away",
            percent(error)
        ),
    }
}

/// Errors below this are of rounding: none.
const ROUNDING: f64 = 1e-9;

/// A share in percent without the sign.
fn percent(share: f64) -> String {
    if share.abs() < ROUNDING { "0".into() } else { significant(100.0 * share, 2) }
}

/// Whether chance has a part in the errors of a setting.
fn is_noisy(point: &Point) -> bool {
    point.noise_square() > ROUNDING * ROUNDING
}

/// Work for the same error, as given over by this setting; none where noise cannot be told.
fn efficiency(ladder: &Ladder, point: &Point) -> Option<f64> {
    let price = |p: &Point| p.noise_square() * (p.cost.seconds - ladder.fixed_seconds()).max(1e-9);
    let base = ladder.points.first().filter(|base| is_noisy(base) && is_noisy(point))?;
    Some(price(base) / price(point)).filter(|e| e.is_finite() && *e > 0.0 && point.knob != TREES)
}

/// What to do, and what not.
fn advice(ladder: &Ladder) -> Vec<String> {
    let Some(base) = ladder.points.first().filter(|base| is_noisy(base)) else {
        return vec!["nothing is left to chance here: more trees change nothing".into()];
    };
    let chosen = |p: &&Point| p.setting.starts_with("--") && p.knob != TREES;
    let time = |p: &Point, error| ladder.seconds_for(p, error);
    let mut lines = Vec::new();
    for error in TARGETS {
        let best = ladder.points.iter().filter(chosen).min_by(|a, b| time(a, error).total_cmp(&time(b, error)));
        let Some(best) = best.filter(|b| time(b, error).is_finite()) else { continue };
        // Another setting than the one given must be worth its while.
        let best = if time(base, error) < WASTE * time(best, error) { base } else { best };
        let trees = best.trees as f64 * best.noise_square() / (error * error - best.floor * best.floor);
        let trees = if trees < 1e4 { 1e2 * (trees / 1e2).ceil() } else { 1e3 * (trees / 1e3).ceil() };
        let with = if best.knob == BASE { String::new() } else { format!("{} and ", best.setting) };
        lines.push(format!(
            "for {} %: {with}--trees {trees}, about {} s",
            percent(error),
            significant(time(best, error), 2)
        ));
    }
    let error = TARGETS[0];
    for p in ladder.points.iter().skip(1).filter(|p| p.knob != TREES) {
        let name = format!("{} ({})", p.setting, p.knob);
        if p.floor > error {
            lines.push(format!("not {name}: off by {} % however many trees are traced", percent(p.floor)));
        } else if time(p, error) > WASTE * time(base, error) {
            let times = time(p, error) / time(base, error);
            lines.push(format!("wasted is {name}: {} times the time for the same error", significant(times, 2)));
        }
    }
    lines
}
