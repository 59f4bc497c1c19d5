//! `gonio-embree film`: plane-parallel stacks by themselves.

use std::path::{Path, PathBuf};

use clap::Args;
use gonio_embree::films::cases::{self, Case};
use gonio_embree::films::{self, Sweep};
use gonio_embree::light::{Polarization, Wavelengths};
use gonio_embree::media::Dispersion;
use gonio_embree::optics::C64;
use gonio_embree::optics::film::Amplitudes;
use gonio_embree::output::{atomic, film as output};
use gonio_embree::plot;

use super::medium::NamedMedium;
use super::numbers::Values;
use super::{Failure, answer, tell};

/// Options of `film`.
#[derive(Debug, Args)]
#[command(
    after_help = "Stacks: first medium | layers | last medium, the light coming from the first. A layer is a medium \
    and a thickness (nm, um or mm; nm if none is given), a medium a name or an index; repetitions may nest:\n  \
    gonio-embree film \"air | 12 x (chitin 50nm, air 150nm) | air\" --angle 0:80:20\n  \
    gonio-embree film \"air | 2 x (2.0+0.01i 74, 3 x (keratin 98, 2.0 148)) | bird keratin\""
)]
pub struct Options {
    /// The stack, or a file of cases (schema gonio-films-1)
    #[arg(value_name = "STACK|FILE.json")]
    stack: String,
    /// Angles of incidence in degrees: start:stop:step (both ends), a list 0,20,75, or one number [default: 0]
    #[arg(long, allow_hyphen_values = true, value_name = "ANGLES")]
    angle: Option<Values>,
    /// Vacuum wavelengths in nm, same forms [default: 400:700:20]
    #[arg(long, value_name = "NM")]
    wavelengths: Option<Values>,
    /// State of polarization: unpolarized, s, p, or a Stokes vector 1,Q,U,V [default: unpolarized]
    #[arg(long)]
    polarization: Option<Polarization>,
    /// A medium of the stack: its index, such as melanin=2.0+0.01i, or a file (.yml of refractiveindex.info, .csv); may
    /// be repeated
    #[arg(long, value_name = "NAME=INDEX|FILE")]
    medium: Vec<NamedMedium>,
    /// Print CSV instead of the table
    #[arg(long, conflicts_with = "json")]
    csv: bool,
    /// Print one JSON document (schema gonio-films-result-1): of a file of cases
    #[arg(long)]
    json: bool,
    /// A picture of the shares over wavelength and angle, with the colours
    #[arg(short, long, value_name = "FILE.svg")]
    output: Option<PathBuf>,
}

/// Solves, and writes what came out.
pub fn run(options: &Options) -> Result<(), Failure> {
    let is_file = options.stack.to_lowercase().ends_with(".json") && !options.stack.contains('|');
    if is_file { run_cases(options) } else { run_sweep(options) }
}

fn run_cases(options: &Options) -> Result<(), Failure> {
    if let Some(name) = options.given_for_stacks() {
        return Err(Failure::Input(format!(
            "{name} belongs to a stack; the file says it for every case: leave it out"
        )));
    }
    let cases = cases::read(Path::new(&options.stack)).map_err(|e| Failure::Input(e.to_string()))?;
    let solved: Vec<(&Case, Amplitudes)> = cases.iter().map(|case| (case, case.solve())).collect();
    let finite = |a: &Amplitudes| [a.r, a.t, a.r_back, a.t_back].into_iter().all(C64::is_finite);
    if let Some((case, _)) = solved.iter().find(|(_, a)| !finite(a)) {
        return Err(Failure::Cannot(format!(
            "case `{}`: its numbers are too large or too small to be solved",
            case.id
        )));
    }
    answer(&if options.json { output::json(&solved) } else { output::cases_table(&solved) })
}

