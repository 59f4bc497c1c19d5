//! Sizes of many bodies that are not all alike.

use rand::rngs::Xoshiro256PlusPlus;
use rand::{Rng, SeedableRng};

use super::super::reader::Table;
use super::web::normal;

/// How the sizes of bodies are distributed.
#[derive(Clone, Debug, PartialEq)]
pub enum Sizes {
    /// All alike, µm.
    Equal(f64),
    /// The logarithm is normal, cut off at three standard deviations.
    LogNormal {
        /// Mean, µm (before the cut, which changes it by less than spread² / 100).
        mean: f64,
        /// Standard deviation over the mean (before the cut).
        spread: f64,
    },
    /// A few sizes, µm, each with its share of the number of bodies.
    Shares(Vec<(f64, f64)>),
}

/// Standard deviations of the logarithm after which sizes are drawn again.
const CUT: f64 = 3.0;

impl Sizes {
    /// All alike or log-normal.
    pub fn spread(mean: f64, spread: f64) -> Self {
        if spread > 0.0 { Self::LogNormal { mean, spread } } else { Self::Equal(mean) }
    }

    /// Reads `key` with `spread`.
    pub(super) fn read(t: &Table<'_>, key: &'static str, example: &str) -> Option<Self> {
        let mean = t.positive_length(key).or_else(|| t.missing_if_absent(key, example));
        let spread = read_spread(t);
        Some(Self::spread(mean?, spread?))
    }

    /// The largest there can be, µm.
    pub fn largest(&self) -> f64 {
        match self {
            Self::Equal(size) => *size,
            Self::LogNormal { mean, spread } => log_normal(*mean, *spread, CUT),
            Self::Shares(all) => all.iter().map(|(size, _)| *size).fold(0.0, f64::max),
        }
    }

    /// Mean of the n-th power, without the cut.
    pub fn mean_power(&self, n: i32) -> f64 {
        match self {
            Self::Equal(size) => size.powi(n),
            Self::LogNormal { mean, spread } => {
                mean.powi(n) * (1.0 + spread * spread).powf(0.5 * f64::from(n) * f64::from(n - 1))
            }
            Self::Shares(all) => all.iter().map(|(size, share)| share * size.powi(n)).sum(),
        }
    }

    /// One of them; of shares the first.
    pub(super) fn one(&self, rng: &mut impl Rng) -> f64 {
        match self {
            Self::Equal(size) => *size,
            Self::LogNormal { mean, spread } => log_normal(*mean, *spread, cut_normal(rng)),
            Self::Shares(all) => all[0].0,
        }
    }

    /// `count` sizes, the largest first; those given by shares come in just these shares.
    pub fn draw(&self, count: usize, seed: u64) -> Vec<f64> {
        let mut rng = random(seed);
        let mut sizes = match self {
            Self::Shares(all) => in_shares(all, count),
            _ => (0..count).map(|_| self.one(&mut rng)).collect(),
        };
        sizes.sort_by(|a, b| b.total_cmp(a));
        sizes
    }

    /// Sizes drawn until the sum of their n-th powers is as near to `sum` as can be, the largest first.
    pub fn draw_up_to(&self, sum: f64, n: i32, seed: u64) -> Vec<f64> {
        if !matches!(self, Self::LogNormal { .. }) {
            return self.draw((sum / self.mean_power(n)).round() as usize, seed);
        }
        let mut rng = random(seed);
        let (mut sizes, mut reached) = (Vec::new(), 0.0);
        loop {
            let next = self.one(&mut rng).powi(n);
            if reached + 0.5 * next > sum {
                break;
            }
            reached += next;
            sizes.push(next.powf(1.0 / f64::from(n)));
        }
        sizes.sort_by(|a, b| b.total_cmp(a));
        sizes
    }
}

/// Numbers apart from those that places are drawn with.
fn random(seed: u64) -> Xoshiro256PlusPlus {
    Xoshiro256PlusPlus::seed_from_u64(seed ^ 0x5151_5151)
}

/// `spread`, 0 if it is not given.
pub(super) fn read_spread(t: &Table<'_>) -> Option<f64> {
    let Some(spread) = t.number("spread") else { return t.get("spread").is_none().then_some(0.0) };
    if (0.0..=1.0).contains(&spread) {
        return Some(spread);
    }
    let message = format!("spread = {spread}: expected the standard deviation over the mean, 0 to 1");
    t.source().note(t.place_of("spread").problem(message));
    None
}

fn log_normal(mean: f64, spread: f64, deviations: f64) -> f64 {
    let variance = (spread * spread).ln_1p();
    mean * (variance.sqrt() * deviations - 0.5 * variance).exp()
}

fn cut_normal(rng: &mut impl Rng) -> f64 {
    loop {
        let x = normal(rng);
        if x.abs() <= CUT {
            return x;
        }
    }
}

/// Each size as often as its share says, to within rounding of the running sum.
fn in_shares(all: &[(f64, f64)], count: usize) -> Vec<f64> {
    let (mut sum, mut sizes) = (0.0, Vec::with_capacity(count));
    for (i, (size, share)) in all.iter().enumerate() {
        sum += share;
        let up_to = if i + 1 == all.len() { count } else { (sum * count as f64).round() as usize };
        sizes.resize(up_to.clamp(sizes.len(), count), *size);
    }
    sizes
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 20,000 sizes: 4.5 standard errors are a false alarm in 7 of a million tests.
    #[test]
    fn mean_and_spread_are_as_asked() {
        for spread in [0.05, 0.3] {
            let sizes = Sizes::spread(2.0, spread);
            let all = sizes.draw(20_000, 3);
            let n = all.len() as f64;
            let mean = all.iter().sum::<f64>() / n;
            let deviation = (all.iter().map(|s| (s - mean).powi(2)).sum::<f64>() / n).sqrt();
            let slack = 0.01 * spread * spread;
            assert!((mean / 2.0 - 1.0).abs() < 4.5 * spread / n.sqrt() + slack, "{mean}");
            // The cut takes 1.3 % of a normal variance, more of a skew one.
            assert!((0.93..1.02).contains(&(deviation / mean / spread)), "{deviation}");
            assert!(all[0] <= sizes.largest() && all.is_sorted_by(|a, b| a >= b));
            let cubes = all.iter().map(|s| s.powi(3)).sum::<f64>() / n;
            assert!((cubes / sizes.mean_power(3) - 1.0).abs() < 0.06, "{cubes}");
        }
    }

    #[test]
    fn shares_are_exact() {
        let sizes = Sizes::Shares(vec![(1.0, 0.25), (3.0, 0.75)]);
        let all = sizes.draw(8, 1);
        assert_eq!(all, [3.0, 3.0, 3.0, 3.0, 3.0, 3.0, 1.0, 1.0]);
        assert_eq!(sizes.mean_power(2), 7.0);
    }

    #[test]
    fn sums_are_met() {
        let sizes = Sizes::spread(1.0, 0.3);
        let all = sizes.draw_up_to(500.0, 3, 9);
        let sum = all.iter().map(|r| r.powi(3)).sum::<f64>();
        assert!((sum - 500.0).abs() < sizes.largest().powi(3), "{sum}");
    }
}
