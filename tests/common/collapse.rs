//! Slow twins of the film solver: films as thin-film papers write them, in plain double precision.
#![allow(dead_code, missing_docs, reason = "each user takes its part")]

use gonio_embree::optics::{C64, Pair, outgoing_root};

/// Amplitude coefficients r and t of the electric field; layers are (index, thickness).
pub fn collapse(n0: f64, cos0: f64, layers: &[(C64, f64)], last: C64, wavelength: f64) -> Pair<(C64, C64)> {
    let kz = |n: C64| {
        if n == C64::new(n0, 0.0) { C64::from(n0 * cos0) } else { outgoing_root(n * n - n0 * n0 * (1.0 - cos0 * cos0)) }
    };
    let one = |p| interface_by_interface(&Stack { first: C64::from(n0), layers, last, wavelength, p }, kz);
    Pair { s: one(false), p: one(true) }
}

/// A stack and a polarization.
#[derive(Clone, Copy)]
pub struct Stack<'a> {
    pub first: C64,
    /// Index and thickness.
    pub layers: &'a [(C64, f64)],
    pub last: C64,
    pub wavelength: f64,
    pub p: bool,
}

/// Interfaces collapsed one by one with Airy's formula, from the last to the first: r and t.
/// `kz` is the normal wave number in a medium.
pub fn interface_by_interface(stack: &Stack<'_>, kz: impl Fn(C64) -> C64) -> (C64, C64) {
    let &Stack { first, layers, last, wavelength, p } = stack;
    let interface = |n1: C64, n2: C64| {
        let (k1, k2) = (kz(n1), kz(n2));
        let (a, b) = if p { (n2 / n1 * k1, n1 / n2 * k2) } else { (k1, k2) };
        ((a - b) / (a + b), 2.0 * k1 / (a + b))
    };
    let before = |i: usize| if i == 0 { first } else { layers[i - 1].0 };
    let mut below = interface(before(layers.len()), last);
    for (i, &(n, d)) in layers.iter().enumerate().rev() {
        let (r, t) = interface(before(i), n);
        let phase = (C64::I * kz(n) * (std::f64::consts::TAU * d / wavelength)).exp();
        let round_trip = below.0 * phase * phase;
        let airy = 1.0 / (1.0 + r * round_trip);
        below = ((r + round_trip) * airy, t * below.1 * phase * airy);
    }
    below
}

/// The same, and lit from behind: r, t, r_back, t_back.
pub fn interface_by_interface_both(stack: &Stack<'_>, kz: impl Fn(C64) -> C64) -> [C64; 4] {
    let layers: Vec<_> = stack.layers.iter().rev().copied().collect();
    let turned = Stack { first: stack.last, layers: &layers, last: stack.first, ..*stack };
    let ((r, t), (r_back, t_back)) = (interface_by_interface(stack, &kz), interface_by_interface(&turned, &kz));
    [r, t, r_back, t_back]
}

/// The product of Abelès' characteristic matrices (Born & Wolf, § 1.6.2): r, t, r_back, t_back.
pub fn matrix_product(stack: &Stack<'_>, kz: impl Fn(C64) -> C64) -> [C64; 4] {
    let &Stack { first, layers, last, wavelength, p } = stack;
    let admittance = |n: C64| if p { kz(n) / (n * n) } else { kz(n) };
    let mut m = [C64::ONE, C64::ZERO, C64::ZERO, C64::ONE];
    for &(n, d) in layers {
        let (q, phase) = (admittance(n), kz(n) * (std::f64::consts::TAU * d / wavelength));
        let (sin, cos) = (phase.sin(), phase.cos());
        m = times(m, [cos, -C64::I * sin / q, -C64::I * q * sin, cos]);
    }
    let (q0, qn) = (admittance(first), admittance(last));
    let [u, v] = [m[0] + m[1] * qn, m[2] + m[3] * qn];
    let [u_back, v_back] = [m[3] + m[1] * q0, m[2] + m[0] * q0];
    // Of the tangential field; of p, that is the magnetic one.
    let ratio = if p { first / last } else { C64::ONE };
    let t = 2.0 * q0 / (q0 * u + v) * ratio;
    let t_back = 2.0 * qn / (qn * u_back + v_back) / ratio;
    [(q0 * u - v) / (q0 * u + v), t, (qn * u_back - v_back) / (qn * u_back + v_back), t_back]
}

fn times(a: [C64; 4], b: [C64; 4]) -> [C64; 4] {
    let at = |i: usize, j: usize| a[2 * i] * b[j] + a[2 * i + 1] * b[2 + j];
    [at(0, 0), at(0, 1), at(1, 0), at(1, 1)]
}

/// k_z as papers write it: n cos θ with cos θ = √(1 − sin²θ) and Snell's law, in every medium.
pub fn kz_from_sine(n0: f64, sin0: f64) -> impl Fn(C64) -> C64 {
    move |n| n * outgoing_root_of_one_minus(sin0 * n0 / n)
}

/// √(1 − sin²θ), in the branch in which n cos θ decays.
fn outgoing_root_of_one_minus(sin: C64) -> C64 {
    let cos = (1.0 - sin * sin).sqrt();
    if cos.im < 0.0 { -cos } else { cos }
}

/// k_z by differences of squares, of the cosine if that is the better known: none of its digits are lost.
pub fn kz_by_differences(n0: f64, kz0: f64, kx: f64, from_cosine: bool) -> impl Fn(C64) -> C64 {
    move |n| {
        if n == C64::from(n0) {
            return C64::from(kz0);
        }
        outgoing_root(if from_cosine { (n - n0) * (n + n0) + kz0 * kz0 } else { (n - kx) * (n + kx) })
    }
}
