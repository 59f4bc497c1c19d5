//! Films of absurd numbers, all of them finite and passive: an answer that can be, or none, but never nonsense.

use gonio_embree::films::Films;
use gonio_embree::films::cases::{Case, Direction, read};
use gonio_embree::optics::batch::{Film, Question, Sides, Solver, Spectrum};
use gonio_embree::optics::film::{Incidence, Layer, absorptances};
use gonio_embree::optics::{C64, Pair};
use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};
use serde_json::{Value, json};

/// How many powers of ten numbers reach up and down.
#[derive(Clone, Copy)]
struct Decades {
    indices: f64,
    lengths: f64,
    angles: f64,
}

/// Far beyond all media and films there are; any angle.
const WIDE: Decades = Decades { indices: 2.0, lengths: 6.0, angles: 300.0 };
/// Beyond what can be written of a sample.
const WIDER: Decades = Decades { indices: 5.0, lengths: 300.0, angles: 300.0 };
/// All that double precision holds.
const WIDEST: Decades = Decades { indices: 300.0, lengths: 300.0, angles: 300.0 };

struct Draw {
    rng: Xoshiro256PlusPlus,
    decades: Decades,
}

impl Draw {
    fn new(decades: Decades) -> Self {
        Self { rng: Xoshiro256PlusPlus::seed_from_u64(1), decades }
    }

    fn one_of<T: Copy>(&mut self, all: &[T]) -> T {
        all[self.rng.random_range(0..all.len())]
    }

    fn unit(&mut self) -> f64 {
        self.rng.random()
    }

    fn within(&mut self, decades: f64) -> f64 {
        let between = 10f64.powf(decades * (2.0 * self.unit() - 1.0));
        self.one_of(&[10f64.powf(decades), 10f64.powf(-decades), 1.0, 1.5, between, between, between, between])
    }

    fn index(&mut self) -> C64 {
        let (n, k, usual) = (self.within(self.decades.indices), self.within(self.decades.indices), 1.0 + self.unit());
        let media = [(n, 0.0), (0.0, k), (n, k), (usual, 0.0), (usual, k)];
        let (n, k) = self.one_of(&media);
        C64::new(n, k)
    }

    fn length(&mut self) -> f64 {
        100.0 * self.within(self.decades.lengths)
    }

    /// Sometimes exactly at the critical angle of a layer.
    fn direction(&mut self, first: f64, layers: &[Layer]) -> Direction {
        let critical = layers.iter().map(|l| l.index.re).find(|&n| n > 0.0 && n < first).unwrap_or(0.5 * first);
        let (small, any) = (self.within(self.decades.angles).min(1.0), self.unit());
        let share = self.one_of(&[0.0, 1.0, small, 1.0 - small, any]);
        let (angle, cos, kx) = (Direction::Angle(90.0 * share), Direction::Cos(share), Direction::Kx(first * share));
        self.one_of(&[angle, cos, kx, Direction::Kx(critical)])
    }

    fn case(&mut self) -> Case {
        let n = self.within(self.decades.indices);
        let first = self.one_of(&[1.0, 1.5, n]);
        let layers: Vec<Layer> = (0..self.rng.random_range(0..7))
            .map(|_| Layer { index: self.index(), thickness: self.one_of(&[1.0, 1.0, 1.0, 0.0]) * self.length() })
            .collect();
        let wavelength = self.length();
        let wavelength_nm = self.one_of(&[550.0, wavelength]);
        let (direction, last, p) = (self.direction(first, &layers), self.index(), self.rng.random());
        Case { id: "extreme".into(), once: Films { first, layers, last, wavelength_nm }, repeat: 1, direction, p }
    }
}

/// Whether there is an answer; panics if it cannot be.
fn answered(case: &Case) -> bool {
    let a = case.solve();
    if !a.is_finite() {
        return false;
    }
    // Every layer rounds a few times, and fields within may be larger than the flux that they carry.
    let most = 1.0 + (1e-14 * (case.once.layers.len() * case.repeat) as f64).max(1e-12);
    let physical = |(r, t): (f64, f64)| r >= 0.0 && t >= 0.0 && r <= most && r + t <= most;
    let front = (a.reflectance(), a.transmittance());
    assert!(physical(front), "R, T = {front:?}: {a:?}\n{case:?}");
    let back = case.back(&a);
    assert!(back.is_none_or(physical), "from behind R, T = {back:?}: {a:?}\n{case:?}");
    true
}

#[test]
fn wide_numbers_are_answered() {
    let mut draw = Draw::new(WIDE);
    for case in (0..30_000).map(|_| draw.case()) {
        assert!(answered(&case), "no answer: {case:?}");
    }
}

#[test]
fn wider_numbers_are_answered() {
    let mut draw = Draw::new(WIDER);
    for case in (0..30_000).map(|_| draw.case()) {
        assert!(answered(&case), "no answer: {case:?}");
    }
}

#[test]
fn all_finite_numbers_have_a_finite_answer() {
    let mut draw = Draw::new(WIDEST);
    for case in (0..30_000).map(|_| draw.case()) {
        assert!(case.solve().is_finite(), "no answer: {case:?}");
    }
}

/// What comes back or goes through, and what each layer absorbs.
struct Balance {
    outside: f64,
    absorbed: Vec<f64>,
}

impl Balance {
    fn one_by_one(case: &Case) -> Self {
        let Films { layers, last, wavelength_nm, .. } = &case.once;
        let absorbed = absorptances(&incidence(case), layers, *last, *wavelength_nm);
        let a = case.solve();
        Self { outside: a.reflectance() + a.transmittance(), absorbed: if case.p { absorbed.p } else { absorbed.s } }
    }

