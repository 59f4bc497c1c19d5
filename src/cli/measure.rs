//! The default command: measure a sample.

use std::path::{Path, PathBuf};

use clap::{ArgGroup, Args};
use glam::DVec2;
use gonio_embree::dome::FINEST_LEVEL;
use gonio_embree::experiment::{Origin, Outcome, Settings, measure};
use gonio_embree::intersect::choose::Backend;
use gonio_embree::light::{Incidence, Light, Polarization, SourceMode, Wavelengths};
use gonio_embree::output::{Measured, atomic, netcdf, sha256_of_files, summary, table};
use gonio_embree::plan::{self, Edges, Limits, Name, Probe, Wanted};
use gonio_embree::plot;
use gonio_embree::sample::description::Sides;
use gonio_embree::sample::{Description, Sample, obj};
use gonio_embree::units::{self, LengthUnit};

use super::medium::NamedMedium;
use super::numbers::{Count, Values};
use super::progress::{Line, duration};
use super::{Failure, answer, tell};

/// Options of a measurement.
#[derive(Debug, Args)]
#[command(group(ArgGroup::new("input").args(["mesh", "sample"]).required(true)))]
pub struct Options {
    /// A mesh: every part with a material is a body
    #[arg(long, value_name = "FILE.obj", help_heading = "Sample")]
    mesh: Option<PathBuf>,
    /// A sample file
    #[arg(long, value_name = "FILE.toml", help_heading = "Sample")]
    sample: Option<PathBuf>,
    /// Unit of a mesh: nm, um, mm or m
    #[arg(long, default_value = "um", conflicts_with = "sample", help_heading = "Sample")]
    unit: LengthUnit,
    /// What lies beside a mesh: itself again for ever (periodic), or nothing (open)
    #[arg(long, default_value = "periodic", conflicts_with = "sample", help_heading = "Sample")]
    sides: Sides,
    /// Footprint of the beam on a mesh [default: its bounding box]
    #[arg(long, value_name = "W,D", conflicts_with = "sample", help_heading = "Sample")]
    patch: Option<String>,
    /// Medium of a material of a mesh: its index, such as melanin=2.0+0.01i, or a file (.yml of refractiveindex.info,
    /// .csv); may be repeated
    #[arg(long, value_name = "NAME=INDEX|FILE", conflicts_with = "sample", help_heading = "Sample")]
    medium: Vec<NamedMedium>,

    /// Polar angles of incidence in degrees: start:stop:step (both ends), a list 0,20,75, or one number
    #[arg(long, default_value = "0", allow_hyphen_values = true, value_name = "ANGLES", help_heading = "Light")]
    incident: Values,
    /// Azimuths of incidence in degrees, same forms
    #[arg(long, default_value = "0", allow_hyphen_values = true, value_name = "ANGLES", help_heading = "Light")]
    azimuth: Values,
    /// Vacuum wavelengths in nm, same forms
    #[arg(long, default_value = "400:700:20", value_name = "NM", help_heading = "Light")]
    wavelengths: Values,
    /// State of polarization: unpolarized, s, p, a Stokes vector 1,Q,U,V (Q = p − s), or mueller (all of them: the result
    /// has the 4×4 matrices)
    #[arg(
        long,
        default_value = "unpolarized",
        value_name = "STATE",
        allow_hyphen_values = true,
        help_heading = "Light"
    )]
    polarization: Polarization,
    /// What a wavelength stands for: its band (finite coherence length), or a laser line
    #[arg(long, default_value = "band", value_name = "MODE", help_heading = "Light")]
    source_mode: SourceMode,
    /// Coherence length λ²/Δλ of a Gaussian line, such as 30um, in place of a source mode
    #[arg(
        long,
        value_name = "LENGTH",
        allow_hyphen_values = true,
        conflicts_with = "source_mode",
        help_heading = "Light"
    )]
    coherence_length: Option<String>,

    /// Ray trees per incidence: 200000, 2e5, 200k or 1M
    #[arg(long, default_value = "200k", value_name = "N", help_heading = "Work")]
    trees: Count,
    /// Effects to simulate: auto (those that can matter) or all; +NAME or -NAME switches one by hand, as in auto,-dispersion
    #[arg(long, default_value = "auto", value_name = "EFFECTS", allow_hyphen_values = true, help_heading = "Work")]
    effects: Wanted,
    /// Along what films are searched: normal, or refracted (as the paper does)
    #[arg(long, default_value = "normal", value_name = "HOW", help_heading = "Work")]
    probe: Probe,
    /// Films near the edge of a layer: column (as if it had no end), or reject (no film there)
    #[arg(long, default_value = "column", value_name = "HOW", help_heading = "Work")]
    edges: Edges,
    /// Degrees by which the direction of a wavelength may differ from that of the ray it shares with others; 0: none share
    /// [default: an eighth of a facet of the dome]
    #[arg(long, value_name = "DEG", allow_hyphen_values = true, help_heading = "Work")]
    spread: Option<f64>,
    /// Finest level of the geodesic dome; its facets are 63°/2^level wide
    #[arg(long, default_value_t = plan::DOME_LEVEL, value_name = "LEVEL", help_heading = "Work",
          value_parser = clap::value_parser!(u8).range(1..=i64::from(FINEST_LEVEL)))]
    dome_level: u8,
    /// Interfaces a ray may meet before its power counts as lost
    #[arg(long, default_value_t = Limits::default().depth, value_name = "N", help_heading = "Work",
          value_parser = clap::value_parser!(u32).range(1..))]
    depth: u32,
    /// Who intersects: auto, embree, obvhs or brute
    #[arg(long, default_value = "auto", help_heading = "Work")]
    backend: Backend,
    /// Threads; results do not depend on it [default: all cores]
    #[arg(long, value_name = "N", help_heading = "Work", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Seed of all random numbers
    #[arg(long, default_value_t = 1, value_name = "N", help_heading = "Work")]
    seed: u64,
    /// Largest share of the light that may be lost before the exit code is 1
    #[arg(long, default_value_t = 1e-4, value_name = "SHARE", help_heading = "Work")]
    max_lost: f64,

    /// The result; a picture goes beside it [default: name of the input, .nc]
    #[arg(short, long, value_name = "FILE.nc", help_heading = "Output")]
    output: Option<PathBuf>,
    /// Print one JSON document instead of the table
    #[arg(long, help_heading = "Output")]
    pub(super) json: bool,
    /// Show no progress
    #[arg(long, help_heading = "Output")]
    pub(super) quiet: bool,
}

