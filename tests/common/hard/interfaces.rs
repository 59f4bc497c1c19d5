//! One interface, by Fresnel's formulas.

use std::f64::consts::PI;

use gonio_embree::optics::film::{Incidence, solve};
use gonio_embree::optics::fresnel::{Dielectric, dielectric, other_leg};
use num_complex::Complex;

use super::twin::{Answer32, Stack32};
use super::{Case, worst};

const N: f64 = 1.5;
const SINES: &str = "Fresnel by sines, angle by acos";

pub fn all() -> Vec<Case> {
    let angles = [("0°", 0.0), ("1e-9°", 1e-9), ("89.999°", 89.999)];
    let into_glass = angles.into_iter().flat_map(|(name, deg)| [false, true].map(|p| through(name, deg, p)));
    into_glass
        .chain([
            brewster(),
            reflection_of_nearly_equal(),
            critical(-1e-12),
            critical(1e-12),
            tangential(-1e-12),
            tangential(1e-12),
        ])
        .collect()
}

/// Cosine and sine of an angle, the cosine from that to the horizon.
fn legs(deg: f64) -> (f64, f64) {
    let cos = if deg > 45.0 { ((90.0 - deg) * PI / 180.0).sin() } else { deg.to_radians().cos() };
    (cos, deg.to_radians().sin())
}

fn single(n1: f64, n2: f64, cos: f64, sin: f64, p: bool) -> Answer32 {
    let (first, last) = (n1 as f32, Complex::from(n2 as f32));
    Stack32 { first, cos: cos as f32, sin: sin as f32, layers: vec![], last, wavelength: 1.0, p }.solve()
}

fn transmitted(at: &Dielectric, p: bool) -> f64 {
    match at {
        Dielectric::Partial(d) => {
            if p {
                d.t_powers().0.p
            } else {
                d.t_powers().0.s
            }
        }
        Dielectric::Total(_) => 0.0,
    }
}

/// r_s = −sin(i − t)/sin(i + t), r_p = tan(i − t)/tan(i + t).
fn by_sines(n: f64, cos: f64, p: bool) -> f64 {
    let i = cos.acos();
    let t = (i.sin() / n).asin();
    if p { (i - t).tan() / (i + t).tan() } else { -(i - t).sin() / (i + t).sin() }
}

/// Into glass: T = 4ab/(a + b)² with a = cos θ, b = √(n² − sin² θ) (s), or a = n² cos θ (p).
fn through(name: &str, deg: f64, p: bool) -> Case {
    let (cos, sin) = legs(deg);
    let behind = (N * N - 1.0 + cos * cos).sqrt();
    let a = if p { N * N * cos } else { cos };
    let truth = 4.0 * a * behind / (a + behind).powi(2);
    let of = if p { "T of p" } else { "T of s" };
    Case::new(format!("into glass at {name}"), of, truth, transmitted(&dielectric(1.0, N, cos, sin), p), 1e-14)
        .relative()
        .single(single(1.0, N, cos, sin, p).transmitted)
        .naive(SINES, 1.0 - by_sines(N, cos, p).powi(2))
}

/// Indices from 1.01 to 4, into glass and out of it. Out of n = 4 r_p has a slope of (n⁴ − 1)/2n = 32 per radian there, and
/// half a unit in the last place of the cosine, 5.5e-17, is 2.3e-16 rad: that makes 7e-15 of it.
fn brewster() -> Case {
    let indices = (1..=299).map(|i| 1.0 + 0.01 * f64::from(i)).flat_map(|n| [(1.0, n), (n, 1.0)]);
    let r = indices.map(|(n1, n2)| {
        let hypotenuse = f64::hypot(n1, n2);
        let (cos, sin) = (n1 / hypotenuse, n2 / hypotenuse);
        let ours = dielectric(n1, n2, cos, sin).r().p.norm();
        [ours, single(n1, n2, cos, sin, true).r.norm().into(), by_sines(n2 / n1, cos, true)]
    });
    let r: Vec<[f64; 3]> = r.collect();
    let [ours, single, naive] = [0, 1, 2].map(|i| worst(r.iter().map(|r| r[i])));
    Case::new("Brewster's angle, n from 1.01 to 4", "r_p", 0.0, ours, 8e-15).single(single).naive(SINES, naive)
}

