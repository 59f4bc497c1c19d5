//! Options of everything that traces: the sample, its light, and how the work is done.

use std::path::{Path, PathBuf};

use clap::{ArgGroup, Args};
use glam::DVec2;
use gonio_embree::dome::FINEST_LEVEL;
use gonio_embree::experiment::{Goal, Origin, Settings, Target};
use gonio_embree::intersect::choose::Backend;
use gonio_embree::light::{Incidence, Light, Polarization, SourceMode, Wavelengths};
use gonio_embree::output::sha256_of_files;
use gonio_embree::plan::{self, Edges, Limits, Name, Probe, Wanted};
use gonio_embree::sample::description::Sides;
use gonio_embree::sample::{Description, Replacement, Sample, obj};
use gonio_embree::units::{self, LengthUnit};

use super::incident::Incident;
use super::medium::NamedMedium;
use super::numbers::{Count, Values};
use super::{Failure, tell};

/// What is given if the user gives nothing.
const INCIDENT: &str = "0";
const AZIMUTH: &str = "0";
const WAVELENGTHS: &str = "400:700:20";

/// The sample, its light, and how the work is done.
#[derive(Clone, Debug, Args)]
#[command(group(ArgGroup::new("input").args(["mesh", "sample"])))]
pub struct Setup {
    /// A mesh: every part with a material is a body
    #[arg(long, value_name = "FILE.obj", help_heading = "Sample")]
    mesh: Option<PathBuf>,
    /// A sample file
    #[arg(long, value_name = "FILE.toml", help_heading = "Sample")]
    sample: Option<PathBuf>,
    /// Another value in the sample file, such as objects.fibre.radius=0.4 or sample.below=water; may be repeated
    #[arg(long, value_name = "KEY=VALUE", conflicts_with = "mesh", help_heading = "Sample")]
    set: Vec<Replacement>,
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

    /// Polar angles of incidence in degrees: start:stop:step (both ends), a list 0,20,75, or one number; or the directions of
    /// a matrix, with their azimuths: klems-full (145), klems-half (77) or klems-quarter (41) [default: 0]
    #[arg(long, allow_hyphen_values = true, value_name = "ANGLES", help_heading = "Light")]
    pub incident: Option<Incident>,
    /// Azimuths of incidence in degrees, same forms [default: 0]
    #[arg(long, allow_hyphen_values = true, value_name = "ANGLES", help_heading = "Light")]
    pub azimuth: Option<Values>,
    /// Vacuum wavelengths in nm, same forms [default: 400:700:20]
    #[arg(long, visible_alias = "wavelength", value_name = "NM", help_heading = "Light")]
    pub wavelengths: Option<Values>,
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
    #[arg(long, default_value = "200k", value_name = "N", help_heading = "Work",
          conflicts_with_all = ["target_error", "max_time", "max_rounds"])]
    trees: Count,
    /// Trace until this error is reached (by 95 of 100 measurements): 1% of the BRDF and the BTDF over the dome, seen in facets
    /// of 8°, and of all reflected and all transmitted light; facet:5% of the worst facet that has at least a hundredth of the
    /// brightest. Work doubles from round to round, for the incidences that need it most
    #[arg(long, value_name = "ERROR", help_heading = "Work")]
    target_error: Option<Target>,
    /// End in time, such as 60s, 5min or 2h: a round that would not fit is made smaller, and is the last; alone: use so much
    /// time
    #[arg(long, value_name = "TIME", allow_hyphen_values = true, help_heading = "Work")]
    max_time: Option<String>,
    /// End after so many rounds; of the last one a part such as 0.25. A run that had no time left tells how many it was
    #[arg(long, value_name = "N", allow_hyphen_values = true, help_heading = "Work")]
    max_rounds: Option<f64>,
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
    /// Who intersects: auto, embree, obvhs, grid (packings of spheres) or brute
    #[arg(long, default_value = "auto", help_heading = "Work")]
    backend: Backend,
    /// Threads; results do not depend on it [default: all cores]
    #[arg(long, value_name = "N", help_heading = "Work", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Seed of all random numbers
    #[arg(long, default_value_t = 1, value_name = "N", help_heading = "Work")]
    seed: u64,
}

/// All that may be used: what a queue has given, or all cores.
pub fn all_threads() -> usize {
    let given = |name| std::env::var(name).ok().and_then(|n| n.parse().ok()).filter(|&n: &usize| n > 0);
    // Slurm tells of cores in one of two ways, and does not keep programs from seeing more.
    let of_queue = ["SLURM_CPUS_PER_TASK", "SLURM_CPUS_ON_NODE"].into_iter().find_map(given);
    of_queue.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, usize::from))
}

fn values(given: &Option<Values>, default: &str) -> Result<Values, Failure> {
    given.clone().map_or_else(|| default.parse().map_err(Failure::Input), Ok)
}

/// What is measured, with the files it came from.
pub struct Scene {
    pub light: Light,
    pub sample: Sample,
    pub files: Vec<PathBuf>,
}

