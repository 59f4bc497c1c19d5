//! `[[object]]`.

use glam::{DMat3, DVec3};

use super::super::description::{Body, Fibre, Object, Shape};
use super::super::fill::{named, read_fill};
use super::super::obj;
use super::super::problem::suggestion;
use super::super::reader::Table;
use super::relief::read_height_field;
use crate::units;

/// Largest number of films in one object, repeats included.
const MOST_FILMS: usize = 100_000;

const SHAPES: [&str; 7] = ["sphere", "cylinder", "box", "mesh", "films", "slab", "height_field"];

/// Whether the shape can be read; if not it is noted.
fn check_shape(t: &Table<'_>, name: &str) -> bool {
    if SHAPES.contains(&name) {
        return true;
    }
    let message = format!("unknown shape `{name}`{}; known: {}", suggestion(name, SHAPES), SHAPES.join(", "));
    t.source().note(t.place_of("shape").problem(message));
    false
}

pub(super) fn read_object(t: &Table<'_>, number: usize) -> Option<Object> {
    let shape_name = t.text("shape").or_else(|| t.missing_if_absent("shape", "\"sphere\""));
    let Some(shape_name) = shape_name.filter(|name| check_shape(t, name)) else {
        t.accept_all_keys();
        return None;
    };
    let name = t.text("name").map_or_else(|| format!("{shape_name} {}", number + 1), Into::into);
    let infinite = matches!(shape_name, "films" | "slab");
    // Bodies lie in slabs and films, unless the file says otherwise.
    let default = if infinite { -1 } else { 0 };
    let priority = t.integer("priority", -1_000_000..1_000_001).map_or(default, |p| p as i32);
    let shape = match shape_name {
        "films" => {
            let body = read_films(t)?;
            return Some(Object { name: name.into(), body, priority, nesting: 0, place: t.place().clone() });
        }
        "sphere" => read_sphere(t),
        "cylinder" => read_cylinder(t),
        "box" => read_box(t),
        "mesh" => read_mesh(t),
        "slab" => read_slab(t),
        "height_field" => read_height_field(t),
        _ => None,
    };
    let fill = read_fill(t);
    let body = Body::Solid(shape?, fill?);
    Some(Object { name: name.into(), body, priority, nesting: 0, place: t.place().clone() })
}

fn read_sphere(t: &Table<'_>) -> Option<Shape> {
    let center = t.point("center").or_else(|| t.missing_if_absent("center", "[0, 0, 5]"));
    let radius = t.positive_length("radius").or_else(|| t.missing_if_absent("radius", "5"));
    Some(Shape::Sphere { center: center?, radius: radius? })
}

fn read_cylinder(t: &Table<'_>) -> Option<Shape> {
    let from = t.point("from").or_else(|| t.missing_if_absent("from", "[0, 0, 0]"));
    let to = t.point("to").or_else(|| t.missing_if_absent("to", "[100, 0, 0]"));
    let radius = t.positive_length("radius").or_else(|| t.missing_if_absent("radius", "10"));
    let inner = t.positive_length("inner_radius");
    let inner_medium = named(t, "inner_medium");
    let flatten = read_flatten(t);
    let caps = t.boolean("caps").unwrap_or(true);
    let (from, to, radius) = (from?, to?, radius?);
    let Some(along) = (to - from).try_normalize() else {
        t.complain(format!("from = {from} µm and to = {to} µm are the same point; a cylinder needs two ends"));
        return None;
    };
    if flatten.is_some_and(|(axis, _)| axis.cross(along).length() < 1e-6) {
        t.complain(
            "flatten.axis is parallel to the axis of the cylinder; give a direction across it, such as [0, 0, 1]",
        );
        return None;
    }
    let lumen = match (inner, inner_medium) {
        (Some(r), _) if r >= radius => {
            let [r, radius] = [r, radius].map(units::show_length);
            t.complain(format!("inner_radius = {r} must be smaller than radius = {radius}"));
            return None;
        }
        (Some(r), Some(medium)) => Some((r, medium)),
        (Some(_), None) => return t.missing("inner_medium", "\"air\""),
        (None, Some(_)) => return t.missing("inner_radius", "5"),
        (None, None) => None,
    };
    Some(Fibre { from, to, radius, lumen, flatten, caps }.into())
}

/// The direction of flattening and the thickness over the width, which may stand alone: then it is flattened from above.
fn read_flatten(t: &Table<'_>) -> Option<(DVec3, f64)> {
    if t.get("flatten")?.get_ref().is_table() {
        let table = t.table("flatten")?;
        let axis = table.direction("axis").or_else(|| table.missing_if_absent("axis", "[0, 0, 1]"));
        let ratio = table.number("ratio").or_else(|| table.missing_if_absent("ratio", "0.5"));
        table.refuse_unknown_keys();
        let ratio = ratio.and_then(|ratio| fit_ratio(&table, "ratio", ratio));
        return Some((axis?, ratio?));
    }
    Some((DVec3::Z, fit_ratio(t, "flatten", t.number("flatten")?)?))
}

