//! Complex refractive indices over wavelength.
//!
//! ```text
//! file ─┬─ .yml ─ refractiveindex ─┐
//!       └─ .csv ─ csv ─────────────┼─► Dispersion ─index(λ)─► n + ik
//! name ─── builtin ────────────────┘    n, k: Curve
//! ```

mod builtin;
mod csv;
mod curve;
mod dispersion;
mod file;
mod formula;
mod refractiveindex;
mod yaml;

pub use builtin::{Builtin, Certainty, builtin, builtins};
pub use curve::Curve;
pub use dispersion::{Dispersion, NoIndex};
pub use file::{FromFile, is_file, read_csv, read_file};
pub use formula::Formula;

use std::str::FromStr;

use crate::optics::C64;

/// Largest k of a medium that counts as transparent where light has to come through it: clear glass is published with
/// 1e-8 for visible light, and up to 1e-5 at the ends of its range.
pub const TRANSPARENT: f64 = 1e-5;

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
}
