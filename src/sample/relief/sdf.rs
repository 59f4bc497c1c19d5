//! Surface data files of ISO 25178-71 (versions 1.0 and 2.0, text and binary), and their predecessor BCR-STM. Steps and
//! heights are in metres.

use glam::DVec2;

use super::{Flaw, Raw, check_count, check_size, flaw, flaw_at};

const METRE: f64 = 1e6;

pub(super) fn is_text(bytes: &[u8]) -> bool {
    [&b"aISO-1.0"[..], b"aISO-2.0", b"aBCR-0.0", b"aBCR-1.0"].iter().any(|magic| bytes.starts_with(magic))
}

pub(super) fn is_binary(bytes: &[u8]) -> bool {
    [&b"bISO-1.0"[..], b"bISO-2.0", b"bBCR-0.0", b"bBCR-1.0"].iter().any(|magic| bytes.starts_with(magic))
}

/// What both forms say before the heights.
struct Header {
    columns: usize,
    rows: usize,
    pixel: DVec2,
    /// Metres per unit of the heights.
    scale: f64,
}

impl Header {
    fn new(columns: u64, rows: u64, [x, y, scale]: [f64; 3]) -> Result<Self, Flaw> {
        let (columns, rows) = check_size(columns, rows)?;
        for (name, step) in [("Xscale", x), ("Yscale", y)] {
            if !(step > 0.0 && step.is_finite()) {
                return flaw(format!("{name} = {step}: expected a step greater than 0, in metres"));
            }
        }
        if scale == 0.0 || !scale.is_finite() {
            return flaw(format!("Zscale = {scale}: expected the metres per unit of the heights"));
        }
        Ok(Self { columns, rows, pixel: DVec2::new(x, y) * METRE, scale })
    }

    fn raw(self, mut values: Vec<f64>) -> Result<Raw, Flaw> {
        let Self { columns, rows, pixel, scale } = self;
        check_count(values.len(), columns, rows)?;
        values.iter_mut().for_each(|v| *v = *v * scale * METRE);
        Ok(Raw { columns, rows, pixel: Some(pixel), values, white: None })
    }
}

/// Lines `Key = value`, a line `*`, the heights, a line `*`, and a trailer, which may be missing.
pub(super) fn parse_text(bytes: &[u8]) -> Result<Raw, Flaw> {
    // Names and comments may be in any alphabet.
    let text = String::from_utf8_lossy(bytes);
    let mut entries: Vec<(usize, &str, &str)> = Vec::new();
    let mut lines = text.lines().enumerate().skip(1).map(|(i, l)| (i + 1, l.trim()));
    loop {
        match lines.next() {
            None => return flaw("the header has no end: expected a line `*` before the heights; the file is cut off"),
            Some((_, "*")) => break,
            Some((_, line)) if line.is_empty() || line.starts_with(';') => {}
            Some((number, line)) => match line.split_once('=') {
                Some((key, value)) => entries.push((number, key.trim(), value.trim())),
                None => {
                    return flaw_at(number, format!("`{line}`: expected `name = value`, or `*` before the heights"));
                }
            },
        }
    }
    let find = |name: &str| match entries.iter().find(|(_, key, _)| key.eq_ignore_ascii_case(name)) {
        Some(&(line, _, value)) => Ok((line, value)),
        None => flaw(format!("the header has no {name}")),
    };
    let count = |name: &str| {
        let (line, text) = find(name)?;
        text.parse::<u64>().or_else(|_| flaw_at(line, format!("{name} = {text}: expected a number of heights")))
    };
    let number = |name: &str| {
        let (line, text) = find(name)?;
        text.parse::<f64>().or_else(|_| flaw_at(line, format!("{name} = {text}: expected a number")))
    };
    let scales = [number("Xscale")?, number("Yscale")?, number("Zscale")?];
    let header = Header::new(count("NumPoints")?, count("NumProfiles")?, scales)?;
    let mut values = Vec::with_capacity(header.columns * header.rows);
    for (number, line) in lines {
        if line.starts_with('*') {
            break;
        }
        for word in line.split_ascii_whitespace() {
            match word.parse::<f64>() {
                _ if word.eq_ignore_ascii_case("bad") => values.push(f64::NAN),
                Ok(z) => values.push(z),
                Err(_) => return flaw_at(number, format!("`{word}`: expected a height, or BAD where there is none")),
            }
        }
    }
    header.raw(values)
}

