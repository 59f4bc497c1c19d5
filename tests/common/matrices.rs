//! Mueller matrices for tests, from first principles. Stokes vectors are (I, Q, U, V) with U + iV = 2 Eₓ E_y*.

use num_complex::Complex;

type C64 = Complex<f64>;

/// A Mueller matrix, by rows.
pub type Mueller = [f64; 16];

/// A Jones matrix, by rows.
pub type Jones = [[C64; 2]; 2];

/// E†σE for these are I, Q, U and V.
const PAULI: [Jones; 4] = {
    let (o, e, i) = (C64::ZERO, C64::ONE, C64::I);
    let (minus, minus_i) = (C64::new(-1.0, 0.0), C64::new(0.0, -1.0));
    [[[e, o], [o, e]], [[e, o], [o, minus]], [[o, e], [e, o]], [[o, i], [minus_i, o]]]
};

fn times(a: &Jones, b: &Jones) -> Jones {
    a.map(|row| [0, 1].map(|j| row[0] * b[0][j] + row[1] * b[1][j]))
}

fn adjoint(a: &Jones) -> Jones {
    [0, 1].map(|i| [0, 1].map(|j| a[j][i].conj()))
}

/// The matrix of light that keeps its phase: M_ij = tr(σ_i J σ_j J†)/2.
pub fn of_jones(j: &Jones) -> Mueller {
    std::array::from_fn(|at| {
        let product = times(&PAULI[at / 4], &times(j, &times(&PAULI[at % 4], &adjoint(j))));
        0.5 * (product[0][0] + product[1][1]).re
    })
}

/// Different amplitudes for x and for y.
pub fn diagonal(x: C64, y: C64) -> Mueller {
    of_jones(&[[x, C64::ZERO], [C64::ZERO, y]])
}

/// Light told in the frame whose x̂ is cos·x̂ + sin·ŷ.
pub fn turn(cos: f64, sin: f64) -> Mueller {
    of_jones(&[[cos.into(), sin.into()], [(-sin).into(), cos.into()]])
}

/// The light of `b`, then through `a`.
pub fn product(a: &Mueller, b: &Mueller) -> Mueller {
    std::array::from_fn(|at| (0..4).map(|k| a[4 * (at / 4) + k] * b[4 * k + at % 4]).sum())
}

pub fn applied(m: &Mueller, stokes: [f64; 4]) -> [f64; 4] {
    std::array::from_fn(|row| (0..4).map(|c| m[4 * row + c] * stokes[c]).sum())
}

pub fn transposed(m: &Mueller) -> Mueller {
    std::array::from_fn(|at| m[4 * (at % 4) + at / 4])
}

/// The largest difference of two matrices.
pub fn distance(a: &Mueller, b: &Mueller) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Whether a matrix is a sum of those of light that keeps its phase, with weights that are not negative, but for an error
/// of `rounding` of the whole: Cloude's coherency matrix Σ M_ij σ_i ⊗ σ_j*/4 is positive semidefinite.
pub fn is_physical(m: &Mueller, rounding: f64) -> bool {
    let mut h = [[C64::ZERO; 4]; 4];
    for at in 0..16 {
        let (a, b) = (&PAULI[at / 4], &PAULI[at % 4]);
        for row in 0..4 {
            for column in 0..4 {
                h[row][column] += 0.25 * m[at] * a[row / 2][column / 2] * b[row % 2][column % 2].conj();
            }
        }
    }
    (0..4).for_each(|i| h[i][i] += rounding * m[0]);
    is_positive(h)
}

/// Cholesky.
fn is_positive(mut h: [[C64; 4]; 4]) -> bool {
    for i in 0..4 {
        let pivot = h[i][i].re;
        if pivot <= 0.0 {
            return false;
        }
        let row = h[i];
        for below in &mut h[i + 1..] {
            let by = below[i] / pivot;
            below.iter_mut().zip(row).for_each(|(x, above)| *x -= by * above);
        }
    }
    true
}

#[test]
fn matrices_of_phases_are_physical_and_others_are_not() {
    let jones = [[C64::new(0.3, -0.2), C64::new(0.5, 0.7)], [C64::new(-0.1, 0.9), C64::new(0.4, 0.0)]];
    let m = of_jones(&jones);
    assert!(is_physical(&m, 1e-14));
    // The other handedness of what leaves, as of a transposition: no passive thing does that.
    let mut wrong = m;
    (12..16).for_each(|i| wrong[i] = -wrong[i]);
    assert!(!is_physical(&wrong, 1e-3));
    let e = [C64::new(0.6, 0.0), C64::new(0.0, 0.8)];
    let out = [0, 1].map(|i| jones[i][0] * e[0] + jones[i][1] * e[1]);
    let stokes = |e: [C64; 2]| {
        let cross = 2.0 * e[0] * e[1].conj();
        [e[0].norm_sqr() + e[1].norm_sqr(), e[0].norm_sqr() - e[1].norm_sqr(), cross.re, cross.im]
    };
    applied(&m, stokes(e)).iter().zip(stokes(out)).for_each(|(a, b)| assert!((a - b).abs() < 1e-15));
}
