//! What all `[[generate]]` tables have in common.

use glam::DVec2;

use super::super::description::{Body, Named, Object, Patch, Shape};
use super::super::problem::Place;
use super::super::reader::Table;

/// What a generator needs to know of the rest of the sample.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setting {
    /// Whether the sample repeats.
    pub periodic: bool,
    /// The footprint, if the file gives it.
    pub patch: Option<Patch>,
    /// Height of the highest point of the bodies described before, µm; slabs and films do not count.
    pub top: Option<f64>,
}

/// Keys that every kind of random sample takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Common {
    /// Seed: the same one gives the same sample.
    pub seed: u64,
    /// Whether the sample repeats in x and y.
    pub periodic: bool,
    /// Height of its lower face, µm.
    pub bottom: f64,
    /// Priority of the bodies.
    pub priority: i32,
}

impl Default for Common {
    fn default() -> Self {
        Self { seed: 1, periodic: true, bottom: 0.0, priority: 0 }
    }
}

impl Common {
    /// Reads `seed`, `periodic`, `bottom`, `on` and `priority`.
    pub(super) fn read(t: &Table<'_>, setting: Setting) -> Option<Self> {
        let seed = t.integer("seed", 0..i64::MAX).map_or(1, |s| s as u64);
        let periodic = t.boolean("periodic").unwrap_or(setting.periodic);
        let above = t.length("bottom").unwrap_or(0.0);
        let priority = t.integer("priority", -1_000_000..1_000_001).map_or(0, |p| p as i32);
        Some(Self { seed, periodic, bottom: read_base(t, setting)? + above, priority })
    }
}

/// The height from which `bottom` counts: 0, or what `on = "top"` says.
fn read_base(t: &Table<'_>, setting: Setting) -> Option<f64> {
    let Some(on) = t.text("on") else { return Some(0.0) };
    let wrong = match (on, setting.top) {
        ("top", Some(top)) => return Some(top),
        ("top", None) => "on = \"top\": no bodies are described before this; give their height as `bottom`".into(),
        _ => format!("on = \"{on}\": expected \"top\", the highest point of the bodies described before"),
    };
    t.source().note(t.place_of("on").problem(wrong));
    None
}

/// Lowest and highest point of all bodies, µm; slabs and films do not count. `None` without bodies.
pub fn heights(objects: &[Object]) -> Option<[f64; 2]> {
    let of = |object: &Object| match &object.body {
        Body::Solid(Shape::Sphere { center, radius }, _) => Some([center.z - radius, center.z + radius]),
        Body::Solid(Shape::Cylinder(fibre), _) => {
            let bounds = fibre.cylinder(fibre.radius).bounds();
            Some([bounds.min.z, bounds.max.z])
        }
        Body::Solid(Shape::Cuboid { min, max }, _) => Some([min.z, max.z]),
        Body::Solid(Shape::Mesh(mesh), _) => Some([mesh.bounds().min.z, mesh.bounds().max.z]),
        Body::Solid(Shape::Relief(relief), _) => Some([relief.floor, relief.field.range()[1]]),
        Body::Solid(Shape::Slab { .. }, _) | Body::Films { .. } => None,
    };
    objects.iter().filter_map(of).reduce(|[a, b], [c, d]| [a.min(c), b.max(d)])
}

/// A name and its place, or a default.
pub(super) fn named_or(t: &Table<'_>, key: &'static str, default: &str) -> Named {
    let (name, place) = t.text(key).map_or((default, Place::default()), |name| (name, t.place_of(key)));
    Named { name: name.into(), place }
}

/// `size = [w, d]`, µm, both greater than 0.
pub(super) fn read_footprint(t: &Table<'_>) -> Option<DVec2> {
    let size = DVec2::from_array(t.lengths("size", "two lengths such as [\"1 mm\", \"1 mm\"]")?);
    if size.min_element() > 0.0 {
        return Some(size);
    }
    let message = format!("size = {size}: expected two lengths greater than 0");
    t.source().note(t.place_of("size").problem(message));
    None
}
