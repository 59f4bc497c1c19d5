//! `scan`: what a detector on the arm of a goniometer reads.

use std::path::{Path, PathBuf};

use clap::Args;
use gonio_embree::bsdf::{Arm, Overlay, Point, Scan};
use gonio_embree::experiment::{Settings, measure};
use gonio_embree::output::{overlay, scan as output};
use gonio_embree::plot;

use super::incident::Incident;
use super::numbers::Values;
use super::progress::{Line, SETTING_UP, Waiting};
use super::setup::{Scene, Setup};
use super::work::reached;
use super::{Failure, answer, draw, stored, tell};

/// Options that a result has answered already.
const FOR_A_SAMPLE: [&str; 22] = [
    "mesh",
    "sample",
    "unit",
    "sides",
    "patch",
    "medium",
    "polarization",
    "source_mode",
    "coherence_length",
    "trees",
    "target_error",
    "max_time",
    "max_rounds",
    "effects",
    "probe",
    "edges",
    "spread",
    "dome_level",
    "depth",
    "backend",
    "threads",
    "seed",
];
/// More lost light than this spoils a scan.
const MOST_LOST: f64 = 1e-4;

/// Options of `scan`.
#[derive(Debug, Args)]
#[command(
    after_help = "A stored result is read under the detector's aperture, facet by facet: nothing finer than these shows. \
    With --mesh or --sample the light is measured by the detector itself:\n  \
    gonio-embree scan feather.nc --incident 45 --wavelength 560 --csv\n  \
    gonio-embree scan --sample web.toml --incident 20,45,75 --wavelength 670 --polarization s --trees 2M -o web.svg\n\
    --azimuth 90 turns the sample by 90° under the light, the other way round."
)]
pub struct Options {
    /// A result; without it the sample is measured
    #[arg(value_name = "FILE.nc", conflicts_with_all = FOR_A_SAMPLE)]
    result: Option<PathBuf>,
    #[command(flatten)]
    setup: Setup,
    /// Signed exit angles in degrees, positive on the side of the mirror direction, negative on that of the source
    /// [default: -90:90:1, or those of --overlay]
    #[arg(long, allow_hyphen_values = true, value_name = "ANGLES", help_heading = "Detector")]
    exit: Option<Values>,
    /// Full width of the detector's aperture, degrees
    #[arg(long, default_value_t = 2.0, value_name = "DEG", help_heading = "Detector")]
    aperture: f64,
    /// Turn the plane of the detector about the normal of the sample, away from the plane of incidence, degrees
    #[arg(long, default_value_t = 0.0, allow_hyphen_values = true, value_name = "DEG", help_heading = "Detector")]
    turn: f64,
    /// The detector goes below the sample
    #[arg(long, help_heading = "Detector")]
    below: bool,
    /// Print CSV instead of the table
    #[arg(long, help_heading = "Output")]
    csv: bool,
    /// A measured scan to compare with: lines of angle,value or angle,value,se (degrees, 1/sr)
    #[arg(long, conflicts_with = "exit", value_name = "FILE.csv", help_heading = "Output")]
    overlay: Option<PathBuf>,
    /// A picture, SVG or PNG by its name
    #[arg(short, long, value_name = "FILE.svg|FILE.png", help_heading = "Output")]
    output: Option<PathBuf>,
    /// Show no progress
    #[arg(long, help_heading = "Output")]
    quiet: bool,
}

/// Scans, and writes what came out.
pub fn run(options: &Options) -> Result<(), Failure> {
    let measured = options.overlay.as_deref().map(overlay::read).transpose().map_err(Failure::Input)?;
    let angles_deg = match (&measured, &options.exit) {
        (Some(points), _) => points.iter().map(|p| p.angle_deg).collect(),
        (None, Some(exit)) => exit.all.clone(),
        (None, None) => (-90..=90).map(f64::from).collect(),
    };
    let arm = Arm { angles_deg, aperture_deg: options.aperture, below: options.below, turn_deg: options.turn };
    arm.check().map_err(|e| Failure::Input(format!("--exit, --aperture, --turn: {e}")))?;
    let (scans, gates) = match &options.result {
        Some(path) => (options.stored(path, &arm)?, Ok(())),
        None => options.measured(arm)?,
    };
    let overlay = measured.map(|points| overlaid(&scans, points)).transpose()?;
    answer(&if options.csv { output::csv(&scans) } else { output::table(&scans) })?;
    if let Some(path) = &options.output {
        draw(
            path,
            &match &overlay {
                Some(overlay) => plot::overlaid(&scans[0], overlay, options.below),
                None => plot::scans(&scans, options.below),
            },
        )?;
        if !options.quiet {
            tell(&format!("wrote {}", path.display()));
        }
    }
    if let Some(overlay) = &overlay {
        tell(&overlay::verdict(overlay));
    }
    gates
}

