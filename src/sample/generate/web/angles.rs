//! Directions of fibres about the machine direction.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI, TAU};

use rand::{Rng, RngExt};

/// How far fibres deviate from the machine direction, x.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Deviation {
    /// By this angle in the mean, without its sign, radians: less than π/4.
    Mean(f64),
    /// At random: all directions in the plane alike. The mean is π/4.
    Random,
}

/// Directions drawn one by one.
///
/// A fibre has no sense, so its deviation lies within ±π/2. It is distributed normally, cut off there; the standard
/// deviation before the cut is such that the mean of |deviation| is exactly what was asked for.
pub(super) enum Angles {
    Normal { sigma: f64 },
    Uniform,
}

impl Angles {
    pub fn new(deviation: Deviation) -> Self {
        match deviation {
            Deviation::Mean(mean) => Self::Normal { sigma: sigma_of(mean) },
            Deviation::Random => Self::Uniform,
        }
    }

    pub fn draw(&self, rng: &mut impl Rng) -> f64 {
        match *self {
            Self::Uniform => PI * (rng.random::<f64>() - 0.5),
            Self::Normal { sigma } => loop {
                let angle = sigma * normal(rng);
                if angle.abs() <= FRAC_PI_2 {
                    return angle;
                }
            },
        }
    }
}

/// A number of the standard normal distribution (Box and Muller 1958).
pub fn normal(rng: &mut impl Rng) -> f64 {
    let (u, v): (f64, f64) = (rng.random(), rng.random());
    (-2.0 * (1.0 - u).ln()).sqrt() * (TAU * v).cos()
}

/// The standard deviation whose cut normal distribution has this mean deviation.
fn sigma_of(mean: f64) -> f64 {
    // Without the cut it would be so much; the cut only lowers the mean.
    let mut low = mean * FRAC_PI_2.sqrt();
    let mut high = low.max(1e-3);
    if mean <= 0.0 {
        return 0.0;
    }
    while mean_of(high) < mean && high < 1e3 {
        high *= 2.0;
    }
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if mean_of(middle) < mean {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// Mean of |x| for a normal distribution cut off at ±π/2, by Simpson's rule.
fn mean_of(sigma: f64) -> f64 {
    let end = FRAC_PI_2.min(12.0 * sigma);
    let steps = 512;
    let weight = |i: usize| if i == 0 || i == steps { 1.0 } else { [2.0, 4.0][i % 2] };
    let at = |i: usize| end * i as f64 / steps as f64;
    let density = |i: usize| weight(i) * (-0.5 * (at(i) / sigma).powi(2)).exp();
    let (sum, norm) = (0..=steps).fold((0.0, 0.0), |(s, n), i| (s + at(i) * density(i), n + density(i)));
    sum / norm
}

/// Largest mean deviation that can be asked for, short of all directions alike.
pub(super) const LARGEST: f64 = 0.98 * FRAC_PI_4;

#[cfg(test)]
mod tests {
    use rand::SeedableRng;
    use rand::rngs::Xoshiro256PlusPlus;

    use super::*;

    /// 20,000 angles each: a mean off by more than 4.5 standard errors is a false alarm in 7 of a million tests.
    #[test]
    fn the_mean_deviation_is_as_asked() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(12);
        let asked = [0.001_f64, 5.0, 15.0, 30.0, 40.0, 44.0].map(f64::to_radians);
        let asked = asked.map(|mean| (Deviation::Mean(mean), mean)).into_iter().chain([(Deviation::Random, FRAC_PI_4)]);
        for (deviation, mean) in asked {
            let angles = Angles::new(deviation);
            let all: Vec<f64> = (0..20_000).map(|_| angles.draw(&mut rng)).collect();
            let n = all.len() as f64;
            let found = all.iter().map(|a| a.abs()).sum::<f64>() / n;
            let variance = all.iter().map(|a| (a.abs() - found).powi(2)).sum::<f64>() / n;
            assert!((found - mean).abs() < 4.5 * (variance / n).sqrt(), "{deviation:?}: {found}");
            let skew = all.iter().sum::<f64>() / n;
            assert!(
                skew.abs() < 4.5 * (all.iter().map(|a| a * a).sum::<f64>() / n / n).sqrt(),
                "{deviation:?}: {skew}"
            );
        }
        assert_eq!(Angles::new(Deviation::Mean(0.0)).draw(&mut rng).abs(), 0.0);
    }

    #[test]
    fn a_narrow_distribution_is_the_normal_one() {
        let mean = 0.1;
        assert!((sigma_of(mean) / (mean * FRAC_PI_2.sqrt()) - 1.0).abs() < 1e-9);
        assert!(sigma_of(LARGEST).is_finite());
    }
}
