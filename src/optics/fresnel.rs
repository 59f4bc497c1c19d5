//! One plane interface.

use std::hint::select_unpredictable;

use super::{C64, Coefficients, Pair, outgoing_root};

/// What the interface between two transparent media does to light from the first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Dielectric {
    /// Part of it is refracted.
    Partial(Refracted),
    /// Total reflection: amplitude coefficients of modulus 1.
    Total(Pair<C64>),
}

/// Fresnel's formulas, with what they share: q = n cos θ on both sides.
///
/// Reflection in the form of differences of squares, r_s = (n₁²−n₂²)/(q₁+q₂)², r_p =
/// (n₂²−n₁²)(n₂²q₁²−n₁²kₓ²)/(n₂²q₁+n₁²q₂)², which is relatively accurate for nearly equal indices, too (Born & Wolf,
/// *Principles of Optics*, 7th ed., §1.5.2, rearranged).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Refracted {
    r: Pair<f64>,
    /// q₁q₂ and n₁n₂.
    product: f64,
    index_product: f64,
    /// 1/(q₁+q₂) and 1/(n₂²q₁+n₁²q₂).
    per: Pair<f64>,
    /// Index before over index behind.
    pub ratio: f64,
    /// Cosine of the angle of refraction.
    pub cos: f64,
}

impl Refracted {
    /// Amplitude reflection coefficients.
    #[inline]
    pub fn r(&self) -> Pair<f64> {
        self.r
    }

    /// Power-normalised amplitude transmission coefficients, t √(q₂/q₁): the same seen from both sides.
    pub fn t(&self) -> Pair<f64> {
        let common = 2.0 * self.product.sqrt();
        Pair { s: common * self.per.s, p: common * self.index_product * self.per.p }
    }

    /// Their squares, and their product.
    #[inline]
    pub fn t_powers(&self) -> (Pair<f64>, f64) {
        let (s, p) = (self.per.s, self.index_product * self.per.p);
        let common = 4.0 * self.product;
        (Pair { s: common * s * s, p: common * p * p }, common * s * p)
    }
}

impl Dielectric {
    /// Amplitude reflection coefficients.
    pub fn r(&self) -> Pair<C64> {
        match self {
            Self::Partial(d) => d.r.map(C64::from),
            Self::Total(r) => *r,
        }
    }
}

/// (n₂ cos θ₂)² without cancellation: near grazing incidence from the difference of the squares of the indices,
/// else from the tangential wave number.
#[inline]
fn normal_index_squared(n1: f64, n2: f64, cos: f64, sin: f64) -> f64 {
    let (q1, kx) = (n1 * cos, n1 * sin);
    let (by_indices, by_wave_number) = ((n2 - n1) * (n2 + n1) + q1 * q1, (n2 - kx) * (n2 + kx));
    select_unpredictable(cos * cos < 0.5, by_indices, by_wave_number)
}

/// Cosine of the angle of refraction; `None` in total reflection.
pub fn refracted_cos(n1: f64, n2: f64, cos: f64, sin: f64) -> Option<f64> {
    let q2_squared = normal_index_squared(n1, n2, cos, sin);
    (q2_squared > 0.0).then(|| q2_squared.sqrt() / n2)
}

/// √(1 − c²), accurate at both ends.
#[inline]
pub fn other_leg(c: f64) -> f64 {
    ((1.0 - c) * (1.0 + c)).sqrt()
}

/// The interface between media of real index, for light at an angle of incidence given by its cosine and sine.
#[inline]
pub fn dielectric(n1: f64, n2: f64, cos: f64, sin: f64) -> Dielectric {
    let q1 = n1 * cos;
    let q2_squared = normal_index_squared(n1, n2, cos, sin);
    let (n1_2, n2_2) = (n1 * n1, n2 * n2);
    if q2_squared <= 0.0 {
        return Dielectric::Total(total_reflection(q1, (-q2_squared).sqrt(), n2_2 / n1_2));
    }
    let q2 = q2_squared.sqrt();
    let kx_squared = n1_2 * (sin * sin);
    let difference = (n1 - n2) * (n1 + n2);
    let per = Pair { s: 1.0 / (q1 + q2), p: 1.0 / (n2_2 * q1 + n1_2 * q2) };
    let per_n2 = 1.0 / n2;
    let r =
        Pair { s: difference * per.s * per.s, p: -difference * (n2_2 * q1 * q1 - n1_2 * kx_squared) * per.p * per.p };
    Dielectric::Partial(Refracted {
        r,
        product: q1 * q2,
        index_product: n1 * n2,
        per,
        ratio: n1 * per_n2,
        cos: q2 * per_n2,
    })
}

/// r = (q₁ − iκ)/(q₁ + iκ), for p with κ n₁²/n₂² in place of κ and the sign of p.
#[cold]
fn total_reflection(q1: f64, decay: f64, ratio: f64) -> Pair<C64> {
    let phase = |q: f64, k: f64| {
        let norm = q * q + k * k;
        if norm == 0.0 { C64::new(1.0, 0.0) } else { C64::new((q - k) * (q + k), -2.0 * q * k) / norm }
    };
    Pair { s: phase(q1, decay), p: phase(ratio * q1, decay) }
}