/// The only scan beside what was measured.
fn overlaid(scans: &[Scan], points: Vec<Point>) -> Result<Overlay, Failure> {
    match scans {
        [scan] if scan.wavelength_nm.len() == 1 => Ok(scan.overlaid(points)),
        _ => Err(Failure::Input(
            "--overlay: a measured scan is of one incidence and one wavelength; choose them by --incident, --azimuth and \
             --wavelength"
                .into(),
        )),
    }
}

impl Options {
    /// The scans, and whether they are as good as they should be.
    fn measured(&self, arm: Arm) -> Result<(Vec<Scan>, Result<(), Failure>), Failure> {
        let mut waiting = Some(Waiting::new(SETTING_UP, self.quiet));
        let Scene { light, sample, .. } = self.setup.scene()?;
        let settings = Settings { arm: Some(arm), ..self.setup.settings()? };
        let mut line = Line::new(self.quiet);
        let outcome = measure(&sample, &light, &settings, |p| {
            waiting = None;
            line.show(&p, light.incidences.len());
        });
        drop(waiting);
        line.clear();
        let outcome = outcome.map_err(|e| Failure::Cannot(e.to_string()))?;
        let lost = outcome.bsdf.largest_loss();
        let gates = match settings.goal.zip(outcome.ending) {
            _ if lost > MOST_LOST => Err(Failure::Quality(format!(
                "{lost:.2e} of the light was lost; a measurement without `scan` says to what"
            ))),
            Some((goal, ending)) => reached(&goal, &ending, &outcome.bsdf, outcome.seconds),
            None => Ok(()),
        };
        Ok((outcome.scans, gates))
    }

    /// What is asked for of a result: all, unless the user says which.
    fn stored(&self, path: &Path, arm: &Arm) -> Result<Vec<Scan>, Failure> {
        let named = |e: &dyn std::fmt::Display| Failure::Input(format!("{}: {e}", path.display()));
        let bsdf = stored(path)?.bsdf;
        let theta: Vec<f64> = bsdf.incidences.iter().map(|s| s.incidence.theta_deg).collect();
        let phi: Vec<f64> = bsdf.incidences.iter().map(|s| s.incidence.phi_deg).collect();
        let wanted = |name: &str, given: &Option<Values>, there: &[f64]| {
            chosen(given, there).map_err(|e| named(&format!("--{name}: {e}")))
        };
        let angles = match &self.setup.incident {
            Some(Incident::Angles(angles)) => Some(angles.clone()),
            Some(Incident::Klems(name, _)) => {
                return Err(named(&format!("--incident: {name} is no angle; leave it out for all that were measured")));
            }
            None => None,
        };
        let theta_wanted = wanted("incident", &angles, &theta)?;
        let phi_wanted = wanted("azimuth", &self.setup.azimuth, &phi)?;
        let wavelengths = wanted("wavelength", &self.setup.wavelengths, &bsdf.wavelength_nm)?;
        let incidences = (0..theta.len()).filter(|&i| theta_wanted.contains(&theta[i]) && phi_wanted.contains(&phi[i]));
        Ok(incidences.map(|i| bsdf.scan(arm, i).only(&wavelengths)).collect())
    }
}

/// Values that are asked for, which must be there; all that are there if none are.
fn chosen(given: &Option<Values>, there: &[f64]) -> Result<Vec<f64>, String> {
    let Some(given) = given else { return Ok(there.to_vec()) };
    if let Some(missing) = given.all.iter().find(|x| !there.contains(x)) {
        let mut known: Vec<String> = there.iter().map(f64::to_string).collect();
        known.dedup();
        return Err(format!("{missing} was not measured; there are {}", known.join(", ")));
    }
    Ok(given.all.clone())
}