impl Setup {
    /// The sample under its light.
    pub fn scene(&self) -> Result<Scene, Failure> {
        let light = self.light()?;
        let description = self.description()?;
        let sample = Sample::new(&description, &light.wavelengths, light.coherence())
            .map_err(|e| Failure::Input(e.to_string()))?;
        Ok(Scene { light, sample, files: description.files })
    }

    /// The same of another sample, a mesh if it is called after one.
    pub fn of(&self, path: &Path) -> Self {
        let path = Some(path.to_path_buf());
        let is_mesh = path.as_ref().is_some_and(|p| p.extension().is_some_and(|e| e.eq_ignore_ascii_case("obj")));
        let (mesh, sample) = if is_mesh { (path, None) } else { (None, path) };
        Self { mesh, sample, ..self.clone() }
    }

    /// On so many threads, unless it says itself.
    pub fn use_threads(&mut self, threads: usize) {
        self.threads = self.threads.or(u16::try_from(threads).ok());
    }

    /// What shines on the sample.
    pub fn light(&self) -> Result<Light, Failure> {
        let incidences = self.incidences()?;
        for incidence in &incidences {
            incidence.check().map_err(|e| Failure::Input(format!("--incident: {e}")))?;
        }
        let wavelengths = Wavelengths::from_nm(values(&self.wavelengths, WAVELENGTHS)?.all)
            .map_err(|e| Failure::Input(format!("--wavelengths: {e}")))?;
        Ok(Light { wavelengths, incidences, polarization: self.polarization, source: self.source()? })
    }

    fn incidences(&self) -> Result<Vec<Incidence>, Failure> {
        let of = |[theta_deg, phi_deg]: [f64; 2]| Incidence { theta_deg, phi_deg };
        match (&self.incident, &self.azimuth) {
            (Some(Incident::Klems(name, _)), Some(_)) => Err(Failure::Input(format!(
                "--azimuth: the directions of {name} have their own azimuths; leave it out"
            ))),
            (Some(Incident::Klems(_, basis)), None) => Ok(basis.sources().map(of).collect()),
            (angles, azimuths) => {
                let thetas = match angles {
                    Some(Incident::Angles(thetas)) => thetas.clone(),
                    _ => values(&None, INCIDENT)?,
                };
                let phis = values(azimuths, AZIMUTH)?.all;
                Ok(phis.iter().flat_map(|&phi| thetas.all.iter().map(move |&theta| of([theta, phi]))).collect())
            }
        }
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

    /// What lies under the instrument.
    pub fn description(&self) -> Result<Description, Failure> {
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
                let description = Description::from_toml_with(path, &self.set).map_err(|e| wrong(&e))?;
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

    /// How it is measured.
    pub fn settings(&self) -> Result<Settings, Failure> {
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
        let goal = self.goal()?;
        Ok(Settings {
            trees: if goal.is_some() { default.trees } else { self.trees.0 },
            goal,
            seed: self.seed,
            threads: self.threads.map_or_else(all_threads, usize::from),
            backend: self.backend,
            dome_level: self.dome_level,
            options: plan::Options {
                limits: Limits { depth: self.depth, spread, ..Limits::default() },
                wanted: self.effects,
                probe: self.probe,
                edges: self.edges,
                error: self.target_error.map_or(default.options.error, Target::error),
            },
            arm: None,
        })
    }

    /// When enough is traced, if not after a number of trees.
    fn goal(&self) -> Result<Option<Goal>, Failure> {
        if let Some(rounds) = self.max_rounds.filter(|r| !(*r >= 1.0 && r.is_finite())) {
            return Err(Failure::Input(format!("--max-rounds {rounds}: expected 1 or more")));
        }
        let seconds = self.max_time.as_deref().map(units::seconds).transpose();
        let goal = Goal {
            target: self.target_error,
            max_seconds: seconds.map_err(|e| Failure::Input(format!("--max-time {e}")))?,
            max_rounds: self.max_rounds,
        };
        Ok((goal != Goal::default()).then_some(goal))
    }

    /// The file of the sample.
    pub fn input(&self) -> &Path {
        self.mesh.as_ref().or(self.sample.as_ref()).map_or(Path::new("result"), PathBuf::as_path)
    }

    /// Where the sample comes from, and the command that gives the same result.
    pub fn origin(&self, files: Vec<PathBuf>) -> Result<Origin, Failure> {
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
            (None, path) => {
                path.iter().for_each(|p| add("sample", &p.display()));
                self.set.iter().for_each(|s| add("set", s));
            }
        }
        let text = |given: &Option<Values>, default: &str| given.as_ref().map_or(default.into(), Values::to_string);
        add("incident", &self.incident.as_ref().map_or(INCIDENT.into(), Incident::to_string));
        if !matches!(self.incident, Some(Incident::Klems(..))) {
            add("azimuth", &text(&self.azimuth, AZIMUTH));
        }
        add("wavelengths", &text(&self.wavelengths, WAVELENGTHS));
        add("polarization", &self.polarization);
        match &self.coherence_length {
            Some(length) => add("coherence-length", length),
            None => add("source-mode", &self.source_mode),
        }
        if self.target_error.is_none() && self.max_time.is_none() && self.max_rounds.is_none() {
            add("trees", &self.trees);
        }
        self.target_error.iter().for_each(|t| add("target-error", t));
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
}
