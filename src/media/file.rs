//! Media from files of the user.

use std::path::Path;

use super::yaml::Wrong;
use super::{Dispersion, csv, refractiveindex};
use crate::text;

/// Largest file taken, bytes.
const MOST_BYTES: u64 = 100 << 20;

/// A medium from a file.
#[derive(Clone, Debug, PartialEq)]
pub struct FromFile {
    /// The numbers.
    pub dispersion: Dispersion,
    /// What the file says of where they come from: `REFERENCES` as it is there, or the comments of a table.
    pub source: String,
}

/// Whether a text that may be an index or a name is that of a file of a medium: it ends in .yml, .yaml or .csv.
pub fn is_file(text: &str) -> bool {
    format_of(Path::new(text)).is_some()
}

#[derive(Clone, Copy)]
enum Format {
    RefractiveIndex,
    Csv,
}

fn format_of(path: &Path) -> Option<Format> {
    match path.extension()?.to_str()?.to_lowercase().as_str() {
        "yml" | "yaml" => Some(Format::RefractiveIndex),
        "csv" => Some(Format::Csv),
        _ => None,
    }
}

/// Reads a file of refractiveindex.info (.yml, .yaml), or a table (.csv) of columns wavelength in nm, n and, where it
/// absorbs, k.
///
/// # Errors
/// File, line and what was expected.
pub fn read_file(path: &Path) -> Result<FromFile, String> {
    let expected = "expected a file of refractiveindex.info (.yml or .yaml) or a table (.csv)";
    read(path, format_of(path).ok_or_else(|| format!("{}: {expected}", path.display()))?)
}

/// Reads a table, whatever the name of the file.
///
/// # Errors
/// File, line and what was expected.
pub fn read_csv(path: &Path) -> Result<FromFile, String> {
    read(path, Format::Csv)
}

fn read(path: &Path, format: Format) -> Result<FromFile, String> {
    let text = text::read(path, MOST_BYTES).map_err(|e| format!("{}: {e}", path.display()))?;
    // Some editors begin a file with a mark of its encoding.
    let text = text.trim_start_matches('\u{feff}');
    let read = match format {
        Format::RefractiveIndex => refractiveindex::parse(text).map(|page| (page.dispersion, page.references)),
        Format::Csv => csv::parse(text).map(|dispersion| (dispersion, csv::comments(text))),
    };
    let wrong = |Wrong { line, message }: Wrong| format!("{}:{line}: {message}", path.display());
    read.map(|(dispersion, source)| FromFile { dispersion, source }).map_err(wrong)
}
