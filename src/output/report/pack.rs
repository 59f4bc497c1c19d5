//! Numbers as short text: logarithmic codes, and bytes as base64.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;
use serde::Serialize;

/// Positive numbers by the nearest step of a logarithmic scale: code 0 is no light (0, or less), codes 1 to `count` are
/// `least · exp(step · (code − 1))`, and the one after them stands for what is not a number.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Codes {
    /// The least positive number.
    pub least: f64,
    /// Logarithm of the ratio of neighbours.
    pub step: f64,
    /// Codes of positive numbers.
    pub count: u32,
}

impl Codes {
    /// A scale from the least to the greatest positive one of `numbers`.
    pub fn over(numbers: impl Iterator<Item = f64>, count: u32) -> Self {
        let positive = numbers.filter(|x| *x > 0.0 && x.is_finite());
        let (least, most) = positive.fold((f64::INFINITY, 0.0), |(a, b), x| (f64::min(a, x), f64::max(b, x)));
        if most == 0.0 {
            return Self { least: 1.0, step: 0.0, count };
        }
        Self { least, step: (most / least).ln() / f64::from(count - 1), count }
    }

    /// The code of a number; those beyond the scale get its ends.
    pub fn code(&self, x: f64) -> u32 {
        if !x.is_finite() {
            return self.count + 1;
        }
        if x <= 0.0 {
            return 0;
        }
        if self.step == 0.0 {
            return 1;
        }
        let steps = ((x / self.least).ln() / self.step).round();
        1 + steps.clamp(0.0, f64::from(self.count - 1)) as u32
    }

    /// The number of a code, as the page takes it.
    #[cfg(test)]
    pub fn number(&self, code: u32) -> f64 {
        match code {
            0 => 0.0,
            c if c > self.count => f64::NAN,
            c => self.least * (self.step * f64::from(c - 1)).exp(),
        }
    }

    /// Largest relative error of a number within the scale.
    pub fn error(&self) -> f64 {
        (0.5 * self.step).exp() - 1.0
    }
}

/// Bytes as base64.
pub fn base64(bytes: impl IntoIterator<Item = u8>) -> String {
    STANDARD.encode(bytes.into_iter().collect::<Vec<_>>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn codes_are_within_their_error() {
        let numbers: Vec<f64> = (0..1000).map(|i| 1e-9 * 1.03f64.powi(i)).collect();
        for count in [253, 65_534] {
            let codes = Codes::over(numbers.iter().copied(), count);
            for &x in &numbers {
                let back = codes.number(codes.code(x));
                assert!((back / x - 1.0).abs() <= codes.error() * (1.0 + 1e-9), "{x} {back}");
            }
            assert_eq!((codes.code(numbers[0]), codes.code(numbers[999])), (1, count));
            assert_eq!((codes.code(1e-30), codes.code(1e30)), (1, count));
        }
    }

    #[test]
    fn nothing_and_the_unknown_have_codes_of_their_own() {
        for codes in [Codes::over([0.0, f64::NAN].into_iter(), 253), Codes::over([2.0, 2.0].into_iter(), 253)] {
            assert_eq!(codes.code(0.0), 0);
            assert_eq!(codes.code(-1e-9), 0);
            assert!(codes.number(codes.code(f64::NAN)).is_nan());
        }
        let single = Codes::over([2.0].into_iter(), 253);
        assert_eq!((single.number(single.code(2.0)), single.error()), (2.0, 0.0));
    }
}
