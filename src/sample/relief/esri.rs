//! ESRI ASCII grids: `ncols`, `nrows`, the corner, `cellsize` (or `dx` and `dy`), `NODATA_value`, and the rows, that of
//! largest y first.

use glam::DVec2;

use super::{Flaw, Raw, as_text, check_count, check_size, flaw, flaw_at};
use crate::units::LengthUnit;

/// Whether the file begins as such a grid does.
pub(super) fn is_grid(bytes: &[u8]) -> bool {
    let start = bytes.trim_ascii_start();
    ["ncols", "nrows"].iter().any(|key| start.len() > 5 && start[..5].eq_ignore_ascii_case(key.as_bytes()))
}

#[derive(Default)]
struct Header {
    columns: Option<u64>,
    rows: Option<u64>,
    dx: Option<f64>,
    dy: Option<f64>,
    missing: Option<f64>,
}

pub(super) fn parse(bytes: &[u8], unit: LengthUnit) -> Result<Raw, Flaw> {
    let text = as_text(bytes)?;
    let mut header = Header::default();
    let mut lines = text.lines().enumerate().map(|(i, l)| (i + 1, l.trim())).filter(|(_, l)| !l.is_empty()).peekable();
    while let Some((number, line)) = lines.next_if(|(_, l)| is_entry(l)) {
        header.take(number, line)?;
    }
    let Header { columns: Some(columns), rows: Some(rows), .. } = header else {
        return flaw("the header lacks ncols or nrows");
    };
    let (columns, rows) = check_size(columns, rows)?;
    let pixel = header.dx.zip(header.dy).map(|(x, y)| DVec2::new(x, y) * unit.micrometres());
    let missing = header.missing.unwrap_or(-9999.0);
    let mut values = Vec::with_capacity(columns * rows);
    for (number, line) in lines {
        for word in line.split_ascii_whitespace() {
            match word.parse::<f64>() {
                Ok(z) if z == missing => values.push(f64::NAN),
                Ok(z) => values.push(unit.to_micrometres(z)),
                Err(_) => return flaw_at(number, format!("`{word}`: expected a height, a number")),
            }
        }
        if values.len() > columns * rows {
            return flaw_at(number, format!("more heights than ncols x nrows = {columns} x {rows}"));
        }
    }
    check_count(values.len(), columns, rows)?;
    Ok(Raw { columns, rows, pixel, values, white: None })
}

/// Whether a line begins with a word that is no number.
fn is_entry(line: &str) -> bool {
    line.starts_with(|c: char| c.is_alphabetic())
        && line.split_ascii_whitespace().next().is_some_and(|word| word.parse::<f64>().is_err())
}

impl Header {
    fn take(&mut self, number: usize, line: &str) -> Result<(), Flaw> {
        let (key, text) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
        let text = text.trim();
        let wrong = |expected: &str| Flaw { line: Some(number), message: format!("{key} {text}: expected {expected}") };
        let size = || match text.parse::<f64>() {
            Ok(x) if x > 0.0 && x.is_finite() => Ok(Some(x)),
            _ => Err(wrong("a length greater than 0")),
        };
        let count = || text.parse().map(Some).map_err(|_| wrong("a number of heights"));
        match key.to_ascii_lowercase().as_str() {
            "ncols" => self.columns = count()?,
            "nrows" => self.rows = count()?,
            "cellsize" => (self.dx, self.dy) = (size()?, size()?),
            "dx" => self.dx = size()?,
            "dy" => self.dy = size()?,
            "nodata_value" => self.missing = text.parse().map(Some).map_err(|_| wrong("a number"))?,
            "xllcorner" | "yllcorner" | "xllcenter" | "yllcenter" => {}
            _ => return Err(wrong("ncols, nrows, xllcorner, yllcorner, cellsize, NODATA_value, or a row of heights")),
        }
        Ok(())
    }
}
