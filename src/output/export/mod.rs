//! Results in the formats of others. To add a format: a file with a pure function from a [`Source`] to bytes, a line in
//! [`Format`].

mod astm;
mod csv;
mod merl;
mod mueller;
mod npy;
mod points;
mod radiance;
mod rgl;
mod rows;
mod zemax;

use std::fmt;

use crate::bsdf::{Bsdf, Lookup};
use crate::colour::{self, Illuminant};
use crate::dome::klems;

pub use rgl::{Exits, Grid, Warped, tensor};

/// A format that a result can be written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// `measured` of Mitsuba 3, read by pbrt-v4, too.
    Rgl,
    /// The same in linear sRGB.
    RglRgb,
    /// `measured_polarized` of Mitsuba 3.
    Pbsdf,
    /// Radiance and WINDOW: Klems matrix of 145 patches.
    KlemsFull,
    /// Of 77 patches.
    KlemsHalf,
    /// Of 41 patches.
    KlemsQuarter,
    /// Radiance: isotropic tensor tree.
    TensorTree3,
    /// Radiance: anisotropic tensor tree.
    TensorTree4,
    /// Zemax OpticStudio.
    Zemax,
    /// ASTM E1392, E2387.
    Astm,
    /// MERL.
    Merl,
    /// A long table of the facets.
    Csv,
    /// The same for numpy.
    Npy,
}

/// Name on the command line, usual extension, who reads it.
type About = (Format, &'static str, &'static str, &'static str);

const ABOUT: [About; 13] = [
    (Format::Rgl, "rgl", "bsdf", "Mitsuba 3 (spectral variants), pbrt-v4: BRDF per wavelength"),
    (Format::RglRgb, "rgl-rgb", "bsdf", "Mitsuba 3 (RGB variants): BRDF in linear sRGB"),
    (Format::Pbsdf, "pbsdf", "pbsdf", "Mitsuba 3: Mueller matrices of an isotropic BRDF at five wavelengths"),
    (Format::KlemsFull, "klems-full", "xml", "Radiance, WINDOW: BRDF and BTDF in X, Y, Z, 145 patches"),
    (Format::KlemsHalf, "klems-half", "xml", "the same, 77 patches"),
    (Format::KlemsQuarter, "klems-quarter", "xml", "the same, 41 patches"),
    (Format::TensorTree3, "tensor-tree-3", "xml", "Radiance: isotropic BRDF and BTDF, 64 cells across"),
    (Format::TensorTree4, "tensor-tree-4", "xml", "Radiance: anisotropic BRDF and BTDF, 32 cells across"),
    (Format::Zemax, "zemax", "bsdf", "OpticStudio: BRDF, or BTDF with --below"),
    (Format::Astm, "astm", "astm", "text of ASTM E1392 and E2387: BRDF, or BTDF with --below, per wavelength"),
    (Format::Merl, "merl", "binary", "MERL: isotropic BRDF in linear sRGB"),
    (Format::Csv, "csv", "csv", "a table of all facets: pandas, spreadsheets"),
    (Format::Npy, "npy", "npy", "the same as a structured array: numpy"),
];

impl Format {
    /// All.
    pub fn all() -> impl Iterator<Item = Self> {
        ABOUT.iter().map(|a| a.0)
    }

    fn about(self) -> &'static About {
        ABOUT.iter().find(|a| a.0 == self).unwrap_or(&ABOUT[0])
    }

    /// Name on the command line.
    pub fn name(self) -> &'static str {
        self.about().1
    }

    /// What its files are called after the point.
    pub fn extension(self) -> &'static str {
        self.about().2
    }

    /// Who reads it, and what it holds.
    pub fn purpose(self) -> &'static str {
        self.about().3
    }
}

/// What is exported.
#[derive(Clone, Debug)]
pub struct Source<'a> {
    /// The result.
    pub front: &'a Lookup<'a>,
    /// The sample lit from below: turned about x by half a turn.
    pub back: Option<&'a Lookup<'a>>,
    /// Where it comes from.
    pub title: String,
    /// The only wavelength to export, by its number; all, or their colour, if none.
    pub wavelength: Option<usize>,
    /// Illuminant of the formats that hold colours.
    pub illuminant: Illuminant,
    /// BTDF in place of BRDF, in formats of one side.
    pub below: bool,
    /// Full width, degrees, of the lobe that stands for the specular (undeflected) part in formats that have no place for
    /// it; none leaves it out.
    pub specular_width_deg: Option<f64>,
}

/// A file, and what its format could not hold.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Exported {
    /// The file.
    pub bytes: Vec<u8>,
    /// To be told to the user.
    pub notes: Vec<String>,
}

/// Why a result cannot be had in a format.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExportError(String);

