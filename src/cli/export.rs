//! `export`: a result in the format of another program.

use std::path::PathBuf;

use clap::Args;
use clap::builder::{PossibleValue, TypedValueParser as _};
use gonio_embree::bsdf::Lookup;
use gonio_embree::colour::Illuminant;
use gonio_embree::output::Measured;
use gonio_embree::output::export::{Format, Source, export};

use super::{Failure, stored, tell, write};

/// Options of `export`.
#[derive(Debug, Args)]
#[command(after_help = "What a format cannot hold is told, with the name of one that can.\n  \
    gonio-embree export feather.nc --to rgl -o feather.bsdf\n  \
    gonio-embree export feather.nc --to klems-full -o feather.xml\n  \
    gonio-embree export feather.nc --to zemax --wavelength 560 -o feather-560.bsdf")]
pub struct Options {
    /// A result
    #[arg(value_name = "FILE.nc")]
    result: PathBuf,
    /// The format
    #[arg(long, value_name = "FORMAT", value_parser = formats())]
    to: Format,
    /// The file [default: name of the result and of the format]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Only this wavelength, nm
    #[arg(long, value_name = "NM")]
    wavelength: Option<f64>,
    /// Light under which colours are seen, D65 or A
    #[arg(long, default_value_t = Illuminant::D65, value_name = "NAME")]
    illuminant: Illuminant,
    /// What goes below the sample (BTDF), in formats of one side
    #[arg(long)]
    below: bool,
    /// A result of the same sample turned about x by half a turn: light from below, for Radiance
    #[arg(long, value_name = "FILE.nc")]
    back: Option<PathBuf>,
    /// Full width, degrees, of the lobe that stands for the specular part where a format has no place for it; 0 leaves the
    /// part out
    #[arg(long, default_value_t = 2.0, value_name = "DEG")]
    specular_width: f64,
    /// Say nothing but errors
    #[arg(long)]
    quiet: bool,
}

fn formats() -> impl clap::builder::TypedValueParser<Value = Format> {
    let values = Format::all().map(|f| PossibleValue::new(f.name()).help(f.purpose()));
    let named = |name: String| Format::all().find(|f| f.name() == name).unwrap_or(Format::Csv);
    clap::builder::PossibleValuesParser::new(values).map(named)
}

/// Widest lobe of the specular part, degrees.
const WIDEST: f64 = 60.0;

/// Exports.
pub fn run(options: &Options) -> Result<(), Failure> {
    let width = options.specular_width;
    if !(0.0..=WIDEST).contains(&width) {
        return Err(Failure::Input(format!("--specular-width {width}: expected 0 to {WIDEST} degrees")));
    }
    let front = stored(&options.result)?;
    let back = options.back.as_deref().map(stored).transpose()?;
    let wavelength = options.wavelength(&front)?;
    let lookup = Lookup::new(&front.bsdf);
    let back = back.as_ref().map(|b| Lookup::new(&b.bsdf));
    let source = Source {
        front: &lookup,
        back: back.as_ref(),
        title: title(&front),
        wavelength,
        illuminant: options.illuminant,
        below: options.below,
        specular_width_deg: (width > 0.0).then_some(width),
    };
    let named = |e| Failure::Input(format!("{}: {e}", options.result.display()));
    let exported = export(options.to, &source).map_err(named)?;
    let output = options.output();
    write(&output, &exported.bytes)?;
    if !options.quiet {
        exported.notes.iter().for_each(|note| tell(&format!("note: {note}")));
        tell(&format!("wrote {}", output.display()));
    }
    Ok(())
}

/// What was measured, in one line.
fn title(measured: &Measured) -> String {
    let p = &measured.provenance;
    format!("{}, sha256 {}", p.command, p.sample_sha256.chars().take(12).collect::<String>())
}

impl Options {
    fn output(&self) -> PathBuf {
        let stem = || {
            let name = self.result.file_stem().unwrap_or_default().to_string_lossy();
            PathBuf::from(format!("{name}-{}.{}", self.to.name(), self.to.extension()))
        };
        self.output.clone().unwrap_or_else(stem)
    }

    fn wavelength(&self, measured: &Measured) -> Result<Option<usize>, Failure> {
        let Some(nm) = self.wavelength else { return Ok(None) };
        let known = &measured.bsdf.wavelength_nm;
        known.iter().position(|&w| w == nm).map(Some).ok_or_else(|| {
            let list: Vec<String> = known.iter().map(f64::to_string).collect();
            Failure::Input(format!("--wavelength {nm} was not measured; there are {}", list.join(", ")))
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_named_after_result_and_format() {
        let parse = |text: &[&str]| {
            #[derive(clap::Parser)]
            struct Only {
                #[command(flatten)]
                options: Options,
            }
            use clap::Parser as _;
            Only::parse_from(text).options
        };
        assert_eq!(parse(&["x", "a/b.nc", "--to", "klems-full"]).output(), PathBuf::from("b-klems-full.xml"));
        assert_eq!(parse(&["x", "b.nc", "--to", "rgl", "-o", "c"]).output(), PathBuf::from("c"));
    }
}