/// r_s of n = 1.5 and the next number up by 1e-13, at 60°: (n₁ − n₂)(n₁ + n₂)/(q₁ + q₂)² to first order, −Δn/(2n cos² θ).
fn reflection_of_nearly_equal() -> Case {
    let (cos, sin) = (0.5, 0.75f64.sqrt());
    let next = N + 1e-13;
    let truth = -(next - N) / (2.0 * N * cos * cos);
    let sin2 = N * sin / next;
    let (a, b) = (N * cos, next * (1.0 - sin2 * sin2).sqrt());
    Case::new("indices 1e-13 apart, 60°", "r_s", truth, dielectric(N, next, cos, sin).r().s.re, 1e-11)
        .relative()
        .single(single(N, next, cos, sin, false).r.re.into())
        .naive("(q₁ − q₂)/(q₁ + q₂)", (a - b) / (a + b))
}

/// Out of glass near the critical angle: T_s = 4ab/(a + b)² with b² = 1 − n² sin² θ = n² sin(c − θ) sin(c + θ).
///
/// Light comes with its cosine, of which half a unit in the last place moves the angle by 7e-17 and so b², which is 2e-12, by
/// 1e-4 of itself: no program that is told cos θ in double precision knows T to better than 1e-4.
fn critical(beyond: f64) -> Case {
    let critical = (1.0 / N).asin();
    // The cosine of the critical angle is √(1 − 1/n²); one more term turns it.
    let (sin_c, cos_c) = (1.0 / N, (1.0 - 1.0 / (N * N)).sqrt());
    let cos = cos_c - beyond * sin_c;
    let a = N * cos;
    let b = (N * N * (-beyond).max(0.0) * (2.0 * critical + beyond).sin()).sqrt();
    let truth = 4.0 * a * b / (a + b).powi(2);
    let (name, bound) = if beyond > 0.0 { ("beyond", 0.0) } else { ("before", 2e-4) };
    let ours = transmitted(&dielectric(N, 1.0, cos, other_leg(cos)), false);
    let case = Case::new(format!("out of glass, {name} the critical angle by 1e-12"), "T of s", truth, ours, bound)
        .single(single(N, 1.0, cos, other_leg(cos), false).transmitted)
        .naive(SINES, 1.0 - by_sines(1.0 / N, cos, false).powi(2));
    if truth > 0.0 { case.relative() } else { case }
}

/// From n = 1.5 into 1.37 with a tangential wave number of 1.37 but for 1e-12 of it, which subtraction tells exactly: b² = n² − kₓ²
/// as a product, a² likewise. Before T = 4ab/(a + b)², beyond arg r = −2 atan(|b|/a).
fn tangential(beyond: f64) -> Case {
    let (n1, n2) = (N, 1.37f64);
    let kx = n2 * (1.0 + beyond);
    let (a, b2) = (((n1 - kx) * (n1 + kx)).sqrt(), (n2 - kx) * (n2 + kx));
    let b = b2.abs().sqrt();
    let ours = solve(&Incidence::from_kx(n1, kx), &[], n2.into(), 1.0).s;
    let (sin, cos) = (kx / n1, a / n1);
    let single = single(n1, n2, cos, sin, false);
    let textbook = (n2 * n2 - kx * kx).abs().sqrt();
    let form = "√(n² − kₓ²)";
    if beyond < 0.0 {
        let t = |b: f64| 4.0 * a * b / (a + b).powi(2);
        return Case::new("1.5 to 1.37, kₓ before critical by 1e-12", "T of s", t(b), ours.transmittance(), 1e-14)
            .relative()
            .single(single.transmitted)
            .naive(form, t(textbook));
    }
    let phase = |b: f64| -2.0 * (b / a).atan();
    Case::new("1.5 to 1.37, kₓ beyond critical by 1e-12", "phase of r_s, rad", phase(b), ours.r.arg(), 1e-14)
        .relative()
        .single(single.r.arg().into())
        .naive(form, phase(textbook))
}
