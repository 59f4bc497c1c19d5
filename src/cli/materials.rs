//! `gonio-embree materials`: media by themselves.

use std::path::{Path, PathBuf};

use clap::Args;
use gonio_embree::light::Wavelengths;
use gonio_embree::media::{self, Curve, Dispersion};
use gonio_embree::optics::C64;
use gonio_embree::output::atomic;
use gonio_embree::output::materials::{self as output, Material};
use gonio_embree::plot::{self, IndexCurve};
use gonio_embree::sample::problem::suggestion;

use super::numbers::Values;
use super::{Failure, answer, tell};

/// Options of `materials`.
#[derive(Debug, Args)]
pub struct Options {
    /// A built-in medium, or a file of one (.yml of refractiveindex.info, .csv) [default: a table of all built-in ones]
    #[arg(value_name = "NAME|FILE")]
    name: Vec<String>,
    /// Vacuum wavelengths in nm: start:stop:step (both ends), a list 400,550,700, or one number [default: visible ones]
    #[arg(long, value_name = "NM", requires = "name")]
    wavelengths: Option<Values>,
    /// A picture of n and k over wavelength
    #[arg(long, value_name = "FILE.svg", requires = "name")]
    plot: Option<PathBuf>,
    /// Print one JSON document (schema gonio-materials-1) instead of the table
    #[arg(long)]
    json: bool,
}

/// Looks up, and shows.
pub fn run(options: &Options) -> Result<(), Failure> {
    if options.name.is_empty() { all(options.json) } else { one(options) }
}

fn all(json: bool) -> Result<(), Failure> {
    let all: Vec<Material> = media::builtins().iter().map(Material::from).collect();
    if !json {
        return answer(&output::table(&all));
    }
    let grids: Vec<Vec<f64>> = all.iter().map(Material::some_wavelengths).collect();
    let indices: Vec<Vec<C64>> = all.iter().zip(&grids).map(|(m, nm)| indices(m, nm)).collect::<Result<_, _>>()?;
    let both = grids.iter().zip(&indices);
    let entries: Vec<_> = all.iter().zip(both).map(|(m, (nm, index))| (m, &nm[..], &index[..])).collect();
    answer(&output::json(&entries))
}

fn one(options: &Options) -> Result<(), Failure> {
    let material = look_up(&options.name.join(" "))?;
    let given = options.wavelengths.as_ref().map(|v| Wavelengths::from_nm(v.all.clone()));
    let given = given.transpose().map_err(|e| Failure::Input(format!("--wavelengths: {e}")))?;
    let nm = given.as_ref().map_or_else(|| material.some_wavelengths(), |given| given.nm().to_vec());
    let index = indices(&material, &nm)?;
    let picture = options.plot.as_deref().map(|path| picture(path, &material, given.as_ref())).transpose()?;
    let details = || output::details(&material, &nm, &index);
    answer(&if options.json { output::json(&[(&material, &nm[..], &index[..])]) } else { details() })?;
    if let (Some(path), Some(picture)) = (&options.plot, picture) {
        atomic::write(path, picture.as_bytes())
            .map_err(|e| Failure::Cannot(format!("{}: cannot be written: {e}", path.display())))?;
        tell(&format!("wrote {}", path.display()));
    }
    Ok(())
}

fn look_up(name: &str) -> Result<Material, Failure> {
    if let Some(known) = media::builtin(name) {
        return Ok(known.into());
    }
    if media::is_file(name) {
        let file = media::read_file(Path::new(name)).map_err(Failure::Input)?;
        return Ok(Material::of_file(name, file));
    }
    let hint = suggestion(name, media::builtins().iter().flat_map(|b| b.names.iter().copied()));
    Err(Failure::Input(format!(
        "found no built-in medium `{name}`{hint}; `gonio-embree materials` lists them all; a file ends in .yml, .yaml \
         or .csv"
    )))
}

fn indices(material: &Material, nm: &[f64]) -> Result<Vec<C64>, Failure> {
    material.indices(nm).map_err(|e| Failure::Input(format!("{}: {e}", material.names.join(", "))))
}

fn picture(path: &Path, material: &Material, given: Option<&Wavelengths>) -> Result<String, Failure> {
    let wrong = |why: String| Failure::Input(format!("--plot {}: {why}", path.display()));
    if path.extension().is_none_or(|e| !e.eq_ignore_ascii_case("svg")) {
        return Err(wrong("it is a picture; name it FILE.svg".into()));
    }
    atomic::check(path).map_err(|e| wrong(format!("cannot be written: {e}")))?;
    let nm = given.map_or_else(|| material.curve_wavelengths(), |given| given.nm().to_vec());
    let index = indices(material, &nm)?;
    let (measured_n, measured_k): (&[_], &[_]) = match &material.dispersion {
        Dispersion::Curves { n, k } => (Curve::points(n), Curve::points(k)),
        _ => (&[], &[]),
    };
    let title = output::title(material);
    Ok(plot::material(&IndexCurve { title: &title, nm: &nm, index: &index, measured_n, measured_k }))
}
