//! What a ray carries per wavelength, in its own frame (x̂, ŷ = k̂ × x̂) and normalised to power, and what an interface
//! does to it: from a mere power to a Mueller matrix.
//!
//! The choice is the plan's. All kinds go the same ways, but for [`Power`], which knows no polarization: with it an
//! interface divides light by the mean of what it does to s and to p.

mod jones;
mod mueller;
mod power;
mod stokes;

pub use jones::{Amplitudes, Jones};
pub use mueller::Mueller;
pub use power::{Power, Range};
pub use stokes::{Powers, Stokes};

use pulp::Simd;

use super::fresnel::{Dielectric, Refracted};
use super::lanes::{Lanes, Number};
use super::{C64, Pair};

/// Something made of a fixed count of numbers, which lie apart from each other where many of its kind are kept.
///
/// None of this is done by closures: those are not compiled for the registers of the processor.
pub trait Parts<T: Number>: Copy {
    /// How many.
    const PARTS: usize;

    /// From its numbers, in order.
    fn from_parts(parts: &[T]) -> Self;

    /// Writes its numbers, in order.
    fn write(&self, to: &mut [T]);
}

/// Nothing has more parts.
pub const MOST_PARTS: usize = 16;

/// What lies at lane `at` of a list of all first numbers, then all second ones, and so on, `apart` of each.
#[inline(always)]
pub fn gather<P: Parts<f64>>(from: &[f64], at: usize, apart: usize) -> P {
    let mut parts = [0.0; MOST_PARTS];
    for i in 0..P::PARTS {
        parts[i] = from[i * apart + at];
    }
    P::from_parts(&parts)
}

/// Writes to where [`gather`] reads.
#[inline(always)]
pub fn scatter<P: Parts<f64>>(what: &P, to: &mut [f64], at: usize, apart: usize) {
    let mut parts = [0.0; MOST_PARTS];
    what.write(&mut parts);
    for i in 0..P::PARTS {
        to[i * apart + at] = parts[i];
    }
}

/// The same as [`gather`] for a whole block of lanes.
#[inline(always)]
pub fn load<S: Simd, P: Parts<Lanes<S>>>(s: S, from: &[f64], block: usize, apart: usize) -> P {
    let mut parts = [Lanes::splat(s, 0.0); MOST_PARTS];
    for i in 0..P::PARTS {
        parts[i] = Lanes::load(s, &from[i * apart..(i + 1) * apart], block);
    }
    P::from_parts(&parts)
}

/// Writes to where [`load`] reads.
#[inline(always)]
pub fn store<S: Simd, P: Parts<Lanes<S>>>(s: S, what: &P, to: &mut [f64], block: usize, apart: usize) {
    let mut parts = [Lanes::splat(s, 0.0); MOST_PARTS];
    what.write(&mut parts);
    for i in 0..P::PARTS {
        parts[i].store(&mut to[i * apart..(i + 1) * apart], block);
    }
}

/// The same for a whole block of lanes.
#[inline(always)]
pub fn splat<S: Simd, P: Parts<f64>, W: Parts<Lanes<S>>>(s: S, what: &P) -> W {
    let mut parts = [0.0; MOST_PARTS];
    what.write(&mut parts);
    let mut wide = [Lanes::splat(s, 0.0); MOST_PARTS];
    for i in 0..W::PARTS {
        wide[i] = Lanes::splat(s, parts[i]);
    }
    W::from_parts(&wide)
}

/// The state of light on a ray: at one wavelength, or at several side by side.
pub trait State<T: Number>: Parts<T> {
    /// What reflection, or transmission, at an interface does to this kind of state.
    type Passage: Shares<T>;

    /// Power along x̂ and along ŷ.
    fn powers(&self) -> [T; 2];

    /// All power.
    #[inline(always)]
    fn power(&self) -> T {
        let [x, y] = self.powers();
        x + y
    }

    /// The same light in the frame whose x̂ is cos·x̂ + sin·ŷ.
    #[must_use]
    fn rotated(&self, cos: f64, sin: f64) -> Self;

    /// The light behind an interface whose plane of incidence is spanned by x̂: x̂ is p, ŷ is s.
    #[must_use]
    fn times(&self, by: &Self::Passage) -> Self;

    /// The light with its power multiplied.
    #[must_use]
    fn scaled(&self, power: T) -> Self;
}

/// The state of light on a ray at one wavelength.
pub trait Field: State<f64, Passage: Passage> + Send + Sync + std::fmt::Debug + 'static {
    /// The same kind of state at several wavelengths.
    type Of<T: Number>: State<T>;

    /// How many numbers tell of light that has left: its power first.
    const COMPONENTS: usize;

    /// Light of this Stokes vector (I, Q, U, V), x̂ along p.
    fn incident(stokes: [f64; 4]) -> Self;

    /// The same power, unpolarized, times `share`: what a matt surface leaves.
    #[must_use]
    fn depolarized(&self, share: f64) -> Self;

    /// Adds the numbers that tell of this light to `out`.
    #[inline]
    fn add_to(&self, out: &mut [f64]) {
        out[0] += self.power();
    }
}

