//! Films by themselves.

use std::f64::consts::{FRAC_PI_2, PI};
use std::path::Path;

use gonio_embree::films::Films;
use gonio_embree::films::cases::{Case as Question, Direction, read};
use gonio_embree::optics::C64;
use gonio_embree::optics::film::{Amplitudes, Incidence, Layer, solve};
use num_complex::Complex;
use serde_json::Value;

use super::twin::{Answer32, Stack32};
use super::{Case, worst};
use crate::common::collapse::{Stack, kz_from_sine, matrix_product};

const FILE: &str = "tests/reference/films.json";
const MATRIX: &str = "product of matrices";

pub fn all() -> Vec<Case> {
    [from_the_file(), mirrors(), vec![metal(), metal_lets_nothing_through(), phase()], vec![tunnel()]].concat()
}

/// A stack of the file with 40 digits, and the answers to it.
struct Known {
    truth: Value,
    ours: Amplitudes,
    single: Answer32,
    naive: [C64; 4],
}

impl Known {
    fn of(name: &str) -> Self {
        let file: Value = serde_json::from_str(&std::fs::read_to_string(FILE).unwrap()).unwrap();
        let truths = file["cases"].as_array().unwrap();
        let at = truths.iter().position(|t| t["name"] == name).unwrap_or_else(|| panic!("there is no {name}"));
        let question = read(Path::new(FILE)).unwrap().swap_remove(at);
        let (ours, single, naive) = (question.solve(), single(&question), naive(&question));
        Self { truth: truths[at].clone(), ours, single, naive }
    }

    fn truth(&self, value: &Value) -> f64 {
        value.as_str().and_then(|s| s.parse().ok()).unwrap_or_else(|| panic!("{value} in {}", self.truth["name"]))
    }

    fn reflected(&self, name: &str, bound: f64) -> Case {
        Case::new(name, "R", self.truth(&self.truth["R"]), self.ours.reflectance(), bound)
            .single(self.single.reflected)
            .naive(MATRIX, self.naive[0].norm_sqr())
    }

    fn transmitted(&self, name: &str, bound: f64) -> Case {
        Case::new(name, "T", self.truth(&self.truth["T"]), self.ours.transmittance(), bound)
            .relative()
            .single(self.single.transmitted)
            .naive(MATRIX, self.naive[1].norm_sqr() * self.ours.flux_ratio)
    }

    fn lagging(&self, name: &str, bound: f64) -> Case {
        Case::new(name, "Im r", self.truth(&self.truth["r"][1]), self.ours.r.im, bound)
            .single(self.single.r.im.into())
            .naive(MATRIX, self.naive[0].im)
    }
}

/// Cosine and sine of the angle of incidence.
fn legs(question: &Question) -> (f64, f64) {
    match question.direction {
        Direction::Angle(deg) => (deg.to_radians().cos(), deg.to_radians().sin()),
        Direction::Cos(cos) => (cos, (1.0 - cos * cos).sqrt()),
        Direction::Kx(kx) => ((1.0 - (kx / question.once.first).powi(2)).sqrt(), kx / question.once.first),
    }
}

fn single(question: &Question) -> Answer32 {
    let (cos, sin) = legs(question);
    let index = |n: C64| Complex::new(n.re as f32, n.im as f32);
    let layers: Vec<_> = question.once.layers.iter().map(|l| (index(l.index), l.thickness as f32)).collect();
    let (first, last) = (question.once.first as f32, index(question.once.last));
    let wavelength = question.once.wavelength_nm as f32;
    let layers = layers.repeat(question.repeat);
    Stack32 { first, cos: cos as f32, sin: sin as f32, layers, last, wavelength, p: question.p }.solve()
}

/// Abelès' matrices, with Snell's law for sines.
fn naive(question: &Question) -> [C64; 4] {
    let once: Vec<_> = question.once.layers.iter().map(|l| (l.index, l.thickness)).collect();
    let (first, layers) = (C64::from(question.once.first), once.repeat(question.repeat));
    let (last, wavelength, p) = (question.once.last, question.once.wavelength_nm, question.p);
    matrix_product(&Stack { first, layers: &layers, last, wavelength, p }, kz_from_sine(first.re, legs(question).1))
}