fn fit_ratio(t: &Table<'_>, key: &str, ratio: f64) -> Option<f64> {
    if ratio > 0.0 && ratio <= 1.0 {
        return Some(ratio);
    }
    t.complain(format!("{key} = {ratio}: expected the thickness over the width, above 0 and at most 1"));
    None
}

fn read_box(t: &Table<'_>) -> Option<Shape> {
    let min = t.point("min").or_else(|| t.missing_if_absent("min", "[-1, -1, 0]"));
    let max = t.point("max").or_else(|| t.missing_if_absent("max", "[1, 1, 0.5]"));
    let (min, max) = (min?, max?);
    if min.cmpge(max).any() {
        t.complain(format!("min = {min} µm must be below max = {max} µm in every coordinate"));
        return None;
    }
    Some(Shape::Cuboid { min, max })
}

fn read_mesh(t: &Table<'_>) -> Option<Shape> {
    let file = t.text("file").or_else(|| t.missing_if_absent("file", "\"grain.obj\""));
    let scale = t.number("scale").unwrap_or(1.0);
    let translate = t.point("translate").unwrap_or(DVec3::ZERO);
    let turn = t.table("rotate").and_then(|r| {
        let axis = r.direction("axis").or_else(|| r.missing_if_absent("axis", "[0, 0, 1]"));
        let angle = r.angle("angle").or_else(|| r.missing_if_absent("angle", "\"30 deg\""));
        r.refuse_unknown_keys();
        Some(DMat3::from_axis_angle(axis?, angle?))
    });
    if scale <= 0.0 {
        t.complain(format!("scale = {scale}: expected a number greater than 0"));
        return None;
    }
    let turn = turn.unwrap_or(DMat3::IDENTITY);
    let file = file?;
    match obj::load_mesh(&t.source().beside(file), t.unit()) {
        // Products too large for a number become infinite and are refused with what is too far off.
        Ok(mesh) => Some(Shape::Mesh(mesh.map(|p| translate + turn * (scale * p)))),
        Err(problems) => {
            for p in problems.iter() {
                let about_the_file = t.place_of("file").problem(format!("file = \"{file}\": {}", p.message));
                t.source().note(if p.place.line.is_none() { about_the_file } else { p.clone() });
            }
            None
        }
    }
}

fn read_films(t: &Table<'_>) -> Option<Body> {
    let top = t.length("top").unwrap_or(0.0);
    let repeat = t.integer("repeat", 1..MOST_FILMS as i64 + 1).unwrap_or(1) as usize;
    if t.get("layers").is_none() {
        return t.missing("layers", "[{ medium = \"chitin\", thickness = \"50 nm\" }]");
    }
    let mut once = Vec::new();
    let tables = t.tables("layers");
    let expected = tables.len();
    for layer in tables {
        let medium = named(&layer, "medium").or_else(|| layer.missing_if_absent("medium", "\"chitin\""));
        let thickness = layer.length("thickness").or_else(|| layer.missing_if_absent("thickness", "\"50 nm\""));
        layer.refuse_unknown_keys();
        if let Some(d) = thickness.filter(|&d| d < 0.0) {
            layer.complain(format!("thickness = {}: expected a length of 0 or more", units::show_length(d)));
        }
        once.extend(medium.zip(thickness.filter(|&d| d >= 0.0)));
    }
    if expected == 0 {
        t.complain("`layers` is empty; give at least one { medium = ..., thickness = ... }");
    }
    if once.len() < expected || expected == 0 {
        return None;
    }
    if once.len().saturating_mul(repeat) > MOST_FILMS {
        t.complain(format!("{} layers repeated {repeat} times: at most {MOST_FILMS} films are taken", once.len()));
        return None;
    }
    let count = once.len() * repeat;
    Some(Body::Films { top, layers: once.into_iter().cycle().take(count).collect() })
}

fn read_slab(t: &Table<'_>) -> Option<Shape> {
    let top = t.length("top").or_else(|| t.missing_if_absent("top", "0"));
    let bottom = t.length("bottom").or_else(|| t.missing_if_absent("bottom", "\"-1 mm\""));
    let (top, bottom) = (top?, bottom?);
    if bottom >= top {
        let [bottom, top] = [bottom, top].map(units::show_length);
        t.complain(format!("bottom = {bottom} must be below top = {top}"));
        return None;
    }
    Some(Shape::Slab { top, bottom })
}
