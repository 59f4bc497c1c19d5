//! What the user wrote, as it was written: shapes, media by name, and where each stood.

use std::path::{Path, PathBuf};

use glam::{DMat3, DVec2, DVec3};
use toml::de::DeValue;

use super::generate::Generate;
use super::mesh::Mesh;
use super::obj;
use super::problem::{Place, Problems, suggestion};
use super::reader::{Source, Table};
use crate::media::{self, Dispersion};
use crate::optics::C64;
use crate::units::{self, LengthUnit};

/// Largest number of films in one object, repeats included.
const MOST_FILMS: usize = 100_000;

/// A sample before it is checked and flattened.
#[derive(Clone, Debug)]
pub struct Description {
    /// File it came from.
    pub place: Place,
    /// All files it came from.
    pub files: Vec<PathBuf>,
    /// Name of the medium above.
    pub above: Named,
    /// Name of the medium below.
    pub below: Named,
    /// Footprint of the beam; around everything if not given.
    pub patch: Option<Patch>,
    /// What happens at the sides.
    pub sides: Sides,
    /// Media the file defines.
    pub media: Vec<Medium>,
    /// The bodies.
    pub objects: Vec<Object>,
}

/// A name in a file.
#[derive(Clone, Debug, PartialEq)]
pub struct Named {
    /// The name.
    pub name: String,
    /// Where it stands.
    pub place: Place,
}

/// A medium with a name.
#[derive(Clone, Debug, PartialEq)]
pub struct Medium {
    /// Its name.
    pub name: String,
    /// Its index.
    pub dispersion: Dispersion,
    /// Where it is defined.
    pub place: Place,
}

/// The rectangle through which light comes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch {
    /// Edge lengths, µm.
    pub size: DVec2,
    /// Centre, µm.
    pub center: DVec2,
}

/// What lies beside the patch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sides {
    /// The patch again, for ever.
    #[default]
    Periodic,
    /// Nothing: the sample stands alone.
    Open,
}

impl std::fmt::Display for Sides {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Periodic => "periodic",
            Self::Open => "open",
        })
    }
}

impl std::str::FromStr for Sides {
    type Err = String;

    fn from_str(s: &str) -> Result<Self, String> {
        match s {
            "periodic" => Ok(Self::Periodic),
            "open" => Ok(Self::Open),
            _ => Err(format!("`{s}`: expected periodic or open")),
        }
    }
}

/// A body, or a stack of films.
#[derive(Clone, Debug)]
pub struct Object {
    /// What people call it.
    pub name: String,
    /// Its form and what it is made of.
    pub body: Body,
    /// Higher wins where solids overlap.
    pub priority: i32,
    /// Order among equal priorities: a core wins over the shell it lies in.
    pub nesting: u32,
    /// Where it is described.
    pub place: Place,
}

/// A body, or a stack of films.
#[derive(Clone, Debug)]
#[expect(clippy::large_enum_variant, reason = "most objects are solids")]
pub enum Body {
    /// One body.
    Solid(Shape, Fill),
    /// Plane-parallel, infinite films.
    Films {
        /// Height of the first interface, µm.
        top: f64,
        /// Medium and thickness in µm, from the top down.
        layers: Vec<(Named, f64)>,
    },
}

/// What a body is made of.
#[derive(Clone, Debug, PartialEq)]
pub enum Fill {
    /// A medium light can enter.
    Medium(Named),
    /// An opaque surface that reflects by Lambert's law.
    Diffuse(f64),
    /// An opaque surface that reflects this share like a mirror.
    Mirror(f64),
}

/// The form of a body.
#[derive(Clone, Debug)]
pub enum Shape {
    /// A ball.
    Sphere {
        /// Centre, µm.
        center: DVec3,
        /// Radius, µm.
        radius: f64,
    },
    /// A rod or fibre.
    Cylinder(Fibre),
    /// A box.
    Cuboid {
        /// Smallest coordinates, µm.
        min: DVec3,
        /// Largest coordinates, µm.
        max: DVec3,
    },
    /// A closed (or, if opaque, open) surface of triangles.
    Mesh(Mesh),
    /// An infinite plane-parallel body.
    Slab {
        /// Upper face, µm.
        top: f64,
        /// Lower face, µm.
        bottom: f64,
    },
}

