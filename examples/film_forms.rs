//! Four forms of the film solver against 40-digit truth: the table of docs/films.md.
//! `cargo run --example film_forms`
#![allow(missing_docs, clippy::print_stdout)]

#[path = "../tests/common/collapse.rs"]
mod collapse;

use std::error::Error;
use std::path::Path;

use collapse::{Stack, interface_by_interface_both, kz_by_differences, kz_from_sine, matrix_product};
use gonio_embree::films::cases::{Case, Direction, read};
use gonio_embree::optics::C64;
use serde_json::Value;

const FILE: &str = "tests/reference/films.json";
const AMPLITUDES: [&str; 4] = ["r", "t", "r_back", "t_back"];

/// A form gives r, t, r_back and t_back.
type Form = fn(&Case) -> [C64; 4];
const FORMS: [(&str, Form); 4] = [
    ("this program", this_program),
    ("Airy, cos = √(1 − sin²)", paper),
    ("Airy, careful k_z", careful),
    ("Abelès, careful k_z", abeles),
];

fn this_program(case: &Case) -> [C64; 4] {
    let a = case.solve();
    [a.r, a.t, a.r_back, a.t_back]
}

fn paper(case: &Case) -> [C64; 4] {
    let n = case.once.first;
    let sin = match case.direction {
        Direction::Angle(deg) => deg.to_radians().sin(),
        Direction::Cos(cos) => (1.0 - cos * cos).sqrt(),
        Direction::Kx(kx) => kx / n,
    };
    with_stack(case, |stack| interface_by_interface_both(stack, kz_from_sine(n, sin)))
}

fn careful(case: &Case) -> [C64; 4] {
    with_stack(case, |stack| interface_by_interface_both(stack, careful_kz(case)))
}

fn abeles(case: &Case) -> [C64; 4] {
    with_stack(case, |stack| matrix_product(stack, careful_kz(case)))
}

/// From n cos θ and n sin θ in the first medium, with all the digits that the input has.
fn careful_kz(case: &Case) -> impl Fn(C64) -> C64 {
    let n = case.once.first;
    let (kz0, kx, is_kx) = match case.direction {
        Direction::Angle(deg) => (n * deg.to_radians().cos(), n * deg.to_radians().sin(), false),
        Direction::Cos(cos) => (n * cos, n * ((1.0 - cos) * (1.0 + cos)).sqrt(), false),
        Direction::Kx(kx) => (((n - kx) * (n + kx)).sqrt(), kx, true),
    };
    kz_by_differences(n, kz0, kx, kz0 < kx && !is_kx)
}

fn with_stack(case: &Case, solve: impl Fn(&Stack<'_>) -> [C64; 4]) -> [C64; 4] {
    let once: Vec<_> = case.once.layers.iter().map(|l| (l.index, l.thickness)).collect();
    let (first, wavelength) = (C64::from(case.once.first), case.once.wavelength_nm);
    solve(&Stack { first, layers: &once.repeat(case.repeat), last: case.once.last, wavelength, p: case.p })
}

/// The largest error of the four amplitudes over what is allowed: four times the effect of rounding the input, and
/// 2e-15. Infinite where an amplitude is no number.
fn worst(truth: &Value, got: [C64; 4]) -> f64 {
    let part = |v: &Value| v.as_str().map_or(f64::NAN, |s| s.parse().unwrap_or(f64::NAN));
    let fraction = |(name, got): (&str, C64)| {
        let exact = C64::new(part(&truth[name][0]), part(&truth[name][1]));
        let noise = truth["noise_1ulp"][name].as_f64().unwrap_or(f64::NAN);
        let fraction = (got - exact).norm() / (4.0 * noise + 2e-15 * exact.norm().max(1.0));
        if fraction.is_nan() { f64::INFINITY } else { fraction }
    };
    AMPLITUDES.into_iter().zip(got).map(fraction).fold(0.0, f64::max)
}

/// How many fail, how many of them with NaN, and the worst of the others.
fn cell(fractions: &[f64]) -> String {
    let failed = fractions.iter().filter(|&&f| f > 1.0).count();
    let nan = fractions.iter().filter(|f| f.is_infinite()).count();
    let nan = if nan > 0 { format!(", {nan} NaN") } else { String::new() };
    match fractions.iter().copied().filter(|f| f.is_finite()).fold(0.0, f64::max) {
        worst if worst >= 1000.0 => format!("{failed}{nan} ({worst:.0e})"),
        worst if worst >= 10.0 => format!("{failed}{nan} ({worst:.0})"),
        worst => format!("{failed}{nan} ({worst:.2})"),
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let file: Value = serde_json::from_str(&std::fs::read_to_string(FILE)?)?;
    let truths = file["cases"].as_array().ok_or("no cases")?;
    let cases = read(Path::new(FILE)).map_err(|problems| problems.to_string())?;
    let results: Vec<(&str, [f64; 4])> = cases
        .iter()
        .zip(truths)
        .map(|(case, truth)| (truth["cls"].as_str().unwrap_or(""), FORMS.map(|(_, form)| worst(truth, form(case)))))
        .collect();
    let mut classes: Vec<&str> = results.iter().map(|r| r.0).collect();
    classes.sort_unstable();
    classes.dedup();
    println!("| class | cases | {} |", FORMS.map(|f| f.0).join(" | "));
    println!("|---|--:|{}", "--:|".repeat(FORMS.len()));
    for class in classes.into_iter().chain(["all"]) {
        let of_class: Vec<_> = results.iter().filter(|r| r.0 == class || class == "all").map(|r| r.1).collect();
        let cells: [String; 4] = std::array::from_fn(|i| cell(&of_class.iter().map(|f| f[i]).collect::<Vec<_>>()));
        println!("| {} | {} | {} |", class.replace('_', " "), of_class.len(), cells.join(" | "));
    }
    Ok(())
}
