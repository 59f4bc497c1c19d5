//! Numbers as people type them: ranges, lists, counts.

use std::fmt;
use std::str::FromStr;

/// Most values a range may have.
const MOST_VALUES: f64 = 100_000.0;

/// Values given as `start:stop:step` (both ends), as a list `0,20,75`, or as one number.
#[derive(Clone, Debug, PartialEq)]
pub struct Values {
    /// The values.
    pub all: Vec<f64>,
    text: String,
}

impl FromStr for Values {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts: Vec<&str> = text.split(':').collect();
        let all = match parts[..] {
            [_] => text.split(',').map(number).collect::<Result<_, _>>()?,
            [start, stop, step] => range(number(start)?, number(stop)?, number(step)?)?,
            _ => return Err("expected start:stop:step such as 0:80:5, a list such as 0,20,75, or one number".into()),
        };
        Ok(Self { all, text: text.into() })
    }
}

impl fmt::Display for Values {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

fn number(text: &str) -> Result<f64, String> {
    let x = text.trim().parse().ok().filter(|x: &f64| x.is_finite());
    x.ok_or_else(|| format!("`{}` is no number", text.trim()))
}

/// Both ends belong to a range, so its step must divide it.
fn range(start: f64, stop: f64, step: f64) -> Result<Vec<f64>, String> {
    let steps = (stop - start) / step;
    if !(0.0..MOST_VALUES).contains(&steps) {
        return Err(format!(
            "a step of {step} does not lead from {start} to {stop} (in fewer than {MOST_VALUES} steps)"
        ));
    }
    let count = steps.round();
    if (steps - count).abs() > 1e-6 {
        let last = start + steps.floor() * step;
        return Err(format!("steps of {step} from {start} end at {last} and miss {stop}; choose a step that divides"));
    }
    let count = count as usize;
    Ok((0..=count).map(|i| if i == count { stop } else { start + i as f64 * step }).collect())
}

/// Most trees per incidence.
const MOST_TREES: f64 = 1e11;

/// A whole number given as `200000`, `2e5`, `200k` or `1M`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Count(pub u64);

impl FromStr for Count {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (digits, factor) = match text.chars().last() {
            Some('k' | 'K') => (&text[..text.len() - 1], 1e3),
            Some('M') => (&text[..text.len() - 1], 1e6),
            Some('G') => (&text[..text.len() - 1], 1e9),
            _ => (text, 1.0),
        };
        let x = number(&digits.replace('_', ""))? * factor;
        if x.fract() != 0.0 || !(1.0..=MOST_TREES).contains(&x) {
            return Err(format!("expected a whole number from 1 to {MOST_TREES:e}, such as 200000, 2e5, 200k or 1M"));
        }
        Ok(Self(x as u64))
    }
}

impl fmt::Display for Count {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(text: &str) -> Result<Vec<f64>, String> {
        text.parse::<Values>().map(|v| v.all)
    }

    #[test]
    fn ranges_have_both_ends() {
        assert_eq!(values("0:80:5").unwrap().len(), 17);
        assert_eq!(values("400:700:20").unwrap().last(), Some(&700.0));
        assert_eq!(values("80:0:-40").unwrap(), [80.0, 40.0, 0.0]);
        assert_eq!(values("0:0.3:0.1").unwrap().last(), Some(&0.3));
        assert_eq!(values("30").unwrap(), [30.0]);
        assert_eq!(values("0, 20,75").unwrap(), [0.0, 20.0, 75.0]);
        assert!(values("0:80:7").unwrap_err().contains("77"));
        for bad in ["", "0:80", "0:80:0", "0:80:-5", "a", "1,,2", "nan", "0:1e9:1", "1:2:3:4"] {
            assert!(values(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn counts_have_four_forms() {
        for text in ["200000", "2e5", "200k", "0.2M", "200_000"] {
            assert_eq!(text.parse(), Ok(Count(200_000)), "{text}");
        }
        for bad in ["0", "-1", "1.5", "k", "1e12", "inf", ""] {
            assert!(bad.parse::<Count>().is_err(), "{bad}");
        }
    }
}