/// What one of the two beams of an interface gets.
pub trait Shares<T: Number>: Parts<T> {
    /// Shares of the power that s and p light have in this beam.
    fn shares(&self) -> Pair<T>;
}

/// One of the two beams of an interface, at one wavelength.
pub trait Passage: Shares<f64> + Send + Sync + std::fmt::Debug + 'static {
    /// From power-normalised amplitude coefficients.
    fn new(amplitudes: Pair<C64>) -> Self;

    /// Reflection at an interface between transparent media.
    fn reflection(d: &Dielectric) -> Self;

    /// Transmission through one.
    fn transmission(d: &Refracted) -> Self;
}

#[cfg(test)]
mod tests {
    use rand::rngs::Xoshiro256PlusPlus;
    use rand::{RngExt, SeedableRng};

    use super::super::fresnel::dielectric;
    use super::*;

    #[test]
    fn interfaces_act_alike_on_all() {
        for (n1, n2) in [(1.0, 1.5), (1.5, 1.0)] {
            for i in 1..50 {
                let cos: f64 = f64::from(i) / 50.0;
                let d = dielectric(n1, n2, cos, ((1.0 - cos) * (1.0 + cos)).sqrt());
                let same = |a: Powers, b: Amplitudes| {
                    let b = Powers::new(b.pair());
                    assert!((a.shares().s - b.shares().s).abs() < 1e-15 && (a.shares().p - b.shares().p).abs() < 1e-15);
                    assert!((a.cross() - b.cross()).norm() < 1e-15);
                };
                same(Powers::reflection(&d), Amplitudes::reflection(&d));
                if let Dielectric::Partial(t) = d {
                    same(Powers::transmission(&t), Amplitudes::transmission(&t));
                }
            }
        }
    }

    /// Random numbers between −1 and 1.
    fn numbers() -> impl FnMut() -> f64 {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(4);
        move || 2.0 * rng.random::<f64>() - 1.0
    }

    #[test]
    fn stokes_and_mueller_follow_jones() {
        let mut number = numbers();
        for start in [[1.0, 0.0, 0.0, 0.0], [1.0, 1.0, 0.0, 0.0], [1.0, -1.0, 0.0, 0.0], [1.0, 0.3, -0.5, 0.7]] {
            let (mut jones, mut stokes) = (Jones::incident(start), Stokes::incident(start));
            let mut mueller = Mueller::incident([1.0, 0.0, 0.0, 0.0]);
            for _ in 0..20 {
                let angle: f64 = 3.0 * number();
                let by = Pair { s: C64::new(number(), number()), p: C64::new(number(), number()) };
                jones = jones.rotated(angle.cos(), angle.sin()).times(&Amplitudes::new(by));
                stokes = stokes.rotated(angle.cos(), angle.sin()).times(&Powers::new(by));
                mueller = mueller.rotated(angle.cos(), angle.sin()).times(&Powers::new(by));
                let scale = 1.0 / jones.power();
                (jones, stokes, mueller) = (jones.scaled(scale), stokes.scaled(scale), mueller.scaled(scale));
                let same = Stokes::from(jones);
                let product = mueller.applied_to(start);
                for (a, b, c) in
                    [(same.i, stokes.i, 0), (same.q, stokes.q, 1), (same.u, stokes.u, 2), (same.v, stokes.v, 3)]
                {
                    assert!((a - b).abs() < 1e-12 && (a - product[c]).abs() < 1e-12, "{same:?} {stokes:?} {product:?}");
                }
                assert!((jones.powers()[0] - stokes.powers()[0]).abs() < 1e-12);
            }
        }
    }

    /// The bound of what polarization does to the power: for light of any state, and chains of interfaces whose planes of
    /// incidence have any position, the power without it is off by no more.
    #[test]
    fn polarization_stays_within_its_range() {
        let mut number = numbers();
        for i in 0..3000 {
            let [q, u, v] = [number(), number(), number()];
            let part = f64::from(i % 3) / 2.0 / (q * q + u * u + v * v).sqrt();
            let light = [1.0, part * q, part * u, part * v];
            let (mut stokes, mut range) = (Stokes::incident(light), Range::incident(light));
            for _ in 0..6 {
                let angle: f64 = 3.0 * number();
                let by = Powers::new(Pair { s: C64::new(number(), number()), p: C64::new(number(), number()) });
                stokes = stokes.rotated(angle.cos(), angle.sin()).times(&by);
                range = range.rotated(angle.cos(), angle.sin()).times(&by);
                let off = (stokes.i / range.power() - 1.0).abs();
                assert!(off <= range.most() + 1e-12, "{off} {range:?}");
            }
        }
    }
}
