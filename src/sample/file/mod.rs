//! The sample file (TOML).

mod edit;
mod media;
mod objects;
mod relief;

use std::path::Path;

use glam::DVec2;

use super::description::{Description, Named, Object, Patch, Sides};
use super::fill::named;
use super::generate::Generate;
use super::generate::common::{Setting, heights};
use super::problem::{Place, Problems};
use super::reader::{Source, Table};
use crate::units::LengthUnit;
use media::read_media;
use objects::read_object;

pub use edit::Replacement;

impl Description {
    /// Reads a sample file.
    ///
    /// # Errors
    /// Everything that is wrong with it.
    pub fn from_toml(path: &Path) -> Result<Self, Problems> {
        Self::from_toml_with(path, &[])
    }

    /// The same with some values replaced. What is wrong with those that stand in their place is told as if it stood there.
    ///
    /// # Errors
    /// Everything that is wrong with it.
    pub fn from_toml_with(path: &Path, replacements: &[Replacement]) -> Result<Self, Problems> {
        let source = Source::read(path)?;
        if replacements.is_empty() {
            return read_source(source, path).map(|(description, _)| description);
        }
        let text = edit::replace(source.as_text(), replacements).map_err(|e| Place::file(path).problem(e))?;
        read_source(source.with_text(text), path).map(|(description, _)| description)
    }

    /// Reads the text of a sample file that is not written yet, with what generates its bodies.
    ///
    /// # Errors
    /// Everything that is wrong with it, without places.
    pub fn from_text(text: &str) -> Result<(Self, Vec<Generate>), Problems> {
        read_source(Source::text(text), Path::new(""))
    }
}

fn read_source(source: Source, path: &Path) -> Result<(Description, Vec<Generate>), Problems> {
    let all = {
        let root = source.parse();
        // What follows from broken syntax is no help.
        if !source.is_clean() {
            return Err(source.into_problems());
        }
        let span = root.span();
        let root = root.get_ref();
        let file = Table::new(&source, root, &span, LengthUnit::Micrometre);
        read_file(&file, path)
    };
    source.into_problems().or(all)
}

fn read_file(file: &Table<'_>, path: &Path) -> (Description, Vec<Generate>) {
    let air = || Named { name: "air".into(), place: Place::file(path) };
    let header = file.table("sample");
    let unit = header.as_ref().and_then(read_unit).unwrap_or(LengthUnit::Micrometre);
    let (mut above, mut below, mut patch, mut sides) = (air(), air(), None, Sides::default());
    if let Some(t) = header.map(|t| t.with_unit(unit)) {
        above = named(&t, "above").unwrap_or(above);
        below = named(&t, "below").unwrap_or(below);
        (patch, sides) = t.table("patch").map_or((None, sides), |p| read_patch(&p));
        t.refuse_unknown_keys();
    }
    let media = file.table("media").map(|t| read_media(&t)).unwrap_or_default();
    let mut objects: Vec<Object> = Vec::new();
    for table in file.tables("object") {
        let table = table.with_unit(unit);
        objects.extend(read_object(&table, objects.len()));
        table.refuse_unknown_keys();
    }
    let (given, mut generated) = (patch, Vec::new());
    for table in file.tables("generate") {
        let table = table.with_unit(unit);
        let top = heights(&objects).map(|[_, top]| top);
        let setting = Setting { periodic: sides == Sides::Periodic, patch: given, top };
        if let Some(generate) = Generate::read(&table, setting) {
            patch = patch.or(generate.patch());
            let mut bodies = generate.objects(&table).unwrap_or_default();
            if objects.is_empty() {
                objects = bodies
            } else {
                objects.append(&mut bodies)
            }
            generated.push(generate);
        }
        table.refuse_unknown_keys();
    }
    file.refuse_unknown_keys();
    if objects.is_empty() && file.get("object").is_none() && file.get("generate").is_none() {
        file.source().note(Place::file(path).problem("the sample is empty; add an [[object]] or a [[generate]]"));
    }
    let files = file.source().files();
    (Description { place: Place::file(path), files, above, below, patch, sides, media, objects }, generated)
}

fn read_unit(header: &Table<'_>) -> Option<LengthUnit> {
    let text = header.text("unit")?;
    text.parse().map_err(|e| header.source().note(header.place_of("unit").problem(format!("unit = {e}")))).ok()
}

fn read_patch(t: &Table<'_>) -> (Option<Patch>, Sides) {
    let size = t.lengths::<2>("size", "two lengths such as [12, 10]").map(DVec2::from_array);
    let center = t.lengths::<2>("center", "two lengths such as [0, 0]").map_or(DVec2::ZERO, DVec2::from_array);
    let sides = t.text("sides").map_or(Ok(Sides::default()), str::parse);
    let sides = sides.unwrap_or_else(|e| {
        t.source().note(t.place_of("sides").problem(format!("sides = {e}")));
        Sides::default()
    });
    if t.get("center").is_some() && t.get("size").is_none() {
        t.missing::<()>("size", "[12, 10]");
    }
    t.refuse_unknown_keys();
    if let Some(s) = size.filter(|s| s.min_element() <= 0.0) {
        let message = format!("size = {s}: expected two lengths greater than 0");
        t.source().note(t.place_of("size").problem(message));
        return (None, sides);
    }
    (size.map(|size| Patch { size, center }), sides)
}