/// A cylinder as people describe it.
#[derive(Clone, Debug, PartialEq)]
pub struct Fibre {
    /// Centre of the first end, µm.
    pub from: DVec3,
    /// Centre of the second end, µm.
    pub to: DVec3,
    /// Radius before flattening, µm.
    pub radius: f64,
    /// Radius of the lumen, µm, and what fills it.
    pub lumen: Option<(f64, Named)>,
    /// Direction of flattening and the ratio of thickness to width.
    pub flatten: Option<(DVec3, f64)>,
    /// Whether it ends at its ends, or goes on for ever.
    pub caps: bool,
}

impl Description {
    /// Reads a sample file.
    ///
    /// # Errors
    /// Everything that is wrong with it.
    pub fn from_toml(path: &Path) -> Result<Self, Problems> {
        let source = Source::read(path)?;
        let description = {
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
        source.into_problems().or(description)
    }
}

fn read_file(file: &Table<'_>, path: &Path) -> Description {
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
    for table in file.tables("generate") {
        let table = table.with_unit(unit);
        if let Some(generate) = Generate::read(&table) {
            patch = patch.or(generate.patch());
            objects.extend(generate.objects(&table).into_iter().flatten());
        }
        table.refuse_unknown_keys();
    }
    file.refuse_unknown_keys();
    if objects.is_empty() && file.get("object").is_none() && file.get("generate").is_none() {
        file.source().note(Place::file(path).problem("the sample is empty; add an [[object]] or a [[generate]]"));
    }
    let files = file.source().files();
    Description { place: Place::file(path), files, above, below, patch, sides, media, objects }
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

fn read_media(t: &Table<'_>) -> Vec<Medium> {
    let mut media: Vec<Medium> = Vec::new();
    for (name, value) in t.named() {
        let place = t.source().place(&value.span());
        if let Some(dispersion) = read_medium(t, name, value, &place) {
            media.push(Medium { name: name.into(), dispersion, place });
        }
    }
    media
}

/// Forms of a medium in the file, for messages.
const MEDIUM_FORMS: &str = "1.5, \"2.0+0.01i\", { n = 1.5, k = 0.01 }, { cauchy_nm = [1.517, 8800] }, \
                            { csv = \"file\" } or { material = \"keratin\" }";

fn read_medium(t: &Table<'_>, name: &str, value: &toml::Spanned<DeValue<'_>>, place: &Place) -> Option<Dispersion> {
    let note = |message: String| -> Option<Dispersion> {
        t.source().note(place.problem(format!("{name}: {message}")));
        None
    };
    let constant = |text: &str| match media::parse_index(text) {
        Ok(n) => Some(Dispersion::Constant(n)),
        Err(e) => note(e),
    };
    match value.get_ref() {
        DeValue::Integer(i) => constant(&i.as_str().replace('_', "")),
        DeValue::Float(f) => constant(&f.as_str().replace('_', "")),
        DeValue::String(s) => constant(s),
        DeValue::Table(_) => {
            let m = t.named_table(value)?;
            let dispersion = read_medium_table(&m, name);
            m.refuse_unknown_keys();
            dispersion
        }
        _ => note(format!("expected {MEDIUM_FORMS}")),
    }
}

/// Keys of [`MEDIUM_FORMS`] that exclude one another.
const MEDIUM_KEYS: [&str; 4] = ["n", "cauchy_nm", "material", "csv"];

fn read_medium_table(m: &Table<'_>, name: &str) -> Option<Dispersion> {
    let n = m.number("n");
    let k = m.number("k");
    let material = m.text("material");
    let csv = m.text("csv");
    let cauchy = m.numbers::<2>("cauchy_nm", "two numbers such as [1.517, 8800]");
    let given: Vec<&str> = MEDIUM_KEYS.into_iter().filter(|key| m.get(key).is_some()).collect();
    if given.len() > 1 {
        m.complain(format!("{name}: {} exclude one another; keep one of them", given.join(" and ")));
        return None;
    }
    if m.get("k").is_some() && m.get("n").is_none() {
        m.complain(format!("{name}: k belongs to an index n; write for example {{ n = 1.5, k = 0.01 }}"));
        return None;
    }
    if given.first().is_some_and(|_| n.is_none() && cauchy.is_none() && material.is_none() && csv.is_none()) {
        // What is wrong with the value has been noted.
        return None;
    }
    if let Some(re) = n {
        let index = C64::new(re, k.unwrap_or(0.0));
        return match media::check_index(index) {
            Ok(()) => Some(Dispersion::Constant(index)),
            Err(e) => {
                m.complain(format!("{name}: {e}"));
                None
            }
        };
    }
    if let Some([a, b]) = cauchy {
        return Some(Dispersion::Cauchy { a, b });
    }
    if let Some(material) = material {
        let found = media::builtin(material);
        if found.is_none() {
            let all = media::builtins();
            let hint = suggestion(material, all.iter().flat_map(|b| b.names.iter().copied()));
            m.complain(format!("{name}: no built-in material `{material}`{hint}"));
        }
        return found.map(|b| b.dispersion);
    }
    if let Some(csv) = csv {
        return media::read_csv(&m.source().beside(csv)).map_err(|e| m.complain(format!("{name}: {e}"))).ok();
    }
    m.complain(format!("{name}: expected {MEDIUM_FORMS}"));
    None
}

/// A name and its place.
fn named(t: &Table<'_>, key: &'static str) -> Option<Named> {
    t.text(key).map(|name| Named { name: name.into(), place: t.place_of(key) })
}

const SHAPES: [&str; 7] = ["sphere", "cylinder", "box", "mesh", "films", "slab", "height_field"];

/// Whether the shape can be read; if not it is noted.
fn check_shape(t: &Table<'_>, name: &str) -> bool {
    let message = match name {
        "height_field" => "shape = \"height_field\" is not there yet; make a closed mesh of the relief".into(),
        known if SHAPES.contains(&known) => return true,
        _ => format!("unknown shape `{name}`{}; known: {}", suggestion(name, SHAPES), SHAPES.join(", ")),
    };
    t.source().note(t.place_of("shape").problem(message));
    false
}

fn read_object(t: &Table<'_>, number: usize) -> Option<Object> {
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
            return Some(Object { name, body, priority, nesting: 0, place: t.place().clone() });
        }
        "sphere" => read_sphere(t),
        "cylinder" => read_cylinder(t),
        "box" => read_box(t),
        "mesh" => read_mesh(t),
        "slab" => read_slab(t),
        _ => None,
    };
    let fill = read_fill(t);
    let body = Body::Solid(shape?, fill?);
    Some(Object { name, body, priority, nesting: 0, place: t.place().clone() })
}

