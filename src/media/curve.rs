//! A real number over wavelength: n by itself, or k.

use super::Formula;
use crate::units::significant;

/// n or k of a medium over the vacuum wavelength in µm.
#[derive(Clone, Debug, PartialEq)]
pub enum Curve {
    /// The same at all wavelengths.
    Constant(f64),
    /// A formula for n.
    Formula(Formula),
    /// a exp(−λ/b), between two wavelengths.
    Exponential {
        /// Value for λ = 0.
        a: f64,
        /// Where it has fallen to 1/e of that, µm.
        b: f64,
        /// Range of validity, µm.
        range: (f64, f64),
    },
    /// Measured (λ, value), at least one, λ ascending; linear between.
    Table(Vec<(f64, f64)>),
}

impl Curve {
    /// Its value at a wavelength of its range.
    pub fn at(&self, wavelength: f64) -> f64 {
        match self {
            Self::Constant(x) => *x,
            Self::Formula(formula) => formula.n(wavelength),
            Self::Exponential { a, b, .. } => a * (-wavelength / b).exp(),
            Self::Table(rows) => interpolate(rows, wavelength),
        }
    }

    /// Where it is known, µm: from 0 to infinity if everywhere.
    pub fn range(&self) -> (f64, f64) {
        match self {
            Self::Constant(_) => (0.0, f64::INFINITY),
            Self::Formula(formula) => formula.range(),
            Self::Exponential { range, .. } => *range,
            Self::Table(rows) => (rows[0].0, rows[rows.len() - 1].0),
        }
    }

    /// The measured points, if that is what it is made of.
    pub fn points(&self) -> &[(f64, f64)] {
        if let Self::Table(rows) = self { rows } else { &[] }
    }

    /// What it is, for people.
    pub fn description(&self) -> String {
        match self {
            Self::Constant(x) => x.to_string(),
            Self::Formula(formula) => formula.description(),
            Self::Exponential { a, b, .. } => format!("{a} exp(−λ/{} nm)", significant(b * 1e3, 12)),
            Self::Table(rows) => format!("table of {} wavelengths, linear between them", rows.len()),
        }
    }
}

/// Linear between rows; beyond them the nearest one.
fn interpolate(rows: &[(f64, f64)], wavelength: f64) -> f64 {
    let above = rows.partition_point(|row| row.0 < wavelength);
    let (l1, y1) = rows[above.min(rows.len() - 1)];
    let (l0, y0) = rows[above.saturating_sub(1)];
    let w = if l1 > l0 { ((wavelength - l0) / (l1 - l0)).clamp(0.0, 1.0) } else { 0.0 };
    y0 * (1.0 - w) + y1 * w
}

/// k below 0 by no more than this is noise of a measurement, and taken as 0.
const NOISE: f64 = 1e-8;

/// Rows of a table that is read line by line.
#[derive(Debug, Default)]
pub(super) struct Rows {
    /// (λ in µm, n).
    pub(super) n: Vec<(f64, f64)>,
    /// (λ in µm, k).
    pub(super) k: Vec<(f64, f64)>,
    last: Option<f64>,
}

impl Rows {
    /// Adds what is known at a wavelength in µm.
    ///
    /// # Errors
    /// Where wavelengths do not ascend, or the medium would not be passive.
    pub(super) fn push(&mut self, wavelength: f64, n: Option<f64>, k: Option<f64>) -> Result<(), String> {
        let show = |um: f64| significant(um * 1e3, 9);
        let nm = show(wavelength);
        if !(wavelength > 0.0 && wavelength.is_finite()) {
            return Err(format!("wavelength {nm} nm: expected one greater than 0"));
        }
        match self.last {
            Some(last) if last == wavelength => return Err(format!("wavelength {nm} nm comes twice; leave one out")),
            Some(last) if last > wavelength => {
                return Err(format!("wavelength {nm} nm behind {} nm: sort them, they must ascend", show(last)));
            }
            _ => self.last = Some(wavelength),
        }
        if let Some(n) = n {
            if !(n > 0.0 && n.is_finite()) {
                return Err(format!("n = {n} at {nm} nm: expected n greater than 0"));
            }
            self.n.push((wavelength, n));
        }
        if let Some(k) = k {
            if !(k >= -NOISE && k.is_finite()) {
                return Err(format!("k = {k} at {nm} nm: expected k from 0 (n + ik with k > 0 absorbs)"));
            }
            self.k.push((wavelength, k.max(0.0)));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_linear_between_their_rows() {
        let table = Curve::Table(vec![(0.4, 1.0), (0.5, 2.0), (0.7, 1.0)]);
        for (um, y) in [(0.4, 1.0), (0.425, 1.25), (0.5, 2.0), (0.6, 1.5), (0.7, 1.0)] {
            assert!((table.at(um) - y).abs() < 1e-12, "{um}");
        }
        assert_eq!(table.range(), (0.4, 0.7));
        assert_eq!(Curve::Table(vec![(0.5, 1.5)]).at(0.5), 1.5);
    }

    #[test]
    fn rows_ascend_and_are_passive() {
        let mut rows = Rows::default();
        assert_eq!(rows.push(0.5, Some(1.5), Some(-1e-9)), Ok(()));
        let wrong = |um, n, k| Rows { last: Some(0.5), ..Rows::default() }.push(um, n, k).unwrap_err();
        assert_eq!(wrong(0.5, None, None), "wavelength 500 nm comes twice; leave one out");
        assert_eq!(wrong(0.4, None, None), "wavelength 400 nm behind 500 nm: sort them, they must ascend");
        assert_eq!(wrong(0.0, None, None), "wavelength 0 nm: expected one greater than 0");
        assert_eq!(wrong(0.6, Some(0.0), None), "n = 0 at 600 nm: expected n greater than 0");
        assert!(wrong(0.6, Some(1.5), Some(-1e-7)).starts_with("k = -0.0000001 at 600 nm: expected k from 0"));
        assert!(wrong(0.6, Some(1.5), Some(f64::NAN)).starts_with("k = NaN at 600 nm"));
        assert_eq!((rows.n, rows.k), (vec![(0.5, 1.5)], vec![(0.5, 0.0)]));
    }
}
