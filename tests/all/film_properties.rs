//! What holds for every film stack, on random ones.

use crate::common::collapse;
use gonio_embree::optics::batch::{Film, Question, Sides, Solver, Spectrum};
use gonio_embree::optics::film::{Amplitudes, Incidence, Layer, absorptances, solve};
use gonio_embree::optics::{C64, Pair};
use proptest::prelude::*;
use proptest::test_runner::{Config, TestRunner};

/// A stack of transparent or absorbing layers between transparent media; wavelength 0.5.
#[derive(Clone, Debug)]
struct Stack {
    first: f64,
    cos: f64,
    layers: Vec<Layer>,
    last: f64,
}

impl Stack {
    fn solve(&self) -> Pair<Amplitudes> {
        self.solve_scaled(1.0)
    }

    /// As one of many wavelengths.
    fn solve_in_lanes(&self) -> Pair<Amplitudes> {
        in_lanes(std::slice::from_ref(self))[0]
    }

    /// With all lengths multiplied.
    fn solve_scaled(&self, scale: f64) -> Pair<Amplitudes> {
        let layers: Vec<Layer> = self.layers.iter().map(|l| Layer { thickness: l.thickness * scale, ..*l }).collect();
        solve(&Incidence::from_cos(self.first, self.cos), &layers, C64::from(self.last), WAVELENGTH * scale)
    }

    /// Whether light travels behind the stack.
    fn transmits(&self) -> bool {
        self.first * (1.0 - self.cos * self.cos).sqrt() < self.last
    }

    fn with(&self, layers: Vec<Layer>) -> Self {
        Self { layers, ..self.clone() }
    }

    /// How much rounding of the input may change any amplitude.
    fn noise(&self) -> f64 {
        let exact = self.solve();
        let shifted = |index: f64, thickness: f64| {
            let shift = |(i, l): (usize, &Layer)| {
                let sign = if i % 2 == 0 { 1.0 } else { -1.0 };
                Layer { index: l.index * (1.0 + sign * index), thickness: l.thickness * (1.0 + sign * thickness) }
            };
            difference(&exact, &self.with(self.layers.iter().enumerate().map(shift).collect()).solve())
        };
        [(ULP, ULP), (ULP, -ULP), (-ULP, 0.0), (0.0, ULP)].iter().map(|s| shifted(s.0, s.1)).fold(0.0, f64::max)
    }
}

const WAVELENGTH: f64 = 0.5;
const ULP: f64 = 4.0 * f64::EPSILON;

fn amplitudes(a: &Amplitudes) -> [C64; 4] {
    [a.r, a.t, a.r_back, a.t_back]
}

fn difference(a: &Pair<Amplitudes>, b: &Pair<Amplitudes>) -> f64 {
    let one = |a, b| amplitudes(a).iter().zip(amplitudes(b)).map(|(x, y)| (x - y).norm()).fold(0.0, f64::max);
    one(&a.s, &b.s).max(one(&a.p, &b.p))
}

fn layer(absorbs: bool) -> impl Strategy<Value = Layer> {
    let k = if absorbs { prop_oneof![Just(0.0), 1e-6..0.1, 0.1..5.0f64].boxed() } else { Just(0.0).boxed() };
    let n = prop_oneof![Just(1.5), 1.0..3.0f64];
    let d = prop_oneof![4 => 0.0..0.3f64, 1 => 0.3..20.0f64];
    (n, k, d).prop_map(|(n, k, thickness)| Layer { index: C64::new(n, k), thickness })
}

fn stacks(absorbs: bool) -> impl Strategy<Value = Stack> {
    let index = || prop_oneof![Just(1.0), Just(1.5), 1.0..2.5f64];
    let cos = prop_oneof![1 => Just(1.0), 1 => 0.0..1e-3f64, 8 => 0.0..1.0f64];
    let layers = prop::collection::vec(layer(absorbs), 0..16);
    (index(), cos, layers, index()).prop_map(|(first, cos, layers, last)| Stack { first, cos, layers, last })
}

fn check(cases: u32, absorbs: bool, property: impl Fn(Stack) -> Result<(), TestCaseError>) {
    let config = Config { cases, failure_persistence: None, ..Config::default() };
    TestRunner::new_with_rng(config, proptest::test_runner::TestRng::deterministic_rng(Default::default()))
        .run(&stacks(absorbs), property)
        .unwrap_or_else(|e| panic!("{e}"));
}

fn near(a: &Pair<Amplitudes>, b: &Pair<Amplitudes>, stack: &Stack) -> Result<(), TestCaseError> {
    let (error, noise) = (difference(a, b), stack.noise());
    let scale = amplitudes(&a.s).iter().chain(&amplitudes(&a.p)).map(|x| x.norm()).fold(1.0, f64::max);
    prop_assert!(error <= 4.0 * noise + 1e-13 * scale, "{error:e}, noise {noise:e}");
    Ok(())
}

