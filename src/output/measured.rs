//! A measurement as files hold it.

use std::fmt::Write as _;
use std::io;
use std::path::Path;

use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use crate::bsdf::Bsdf;

/// A measurement with all that is needed to understand it and to repeat it.
#[derive(Clone, Debug, PartialEq)]
pub struct Measured {
    /// What was measured.
    pub bsdf: Bsdf,
    /// How.
    pub provenance: Provenance,
}

/// How a result came about. It holds nothing that differs between two runs of the same command, such as times or
/// the number of threads: the same measurement gives the same bytes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Provenance {
    /// Version of this program.
    pub version: String,
    /// The command, without the options that cannot change the result.
    pub command: String,
    /// Seed of all random numbers.
    pub seed: u64,
    /// State of the incident light.
    pub polarization: String,
    /// What each wavelength stands for.
    pub source_mode: String,
    /// Files of the sample.
    pub sample_files: Vec<String>,
    /// SHA-256 of the contents of these files, one after the other.
    pub sample_sha256: String,
    /// Who intersected.
    pub backend: UsedBackend,
    /// Which effects were simulated.
    pub effects: Vec<EffectUsed>,
    /// Where ray optics is in doubt.
    pub validity: Validity,
    /// Stacks of films that were met.
    pub stacks: Vec<StackHits>,
    /// What is missing, of a result that was put together before all of it was there.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub incomplete: Option<String>,
}

/// An intersection backend.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct UsedBackend {
    /// Its name.
    pub name: String,
    /// Version of the library.
    pub version: String,
}

/// An effect that was simulated, or not.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EffectUsed {
    /// Its name.
    pub name: String,
    /// Whether it was simulated.
    pub on: bool,
    /// Why.
    pub reason: String,
    /// Bound of what leaving it out would change.
    pub bound: f64,
}

/// Where ray optics is in doubt.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Validity {
    /// The narrowest face or the thinnest film, µm; none if everything is endless.
    pub smallest_feature_um: Option<f64>,
    /// Largest share of the light, of all incidences and wavelengths, that met a face narrower than
    /// [`crate::plan::features::SMALL`] wavelengths outside of films.
    pub small_feature_flux: f64,
    /// Largest share of the light that met a stack of films so near to its edge that light in it would get there.
    pub edge_flux: f64,
    /// What was done there: `column` (the stack counts as endless) or `reject` (it is no stack).
    pub edges: String,
}

/// A stack of films that was met.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StackHits {
    /// Number of its layers.
    pub layers: usize,
    /// Their media, from the side of the light; long stacks are cut short.
    pub media: Vec<String>,
    /// Least and greatest thickness of each of these layers, µm.
    pub thickness_um: Vec<[f64; 2]>,
    /// How often.
    pub hits: u64,
    /// Power that met it, as a share of the incident power, mean of all incidences and wavelengths.
    pub flux_share: f64,
}

/// SHA-256 of the contents of `files`, one after the other, in hexadecimal digits.
///
/// # Errors
/// When one cannot be read.
pub fn sha256_of_files(files: &[impl AsRef<Path>]) -> io::Result<String> {
    let mut hash = Sha256::new();
    for file in files {
        hash.update(std::fs::read(file)?);
    }
    let mut text = String::new();
    for byte in hash.finalize() {
        let _ = write!(text, "{byte:02x}");
    }
    Ok(text)
}
