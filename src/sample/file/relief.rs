//! `shape = "height_field"`.

use glam::DVec2;

use super::super::description::Shape;
use super::super::reader::{LARGEST, Table};
use super::super::relief::{self, DEPTH, HeightField, Relief};

pub(super) fn read_height_field(t: &Table<'_>) -> Option<Shape> {
    let file = t.text("file").or_else(|| t.missing_if_absent("file", "\"surface.gsf\""));
    let pixel = read_pixel(t);
    let levels = read_levels(t);
    let fill = t.length("fill");
    let scale = t.number("scale_z").unwrap_or(1.0);
    let base = t.length("base").unwrap_or(0.0);
    let depth = t.positive_length("bottom");
    let center = t.lengths::<2>("center", "two lengths such as [0, 0]").map_or(DVec2::ZERO, DVec2::from_array);
    if scale == 0.0 {
        t.complain("scale_z = 0: expected a factor for the heights; to turn hills into valleys, a negative one");
        return None;
    }
    let file = file?;
    let about_the_file = |why: &str| t.place_of("file").problem(format!("file = \"{file}\": {why}"));
    let raw = relief::load(&t.source().beside(file), t.unit()).map_err(|p| {
        t.source().note(if p.place.line.is_none() { about_the_file(&p.message) } else { p });
    });
    let field = raw.ok()?.into_field(pixel, levels, fill);
    let mut field = field.map_err(|all| all.iter().for_each(|why| t.source().note(about_the_file(why)))).ok()?;
    field.heights.iter_mut().for_each(|z| *z = base + scale * *z);
    check_extent(&field).map_err(|why| t.source().note(about_the_file(&why))).ok()?;
    let [lowest, highest] = field.range();
    let floor = lowest - depth.unwrap_or((highest - lowest).max(DEPTH));
    Some(Shape::Relief(Box::new(Relief { field, center, floor })))
}

fn check_extent(field: &HeightField) -> Result<(), String> {
    let [lowest, highest] = field.range();
    let far = field.period().max_element().max(highest).max(-lowest);
    if far <= LARGEST {
        return Ok(());
    }
    Err(format!("reaches {far:.3e} µm from the origin: at most 10 m is taken; are its units right?"))
}

/// One length, or two.
fn read_pixel(t: &Table<'_>) -> Option<DVec2> {
    if t.get("pixel")?.get_ref().as_array().is_none() {
        return t.positive_length("pixel").map(DVec2::splat);
    }
    let pixel = DVec2::from_array(t.lengths::<2>("pixel", "a length, or two such as [0.05, 0.1]")?);
    if pixel.min_element() > 0.0 {
        return Some(pixel);
    }
    t.source().note(t.place_of("pixel").problem(format!("pixel = {pixel}: expected two lengths greater than 0")));
    None
}

/// The heights of black and of white.
fn read_levels(t: &Table<'_>) -> Option<[f64; 2]> {
    if t.get("height")?.get_ref().as_array().is_none() {
        return t.positive_length("height").map(|white| [0.0, white]);
    }
    let [black, white] = t.lengths::<2>("height", "a length, or two such as [0, \"1.5 um\"]")?;
    if black < white {
        return Some([black, white]);
    }
    let message = format!(
        "height = [{black}, {white}]: expected the height of black below that of white; to turn hills \
                           into valleys give scale_z = -1"
    );
    t.source().note(t.place_of("height").problem(message));
    None
}