fn run_sweep(options: &Options) -> Result<(), Failure> {
    if options.json {
        return Err(Failure::Input("--json belongs to a file of cases; write --csv for a stack".into()));
    }
    let sweep = options.sweep()?;
    let picture = options.picture()?;
    answer(&if options.csv { output::csv(&sweep) } else { output::table(&sweep) })?;
    if let Some(path) = picture {
        atomic::write(path, plot::film(&options.stack, &sweep).as_bytes())
            .map_err(|e| Failure::Cannot(format!("{}: cannot be written: {e}", path.display())))?;
        tell(&format!("wrote {}", path.display()));
    }
    Ok(())
}

impl Options {
    /// The first option given that a file of cases has no use for.
    fn given_for_stacks(&self) -> Option<&'static str> {
        let all = [
            ("--angle", self.angle.is_some()),
            ("--wavelengths", self.wavelengths.is_some()),
            ("--polarization", self.polarization.is_some()),
            ("--medium", !self.medium.is_empty()),
            ("--csv", self.csv),
            ("--output", self.output.is_some()),
        ];
        all.into_iter().find(|(_, given)| *given).map(|(name, _)| name)
    }

    fn sweep(&self) -> Result<Sweep, Failure> {
        let media = self.media()?;
        let wrong = |e: films::StackError| Failure::Input(e.show(&self.stack).to_string());
        let stack = films::parse(&self.stack).and_then(|stack| stack.resolve(&media)).map_err(wrong)?;
        let (angles, wavelengths) = (self.angles()?, self.wavelengths()?);
        let polarization = self.polarization.unwrap_or(Polarization::Unpolarized);
        if polarization == Polarization::Mueller {
            let why =
                "--polarization mueller: a stack is told for one state; choose unpolarized, s, p or a Stokes vector";
            return Err(Failure::Input(why.into()));
        }
        films::sweep(&stack, wavelengths.nm(), &angles, polarization).map_err(wrong)
    }

    fn media(&self) -> Result<Vec<(String, Dispersion)>, Failure> {
        let mut all: Vec<(String, Dispersion)> = Vec::new();
        for medium in &self.medium {
            let name = &medium.name;
            films::check_name(name).map_err(|e| Failure::Input(format!("--medium: {e}")))?;
            let name = name.split_whitespace().collect::<Vec<_>>().join(" ");
            if all.iter().any(|(n, _)| *n == name) {
                return Err(Failure::Input(format!("--medium {name}: given twice; leave one out")));
            }
            all.push((name, medium.dispersion()?));
        }
        Ok(all)
    }

    fn angles(&self) -> Result<Vec<f64>, Failure> {
        let angles = self.angle.as_ref().map_or_else(|| vec![0.0], |v| v.all.clone());
        match angles.iter().find(|a| !(0.0..=90.0).contains(*a)) {
            Some(bad) => Err(Failure::Input(format!("--angle: {bad}°: expected 0 to 90°"))),
            None => Ok(angles),
        }
    }

    fn wavelengths(&self) -> Result<Wavelengths, Failure> {
        let default = || (0..=15).map(|i| 400.0 + 20.0 * f64::from(i)).collect();
        let nm = self.wavelengths.as_ref().map_or_else(default, |v| v.all.clone());
        Wavelengths::from_nm(nm).map_err(|e| Failure::Input(format!("--wavelengths: {e}")))
    }

    /// Where the picture goes, if there is to be one and it can be written.
    fn picture(&self) -> Result<Option<&Path>, Failure> {
        let Some(path) = self.output.as_deref() else { return Ok(None) };
        let wrong = |why: String| Failure::Input(format!("--output {}: {why}", path.display()));
        if path.extension().is_none_or(|e| !e.eq_ignore_ascii_case("svg")) {
            return Err(wrong("it is a picture; name it FILE.svg".into()));
        }
        atomic::check(path).map_err(|e| wrong(format!("cannot be written: {e}")))?;
        Ok(Some(path))
    }
}
