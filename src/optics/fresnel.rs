//! One plane interface.

use super::{C64, Coefficients, Pair, outgoing_root};

/// The interface between two transparent media, met from the first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dielectric {
    /// Amplitude reflection coefficients; of modulus 1 in total reflection.
    pub r: Pair<C64>,
    /// Power-normalised amplitude transmission coefficients; 0 in total reflection.
    pub t: Pair<f64>,
    /// Cosine of the angle of refraction; 0 in total reflection.
    pub cos_t: f64,
}

/// (n₂ cos θ₂)² from n₁ cos θ₁ without cancellation: near grazing incidence from the difference of the squares
/// of the indices, else from the tangential wave number.
fn normal_index_squared(n1: f64, cos_i: f64, n2: f64) -> f64 {
    if cos_i * cos_i < 0.5 {
        (n2 - n1) * (n2 + n1) + (n1 * cos_i) * (n1 * cos_i)
    } else {
        let kx = n1 * ((1.0 - cos_i) * (1.0 + cos_i)).sqrt();
        (n2 - kx) * (n2 + kx)
    }
}

/// Cosine of the angle of refraction; `None` in total reflection.
pub fn refracted_cos(n1: f64, n2: f64, cos_i: f64) -> Option<f64> {
    let q2_squared = normal_index_squared(n1, cos_i, n2);
    (q2_squared > 0.0).then(|| q2_squared.sqrt() / n2)
}

/// Fresnel's coefficients of an interface between media of real index.
///
/// `cos_i` is the cosine of the angle of incidence, 0..=1. Reflection in the form of differences of squares
/// r_s = (n₁²−n₂²)/(q₁+q₂)², r_p = (n₂²−n₁²)(n₂²q₁²−n₁²kₓ²)/(n₂²q₁+n₁²q₂)² with q = n cos θ, which is relatively
/// accurate for nearly equal indices, too (Born & Wolf, *Principles of Optics*, 7th ed., §1.5.2, rearranged).
#[inline]
pub fn dielectric(n1: f64, n2: f64, cos_i: f64) -> Dielectric {
    let q1 = n1 * cos_i;
    let q2_squared = normal_index_squared(n1, cos_i, n2);
    let (n1_2, n2_2) = (n1 * n1, n2 * n2);
    if q2_squared <= 0.0 {
        return total_reflection(q1, (-q2_squared).sqrt(), n2_2 / n1_2);
    }
    let q2 = q2_squared.sqrt();
    let kx_squared = n1_2 * ((1.0 - cos_i) * (1.0 + cos_i));
    let difference = (n1 - n2) * (n1 + n2);
    let (sum_s, sum_p) = (q1 + q2, n2_2 * q1 + n1_2 * q2);
    let r_s = difference / (sum_s * sum_s);
    let r_p = -difference * (n2_2 * q1 * q1 - n1_2 * kx_squared) / (sum_p * sum_p);
    // t √(q₂/q₁), the same seen from both sides.
    let common = 2.0 * (q1 * q2).sqrt();
    Dielectric {
        r: Pair { s: C64::new(r_s, 0.0), p: C64::new(r_p, 0.0) },
        t: Pair { s: common / sum_s, p: common * n1 * n2 / sum_p },
        cos_t: q2 / n2,
    }
}

/// Total reflection: r = (q₁ − iκ)/(q₁ + iκ), for p with κ n₁²/n₂² in place of κ and the sign of p.
#[cold]
fn total_reflection(q1: f64, decay: f64, ratio: f64) -> Dielectric {
    let phase = |q: f64, k: f64| {
        let norm = q * q + k * k;
        if norm == 0.0 { C64::new(1.0, 0.0) } else { C64::new((q - k) * (q + k), -2.0 * q * k) / norm }
    };
    Dielectric { r: Pair { s: phase(q1, decay), p: phase(ratio * q1, decay) }, t: Pair { s: 0.0, p: 0.0 }, cos_t: 0.0 }
}

