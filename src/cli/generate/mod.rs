//! `gonio-embree generate`: samples made by rule. What was typed becomes a sample file, which the reader of sample files
//! judges; that file is written, or the bodies in it as a mesh.

mod keys;
mod text;

use clap::Subcommand;
use gonio_embree::light::{Coherence, Wavelengths};
use gonio_embree::sample::description::{Body, Shape};
use gonio_embree::sample::generate::common::heights;
use gonio_embree::sample::generate::export::{self, Fineness};
use gonio_embree::sample::{Description, Sample};
use gonio_embree::units::significant;

use self::keys::{Bricks, Flakes, Given, HeightField, Mosaic, Packing, Rough, Web};
use super::{Failure, tell, write};

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
    /// A random rough surface; also as a file of heights, FILE.gsf
    Rough(Given<Rough>),
    /// A body under measured heights; also as a file of heights, FILE.gsf
    HeightField(Given<HeightField>),
}

/// Makes it.
pub fn run(kind: &Kind) -> Result<(), Failure> {
    match kind {
        Kind::Bricks(given) => make(given),
        Kind::Web(given) => make(given),
        Kind::Packing(given) => make(given),
        Kind::Flakes(given) => make(given),
        Kind::Mosaic(given) => make(given),
        Kind::Rough(given) => make(given),
        Kind::HeightField(given) => make(given),
    }
}

fn make<K: keys::Kind>(given: &Given<K>) -> Result<(), Failure> {
    let extension = given.output.extension().and_then(|e| e.to_str());
    let as_heights = matches!(K::NAME, "rough" | "height_field") && extension == Some("gsf");
    if !as_heights && !matches!(extension, Some("obj" | "toml")) {
        let library = extension == Some("mtl");
        let why = if library { "the .mtl file is for the materials; " } else { "" };
        return Err(Failure::Input(format!("--output: {why}name the mesh FILE.obj, or the sample FILE.toml")));
    }
    let (head, table) = (text::head(given), text::table(given));
    let (description, generated) =
        Description::from_text(&format!("{head}{table}")).map_err(|e| Failure::Input(e.to_string()))?;
    check(&description)?;
    let title = generated.first().map_or_else(|| K::NAME.replace('_', " "), |g| g.title(description.sides));
    let size = size(&description);
    if as_heights {
        return write_heights(given, &description);
    }
    let bodies = match (extension, given.explode) {
        (Some("obj"), _) => return write_mesh(given, &title, &size, &description),
        (_, true) => export::to_toml(&description.objects).map_err(Failure::Input)?,
        _ => table,
    };
    let patch = text::patch(&description);
    let head = if given.explode { head.replacen("patch = { ", &format!("patch = {{ {patch}, "), 1) } else { head };
    write(&given.output, format!("# {title}\n# {size}\n\n{head}{bodies}").as_bytes())?;
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
    write(&library, materials.as_bytes())?;
    write(&given.output, mesh.as_bytes())?;
    let [w, d] = description.patch.map_or([0.0; 2], |p| p.size.to_array()).map(|x| significant(x, 9));
    let sides = if given.open { " --sides open" } else { "" };
    tell(&format!(
        "wrote {} and {}: {size}; measure it with --patch {w},{d}{sides}",
        given.output.display(),
        library.display()
    ));
    Ok(())
}

/// The first relief as a file of heights, for shape = "height_field".
fn write_heights<K>(given: &Given<K>, description: &Description) -> Result<(), Failure> {
    let field = description.objects.iter().find_map(|object| match &object.body {
        Body::Solid(Shape::Relief(relief), _) => Some(&relief.field),
        _ => None,
    });
    let field = field.ok_or_else(|| Failure::Input("--output: there are no heights to write".into()))?;
    write(&given.output, &field.to_gsf())?;
    tell(&format!("wrote {}: {} x {} heights", given.output.display(), field.columns, field.rows));
    Ok(())
}
