//! The ladders of five samples.

use std::fs;
use std::path::Path;

use gonio_embree::experiment::Settings;
use gonio_embree::experiment::accuracy::{Effort, climb};
use gonio_embree::light::{Incidence, Light, Polarization, SourceMode, Wavelengths};
use gonio_embree::output::accuracy as output;
use gonio_embree::plot;
use gonio_embree::sample::Description;
use gonio_embree::sample::description::Sides;
use gonio_embree::sample::obj;
use gonio_embree::units::LengthUnit;

use super::Failed;

/// A ladder of the page.
pub struct Sample {
    /// Of its files.
    pub stem: &'static str,
    pub title: &'static str,
    /// Under `assets`.
    file: &'static str,
    theta_deg: f64,
    /// First and last wavelength, nm, and their number.
    wavelengths: (f64, f64, usize),
    trees: u64,
}

pub const SAMPLES: [Sample; 5] = [
    Sample {
        stem: "feather",
        title: "The feather",
        file: "feather.obj",
        theta_deg: 30.0,
        wavelengths: (400.0, 700.0, 16),
        trees: 40_000,
    },
    Sample {
        stem: "christiansen",
        title: "The Christiansen slab",
        file: "samples/christiansen.toml",
        theta_deg: 0.0,
        wavelengths: (400.0, 685.0, 20),
        trees: 4000,
    },
    Sample {
        stem: "web",
        title: "The oriented web",
        file: "samples/web-oriented.toml",
        theta_deg: 45.0,
        wavelengths: (450.0, 650.0, 3),
        trees: 12_000,
    },
    Sample {
        stem: "sphere",
        title: "A glass sphere",
        file: "samples/glass-sphere.toml",
        theta_deg: 30.0,
        wavelengths: (450.0, 650.0, 3),
        trees: 200_000,
    },
    Sample {
        stem: "morpho",
        title: "The Morpho film",
        file: "samples/morpho.toml",
        theta_deg: 20.0,
        wavelengths: (400.0, 700.0, 16),
        trees: 20_000,
    },
];

impl Sample {
    fn description(&self) -> Result<Description, Failed> {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets").join(self.file);
        if self.file.ends_with(".obj") {
            let options =
                obj::Options { unit: LengthUnit::Micrometre, sides: Sides::Periodic, patch: None, media: Vec::new() };
            return Ok(Description::from_obj(&path, &options)?);
        }
        Ok(Description::from_toml(&path)?)
    }

    fn light(&self) -> Result<Light, Failed> {
        let (first, last, count) = self.wavelengths;
        let nm = (0..count).map(|i| first + (last - first) * i as f64 / (count - 1) as f64).collect();
        Ok(Light {
            wavelengths: Wavelengths::from_nm(nm)?,
            incidences: vec![Incidence { theta_deg: self.theta_deg, phi_deg: 0.0 }],
            polarization: Polarization::Unpolarized,
            source: SourceMode::Band,
        })
    }

    /// The command that gives the same, but for the number of trees.
    pub fn command(&self) -> String {
        let (first, last, count) = self.wavelengths;
        let step = (last - first) / (count - 1) as f64;
        format!(
            "gonio-embree accuracy assets/{} --incident {} --wavelengths {first}:{last}:{step} --trees {}",
            self.file, self.theta_deg, self.trees
        )
    }
}

/// Climbs those that are not there, and leaves the tables and the pictures in `out`.
pub fn draw(out: &Path) -> Result<(), Failed> {
    for sample in SAMPLES.iter().filter(|s| !out.join(format!("{}.csv", s.stem)).exists()) {
        let settings = Settings { trees: sample.trees, ..Settings::default() };
        let ladder = climb(&sample.description()?, &sample.light()?, &settings, &Effort::FULL, |at| {
            if at.done % 50 == 0 {
                eprintln!("{}: {} of {}", sample.title, at.done, at.total);
            }
        })?;
        fs::write(out.join(format!("{}.svg", sample.stem)), plot::accuracy(&ladder, sample.title))?;
        fs::write(out.join(format!("{}.csv", sample.stem)), output::csv(&ladder))?;
        fs::write(out.join(format!("{}.txt", sample.stem)), output::text(&ladder))?;
    }
    Ok(())
}