/// Amplitude reflection coefficients of an interface into a medium of complex index (a metal, an absorber), met
/// from a transparent one.
pub fn into_complex(n1: f64, n2: C64, cos_i: f64) -> Pair<C64> {
    let kx = n1 * ((1.0 - cos_i) * (1.0 + cos_i)).sqrt();
    let q1 = n1 * cos_i;
    let q2 = outgoing_root((n2 - kx) * (n2 + kx));
    let (n1_2, n2_2) = (n1 * n1, n2 * n2);
    let difference = (n2 - n1) * (n2 + n1);
    let (sum_s, sum_p) = (q2 + q1, n2_2 * q1 + n1_2 * q2);
    Pair { s: -difference / (sum_s * sum_s), p: difference * (n2_2 * q1 * q1 - n1_2 * kx * kx) / (sum_p * sum_p) }
}

/// Coefficients of an interface between weakly absorbing media: reflection as for complex indices, transmission
/// with what is left of the power, so that each interface conserves energy in both directions. What is absorbed
/// is absorbed along the path, not at the interface.
pub fn weakly_absorbing(n1: C64, n2: C64, cos_i: f64) -> (Coefficients, f64) {
    let real = dielectric(n1.re, n2.re, cos_i);
    if real.cos_t == 0.0 {
        let t = Pair { s: C64::ZERO, p: C64::ZERO };
        return (Coefficients { r: real.r, t }, 0.0);
    }
    // Seen from the absorbing side, reflection has the opposite sign at the same kx.
    let r = if n1.im == 0.0 {
        into_complex(n1.re, n2, cos_i)
    } else if n2.im == 0.0 {
        into_complex(n2.re, n1, real.cos_t).map(|r| -r)
    } else {
        real.r
    };
    let t = r.map(|r| C64::new((1.0 - r.norm_sqr()).sqrt(), 0.0));
    (Coefficients { r, t }, real.cos_t)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn power(d: &Dielectric) -> Pair<f64> {
        Pair { s: d.r.s.norm_sqr() + d.t.s * d.t.s, p: d.r.p.norm_sqr() + d.t.p * d.t.p }
    }

    #[test]
    fn energy_is_conserved_everywhere() {
        for (n1, n2) in [(1.0, 1.5), (1.5, 1.0), (1.33, 1.5), (1.0, 4.0), (1.5, 1.5 + 1e-12), (2.0, 1.9999)] {
            for i in 0..=1000 {
                let sum = power(&dielectric(n1, n2, f64::from(i) / 1000.0));
                assert!((sum.s - 1.0).abs() < 2e-15 && (sum.p - 1.0).abs() < 2e-15, "{n1} {n2} {i}: {sum:?}");
            }
        }
    }

    #[test]
    fn brewster_normal_and_critical() {
        let brewster = dielectric(1.0, 1.5, (1.0 / (1.0 + 1.5f64 * 1.5)).sqrt());
        assert!(brewster.r.p.norm() < 1e-16);
        let normal = dielectric(1.0, 1.5, 1.0);
        assert_eq!(normal.r.s, C64::new(-0.2, 0.0));
        assert_eq!(normal.r.p, -normal.r.s);
        let critical = (1.0 - 1.0 / 2.25f64).sqrt();
        assert_eq!(dielectric(1.5, 1.0, critical * (1.0 - 1e-12)).t.s, 0.0);
        assert!(dielectric(1.5, 1.0, critical * (1.0 + 1e-12)).t.s > 0.0);
    }

    #[test]
    fn both_directions_agree() {
        // Stokes: r' = -r, the power-normalised t is the same, angles swap. Near grazing incidence the way back
        // starts near the critical angle, where rounding of its cosine is magnified by 1/cos².
        for i in 1..=100 {
            let c = f64::from(i) / 100.0;
            let forward = dielectric(1.0, 1.7, c);
            let back = dielectric(1.7, 1.0, forward.cos_t);
            let rounding = 4e-16 / (c * c);
            assert!((forward.r.s + back.r.s).norm() < rounding && (forward.r.p + back.r.p).norm() < rounding);
            assert!((forward.t.s - back.t.s).abs() < rounding && (forward.t.p - back.t.p).abs() < rounding);
            assert!((back.cos_t - c).abs() < rounding);
        }
    }

    #[test]
    fn complex_form_contains_the_real_one() {
        for i in 0..=100 {
            let c = f64::from(i) / 100.0;
            let real = dielectric(1.0, 1.5, c).r;
            let complex = into_complex(1.0, C64::new(1.5, 0.0), c);
            assert!((real.s - complex.s).norm() < 1e-15 && (real.p - complex.p).norm() < 1e-15);
        }
    }
}
