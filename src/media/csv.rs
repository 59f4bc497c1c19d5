//! Tables as text: columns wavelength in nm, n and, where it absorbs, k.

use super::curve::Rows;
use super::yaml::Wrong;
use super::{Curve, Dispersion};

/// Reads columns separated by commas, semicolons or blanks; lines that begin with `#` or a letter are skipped.
///
/// # Errors
/// The first thing that is wrong, and its line.
pub(super) fn parse(text: &str) -> Result<Dispersion, Wrong> {
    let mut rows = Rows::default();
    for (i, line) in text.lines().enumerate() {
        let line = line.trim();
        if line.is_empty() || line.starts_with(|c: char| c == '#' || c.is_alphabetic()) {
            continue;
        }
        let fields: Option<Vec<f64>> = line
            .split(|c: char| c == ',' || c == ';' || c.is_whitespace())
            .filter(|field| !field.is_empty())
            .map(|field| field.parse().ok().filter(|x: &f64| x.is_finite()))
            .collect();
        let pushed = match fields.as_deref() {
            Some(&[nm, n]) => rows.push(nm / 1e3, Some(n), Some(0.0)),
            Some(&[nm, n, k]) => rows.push(nm / 1e3, Some(n), Some(k)),
            _ => Err("expected wavelength in nm, n and, where it absorbs, k".into()),
        };
        pushed.map_err(|message| Wrong::at(i + 1, format!("`{line:.80}`: {message}")))?;
    }
    if rows.n.len() < 2 {
        let line = text.lines().count().max(1);
        return Err(Wrong::at(line, "expected at least two lines of wavelength in nm, n and k"));
    }
    Ok(Dispersion::Curves { n: Curve::Table(rows.n), k: Curve::Table(rows.k) })
}

/// Its comments: what it says of where the numbers come from.
pub(super) fn comments(text: &str) -> String {
    let comments = text.lines().filter_map(|line| line.trim().strip_prefix('#'));
    comments.map(str::trim).collect::<Vec<_>>().join("\n")
}