    fn in_lanes(case: &Case, solver: &mut Solver) -> Self {
        let Films { layers, last, wavelength_nm, .. } = &case.once;
        let indices = layers.iter().map(|l| l.index).chain([*last]);
        let media: Vec<Spectrum> = indices.map(|n| [n].into_iter().collect()).collect();
        let film = |(medium, l): (usize, &Layer)| Film { medium, thickness: l.thickness };
        let films: Vec<Film> = layers.iter().enumerate().map(film).collect();
        let (incidences, wavelengths) = (&[incidence(case)], &[*wavelength_nm]);
        let question = Question { incidences, media: &media, films: &films, last: layers.len(), wavelengths };
        let (mut shares, mut amplitudes) = (Vec::new(), Vec::new());
        solver.absorptances(&question, &mut shares);
        solver.solve(&question, Sides::Front, &mut amplitudes);
        let of = |both: &Pair<f64>| if case.p { both.p } else { both.s };
        let outside = amplitudes[0].map(|a| a.reflectance() + a.transmittance());
        Self { outside: of(&outside), absorbed: shares.iter().map(of).collect() }
    }
}

fn incidence(case: &Case) -> Incidence {
    let first = case.once.first;
    match case.direction {
        Direction::Angle(deg) => Incidence::from_angle(first, deg.to_radians()),
        Direction::Cos(cos) => Incidence::from_cos(first, cos),
        Direction::Kx(kx) => Incidence::from_kx(first, kx),
    }
}

/// Layers take shares of the light: with what a clear last medium lets through all that there is, else no more.
fn check_balance(case: &Case, solver: &mut Solver) {
    for Balance { outside, absorbed } in [Balance::one_by_one(case), Balance::in_lanes(case, solver)] {
        let all = outside + absorbed.iter().sum::<f64>();
        let closed = case.once.last.im > 0.0 || all >= 1.0 - 1e-12;
        let shares = absorbed.iter().all(|&x| x >= 0.0) && all <= 1.0 + 1e-12;
        assert!(shares && closed, "{outside} outside, {absorbed:?}: {case:?}");
    }
}

#[test]
fn layers_absorb_shares() {
    let mut solver = Solver::default();
    for decades in [WIDE, WIDER, WIDEST] {
        let mut draw = Draw::new(decades);
        for case in (0..30_000).map(|_| draw.case()) {
            check_balance(&case, &mut solver);
        }
    }
}

/// A wave bound to the back of a metal without losses, met to the last bit, or nearly; behind, something that absorbs
/// less than rounding does.
#[test]
fn bound_modes_absorb_shares() {
    let mut solver = Solver::default();
    for (m, ulps) in (1..400).flat_map(|m| (-40..=40).map(move |ulps| (m, ulps))) {
        let k = 1.0 + 0.01 * f64::from(m);
        // k_x² = ε₁ε₂/(ε₁ + ε₂) between ε₁ = −k² and ε₂ = 1.
        let kx = (k * k / (k * k - 1.0)).sqrt() * (1.0 + f64::from(ulps) * f64::EPSILON);
        for thickness in [1.5, 3.0, 300.0, 1e5] {
            for behind in [None, Some(C64::new(1.0, 1e-18))] {
                let layer = |index, thickness| Layer { index, thickness };
                let metal = [layer(C64::new(0.0, k), thickness)];
                let layers = metal.into_iter().chain(behind.map(|index| layer(index, 0.2))).collect();
                let once = Films { first: 2.0 * kx, layers, last: C64::from(1.0), wavelength_nm: 1.0 };
                let direction = Direction::Kx(kx);
                check_balance(&Case { id: "bound".into(), once, repeat: 1, direction, p: true }, &mut solver);
            }
        }
    }
}

#[test]
fn ten_thousand_layers() {
    let mut draw = Draw::new(WIDE);
    for mut case in (0..150).map(|_| draw.case()) {
        case.repeat = 10_000 / case.once.layers.len().max(1);
        assert!(answered(&case), "no answer: {case:?}");
    }
}

fn pair(n: C64) -> Value {
    json!([n.re, n.im])
}

fn written(case: &Case) -> Value {
    let (kind, value) = match case.direction {
        Direction::Angle(x) => ("angle_deg", x),
        Direction::Cos(x) => ("cos0", x),
        Direction::Kx(x) => ("kx", x),
    };
    let layers: Vec<Value> = case.once.layers.iter().map(|l| json!([l.index.re, l.index.im, l.thickness])).collect();
    json!({
        "id": case.id, "pol": if case.p { "p" } else { "s" }, "wavelength_nm": case.once.wavelength_nm,
        "angle": { "kind": kind, "value": value }, "n_first": [case.once.first, 0.0], "n_last": pair(case.once.last),
        "layers": layers, "repeat": case.repeat,
    })
}

/// A file of cases takes every finite number of a passive stack, and keeps all its digits.
#[test]
fn files_hold_all_numbers() {
    let mut draw = Draw::new(WIDEST);
    let cases: Vec<Case> = (0..3000).map(|_| draw.case()).collect();
    let path = std::env::temp_dir().join(format!("gonio-extremes-{}.json", std::process::id()));
    std::fs::write(&path, json!({ "cases": cases.iter().map(written).collect::<Vec<_>>() }).to_string()).unwrap();
    let got = read(&path);
    std::fs::remove_file(&path).unwrap();
    assert!(got.unwrap() == cases);
}