/// Bounds lie above what rounding of the input does to each (`noise_1ulp` in the file).
fn from_the_file() -> Vec<Case> {
    let known = Known::of;
    vec![
        known("passband_1000_s").reflected("1000 films, pass band", 1e-12),
        known("bandedge_1000_s").reflected("1000 films, edge of the band", 1e-12),
        known("absorbing_1000_p").reflected("1000 films, absorbing", 1e-12),
        known("stopband_1000_s").transmitted("1000 films, stop band", 1e-10),
        known("k5_100um_under_film_p").reflected("100 µm of κ = 5 under a film", 1e-14),
        known("k1_5um_p").transmitted("5 µm of κ = 1, 30°", 1e-10),
        known("near_normal_1e-8deg_p").reflected("film at θ = 1e-8°", 1e-14),
        known("grazing_cos1e-09_film_s").transmitted("film at cos θ = 1e-9", 1e-10),
        known("grazing_cos1e-09_index_matched_s").transmitted("nearly equal indices at cos θ = 1e-9", 1e-10),
        known("critical_exact_inside_gap_s").reflected("film exactly at its critical angle", 1e-14),
        known("critical_rel1e-12_gap_p").reflected("film beyond its critical angle by 1e-12", 1e-14),
        known("critical_rel-1e-12_bare_s").transmitted("interface before its critical angle by 1e-12", 1e-10),
        known("critical_rel1e-12_bare_s").lagging("interface beyond its critical angle by 1e-12", 1e-10),
        known("ftir_T1e-300_s").transmitted("tunnelling, T = 1e-283", 1e-10),
        known("brewster_pile20_p").reflected("20 plates at Brewster's angle", 1e-30),
        reversed("pair0"),
        reversed("pair1"),
    ]
}

/// The same stack from its other side: what goes through is the same, whatever is absorbed.
fn reversed(pair: &str) -> Case {
    let [a, b] = ["fwd", "rev"].map(|way| Known::of(&format!("{pair}_{way}_p")));
    let naive = [&a, &b].map(|k| k.naive[1].norm_sqr() * k.ours.flux_ratio);
    Case::new(
        format!("absorbing stack reversed, {pair}"),
        "T − T",
        0.0,
        a.ours.transmittance() - b.ours.transmittance(),
        1e-15,
    )
    .single(a.single.transmitted - b.single.transmitted)
    .naive(MATRIX, naive[0] - naive[1])
}

/// Pairs of quarter waves of index 2 and 1.5 on glass of 1.5, in air.
fn quarter_waves(pairs: usize) -> Question {
    let wavelength_nm = 500.0;
    let layers = [2.0, 1.5].map(|n| Layer { index: n.into(), thickness: wavelength_nm / (4.0 * n) }).to_vec();
    let once = Films { first: 1.0, layers, last: C64::from(1.5), wavelength_nm };
    Question { id: "mirror".into(), once, repeat: pairs, direction: Direction::Cos(1.0), p: false }
}

/// T = 4Y/(1 + Y)² of the admittance Y = 1.5 (2/1.5)^2N.
fn mirrors() -> Vec<Case> {
    let mirror = |pairs: u16| {
        let y = 1.5 * f64::powi(2.0 / 1.5, 2 * i32::from(pairs));
        let truth = 4.0 * y / ((1.0 + y) * (1.0 + y));
        let question = quarter_waves(pairs.into());
        Case::new(format!("{pairs} pairs of quarter waves"), "T", truth, question.solve().transmittance(), 1e-10)
            .relative()
            .single(single(&question).transmitted)
            .naive("1 − R", 1.0 - naive(&question)[0].norm_sqr())
    };
    let question = quarter_waves(500);
    let perfect = Case::new("500 pairs of quarter waves", "R", 1.0, question.solve().reflectance(), 1e-14)
        .single(single(&question).reflected)
        .naive(MATRIX, naive(&question)[0].norm_sqr());
    [5, 20, 60, 500].into_iter().map(mirror).chain([perfect]).collect()
}

