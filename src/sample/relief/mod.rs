//! Reliefs: heights measured on a grid, the body under them, and the files they come in.
//!
//! Row 0 of a field is its +y edge and column 0 its −x edge, as one sees the picture of it with x to the right and y up;
//! heights are along +z, towards the light. Every height stands in the middle of its pixel. Two triangles span each
//! cell between four heights; they meet along the diagonal from the −x −y corner to the +x +y corner, everywhere.
//!
//! In a periodic sample a field of `columns` × `rows` heights is `columns` × `rows` pixels wide: after the last column
//! comes the first again, one pixel on. There are no walls, and if the heights are periodic there is no seam. A block
//! that stands alone ends at its outermost heights, with upright walls down to its floor.

mod esri;
mod gsf;
mod image;
mod sdf;
mod surface;
#[cfg(test)]
mod tests;

use std::fs::File;
use std::io::Read as _;
use std::path::Path;

use glam::DVec2;

use super::problem::{Place, Problem};
use crate::units::{self, LengthUnit};
pub use surface::Relief;
pub(super) use surface::Wrap;

/// Largest number of heights taken: some millions of triangles.
pub const MOST_HEIGHTS: usize = 1_500_000;

/// The floor lies at least so deep below the lowest height unless another depth is given, µm: metals are opaque then.
pub const DEPTH: f64 = 1.0;

/// Largest file taken, bytes.
const MOST_BYTES: u64 = 256 << 20;

/// Heights on a grid of rectangles.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightField {
    /// Heights along x.
    pub columns: usize,
    /// Heights along y.
    pub rows: usize,
    /// Distance of neighbours along x and y, µm.
    pub pixel: DVec2,
    /// Row by row, that of largest y first, µm.
    pub heights: Vec<f64>,
}

/// What a file of heights says.
#[derive(Clone, Debug, PartialEq)]
pub struct Raw {
    /// Heights along x.
    pub columns: usize,
    /// Heights along y.
    pub rows: usize,
    /// Distance of neighbours, µm, if the file says.
    pub pixel: Option<DVec2>,
    /// Row by row, that of largest y first: µm, or levels of grey; NaN where a height is missing.
    pub values: Vec<f64>,
    /// The level of grey that is white, if the file is a picture.
    pub white: Option<f64>,
}

/// What is wrong with a file of heights.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Flaw {
    /// The line, from 1, in a text.
    line: Option<usize>,
    message: String,
}

fn flaw<T>(message: impl Into<String>) -> Result<T, Flaw> {
    Err(Flaw { line: None, message: message.into() })
}

fn flaw_at<T>(line: usize, message: impl Into<String>) -> Result<T, Flaw> {
    Err(Flaw { line: Some(line), message: message.into() })
}

/// Reads a file of heights; bare lengths in it are in `unit`.
///
/// # Errors
/// When it cannot be read, is of no known format, or is damaged.
pub fn load(path: &Path, unit: LengthUnit) -> Result<Raw, Problem> {
    let place = Place::file(path);
    let mut bytes = Vec::new();
    let read = File::open(path).and_then(|f| f.take(MOST_BYTES + 1).read_to_end(&mut bytes));
    read.map_err(|e| place.problem(format!("cannot be read: {e}")))?;
    if bytes.len() as u64 > MOST_BYTES {
        return Err(place.problem(format!("is larger than {} MB: more is not taken", MOST_BYTES >> 20)));
    }
    parse(&bytes, unit).map_err(|f| Place { line: f.line, ..place }.problem(f.message))
}

/// Tells the format by its first bytes.
fn parse(bytes: &[u8], unit: LengthUnit) -> Result<Raw, Flaw> {
    match bytes {
        _ if bytes.starts_with(gsf::MAGIC) => gsf::parse(bytes, unit),
        _ if sdf::is_text(bytes) => sdf::parse_text(bytes),
        _ if sdf::is_binary(bytes) => sdf::parse_binary(bytes),
        _ if bytes.starts_with(image::PNG) => image::parse_png(bytes),
        _ if image::TIFF.iter().any(|magic| bytes.starts_with(magic)) => image::parse_tiff(bytes, unit),
        _ if esri::is_grid(bytes) => esri::parse(bytes, unit),
        [] => flaw("is empty"),
        _ => flaw(
            "is no file of heights that is known here: expected Gwyddion Simple Field (.gsf), ISO 25178-71 (.sdf), an \
             ESRI ASCII grid (.asc), or a grey picture (.png, .tif)",
        ),
    }
}

/// Whether a field of this size can be taken, asked before there is memory for it.
fn check_size(columns: u64, rows: u64) -> Result<(usize, usize), Flaw> {
    if columns < 2 || rows < 2 {
        return flaw(format!("{columns} x {rows} heights: expected at least 2 x 2"));
    }
    match columns.checked_mul(rows) {
        Some(count) if count <= MOST_HEIGHTS as u64 => Ok((columns as usize, rows as usize)),
        _ => flaw(format!(
            "{columns} x {rows} heights: at most {MOST_HEIGHTS} are taken; crop the field, or scale it down to coarser \
             pixels"
        )),
    }
}

/// `values` if there are as many as the field has.
fn check_count(found: usize, columns: usize, rows: usize) -> Result<(), Flaw> {
    if found == columns * rows {
        return Ok(());
    }
    flaw(format!("{found} heights: expected {columns} x {rows} = {}; the file is cut off or damaged", columns * rows))
}