/// Measures, and writes what came out.
pub fn run(options: &Options) -> Result<(), Failure> {
    let light = options.light()?;
    let description = options.description()?;
    let sample =
        Sample::new(&description, &light.wavelengths, light.coherence()).map_err(|e| Failure::Input(e.to_string()))?;
    let origin = options.origin(&description)?;
    let output = options.output_path();
    let picture = output.with_extension("svg");
    if picture == output {
        return Err(Failure::Input("--output: the .svg file is for the picture; name the result FILE.nc".into()));
    }
    for path in [&output, &picture] {
        atomic::check(path)
            .map_err(|e| Failure::Input(format!("--output {}: cannot be written: {e}", path.display())))?;
    }
    let settings = options.settings()?;
    let mut line = Line::new(options.quiet);
    let outcome = measure(&sample, &light, &settings, |p| line.show(&p, light.incidences.len()));
    line.clear();
    let outcome = outcome.map_err(|e| Failure::Cannot(e.to_string()))?;
    let times = times(&outcome);
    let run = summary::Run { seconds: outcome.seconds, threads: settings.threads };
    let measured = outcome.into_measured(&sample, &light, &settings, origin);
    let bytes = netcdf::to_bytes(&measured).map_err(|e| Failure::Cannot(e.to_string()))?;
    write(&output, &bytes)?;
    write(&picture, plot::measurement(&measured).as_bytes())?;
    answer(&if options.json { summary::json(&measured, &run) + "\n" } else { table::text(&measured) })?;
    if !options.quiet {
        tell(&format!("wrote {} and {}; {times}", output.display(), picture.display()));
    }
    options.gate(&measured)
}

fn write(path: &Path, bytes: &[u8]) -> Result<(), Failure> {
    atomic::write(path, bytes).map_err(|e| Failure::Cannot(format!("{}: cannot be written: {e}", path.display())))
}

fn times(outcome: &Outcome) -> String {
    let trees: u64 = outcome.bsdf.incidences.iter().map(|s| s.trees).sum();
    let rate = trees as f64 / outcome.tracing_seconds / 1e6;
    format!(
        "{} in all, {} of it tracing ({rate:.3} M trees/s)",
        duration(outcome.seconds),
        duration(outcome.tracing_seconds)
    )
}

impl Options {
    pub(super) fn light(&self) -> Result<Light, Failure> {
        let mut incidences = Vec::new();
        for &phi_deg in &self.azimuth.all {
            for &theta_deg in &self.incident.all {
                if !(0.0..=Incidence::MAX_THETA_DEG).contains(&theta_deg) {
                    let most = Incidence::MAX_THETA_DEG;
                    return Err(Failure::Input(format!("--incident: {theta_deg}°: expected 0 to {most}°")));
                }
                incidences.push(Incidence { theta_deg, phi_deg });
            }
        }
        let wavelengths = Wavelengths::from_nm(self.wavelengths.all.clone())
            .map_err(|e| Failure::Input(format!("--wavelengths: {e}")))?;
        Ok(Light { wavelengths, incidences, polarization: self.polarization, source: self.source()? })
    }

    fn source(&self) -> Result<SourceMode, Failure> {
        let Some(text) = &self.coherence_length else { return Ok(self.source_mode) };
        match units::length(text, LengthUnit::Micrometre) {
            Ok(um) if um > 0.0 && um.is_finite() => Ok(SourceMode::Gaussian(um)),
            _ => Err(Failure::Input(format!(
                "--coherence-length {text}: expected a length greater than 0, such as 30um; for a laser --source-mode line"
            ))),
        }
    }

