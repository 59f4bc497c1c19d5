//! What a figure is made of, and how samples are measured for it.

use std::error::Error;
use std::fmt::Display;
use std::path::Path;

use gonio_embree::experiment::{Outcome, Settings, measure};
use gonio_embree::light::{Incidence, Light, Polarization, SourceMode, Wavelengths};
use gonio_embree::output::atomic;
use gonio_embree::sample::{Description, Sample};

use gonio_embree::plot;

pub type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// How much work a figure may be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effort {
    /// A minute for all figures.
    Quick,
    /// As much as the statements need.
    Full,
}

impl Effort {
    /// One of two numbers.
    pub fn pick<T>(self, quick: T, full: T) -> T {
        if self == Self::Quick { quick } else { full }
    }
}

/// A statement that is tested.
#[derive(Clone, Debug)]
pub struct Claim {
    pub what: String,
    pub holds: bool,
}

impl Claim {
    pub fn new(what: impl Into<String>, holds: bool) -> Self {
        Self { what: what.into(), holds }
    }
}

/// A figure with what is to be said about it.
#[derive(Debug)]
pub struct Figure {
    pub title: String,
    /// The files of its samples, and how they were measured.
    pub made_of: String,
    /// What the paper says.
    pub says: String,
    /// What comes out here: one sentence each.
    pub finds: Vec<String>,
    /// What must be so, of what the paper says or in its place.
    pub claims: Vec<Claim>,
    /// Whether the paper's statements hold here if the claims do, and why not where not.
    pub verdict: String,
    pub svg: String,
    pub csv: Table,
}

impl Figure {
    /// Writes `figure-N.svg`, `.png` and `.csv`.
    pub fn write(&self, number: &str, out: &Path) -> Result<()> {
        let file = |extension: &str| out.join(format!("figure-{number}.{extension}"));
        atomic::write(&file("svg"), self.svg.as_bytes())?;
        atomic::write(&file("png"), &plot::png(&self.svg)?)?;
        Ok(atomic::write(&file("csv"), self.csv.0.as_bytes())?)
    }
}

/// Rows of numbers under their names.
#[derive(Debug)]
pub struct Table(pub String);

impl Table {
    pub fn new(columns: &[&str]) -> Self {
        Self(columns.join(",") + "\n")
    }

    /// Adds a row.
    pub fn row(&mut self, fields: &[&dyn Display]) {
        let row: Vec<String> = fields.iter().map(ToString::to_string).collect();
        self.0 += &(row.join(",") + "\n");
    }
}

/// Light for a figure.
pub fn light(nm: &[f64], incidences: &[(f64, f64)], polarization: Polarization, source: SourceMode) -> Result<Light> {
    Ok(Light {
        wavelengths: Wavelengths::from_nm(nm.to_vec())?,
        incidences: incidences.iter().map(|&(theta_deg, phi_deg)| Incidence { theta_deg, phi_deg }).collect(),
        polarization,
        source,
    })
}

/// Measures a file of `assets/samples`.
pub fn measure_file(file: &str, light: &Light, settings: &Settings) -> Result<Outcome> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/samples").join(file);
    measure_description(&Description::from_toml(&path)?, light, settings)
}

/// Measures a sample.
pub fn measure_description(description: &Description, light: &Light, settings: &Settings) -> Result<Outcome> {
    let sample = Sample::new(description, &light.wavelengths, light.coherence())?;
    Ok(measure(&sample, light, settings, |_| {})?)
}

/// A column of a CSV file in `tests/reference`, with its rows' first number.
pub fn reference(file: &str, column: &str) -> Result<Vec<(f64, f64)>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference").join(file);
    let text = std::fs::read_to_string(&path)?;
    let mut lines = text.lines();
    let names = lines.next().ok_or("no columns")?;
    let at = names.split(',').position(|n| n == column).ok_or_else(|| format!("{file} has no column {column}"))?;
    let numbers = |line: &str| -> Result<(f64, f64)> {
        let fields: Vec<&str> = line.split(',').collect();
        Ok((fields[0].parse()?, fields[at].parse()?))
    };
    lines.map(numbers).collect()
}

/// Numbers from `from` to `to`.
pub fn steps(from: f64, to: f64, step: f64) -> Vec<f64> {
    (0..=((to - from) / step).round() as usize).map(|i| from + step * i as f64).collect()
}