/// R + T = 1, and Stokes: r' = −r* t/t*. Between evanescent layers, fields may be far larger than the flux that
/// they carry, and only rounding of the input bounds the error.
fn lossless(stack: Stack) -> Result<(), TestCaseError> {
    let (both, in_lanes) = (stack.solve(), stack.solve_in_lanes());
    let kx = stack.first * (1.0 - stack.cos * stack.cos).sqrt();
    let tunnels = stack.layers.iter().any(|l| l.index.re <= kx);
    let allowed = 1e-14 + if tunnels { 4.0 * stack.noise() } else { 0.0 };
    for a in [both.s, both.p, in_lanes.s, in_lanes.p] {
        let sum = a.reflectance() + a.transmittance();
        prop_assert!((sum - 1.0).abs() <= allowed, "R+T-1 = {:e} > {allowed:e}", sum - 1.0);
        if stack.transmits() && a.t.norm() > 1e-100 {
            let stokes = a.r_back + a.r.conj() * a.t / a.t.conj();
            prop_assert!(stokes.norm() <= 1e-13 + 4.0 * stack.noise(), "Stokes {:e}", stokes.norm());
        }
    }
    Ok(())
}

/// No more comes out than goes in; what is missing is in the layers; no NaN.
fn passive(stack: Stack) -> Result<(), TestCaseError> {
    let both = stack.solve();
    let incidence = Incidence::from_cos(stack.first, stack.cos);
    let absorbed = absorptances(&incidence, &stack.layers, C64::from(stack.last), WAVELENGTH);
    for (a, absorbed) in [(both.s, absorbed.s), (both.p, absorbed.p)] {
        prop_assert!(amplitudes(&a).iter().all(|x| x.is_finite()), "{a:?}");
        let sum = a.reflectance() + a.transmittance();
        let total: f64 = absorbed.iter().sum();
        prop_assert!(sum <= 1.0 + 1e-13 && absorbed.iter().all(|&x| (0.0..=1.0 + 1e-13).contains(&x)));
        prop_assert!((sum + total - 1.0).abs() <= 1e-12, "R+T {sum}, absorbed {total}");
    }
    Ok(())
}

/// Seen from behind, front and back swap.
fn reversed(stack: Stack) -> Result<(), TestCaseError> {
    let sin = stack.first * (1.0 - stack.cos * stack.cos).sqrt() / stack.last;
    if sin > 0.99 || stack.cos < 0.1 {
        return Ok(());
    }
    let cos = ((1.0 - sin) * (1.0 + sin)).sqrt();
    let layers = stack.layers.iter().rev().copied().collect();
    let swap = |a: Amplitudes| Amplitudes { r: a.r_back, t: a.t_back, r_back: a.r, t_back: a.t, ..a };
    let back = Stack { first: stack.last, cos, layers, last: stack.first };
    let noise_of_cos = Stack { cos: cos * (1.0 + ULP), ..back.clone() };
    let conditioning = difference(&back.solve(), &noise_of_cos.solve());
    let error = difference(&stack.solve(), &back.solve().map(swap));
    let allowed = 1e-13 + 8.0 * (stack.noise() + conditioning);
    prop_assert!(error <= allowed, "{error:e} > {allowed:e}");
    Ok(())
}

/// Splitting layers and inserting empty ones changes nothing; scaling by a power of two changes no bit.
fn invariant(stack: Stack) -> Result<(), TestCaseError> {
    let both = stack.solve();
    for scale in [2f64.powi(-7), 2f64.powi(11)] {
        prop_assert_eq!(both, stack.solve_scaled(scale));
    }
    if stack.layers.is_empty() {
        return Ok(());
    }
    let part = |l: &Layer, share: f64| Layer { thickness: l.thickness * share, ..*l };
    let split = stack.layers.iter().flat_map(|l| [part(l, 0.25), part(l, 0.75)]).collect();
    near(&both, &stack.with(split).solve(), &stack)?;
    let empty = stack.layers.iter().flat_map(|l| [*l, Layer { index: C64::new(1.7, 0.3), thickness: 0.0 }]).collect();
    near(&both, &stack.with(empty).solve(), &stack)
}

/// The slow twins agree where they can: away from grazing incidence and from critical angles, and where no matrix
/// overflows.
fn like_the_twins(stack: Stack) -> Result<(), TestCaseError> {
    let kx = stack.first * (1.0 - stack.cos * stack.cos).sqrt();
    if stack.cos < 0.1 || stack.layers.iter().any(|l| (l.index.re - kx).abs() < 0.01) || (stack.last - kx).abs() < 0.01
    {
        return Ok(());
    }
    let layers: Vec<(C64, f64)> = stack.layers.iter().map(|l| (l.index, l.thickness)).collect();
    let twin = collapse::collapse(stack.first, stack.cos, &layers, C64::from(stack.last), WAVELENGTH);
    let both = stack.solve();
    for (a, (r, t)) in [(both.s, twin.s), (both.p, twin.p)] {
        let error = (a.r - r).norm().max((a.t - t).norm());
        prop_assert!(error <= 1e-11 + 100.0 * stack.noise(), "{error:e}");
    }
    let (first, last) = (C64::from(stack.first), C64::from(stack.last));
    for (a, p) in [(both.s, false), (both.p, true)] {
        let question = collapse::Stack { first, layers: &layers, last, wavelength: WAVELENGTH, p };
        let kz = collapse::kz_by_differences(stack.first, stack.first * stack.cos, kx, stack.cos < 0.7);
        let twin = collapse::matrix_product(&question, kz);
        // Elements of the matrix are about 1/t: their squares overflow first, and turn into zeros.
        if twin.iter().all(|x| x.is_finite()) && twin[1].norm() > 1e-100 {
            let error = amplitudes(&a).iter().zip(twin).map(|(x, y)| (x - y).norm()).fold(0.0, f64::max);
            prop_assert!(error <= 1e-11 + 100.0 * stack.noise(), "matrix product: {error:e}");
        }
    }
    Ok(())
}

