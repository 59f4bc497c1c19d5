//! The film solver's slow twin: interfaces collapsed one by one with Airy's formula, as thin-film papers write it.

use gonio_embree::optics::{C64, Pair, outgoing_root};

/// Amplitude coefficients r and t of the electric field; layers are (index, thickness).
pub fn collapse(n0: f64, cos0: f64, layers: &[(C64, f64)], last: C64, wavelength: f64) -> Pair<(C64, C64)> {
    Pair { s: one(n0, cos0, layers, last, wavelength, false), p: one(n0, cos0, layers, last, wavelength, true) }
}

fn one(n0: f64, cos0: f64, layers: &[(C64, f64)], last: C64, wavelength: f64, p: bool) -> (C64, C64) {
    let kz = |n: C64| {
        if n == C64::new(n0, 0.0) { C64::from(n0 * cos0) } else { outgoing_root(n * n - n0 * n0 * (1.0 - cos0 * cos0)) }
    };
    let interface = |n1: C64, n2: C64| {
        let (k1, k2) = (kz(n1), kz(n2));
        let (a, b) = if p { (n2 / n1 * k1, n1 / n2 * k2) } else { (k1, k2) };
        ((a - b) / (a + b), 2.0 * k1 / (a + b))
    };
    let before = |i: usize| if i == 0 { C64::from(n0) } else { layers[i - 1].0 };
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
