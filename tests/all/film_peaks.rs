//! The bands of colour of the stacks in the paper: where they peak, how high, how wide.

use gonio_embree::optics::C64;
use gonio_embree::optics::film::{Incidence, Layer, solve};
use serde_json::Value;

fn numbers(v: &Value) -> Vec<f64> {
    v.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

/// Reflectance at normal incidence; the first and the last of `n` are around the stack.
fn reflectance(n: &[f64], d_nm: &[f64], wavelength_nm: f64) -> f64 {
    let inner = 1..n.len() - 1;
    let layers: Vec<Layer> = inner.map(|i| Layer { index: C64::from(n[i]), thickness: d_nm[i] }).collect();
    solve(&Incidence::from_cos(n[0], 1.0), &layers, C64::from(n[n.len() - 1]), wavelength_nm).s.reflectance()
}

/// The curves have errors of 1.3e-14.
fn check_peak(name: &str, curve: impl Fn(f64) -> f64, range: (u32, u32), peak_nm: f64, truth: f64) {
    let peak = curve(peak_nm);
    assert!((peak - truth).abs() <= 1e-12, "{name}: {peak} for {truth}");
    let highest = (range.0..=range.1).map(f64::from).max_by(|&a, &b| curve(a).total_cmp(&curve(b))).unwrap();
    assert_eq!(highest, peak_nm, "{name}");
}

#[test]
fn readings_of_the_hummingbird_and_films_of_the_morpho() {
    let text = std::fs::read_to_string("tests/reference/figure_stacks_and_peaks.json").unwrap();
    let file: Value = serde_json::from_str(&text).unwrap();
    let number = |name: &str, key: &str| file["peaks"][name][key].as_f64().unwrap();
    for (name, stack) in file["stacks"].as_object().unwrap() {
        let (n, d) = (numbers(&stack["n"]), numbers(&stack["d_nm"]));
        let curve = |nm: f64| reflectance(&n, &d, nm);
        check_peak(name, curve, (350, 1000), number(name, "peak_350_1000_nm"), number(name, "R"));
        let (half, ends) = (0.5 * number(name, "R"), numbers(&file["peaks"][name]["fwhm_vis"]));
        for (end, inwards) in [(ends[0], 1.0), (ends[1], -1.0)] {
            assert!(curve(end) < half && curve(end + inwards) >= half, "{name}: half its height at {end} nm");
        }
    }
    for films in 1..=12 {
        let name = format!("morpho_{films}");
        let gaps = [[1.53, 50.0], [1.0, 150.0]].repeat(films);
        let stack = [&[[1.0, 0.0]], &gaps[..2 * films - 1], &[[1.0, 0.0]]].concat();
        let (n, d): (Vec<f64>, Vec<f64>) = stack.iter().map(|l| (l[0], l[1])).unzip();
        let curve = |nm: f64| reflectance(&n, &d, nm);
        check_peak(&name, curve, (350, 800), number(&name, "peak_nm"), number(&name, "R"));
    }
}