/// Stacks of one form side by side; wavelength and directions are the same.
fn in_lanes(stacks: &[Stack]) -> Vec<Pair<Amplitudes>> {
    let stack = &stacks[0];
    let mut media: Vec<Spectrum> =
        (0..stack.layers.len()).map(|i| stacks.iter().map(|s| s.layers[i].index).collect()).collect();
    media.push(stacks.iter().map(|s| C64::from(s.last)).collect());
    let film = |(medium, l): (usize, &Layer)| Film { medium, thickness: l.thickness };
    let films: Vec<Film> = stack.layers.iter().enumerate().map(film).collect();
    let incidences = vec![Incidence::from_cos(stack.first, stack.cos); stacks.len()];
    let wavelengths = vec![WAVELENGTH; stacks.len()];
    let question = Question {
        incidences: &incidences,
        media: &media,
        films: &films,
        last: films.len(),
        wavelengths: &wavelengths,
    };
    let mut out = Vec::new();
    Solver::default().solve(&question, Sides::Both, &mut out);
    out
}

/// Lanes give what single wavelengths give, also where indices, thus kinds of layers, differ between lanes; and no lane
/// looks at its neighbours.
fn lanes(stack: Stack) -> Result<(), TestCaseError> {
    let shift = |w: usize| 1.0 + 0.02 * w as f64;
    let at = |w: usize| {
        let layers = stack.layers.iter().map(|l| Layer { index: l.index * shift(w), ..*l }).collect();
        stack.with(layers)
    };
    let stacks: Vec<Stack> = (0..11).map(at).collect();
    for (got, stack) in in_lanes(&stacks).iter().zip(&stacks) {
        let (error, noise) = (difference(got, &stack.solve()), stack.noise());
        prop_assert!(error <= 4.0 * noise + 1e-14, "{error:e}, noise {noise:e}");
        prop_assert_eq!(*got, stack.solve_in_lanes());
    }
    Ok(())
}

fn check_all(cases: u32) {
    check(cases, false, lossless);
    check(cases, true, passive);
    for absorbs in [false, true] {
        check(cases, absorbs, reversed);
        check(cases, absorbs, invariant);
        check(cases, absorbs, like_the_twins);
        check(cases, absorbs, lanes);
    }
}

#[test]
fn random_stacks() {
    check_all(300);
}

#[test]
#[ignore = "slow: cargo test --release film_properties:: -- --ignored (a minute)"]
fn many_random_stacks() {
    check_all(100_000);
}

/// Grazing incidence between equal media is the limit, not 0/0.
#[test]
fn grazing_incidence_is_a_limit() {
    for layers in [vec![], vec![Layer { index: C64::from(1.0), thickness: 0.1 }]] {
        let both = Stack { first: 1.0, cos: 0.0, layers, last: 1.0 }.solve();
        assert!(both.s.r.norm() < 1e-15 && (both.p.t - 1.0).norm() < 1e-15, "{both:?}");
    }
}

/// A cavity of finesse 10⁹ and a stack of 1000 layers keep their energy.
#[test]
fn extreme_stacks_conserve_energy() {
    let quarter = |n: f64| Layer { index: C64::from(n), thickness: WAVELENGTH / 4.0 / n };
    let mirror: Vec<Layer> = (0..21).map(|i| quarter(if i % 2 == 0 { 3.5 } else { 1.2 })).collect();
    for detuning in [0.0, 1e-12, 1e-10, 1e-8] {
        let spacer = Layer { index: C64::from(1.2), thickness: WAVELENGTH / 2.4 * (1.0 + detuning) };
        let cavity = [&mirror[..], &[spacer], &mirror[..]].concat();
        energy(cavity, 1e-14);
    }
    energy(mirror.into_iter().cycle().take(1000).collect(), 1e-12);
    energy((0..1000).map(|i| quarter(1.3 + 0.01 * f64::from(i * 37 % 100))).collect(), 1e-12);
}

fn energy(layers: Vec<Layer>, tolerance: f64) {
    let both = Stack { first: 1.0, cos: 1.0, layers, last: 1.0 }.solve();
    for a in [both.s, both.p] {
        let missing = a.reflectance() + a.transmittance() - 1.0;
        assert!(missing.abs() <= tolerance, "{missing:e}");
    }
}