/// 100 µm of n = 1 + 10i on glass, at 550 nm.
fn thick_metal() -> Question {
    let layers = vec![Layer { index: C64::new(1.0, 10.0), thickness: 1e5 }];
    let once = Films { first: 1.0, layers, last: C64::from(1.5), wavelength_nm: 550.0 };
    Question { id: "metal".into(), once, repeat: 1, direction: Direction::Cos(1.0), p: false }
}

/// R = κ²/(4 + κ²) for n = 1 + iκ.
fn metal() -> Case {
    let question = thick_metal();
    Case::new("100 µm of κ = 10", "R", 100.0 / 104.0, question.solve().reflectance(), 1e-14)
        .single(single(&question).reflected)
        .naive(MATRIX, naive(&question)[0].norm_sqr())
}

/// e^(−4πκd/λ) is 1e-9923.
fn metal_lets_nothing_through() -> Case {
    let question = thick_metal();
    Case::new("100 µm of κ = 10", "T", 0.0, question.solve().transmittance(), 0.0)
        .single(single(&question).transmitted)
        .naive(MATRIX, naive(&question)[1].norm_sqr())
}

/// 3000.1 µm at 0.4 µm are 7500¼ waves. Half a unit in the last place of the length is 3.6e-12 rad, of the wavelength 3.3e-12,
/// of their quotient 2.9e-12.
fn phase() -> Case {
    let layer = [Layer { index: 1.0.into(), thickness: 3000.1 }];
    let ours = solve(&Incidence::from_cos(1.0, 1.0), &layer, 1.0.into(), 0.4).s.t.arg();
    let single = (std::f32::consts::TAU * 3000.1f32 / 0.4f32).sin_cos();
    Case::new("3 mm at 400 nm", "phase, rad", FRAC_PI_2, ours, 1e-11).single(single.0.atan2(single.1).into())
}

/// Glass, a gap of air, glass, at 45°: T = 1/(1 + (a² + b²)² sinh²(κd)/(2ab)²) with a = q, b = κ (s) or a = q/n², b = κ (p),
/// for q = n cos θ, κ² = n² sin² θ − 1; the gap from 1 nm to 80 µm, T down to 1e-280.
fn tunnel() -> Case {
    let (n, um) = (1.5, 0.55);
    let (q, kappa) = (n * 0.5f64.sqrt(), (0.5 * n * n - 1.0).sqrt());
    let kx = n * 0.5f64.sqrt();
    let gaps = (0..=98).map(|i| 1e-3 * 10f64.powf(0.05 * f64::from(i)));
    let errors = gaps.flat_map(|gap| [false, true].map(|p| (gap, p))).map(|(gap, p)| {
        let (a, b) = (if p { q / (n * n) } else { q }, kappa);
        let ratio = (a * a + b * b) * (2.0 * PI * kappa * gap / um).sinh() / (2.0 * a * b);
        let truth = 1.0 / (1.0 + ratio * ratio);
        let layers = [Layer { index: 1.0.into(), thickness: gap }];
        let ours = solve(&Incidence::from_kx(n, kx), &layers, n.into(), um);
        let ours = if p { ours.p } else { ours.s };
        let root = 0.5f32.sqrt();
        let single = Stack32 {
            first: n as f32,
            cos: root,
            sin: root,
            layers: vec![(Complex::from(1.0), gap as f32)],
            last: Complex::from(n as f32),
            wavelength: um as f32,
            p,
        };
        [ours.transmittance(), single.solve().transmitted, 1.0 - ours.reflectance()].map(|t| t / truth - 1.0)
    });
    let errors: Vec<[f64; 3]> = errors.collect();
    let [ours, single, naive] = [0, 1, 2].map(|i| worst(errors.iter().map(|e| e[i])));
    Case::new("tunnelling at 45°, gaps of 1 nm to 80 µm", "relative error of T", 0.0, ours, 1e-10)
        .single(single)
        .naive("1 − R", naive)
}
