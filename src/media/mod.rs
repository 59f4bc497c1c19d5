//! Complex refractive indices over wavelength.

mod builtin;

pub use builtin::{Builtin, builtin, builtins};

use std::path::Path;
use std::str::FromStr;

use crate::optics::C64;
use crate::text;

/// How the index of a medium follows from the wavelength.
#[derive(Clone, Debug, PartialEq)]
pub enum Dispersion {
    /// The same at all wavelengths.
    Constant(C64),
    /// n = a + b/λ², λ in nm.
    Cauchy {
        /// Constant term.
        a: f64,
        /// Coefficient of 1/λ², nm².
        b: f64,
    },
    /// n² = 1 + a + Σ bᵢ λ²/(λ² − cᵢ), λ in µm; valid between two wavelengths.
    Sellmeier {
        /// Constant term.
        a: f64,
        /// Pairs (bᵢ, cᵢ in µm²).
        terms: Vec<(f64, f64)>,
        /// Range of validity, µm.
        range: (f64, f64),
    },
    /// Measured (λ in µm, index), ascending; linear between.
    Table(Vec<(f64, C64)>),
}

/// A wavelength at which nothing is known.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutOfRange {
    /// The wavelength asked for, nm.
    pub wavelength_nm: f64,
    /// What is known, nm.
    pub range_nm: (f64, f64),
}

impl std::fmt::Display for OutOfRange {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let (low, high) = self.range_nm;
        write!(f, "no index at {} nm: known from {low} to {high} nm", self.wavelength_nm)
    }
}

impl Dispersion {
    /// The index n + ik at a vacuum wavelength in µm.
    ///
    /// # Errors
    /// Outside the range of a formula or table.
    pub fn index(&self, wavelength: f64) -> Result<C64, OutOfRange> {
        let nm = wavelength * 1e3;
        let within = |(low, high): (f64, f64)| {
            // Wavelengths come from nm by a division, range ends from um: allow their rounding.
            if wavelength >= low * (1.0 - 1e-12) && wavelength <= high * (1.0 + 1e-12) {
                Ok(())
            } else {
                Err(OutOfRange { wavelength_nm: nm, range_nm: (low * 1e3, high * 1e3) })
            }
        };
        match self {
            Self::Constant(n) => Ok(*n),
            Self::Cauchy { a, b } => Ok(C64::new(a + b / (nm * nm), 0.0)),
            Self::Sellmeier { a, terms, range } => {
                within(*range)?;
                let l2 = wavelength * wavelength;
                let n2 = terms.iter().fold(1.0 + a, |sum, (b, c)| sum + b * l2 / (l2 - c));
                Ok(C64::new(n2.sqrt(), 0.0))
            }
            Self::Table(rows) => {
                within((rows[0].0, rows[rows.len() - 1].0))?;
                Ok(interpolate(rows, wavelength))
            }
        }
    }

    /// Whether the index is the same at all wavelengths.
    pub fn is_constant(&self) -> bool {
        matches!(self, Self::Constant(_))
    }
}

fn interpolate(rows: &[(f64, C64)], wavelength: f64) -> C64 {
    let above = rows.partition_point(|r| r.0 < wavelength).clamp(1, rows.len() - 1);
    let ((l0, n0), (l1, n1)) = (rows[above - 1], rows[above]);
    let w = ((wavelength - l0) / (l1 - l0)).clamp(0.0, 1.0);
    n0 * (1.0 - w) + n1 * w
}

/// A complex index as people write it: `1.5`, `2.0+0.01i`, `0.2+3.4i`. The imaginary part must not be negative.
///
/// # Errors
/// What was expected.
pub fn parse_index(text: &str) -> Result<C64, String> {
    let expected = || format!("`{text}`: expected an index such as 1.5 or 2.0+0.01i");
    let n = match text.trim().strip_suffix('i') {
        None => C64::new(text.trim().parse().map_err(|_| expected())?, 0.0),
        Some(_) => C64::from_str(text.trim()).map_err(|_| expected())?,
    };
    check_index(n)?;
    Ok(n)
}

/// Largest table taken, bytes.
const MOST_BYTES: u64 = 64 << 20;

/// Reads a table of columns wavelength in nm, n and (optionally) k, separated by commas or blanks; lines that
/// begin with `#` or a letter are skipped.
///
/// # Errors
/// File, line and what was expected.
pub fn read_csv(path: &Path) -> Result<Dispersion, String> {
    let text = text::read(path, MOST_BYTES).map_err(|e| format!("{}: {e}", path.display()))?;
    let mut rows: Vec<(f64, C64)> = Vec::new();
    for (i, line) in text.lines().enumerate() {
        let line = line.trim();
        if line.is_empty() || line.starts_with(|c: char| c == '#' || c.is_alphabetic()) {
            continue;
        }
        let bad = |why: &str| format!("{}:{}: `{line}`: {why}", path.display(), i + 1);
        let fields: Option<Vec<f64>> = line
            .split(|c: char| c == ',' || c == ';' || c.is_whitespace())
            .filter(|f| !f.is_empty())
            .map(|f| f.parse().ok())
            .collect();
        let (nm, index) = match fields.as_deref() {
            Some(&[nm, n]) => (nm, C64::new(n, 0.0)),
            Some(&[nm, n, k]) => (nm, C64::new(n, k)),
            _ => return Err(bad("expected wavelength in nm, n and, where it absorbs, k")),
        };
        check_index(index).map_err(|e| bad(&e))?;
        if rows.last().is_some_and(|last| last.0 >= nm / 1e3) || !(nm > 0.0 && nm.is_finite()) {
            return Err(bad("wavelengths must be positive and ascend"));
        }
        rows.push((nm / 1e3, index));
    }
    if rows.len() < 2 {
        return Err(format!("{}: expected at least two lines of wavelength in nm, n and k", path.display()));
    }
    Ok(Dispersion::Table(rows))
}

/// Whether an index describes a passive medium that light can be followed in.
///
/// # Errors
/// What is wrong with it.
pub fn check_index(n: C64) -> Result<(), String> {
    if !(n.re.is_finite() && n.im.is_finite()) {
        return Err(format!("index {n}: expected finite numbers"));
    }
    if n.im < 0.0 {
        return Err(format!("index {n}: k must not be negative (n + ik with k > 0 absorbs)"));
    }
    if n.re <= 0.0 || n.re > 20.0 || n.im > 100.0 {
        return Err(format!("index {n}: expected 0 < n <= 20 and k <= 100"));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn indices_parse() {
        assert_eq!(parse_index("1.5"), Ok(C64::new(1.5, 0.0)));
        assert_eq!(parse_index("2.0+0.01i"), Ok(C64::new(2.0, 0.01)));
        assert_eq!(parse_index(" 0.2+3.4i "), Ok(C64::new(0.2, 3.4)));
        for bad in ["", "x", "1.5+i2", "2-0.01i", "-1", "nan", "1e99"] {
            assert!(parse_index(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn tables_are_linear_and_bounded() {
        let table = Dispersion::Table(vec![(0.4, C64::new(1.0, 0.0)), (0.5, C64::new(2.0, 1.0))]);
        assert!((table.index(0.425).unwrap() - C64::new(1.25, 0.25)).norm() < 1e-12);
        assert_eq!(table.index(0.5), Ok(C64::new(2.0, 1.0)));
        assert!(table.index(0.399).is_err());
    }
}