    pub(super) fn description(&self) -> Result<Description, Failure> {
        let wrong = |e: &dyn std::fmt::Display| Failure::Input(e.to_string());
        match (&self.mesh, &self.sample) {
            (Some(path), _) => {
                let media =
                    self.medium.iter().map(|m| Ok((m.name.clone(), m.dispersion()?))).collect::<Result<_, _>>()?;
                let options = obj::Options { unit: self.unit, sides: self.sides, patch: self.patch()?, media };
                let mut description = Description::from_obj(path, &options).map_err(|e| wrong(&e))?;
                description.files.extend(self.medium.iter().filter_map(NamedMedium::file).map(Path::to_path_buf));
                Ok(description)
            }
            (None, Some(path)) => {
                let description = Description::from_toml(path).map_err(|e| wrong(&e))?;
                description.remarks().iter().for_each(|remark| tell(&format!("warning: {remark}")));
                Ok(description)
            }
            (None, None) => Err(Failure::Input("give --mesh FILE.obj or --sample FILE.toml".into())),
        }
    }

    /// Size of the footprint on a mesh, µm.
    fn patch(&self) -> Result<Option<DVec2>, Failure> {
        let Some(text) = &self.patch else { return Ok(None) };
        let lengths: Vec<f64> = text.split(',').filter_map(|x| units::length(x, self.unit).ok()).collect();
        match lengths[..] {
            [w, d] if w > 0.0 && d > 0.0 && text.split(',').count() == 2 => Ok(Some(DVec2::new(w, d))),
            _ => Err(Failure::Input(format!("--patch {text}: expected two lengths greater than 0, such as 12,10"))),
        }
    }

    pub(super) fn settings(&self) -> Result<Settings, Failure> {
        let default = Settings::default();
        let spread = match self.spread {
            None => Limits::spread_for(self.dome_level),
            Some(degrees) if (0.0..=90.0).contains(&degrees) => degrees.to_radians(),
            Some(degrees) => return Err(Failure::Input(format!("--spread {degrees}: expected 0 to 90 degrees"))),
        };
        if self.polarization == Polarization::Mueller && self.effects.by_hand(Name::Polarization) == Some(false) {
            return Err(Failure::Input(
                "--polarization mueller needs what --effects -polarization leaves out: give one of the two".into(),
            ));
        }
        Ok(Settings {
            trees: self.trees.0,
            seed: self.seed,
            threads: self.threads.map_or(default.threads, usize::from),
            backend: self.backend,
            dome_level: self.dome_level,
            options: plan::Options {
                limits: Limits { depth: self.depth, spread, ..Limits::default() },
                wanted: self.effects,
                probe: self.probe,
                edges: self.edges,
                ..default.options
            },
        })
    }

    fn input(&self) -> &Path {
        self.mesh.as_ref().or(self.sample.as_ref()).map_or(Path::new("result"), PathBuf::as_path)
    }

    fn output_path(&self) -> PathBuf {
        let stem = || PathBuf::from(self.input().file_stem().unwrap_or_default()).with_extension("nc");
        self.output.clone().unwrap_or_else(stem)
    }

    fn origin(&self, description: &Description) -> Result<Origin, Failure> {
        let files = description.files.clone();
        let sha256 = sha256_of_files(&files).map_err(|e| Failure::Input(format!("the sample cannot be read: {e}")))?;
        Ok(Origin { command: self.command(), files, sha256 })
    }

    /// The command that gives the same result.
    fn command(&self) -> String {
        let mut out = String::from("gonio-embree");
        let mut add = |name: &str, value: &dyn std::fmt::Display| out += &format!(" --{name} {value}");
        match (&self.mesh, &self.sample) {
            (Some(path), _) => {
                add("mesh", &path.display());
                add("unit", &self.unit);
                add("sides", &self.sides);
                self.patch.iter().for_each(|p| add("patch", p));
                self.medium.iter().for_each(|m| add("medium", m));
            }
            (None, path) => path.iter().for_each(|p| add("sample", &p.display())),
        }
        add("incident", &self.incident);
        add("azimuth", &self.azimuth);
        add("wavelengths", &self.wavelengths);
        add("polarization", &self.polarization);
        match &self.coherence_length {
            Some(length) => add("coherence-length", length),
            None => add("source-mode", &self.source_mode),
        }
        add("trees", &self.trees);
        add("effects", &self.effects);
        add("probe", &self.probe);
        add("edges", &self.edges);
        self.spread.iter().for_each(|s| add("spread", s));
        add("dome-level", &self.dome_level);
        add("depth", &self.depth);
        add("backend", &self.backend);
        add("seed", &self.seed);
        out
    }

    fn gate(&self, measured: &Measured) -> Result<(), Failure> {
        let lost = measured.bsdf.largest_loss();
        if lost <= self.max_lost {
            return Ok(());
        }
        Err(Failure::Quality(format!(
            "{lost:.2e} of the light was lost, more than --max-lost {:e}; the table says to what: a greater --depth \
             helps against lost_depth, a mended mesh against lost_medium",
            self.max_lost
        )))
    }
}