impl fmt::Display for ExportError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for ExportError {}

type Export = Result<Exported, ExportError>;

fn refuse<T>(why: impl Into<String>) -> Result<T, ExportError> {
    Err(ExportError(why.into()))
}

/// Writes the result in a format.
///
/// # Errors
/// What the format, or the result, lacks.
pub fn export(format: Format, source: &Source<'_>) -> Export {
    if source.bsdf().incidences.is_empty() || source.bsdf().wavelength_nm.is_empty() {
        return refuse("the result is empty");
    }
    match format {
        Format::Rgl => rgl::spectral(source),
        Format::RglRgb => rgl::rgb(source),
        Format::Pbsdf => mueller::write(source),
        Format::KlemsFull => radiance::klems(source, &klems::FULL),
        Format::KlemsHalf => radiance::klems(source, &klems::HALF),
        Format::KlemsQuarter => radiance::klems(source, &klems::QUARTER),
        Format::TensorTree3 => radiance::tree(source, 3),
        Format::TensorTree4 => radiance::tree(source, 4),
        Format::Zemax => zemax::write(source),
        Format::Astm => astm::write(source),
        Format::Merl => merl::write(source),
        Format::Csv => Ok(csv::write(source)),
        Format::Npy => Ok(npy::write(source)),
    }
}

impl Source<'_> {
    fn bsdf(&self) -> &Bsdf {
        self.front.bsdf()
    }

    /// Numbers of the wavelengths to export.
    fn wavelengths(&self) -> Vec<usize> {
        self.wavelength.map_or_else(|| (0..self.bsdf().wavelength_nm.len()).collect(), |w| vec![w])
    }

    /// What the channels of a colour format are made of.
    fn channels(&self) -> Result<Channels, ExportError> {
        if let Some(w) = self.wavelength {
            return Ok(Channels::One(w));
        }
        match colour::weights(self.illuminant, &self.bsdf().wavelength_nm) {
            Some(weights) => Ok(Channels::Colour(weights)),
            None => {
                let ((first, last), gap) = (colour::VISIBLE_NM, colour::WIDEST_GAP_NM);
                refuse(format!(
                    "its wavelengths do not tell a colour: expected {first} to {last} nm in steps of at most {gap} nm; \
                     --wavelength exports one of them"
                ))
            }
        }
    }

    /// Whether anything leaves below.
    fn transmits(lookup: &Lookup<'_>) -> bool {
        lookup.bsdf().incidences.iter().any(|s| s.ledger.transmitted.iter().any(|e| e.value > 0.0))
    }

    /// What the format of one side of the sample leaves out.
    fn of_one_side(&self, notes: &mut Vec<String>) {
        if !self.below && Self::transmits(self.front) {
            notes.push(
                "light that is transmitted is not in this file: klems-full, tensor-tree-4, zemax --below, csv and npy hold it"
                    .into(),
            );
        }
    }

    /// Tells how the specular part is held.
    fn of_specular(&self, notes: &mut Vec<String>) {
        let entry = |s: &crate::bsdf::Scattering| {
            let part = if self.below { &s.ledger.undeflected } else { &s.ledger.specular };
            part.iter().map(|e| e.value).fold(0.0, f64::max)
        };
        let most = self.bsdf().incidences.iter().map(entry).fold(0.0, f64::max);
        if most == 0.0 {
            return;
        }
        let name = if self.below { "undeflected" } else { "specular" };
        notes.push(match self.specular_width_deg {
            Some(width) => format!(
                "the {name} part, up to {most:.3} of the light, is a lobe {width}° wide (--specular-width): the format has no place \
                 for one direction"
            ),
            None => format!("the {name} part, up to {most:.3} of the light, is left out"),
        });
    }

    /// Of a format that knows isotropic samples only.
    fn must_be_isotropic(&self, others: &str) -> Result<(), ExportError> {
        if self.front.is_isotropic() && self.back.is_none_or(Lookup::is_isotropic) {
            return Ok(());
        }
        refuse(format!("the sample was measured from several azimuths, and this format is isotropic: {others}"))
    }
}

/// What the channels of a colour format are made of.
#[derive(Clone, Debug, PartialEq)]
enum Channels {
    /// X, Y and Z, by what each wavelength adds.
    Colour(Vec<[f64; 3]>),
    /// One wavelength.
    One(usize),
}

impl Channels {
    /// X, Y and Z of a spectrum; one wavelength is all three.
    fn xyz(&self, spectrum: &[f64]) -> [f64; 3] {
        match self {
            Self::Colour(weights) => colour::summed(weights, spectrum.iter().copied()),
            &Self::One(w) => [spectrum[w]; 3],
        }
    }
}
