//! Cases in which numbers go wrong first: writes the table of `docs/hard-cases.md`.
//! `cargo run --release --example hard_cases`
#![allow(missing_docs, clippy::print_stdout)]

#[path = "../tests/common/mod.rs"]
mod common;

use std::fmt::Write;

use common::hard::{self, Case, Tier};

const BEFORE: &str = "\
# Hard cases

The cases in which a program of this kind goes wrong first. This page is made by

```sh
cargo run --release --example hard_cases
```

and `tests/all/hard_cases.rs` holds this program to what is *allowed*. The **truth** comes from closed forms or from
`tests/reference/films.json` (40 digits); 0 also stands for a difference that there should not be. The last three
columns are **errors**, absolute unless *allowed* says relative: of this program; of the same thing in **float32**, with
rays that go on from a face 256 units in the last place further, as single-precision ray tracers do; and of a
**textbook**'s formula in double precision, named behind the error. *Missed* means that a ray does not find what is there.
";

const AFTER: &str = "
What one learns: float32 cannot hold this geometry. In a scene of 2 mm its rays step over films of 50 nm, a bare rounding
of a path of 3 mm is 4e-3 rad, and it knows nothing of angles and indices that nearly agree. Double precision alone does
not help, either: cosines from sines, angles from cosines, T as 1 − R, growing exponentials, the quadratic formula and small
steps along the ray fail in it, each in its own corner. What holds is to write differences of squares as products, to
start from direction cosines, to follow the solution that grows, and to tell faces apart by identity and order instead of
distance.

Two rows show what is left. Of a film of 1e-3 nm so little comes back that it is decided by lot who follows it, and the
rest carries its power, too. And rays that begin on an edge of a mesh, to the last bit, meet faces in an order that
contradicts itself: some end, and are told as lost (`lost_medium`). By chance, we estimate, one ray in 10¹¹ does.
";

/// An error in one or two digits.
fn error(x: f64) -> String {
    match x.abs() {
        0.0 => "0".into(),
        x if x.is_nan() => "NaN".into(),
        x if x.is_infinite() => "missed".into(),
        x if (100.0..1e6).contains(&x) || x == 1.0 => format!("{x:.0}"),
        x if (0.01..100.0).contains(&x) => format!("{x:.2}"),
        x => format!("{x:.0e}"),
    }
}

fn truth(x: f64) -> String {
    match x.abs() {
        a if a == 0.0 || (1.0..1e5).contains(&a) && x.fract() == 0.0 => format!("{x}"),
        1e-3..1e5 => format!("{x:.5}"),
        _ => format!("{x:.4e}"),
    }
}

fn line(case: &Case) -> String {
    let Case { name, quantity, bound, .. } = case;
    let allowed = format!("{}{}", error(*bound), if case.relative { " relative" } else { "" });
    let single = case.single.map_or_else(|| "–".into(), |x| error(case.error(x)));
    let naive = case.naive.map_or_else(|| "–".into(), |(formula, x)| format!("{} ({formula})", error(case.error(x))));
    let ours = error(case.error(case.ours));
    format!("| {name} | {quantity} | {} | {allowed} | {ours} | {single} | {naive} |", truth(case.truth))
}

fn main() -> std::io::Result<()> {
    let mut page = BEFORE.to_owned();
    for (group, cases) in hard::all(Tier::Quick) {
        let head =
            "| case | quantity | truth | allowed | this program | float32 | textbook |\n|---|---|--:|--:|--:|--:|--:|";
        let lines: Vec<String> = cases.iter().map(line).collect();
        write!(page, "\n## {group}\n\n{head}\n{}\n", lines.join("\n")).expect("a String takes all");
    }
    page += AFTER;
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/hard-cases.md");
    std::fs::write(path, page)?;
    println!("written to {path}");
    Ok(())
}
