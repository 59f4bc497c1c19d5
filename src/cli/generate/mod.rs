//! `gonio-embree generate`: samples made by rule. What was typed becomes a sample file, which the reader of sample files
//! judges; that file is written, or the bodies in it as a mesh.

mod keys;
mod text;

use std::path::Path;

use clap::Subcommand;
use gonio_embree::light::{Coherence, Wavelengths};
use gonio_embree::output::atomic;
use gonio_embree::sample::generate::common::heights;
use gonio_embree::sample::generate::export::{self, Fineness};
use gonio_embree::sample::{Description, Sample};
use gonio_embree::units::significant;

use self::keys::{Bricks, Flakes, Given, Mosaic, Packing, Web};
use super::{Failure, tell};

/// What to make.
#[derive(Debug, Subcommand)]
pub enum Kind {
    /// Interlocking bricks with cores: the platelets of a hummingbird's feather
    Bricks(Given<Bricks>),
    /// The fibre web of a sheet of paper
    Web(Given<Web>),
    /// Spheres at random places in a slab, none overlapping
    Packing(Given<Packing>),
    /// Flakes of an effect pigment at random places in a slab: thin prisms with a skin all round
    Flakes(Given<Flakes>),
    /// Layers of unequal flat platelets with gaps, each layer laid by itself
    Mosaic(Given<Mosaic>),
}

/// Makes it.
pub fn run(kind: &Kind) -> Result<(), Failure> {
    match kind {
        Kind::Bricks(given) => make(given),
        Kind::Web(given) => make(given),
        Kind::Packing(given) => make(given),
        Kind::Flakes(given) => make(given),
        Kind::Mosaic(given) => make(given),
    }
}

fn make<K: keys::Kind>(given: &Given<K>) -> Result<(), Failure> {
    let extension = given.output.extension().and_then(|e| e.to_str());
    if !matches!(extension, Some("obj" | "toml")) {
        let library = extension == Some("mtl");
        let why = if library { "the .mtl file is for the materials; " } else { "" };
        return Err(Failure::Input(format!("--output: {why}name the mesh FILE.obj, or the sample FILE.toml")));
    }
    let (head, table) = (text::head(given), text::table(given));
    let (description, generated) =
        Description::from_text(&format!("{head}{table}")).map_err(|e| Failure::Input(e.to_string()))?;
    check(&description)?;
    let title = generated.first().map(|g| g.title(description.sides)).unwrap_or_default();
    let size = size(&description);
    let bodies = match (extension, given.explode) {
        (Some("obj"), _) => return write_mesh(given, &title, &size, &description),
        (_, true) => export::to_toml(&description.objects).map_err(Failure::Input)?,
        _ => table,
    };
    let patch = text::patch(&description);
    let head = if given.explode { head.replacen("patch = { ", &format!("patch = {{ {patch}, "), 1) } else { head };
    write(&given.output, &format!("# {title}\n# {size}\n\n{head}{bodies}"))?;
    tell(&format!("wrote {}: {size}", given.output.display()));
    Ok(())
}

/// Whether it can be measured: media are known, nothing overlaps.
fn check(description: &Description) -> Result<(), Failure> {
    let green = Wavelengths::from_nm(vec![550.0]).map_err(|e| Failure::Input(e.to_string()))?;
    Sample::new(description, &green, Coherence::Falling(8.0, 16.0))
        .map(|_| ())
        .map_err(|e| Failure::Input(e.to_string()))
}

/// How many bodies there are, and between which heights.
fn size(description: &Description) -> String {
    let [low, high] =
        heights(&description.objects).unwrap_or_default().map(|z| significant((z * 1e9).round() / 1e9 + 0.0, 6));
    format!("{} bodies from z = {low} to {high} um", description.objects.len())
}

fn write_mesh<K>(given: &Given<K>, title: &str, size: &str, description: &Description) -> Result<(), Failure> {
    let library = given.output.with_extension("mtl");
    let name = library.file_name().unwrap_or_default().to_string_lossy();
    let fineness = Fineness { sides: given.fineness as usize, same_volume: given.same_volume };
    let materials = export::to_mtl(&description.objects, &description.media).map_err(Failure::Input)?;
    let mesh = export::to_obj(title, &description.objects, &name, fineness).map_err(Failure::Input)?;
    write(&library, &materials)?;
    write(&given.output, &mesh)?;
    let [w, d] = description.patch.map_or([0.0; 2], |p| p.size.to_array()).map(|x| significant(x, 9));
    let sides = if given.open { " --sides open" } else { "" };
    tell(&format!(
        "wrote {} and {}: {size}; measure it with --patch {w},{d}{sides}",
        given.output.display(),
        library.display()
    ));
    Ok(())
}

fn write(path: &Path, text: &str) -> Result<(), Failure> {
    atomic::write(path, text.as_bytes())
        .map_err(|e| Failure::Cannot(format!("{}: cannot be written: {e}", path.display())))
}