/// A text of bytes, for formats that are text.
fn as_text(bytes: &[u8]) -> Result<&str, Flaw> {
    match std::str::from_utf8(bytes) {
        Ok(text) => Ok(text),
        Err(e) => {
            let line = 1 + bytes[..e.valid_up_to()].iter().filter(|&&b| b == b'\n').count();
            flaw_at(line, "is no text in UTF-8")
        }
    }
}

impl Raw {
    /// The values in µm, missing ones replaced by `fill` (µm), levels of grey spread over `levels` (µm, from black to
    /// white).
    ///
    /// # Errors
    /// What is missing, and how to mend it.
    pub fn into_field(
        mut self,
        pixel: Option<DVec2>,
        levels: Option<[f64; 2]>,
        fill: Option<f64>,
    ) -> Result<HeightField, Vec<String>> {
        let pixel = pixel.or(self.pixel).ok_or_else(|| {
            let fix = "give pixel = \"50 nm\", or [x, y] if they differ";
            format!("the file does not say how far apart its heights are: {fix}")
        });
        let leveled = self.level(levels);
        let filled = self.fill_gaps(fill);
        match (pixel, leveled, filled) {
            (Ok(pixel), Ok(()), Ok(())) => {
                let Self { columns, rows, values: heights, .. } = self;
                Ok(HeightField { columns, rows, pixel, heights })
            }
            (pixel, leveled, filled) => Err([pixel.err(), leveled.err(), filled.err()].into_iter().flatten().collect()),
        }
    }

    /// Turns levels of grey into heights.
    fn level(&mut self, levels: Option<[f64; 2]>) -> Result<(), String> {
        match (self.white, levels) {
            (Some(white), Some([black, top])) => {
                self.values.iter_mut().for_each(|v| *v = black + *v / white * (top - black));
                Ok(())
            }
            (Some(_), None) => Err("a picture does not say how high it is: give height = [low, high], the heights of \
                                    black and of white, or one number for how high white is above black"
                .into()),
            (None, Some(_)) => {
                Err("the file has its own heights; leave `height` out, or change them with scale_z".into())
            }
            (None, None) => Ok(()),
        }
    }

    fn fill_gaps(&mut self, fill: Option<f64>) -> Result<(), String> {
        if let Some(z) = fill {
            self.values.iter_mut().filter(|v| !v.is_finite()).for_each(|v| *v = z);
        }
        let Some(first) = self.values.iter().position(|v| !v.is_finite()) else { return Ok(()) };
        let count = self.values.iter().filter(|v| !v.is_finite()).count();
        let missing = if count == 1 { "1 height is missing".into() } else { format!("{count} heights are missing") };
        let (column, row) = (1 + first % self.columns, 1 + first / self.columns);
        Err(format!(
            "{missing}, the first in column {column} of row {row}: give fill = 0.0, a height to put there, or \
             interpolate them first (in Gwyddion: Interpolate Data Under Mask)"
        ))
    }
}

impl HeightField {
    /// The height in a column and a row, µm.
    pub fn at(&self, column: usize, row: usize) -> f64 {
        self.heights[row * self.columns + column]
    }

    /// One period of it, µm: all its pixels.
    pub fn period(&self) -> DVec2 {
        self.pixel * DVec2::new(self.columns as f64, self.rows as f64)
    }

    /// What its heights span, µm: one pixel less than a period.
    pub fn span(&self) -> DVec2 {
        self.period() - self.pixel
    }

    /// Lowest and highest height, µm.
    pub fn range(&self) -> [f64; 2] {
        let fold = |start: f64, f: fn(f64, f64) -> f64| self.heights.iter().copied().fold(start, f);
        [fold(f64::INFINITY, f64::min), fold(f64::NEG_INFINITY, f64::max)]
    }

    /// Where the field does not go on smoothly when it repeats: the steps there, and the usual ones.
    pub fn seams(&self) -> Option<String> {
        let x = Steps::new((0..self.rows).map(|r| (0..self.columns).map(move |c| self.at(c, r))));
        let y = Steps::new((0..self.columns).map(|c| (0..self.rows).map(move |r| self.at(c, r))));
        let rough: Vec<String> =
            [("columns", x), ("rows", y)].into_iter().filter_map(|(lines, s)| s.tell(lines)).collect();
        (!rough.is_empty()).then(|| {
            format!(
                "the relief does not go on smoothly where it repeats: {}; there it has a steep flank, one pixel wide. \
                 Level the field, or give sides = \"open\"",
                rough.join(", and ")
            )
        })
    }
}

/// Root mean square of the steps between neighbours, and of those from the last to the first.
struct Steps {
    inner: f64,
    seam: f64,
}

impl Steps {
    /// A seam is told if its steps are so many times the usual ones.
    const ROUGH: f64 = 4.0;

    fn new(lines: impl Iterator<Item = impl Iterator<Item = f64>>) -> Self {
        let (mut inner, mut count, mut seam, mut seams) = (0.0, 0.0, 0.0, 0.0);
        for line in lines {
            let heights: Vec<f64> = line.collect();
            inner += heights.windows(2).map(|w| (w[1] - w[0]).powi(2)).sum::<f64>();
            count += (heights.len() - 1) as f64;
            seam += (heights[0] - heights[heights.len() - 1]).powi(2);
            seams += 1.0;
        }
        Self { inner: (inner / count).sqrt(), seam: (seam / seams).sqrt() }
    }

    fn tell(&self, lines: &str) -> Option<String> {
        let Self { inner, seam } = self;
        let [usual, there] = [*inner, *seam].map(units::show_length);
        (*seam > Self::ROUGH * inner)
            .then(|| format!("the first and the last of its {lines} differ by {there} (rms), neighbours by {usual}"))
    }
}
