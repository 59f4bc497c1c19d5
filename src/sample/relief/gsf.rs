//! Gwyddion Simple Field (<http://gwyddion.net/documentation/user-guide-en/gsf.html>): lines `Name = value`, one to
//! four NULs up to a multiple of four bytes, and single-precision heights, little-endian, from the upper left.

use glam::DVec2;

use super::{Flaw, HeightField, Raw, as_text, check_count, check_size, flaw, flaw_at};
use crate::units::LengthUnit;

pub(super) const MAGIC: &[u8] = b"Gwyddion Simple Field 1.0\n";

impl HeightField {
    /// The field as such a file, heights in metres to single precision.
    pub fn to_gsf(&self) -> Vec<u8> {
        let [x, y] = (1e-6 * self.period()).to_array();
        let (columns, rows) = (self.columns, self.rows);
        let sizes = format!("XRes = {columns}\nYRes = {rows}\nXReal = {x:e}\nYReal = {y:e}\n");
        let mut out = [MAGIC, sizes.as_bytes(), b"XYUnits = m\nZUnits = m\n"].concat();
        out.resize(out.len() + 4 - out.len() % 4, 0);
        out.extend(self.heights.iter().flat_map(|z| ((1e-6 * z) as f32).to_le_bytes()));
        out
    }
}

/// A value of the header with its line.
type Entry<'a> = (usize, &'a str);

pub(super) fn parse(bytes: &[u8], unit: LengthUnit) -> Result<Raw, Flaw> {
    let Some(end) = bytes.iter().position(|&b| b == 0) else {
        return flaw("the header has no end: expected a NUL byte before the heights; the file is cut off");
    };
    let header = as_text(&bytes[..end])?;
    let find = |name: &str| -> Option<Entry<'_>> {
        header.lines().enumerate().skip(1).find_map(|(i, line)| {
            let (key, value) = line.split_once('=')?;
            (key.trim() == name).then(|| (i + 1, value.trim()))
        })
    };
    let count = |name: &str| match find(name) {
        None => flaw(format!("the header has no {name}")),
        Some((line, text)) => {
            text.parse::<u64>().or_else(|_| flaw_at(line, format!("{name} = {text}: expected a number of heights")))
        }
    };
    let (columns, rows) = check_size(count("XRes")?, count("YRes")?)?;
    let lateral = unit_of(find("XYUnits"), "XYUnits", unit)?;
    let vertical = unit_of(find("ZUnits"), "ZUnits", unit)?;
    let width = |name: &str, count: usize| match find(name) {
        None => Ok(None),
        Some((line, text)) => match text.parse::<f64>() {
            Ok(x) if x > 0.0 && x.is_finite() => Ok(Some(lateral.to_micrometres(x) / count as f64)),
            _ => flaw_at(line, format!("{name} = {text}: expected a length greater than 0")),
        },
    };
    let pixel = width("XReal", columns)?.zip(width("YReal", rows)?).map(DVec2::from);
    let data = bytes.get(end + 4 - end % 4..).unwrap_or_default();
    check_count(data.len() / 4, columns, rows)?;
    let value = |b: &[u8]| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    let values = data.chunks_exact(4).map(|b| vertical.to_micrometres(value(b))).collect();
    Ok(Raw { columns, rows, pixel, values, white: None })
}

fn unit_of(entry: Option<Entry<'_>>, name: &str, bare: LengthUnit) -> Result<LengthUnit, Flaw> {
    match entry {
        None | Some((_, "")) => Ok(bare),
        Some((line, text)) => text.parse().or_else(|_| {
            flaw_at(
                line,
                format!("{name} = {text}: expected a unit of length (m, mm, um or nm); is it a map of heights?"),
            )
        }),
    }
}