/// How heights are stored, by the number of the standard.
const TYPES: [(u8, usize); 8] = [(0, 1), (1, 2), (2, 4), (3, 4), (4, 1), (5, 2), (6, 4), (7, 8)];

/// Packed fields, little-endian; version 2.0 counts in 32 bit.
pub(super) fn parse_binary(bytes: &[u8]) -> Result<Raw, Flaw> {
    let wide = bytes.starts_with(b"bISO-2.0");
    // Magic, maker, and two dates.
    let mut rest = Bytes(bytes.get(8 + 10 + 12 + 12..).unwrap_or_default());
    let mut count = || {
        Ok::<u64, Flaw>(if wide {
            u32::from_le_bytes(rest.take()?).into()
        } else {
            u16::from_le_bytes(rest.take()?).into()
        })
    };
    let (columns, rows) = (count()?, count()?);
    let mut number = || Ok::<f64, Flaw>(f64::from_le_bytes(rest.take()?));
    let scales = [number()?, number()?, number()?];
    let _resolution = number()?;
    let [compression, kind, check] = rest.take()?;
    let header = Header::new(columns, rows, scales)?;
    if compression != 0 || check != 0 {
        return flaw(format!(
            "Compression = {compression}, CheckType = {check}: expected 0; save the file uncompressed"
        ));
    }
    let Some(&(_, size)) = TYPES.iter().find(|(k, _)| *k == kind) else {
        return flaw(format!("DataType = {kind}: expected 0 to 7"));
    };
    let wanted = size * header.columns * header.rows;
    // Some microscopes write two numbers more before the heights than version 1.0 has.
    let more = bytes.starts_with(b"bISO-1.0") && rest.0.len() == wanted + 8;
    let rest = &rest.0[if more { 8 } else { 0 }..];
    let Some(data) = rest.get(..wanted) else {
        return flaw(format!(
            "{} heights: expected {} x {} = {}; the file is cut off or damaged",
            rest.len() / size,
            header.columns,
            header.rows,
            header.columns * header.rows
        ));
    };
    let values = data.chunks_exact(size).map(|b| height(kind, b)).collect();
    header.raw(values)
}

/// One height; NaN where there is none: at the smallest value of signed types, the largest of unsigned ones.
fn height(kind: u8, bytes: &[u8]) -> f64 {
    let mut b = [0; 8];
    b[..bytes.len()].copy_from_slice(bytes);
    let (two, four) = ([b[0], b[1]], [b[0], b[1], b[2], b[3]]);
    let (value, bad) = match kind {
        0 => (f64::from(b[0]), f64::NAN),
        1 => (f64::from(u16::from_le_bytes(two)), f64::from(u16::MAX)),
        2 => (f64::from(u32::from_le_bytes(four)), f64::from(u32::MAX)),
        3 => (f64::from(f32::from_le_bytes(four)), f64::from(f32::MIN)),
        4 => (f64::from(b[0] as i8), f64::from(i8::MIN)),
        5 => (f64::from(i16::from_le_bytes(two)), f64::from(i16::MIN)),
        6 => (f64::from(i32::from_le_bytes(four)), f64::from(i32::MIN)),
        _ => (f64::from_le_bytes(b), f64::MIN),
    };
    // BCR-STM marks them with the largest numbers of single precision.
    if value == bad || value.abs() > 1.7e38 { f64::NAN } else { value }
}

/// Bytes that are taken from the front.
struct Bytes<'a>(&'a [u8]);

impl Bytes<'_> {
    fn take<const N: usize>(&mut self) -> Result<[u8; N], Flaw> {
        let Some((first, rest)) = self.0.split_first_chunk::<N>() else {
            return flaw("the header has no end; the file is cut off");
        };
        self.0 = rest;
        Ok(*first)
    }
}