/// `medium = "name"` or `surface = { diffuse = 0.8 }`.
pub(super) fn read_fill(t: &Table<'_>) -> Option<Fill> {
    let medium = named(t, "medium");
    let Some(surface) = t.table("surface") else {
        let wrong = t.get("surface").is_some();
        return medium
            .map(Fill::Medium)
            .or_else(|| if wrong { None } else { t.missing_if_absent("medium", "\"glass\"") });
    };
    let share = |key| {
        let share = surface.number(key)?;
        if (0.0..=1.0).contains(&share) {
            return Some(share);
        }
        surface.complain(format!("{key} = {share}: expected a share of the light, 0 to 1"));
        None
    };
    let (diffuse, mirror) = (share("diffuse").map(Fill::Diffuse), share("mirror").map(Fill::Mirror));
    surface.refuse_unknown_keys();
    if medium.is_some() {
        t.complain("an object has a `medium` or a `surface`, not both; leave one out");
    }
    match (diffuse, mirror) {
        (Some(fill), None) | (None, Some(fill)) => Some(fill),
        // What is wrong with the share has been noted.
        (None, None) if surface.get("diffuse").or(surface.get("mirror")).is_some() => None,
        _ => {
            surface.complain("surface: expected { diffuse = 0.8 } or { mirror = 0.95 }");
            None
        }
    }
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
    let flatten = t.table("flatten").and_then(|f| {
        let axis = f.direction("axis").or_else(|| f.missing_if_absent("axis", "[0, 0, 1]"));
        let ratio = f.number("ratio").or_else(|| f.missing_if_absent("ratio", "0.5"));
        f.refuse_unknown_keys();
        let ratio = ratio.filter(|&r| {
            let fine = r > 0.0 && r <= 1.0;
            if !fine {
                f.complain(format!("ratio = {r}: expected the thickness over the width, above 0 and at most 1"));
            }
            fine
        });
        Some((axis?, ratio?))
    });
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
    Some(Shape::Cylinder(Fibre { from, to, radius, lumen, flatten, caps }))
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
