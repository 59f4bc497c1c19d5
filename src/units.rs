//! Text with a unit becomes a number in internal units, and back.
//!
//! Inside the program lengths are micrometres and angles radians; people type and read nm, µm, mm and degrees.

use std::fmt;
use std::str::FromStr;

/// A unit of length.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LengthUnit {
    /// Nanometre.
    Nanometre,
    /// Micrometre.
    Micrometre,
    /// Millimetre.
    Millimetre,
    /// Metre.
    Metre,
}

impl LengthUnit {
    /// Micrometres per unit.
    pub fn micrometres(self) -> f64 {
        match self {
            Self::Nanometre => 1e-3,
            Self::Micrometre => 1.0,
            Self::Millimetre => 1e3,
            Self::Metre => 1e6,
        }
    }

    /// `x` of this unit in micrometres. Divides where that is exact: 172 nm becomes the double nearest 0.172.
    pub fn to_micrometres(self, x: f64) -> f64 {
        if self == Self::Nanometre { x / 1e3 } else { x * self.micrometres() }
    }
}

impl fmt::Display for LengthUnit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Nanometre => "nm",
            Self::Micrometre => "um",
            Self::Millimetre => "mm",
            Self::Metre => "m",
        })
    }
}

impl FromStr for LengthUnit {
    type Err = UnitError;

    fn from_str(s: &str) -> Result<Self, UnitError> {
        match s {
            "nm" => Ok(Self::Nanometre),
            "um" | "µm" | "μm" | "micron" => Ok(Self::Micrometre),
            "mm" => Ok(Self::Millimetre),
            "m" => Ok(Self::Metre),
            _ => Err(UnitError { text: s.into(), expected: "a unit of length: nm, um, mm or m" }),
        }
    }
}

/// Text that is not a quantity.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct UnitError {
    text: String,
    expected: &'static str,
}

impl fmt::Display for UnitError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "`{}`: expected {}", self.text, self.expected)
    }
}

impl std::error::Error for UnitError {}

/// Splits "50 nm" into 50 and "nm".
fn split(text: &str) -> Option<(f64, &str)> {
    let text = text.trim();
    let end = text
        .char_indices()
        .map(|(i, c)| i + c.len_utf8())
        .rev()
        .find(|&i| text[..i].trim_end().parse::<f64>().is_ok())?;
    Some((text[..end].trim_end().parse().ok()?, text[end..].trim()))
}

/// A length such as "50 nm", in µm; a bare number is in `default`.
///
/// # Errors
/// When the text is no number, or its unit no length.
pub fn length(text: &str, default: LengthUnit) -> Result<f64, UnitError> {
    let error = || UnitError { text: text.into(), expected: "a length such as \"50 nm\" or \"2 mm\"" };
    match split(text).ok_or_else(error)? {
        (x, "") => Ok(default.to_micrometres(x)),
        (x, unit) => Ok(unit.parse::<LengthUnit>().map_err(|_| error())?.to_micrometres(x)),
    }
}

/// An angle such as "15 deg" or "0.2 rad", in radians; a bare number is in degrees.
///
/// # Errors
/// When the text is no number, or its unit no angle.
pub fn angle(text: &str) -> Result<f64, UnitError> {
    match split(text) {
        Some((x, "" | "deg" | "°")) => Ok(x.to_radians()),
        Some((x, "rad")) => Ok(x),
        _ => Err(UnitError { text: text.into(), expected: "an angle such as \"15 deg\" or \"0.2 rad\"" }),
    }
}

/// A length for people: the unit that gives a number between 1 and 1000, three significant digits.
pub fn show_length(um: f64) -> String {
    let (x, unit) = match um.abs() {
        a if a == 0.0 || !a.is_finite() => (um, "µm"),
        a if a < 1.0 => (um * 1e3, "nm"),
        a if a < 1e3 => (um, "µm"),
        _ => (um * 1e-3, "mm"),
    };
    format!("{} {unit}", significant(x, 3))
}

/// `x` with `digits` significant digits, without trailing zeros.
pub fn significant(x: f64, digits: usize) -> String {
    if x == 0.0 || !x.is_finite() {
        return x.to_string();
    }
    let decimals = (digits as i32 - 1 - x.abs().log10().floor() as i32).max(0) as usize;
    let text = format!("{x:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}

/// A share such as "1%" or "0.01".
pub fn percentage(text: &str) -> Option<f64> {
    let text = text.trim();
    match text.strip_suffix('%') {
        Some(number) => number.trim_end().parse::<f64>().ok().map(|x| x / 100.0),
        None => text.parse().ok(),
    }
}

/// A share in percent, as short as can be.
pub fn show_percentage(share: f64) -> String {
    format!("{}%", significant(100.0 * share, 6))
}

/// A time in seconds such as "60s", "5 min" or "2h"; a bare number is in seconds.
///
/// # Errors
/// When the text is no number, or its unit no time.
pub fn seconds(text: &str) -> Result<f64, UnitError> {
    let error = || UnitError { text: text.into(), expected: "a time such as 60s, 5min or 2h" };
    let (x, unit) = split(text).ok_or_else(error)?;
    let factor = match unit {
        "" | "s" => 1.0,
        "min" => 60.0,
        "h" => 3600.0,
        _ => return Err(error()),
    };
    if x > 0.0 && x.is_finite() { Ok(factor * x) } else { Err(error()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_and_times() {
        assert_eq!([percentage("1%"), percentage("0.25 %"), percentage("0.5")], [Some(0.01), Some(0.0025), Some(0.5)]);
        assert_eq!(percentage("one"), None);
        assert_eq!(show_percentage(0.012_5), "1.25%");
        assert_eq!(
            [seconds("60s"), seconds("5 min"), seconds("2h"), seconds("3")].map(|s| s.unwrap()),
            [60.0, 300.0, 7200.0, 3.0]
        );
        assert!(seconds("0").is_err() && seconds("-1s").is_err() && seconds("1 day").is_err());
    }

    #[test]
    fn lengths_and_angles() {
        let um = LengthUnit::Micrometre;
        assert_eq!(length("50 nm", um), Ok(0.05));
        assert_eq!(length("172nm", um), Ok(0.172));
        assert_eq!(length(" 2e-1 mm ", um), Ok(200.0));
        assert_eq!(length("3", LengthUnit::Nanometre), Ok(0.003));
        assert_eq!(length("4.5 µm", um), Ok(4.5));
        assert!(length("4.5 kg", um).is_err());
        assert!(length("nm", um).is_err());
        assert!(length("", um).is_err());
        assert_eq!(angle("180"), Ok(std::f64::consts::PI));
        assert_eq!(angle("0.5 rad"), Ok(0.5));
        assert!(angle("1 nm").is_err());
    }

    #[test]
    fn lengths_for_people() {
        assert_eq!(show_length(0.05), "50 nm");
        assert_eq!(show_length(0.0372), "37.2 nm");
        assert_eq!(show_length(12.0), "12 µm");
        assert_eq!(show_length(2000.0), "2 mm");
        assert_eq!(significant(0.000123456, 3), "0.000123");
        assert_eq!(significant(1234.5, 3), "1234");
    }
}
