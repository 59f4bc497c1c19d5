//! The complex index of a medium over wavelength.

use std::fmt;

use super::{Curve, check_index};
use crate::optics::C64;
use crate::units::significant;

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
    /// n and k, known where both of them are.
    Curves {
        /// The real part.
        n: Curve,
        /// The imaginary part.
        k: Curve,
    },
    /// Beyond the range of another, what that one says at the end of its range.
    Extrapolated(Box<Dispersion>),
}

/// Why a medium has no index at a wavelength.
#[derive(Clone, Debug, PartialEq)]
pub enum NoIndex {
    /// Nothing is known there.
    OutOfRange {
        /// The wavelength asked for, nm.
        wavelength_nm: f64,
        /// What is known, nm.
        range_nm: (f64, f64),
    },
    /// Its formula says what no passive medium has.
    Impossible {
        /// The wavelength asked for, nm.
        wavelength_nm: f64,
        /// What is wrong.
        message: String,
    },
}

impl fmt::Display for NoIndex {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::OutOfRange { wavelength_nm, range_nm: (low, high) } => {
                let [nm, low, high] = [wavelength_nm, low, high].map(|nm| significant(*nm, 9));
                write!(f, "no index at {nm} nm: known from {low} to {high} nm")
            }
            Self::Impossible { wavelength_nm, message } => write!(f, "no index at {wavelength_nm} nm: {message}"),
        }
    }
}

impl std::error::Error for NoIndex {}

impl Dispersion {
    /// The index n + ik at a vacuum wavelength in µm.
    ///
    /// # Errors
    /// Where nothing is known, and where a formula gives no index of a passive medium.
    pub fn index(&self, wavelength: f64) -> Result<C64, NoIndex> {
        let wavelength_nm = wavelength * 1e3;
        let (low, high) = self.range();
        let index = match self {
            Self::Constant(n) => *n,
            Self::Cauchy { a, b } => C64::new(a + b / (wavelength_nm * wavelength_nm), 0.0),
            // Wavelengths come from nm by a division, range ends from µm: allow their rounding.
            Self::Curves { .. } if !(low * (1.0 - 1e-12)..=high * (1.0 + 1e-12)).contains(&wavelength) => {
                return Err(NoIndex::OutOfRange { wavelength_nm, range_nm: (low * 1e3, high * 1e3) });
            }
            Self::Curves { n, k } => C64::new(n.at(wavelength), k.at(wavelength)),
            Self::Extrapolated(known) => known.index(wavelength.max(low).min(high))?,
        };
        check_index(index).map_err(|message| NoIndex::Impossible { wavelength_nm, message })?;
        Ok(index)
    }

    /// Where something is known, µm: from 0 to infinity if everywhere.
    pub fn range(&self) -> (f64, f64) {
        match self {
            Self::Constant(_) | Self::Cauchy { .. } => (0.0, f64::INFINITY),
            Self::Curves { n, k } => {
                let (n, k) = (n.range(), k.range());
                (n.0.max(k.0), n.1.min(k.1))
            }
            Self::Extrapolated(known) => known.range(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Formula;
    use super::*;

    fn ink() -> Dispersion {
        let k = Curve::Table(vec![(0.45, 0.0), (0.6, 0.3)]);
        Dispersion::Curves { n: Curve::Table(vec![(0.4, 1.0), (0.5, 2.0)]), k }
    }

    #[test]
    fn n_and_k_are_known_where_both_are() {
        assert_eq!(ink().range(), (0.45, 0.5));
        assert!((ink().index(0.475).unwrap() - C64::new(1.75, 0.05)).norm() < 1e-12);
        assert_eq!(ink().index(0.5).unwrap().re, 2.0);
        for um in [0.4499, 0.5001, f64::NAN] {
            let e = ink().index(um).unwrap_err();
            assert!(e.to_string().ends_with("nm: known from 450 to 500 nm"), "{e}");
        }
        let nm = 365.01;
        let formula = Formula::new(5, vec![1.5], (0.365_01, 0.8)).unwrap();
        let glass = Dispersion::Curves { n: Curve::Formula(formula), k: Curve::Constant(0.0) };
        assert!(glass.index(nm / 1e3).is_ok(), "rounding does not leave the range");
        assert!(glass.index(nm / 1e3 - 1e-9).unwrap_err().to_string().contains("known from 365.01 to 800 nm"));
    }

    #[test]
    fn extrapolation_holds_the_ends() {
        let ink = Dispersion::Extrapolated(Box::new(ink()));
        assert_eq!(ink.index(0.1), ink.index(0.45));
        assert_eq!(ink.index(9.0), ink.index(0.5));
        assert_eq!(ink.range(), (0.45, 0.5));
    }

    #[test]
    fn a_formula_may_say_what_cannot_be() {
        let e = Dispersion::Cauchy { a: 1.0, b: -1e6 }.index(0.4).unwrap_err().to_string();
        assert_eq!(e, "no index at 400 nm: index -5.25+0i: expected 0 < n <= 20 and k <= 100");
        let pole = Formula::new(2, vec![0.0, 1.0, 0.25], (0.3, 1.0)).unwrap();
        let e = Dispersion::Curves { n: Curve::Formula(pole), k: Curve::Constant(0.0) }.index(0.5).unwrap_err();
        assert!(e.to_string().contains("expected finite numbers"), "{e}");
    }
}