/// Amplitude reflection coefficients of an interface into a medium of complex index (a metal, an absorber), met
/// from a transparent one.
pub fn into_complex(n1: f64, n2: C64, cos: f64, sin: f64) -> Pair<C64> {
    let (q1, kx) = (n1 * cos, n1 * sin);
    let q2 = outgoing_root((n2 - kx) * (n2 + kx));
    let (n1_2, n2_2) = (n1 * n1, n2 * n2);
    let difference = (n2 - n1) * (n2 + n1);
    let (sum_s, sum_p) = (q2 + q1, n2_2 * q1 + n1_2 * q2);
    Pair { s: -difference / (sum_s * sum_s), p: difference * (n2_2 * q1 * q1 - n1_2 * kx * kx) / (sum_p * sum_p) }
}

/// Coefficients of an interface between weakly absorbing media: reflection as for complex indices, transmission
/// with what is left of the power, so that each interface conserves energy in both directions. What is absorbed
/// is absorbed along the path, not at the interface.
pub fn weakly_absorbing(n1: C64, n2: C64, cos: f64, sin: f64) -> Coefficients {
    let d = match dielectric(n1.re, n2.re, cos, sin) {
        Dielectric::Total(r) => return Coefficients { r, t: Pair { s: C64::ZERO, p: C64::ZERO } },
        Dielectric::Partial(d) => d,
    };
    let r = if n1.im == 0.0 {
        into_complex(n1.re, n2, cos, sin)
    } else if n2.im == 0.0 {
        // Seen from the absorbing side, reflection has the opposite sign at the same kx.
        into_complex(n2.re, n1, d.cos, other_leg(d.cos)).map(|r| -r)
    } else {
        d.r.map(C64::from)
    };
    Coefficients { r, t: r.map(|r| C64::new((1.0 - r.norm_sqr()).sqrt(), 0.0)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(n1: f64, n2: f64, cos: f64) -> Dielectric {
        dielectric(n1, n2, cos, other_leg(cos))
    }

    fn refracted(n1: f64, n2: f64, cos: f64) -> Refracted {
        match at(n1, n2, cos) {
            Dielectric::Partial(d) => d,
            Dielectric::Total(_) => panic!("total reflection"),
        }
    }

    #[test]
    fn energy_is_conserved_everywhere() {
        for (n1, n2) in [(1.0, 1.5), (1.5, 1.0), (1.33, 1.5), (1.0, 4.0), (1.5, 1.5 + 1e-12), (2.0, 1.9999)] {
            for i in 0..=1000 {
                let d = at(n1, n2, f64::from(i) / 1000.0);
                let t = if let Dielectric::Partial(d) = d { d.t_powers().0 } else { Pair { s: 0.0, p: 0.0 } };
                let (s, p) = (d.r().s.norm_sqr() + t.s, d.r().p.norm_sqr() + t.p);
                assert!((s - 1.0).abs() < 2e-15 && (p - 1.0).abs() < 2e-15, "{n1} {n2} {i}: {s} {p}");
            }
        }
    }

    #[test]
    fn brewster_normal_and_critical() {
        let brewster = refracted(1.0, 1.5, (1.0 / (1.0 + 1.5f64 * 1.5)).sqrt());
        assert!(brewster.r.p.abs() < 1e-16);
        let normal = refracted(1.0, 1.5, 1.0);
        assert!((normal.r.s + 0.2).abs() < 1e-16);
        assert_eq!(normal.r.p, -normal.r.s);
        let critical = (1.0 - 1.0 / 2.25f64).sqrt();
        assert!(matches!(at(1.5, 1.0, critical * (1.0 - 1e-12)), Dielectric::Total(_)));
        assert!(refracted(1.5, 1.0, critical * (1.0 + 1e-12)).t().s > 0.0);
    }

    #[test]
    fn both_directions_agree() {
        // Stokes: r' = -r, the power-normalised t is the same, angles swap. Near grazing incidence the way back
        // starts near the critical angle, where rounding of its cosine is magnified by 1/cos².
        for i in 1..=100 {
            let c = f64::from(i) / 100.0;
            let forward = refracted(1.0, 1.7, c);
            let back = refracted(1.7, 1.0, forward.cos);
            let rounding = 4e-16 / (c * c);
            let (t, u) = (forward.t(), back.t());
            assert!((forward.r.s + back.r.s).abs() < rounding && (forward.r.p + back.r.p).abs() < rounding);
            assert!((t.s - u.s).abs() < rounding && (t.p - u.p).abs() < rounding);
            assert!((back.cos - c).abs() < rounding);
        }
    }

    #[test]
    fn complex_form_contains_the_real_one() {
        for i in 0..=100 {
            let c = f64::from(i) / 100.0;
            let real = at(1.0, 1.5, c).r();
            let complex = into_complex(1.0, C64::new(1.5, 0.0), c, other_leg(c));
            assert!((real.s - complex.s).norm() < 1e-15 && (real.p - complex.p).norm() < 1e-15);
        }
    }

    #[test]
    fn total_reflection_has_the_sign_of_the_complex_form() {
        // The same interface as a limit of a complex index.
        for cos in [0.1, 0.4, 0.7] {
            let total = at(1.5, 1.0, cos).r();
            let complex = into_complex(1.5, C64::new(1.0, 1e-300), cos, other_leg(cos));
            assert!((total.s - complex.s).norm() < 1e-14 && (total.p - complex.p).norm() < 1e-14);
        }
    }
}
