//! Wavefront OBJ files: bodies of triangles, their media by the names of their materials.

use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

use glam::{DVec2, DVec3};
use tobj::{LoadError, LoadOptions};

use super::description::{Body, Description, Fill, Medium, Named, Object, Patch, Shape, Sides};
use super::mesh::Mesh;
use super::problem::{Place, Problem, Problems, suggestion};
use super::reader::LARGEST;
use crate::geometry::Aabb;
use crate::media::{self, Builtin, Dispersion, builtin};
use crate::optics::C64;
use crate::text;
use crate::units::LengthUnit;

/// Largest file taken, bytes.
const MOST_BYTES: u64 = 2 << 30;

/// What an OBJ file does not say.
#[derive(Clone, Debug)]
pub struct Options {
    /// Unit of its coordinates.
    pub unit: LengthUnit,
    /// What happens at the sides.
    pub sides: Sides,
    /// Size of the footprint of the beam, µm, if not that of the bounding box; it lies around the centre of that.
    pub patch: Option<DVec2>,
    /// Media of materials, by name.
    pub media: Vec<(String, Dispersion)>,
}

/// One `o`, `g` or `usemtl` section.
struct Part {
    name: String,
    mesh: Mesh,
    material: Option<usize>,
}

struct File {
    path: PathBuf,
    /// First line of each (keyword, name).
    lines: HashMap<(String, String), usize>,
    parts: Vec<Part>,
    materials: Vec<tobj::Material>,
}

impl Description {
    /// Reads a bare mesh.
    ///
    /// # Errors
    /// Everything that is wrong with it.
    pub fn from_obj(path: &Path, options: &Options) -> Result<Self, Problems> {
        let file = read(path, options.unit)?;
        let mut problems = Problems::default();
        let mut media: Vec<Medium> = Vec::new();
        let mut objects = Vec::new();
        for (i, part) in file.parts.iter().enumerate() {
            let place = file.place_of_part(part);
            match file.medium(part, options) {
                Ok(medium) => {
                    if !media.iter().any(|m| m.name == medium.name) {
                        media.push(medium.clone());
                    }
                    let name = if part.name.is_empty() { format!("part {}", i + 1) } else { part.name.clone() };
                    let fill = Fill::Medium(Named { name: medium.name.into(), place: place.clone() });
                    let body = Body::Solid(Shape::Mesh(part.mesh.clone()), fill);
                    objects.push(Object { name: name.into(), body, priority: 0, nesting: 0, place });
                }
                Err(problem) => problems.push(problem),
            }
        }
        for (name, _) in &options.media {
            if !file.materials.iter().any(|m| m.name == *name) {
                let hint = suggestion(name, file.materials.iter().map(|m| m.name.as_str()));
                problems.push(Place::file(path).problem(format!("--medium {name}: no such material here{hint}")));
            }
        }
        nest(&mut objects);
        let air = Named { name: "air".into(), place: Place::file(path) };
        problems.or(Self {
            place: Place::file(path),
            files: file.files(),
            above: air.clone(),
            below: air,
            patch: options.patch.map(|size| file.patch(size)),
            sides: options.sides,
            media,
            objects,
        })
    }
}

/// Reads all triangles of a file as one surface.
///
/// # Errors
/// Everything that is wrong with the file.
pub fn load_mesh(path: &Path, unit: LengthUnit) -> Result<Mesh, Problems> {
    let mut all = Mesh::default();
    for part in read(path, unit)?.parts {
        all.append(&part.mesh);
    }
    Ok(all)
}

fn read(path: &Path, unit: LengthUnit) -> Result<File, Problems> {
    let place = Place::file(path);
    let text = text::read(path, MOST_BYTES).map_err(|e| place.problem(e))?;
    check_lines(path, &text)?;
    let options = LoadOptions { triangulate: true, ignore_points: true, ignore_lines: true, ..LoadOptions::default() };
    let (models, materials) = tobj::load_obj(path, &options).map_err(|e| parse_problem(path, &text, e))?;
    let materials = materials.map_err(|e| {
        let (line, library) = find_line(&text, "mtllib").unwrap_or((1, String::new()));
        Place::line(path, line).problem(format!("mtllib {library}: cannot be read: {e}; put it beside the OBJ file"))
    })?;
    let parts: Vec<Part> = models
        .into_iter()
        .map(|m| Part { name: m.name, mesh: to_mesh(&m.mesh, unit), material: m.mesh.material_id })
        .filter(|p| !p.mesh.triangles.is_empty())
        .collect();
    if parts.is_empty() {
        return Err(place.problem("there are no faces in it").into());
    }
    let file = File { path: path.into(), lines: named_lines(&text), parts, materials };
    file.check_extent()?;
    Ok(file)
}

fn to_mesh(mesh: &tobj::Mesh, unit: LengthUnit) -> Mesh {
    let vertices = mesh.positions.chunks_exact(3).map(|p| DVec3::from_slice(p));
    Mesh {
        vertices: vertices.map(|p| DVec3::from_array(p.to_array().map(|x| unit.to_micrometres(x)))).collect(),
        triangles: mesh.indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect(),
    }
}

/// Looks for vertices that are no finite numbers and faces of fewer than three corners, which the parser would take
/// or report without a place.
fn check_lines(path: &Path, text: &str) -> Result<(), Problems> {
    let wrong = |(i, line): (usize, &str)| {
        let mut words = line.split_whitespace();
        let keyword = words.next();
        let is_number = |w: &&str| w.parse::<f64>().is_ok_and(f64::is_finite);
        let expected = match keyword {
            Some("v") if words.clone().take(3).filter(is_number).count() < 3 => "v x y z with finite numbers",
            Some("f") if words.count() < 3 => "f with at least 3 indices of vertices",
            _ => return None,
        };
        Some(Place::line(path, i + 1).problem(format!("`{}`: expected {expected}", line.trim())))
    };
    text.lines().enumerate().filter_map(wrong).collect::<Problems>().or(())
}

fn parse_problem(path: &Path, text: &str, error: LoadError) -> Problem {
    let vertices = text.lines().filter(|l| l.starts_with("v ")).count() as i64;
    let bad_face = text.lines().enumerate().find(|(_, l)| {
        let mut words = l.split_whitespace();
        words.next() == Some("f")
            && (words.clone().count() < 3
                || words.any(|w| {
                    let index = w.split('/').next().and_then(|i| i.parse::<i64>().ok()).unwrap_or(0);
                    index == 0 || index.abs() > vertices
                }))
    });
    match bad_face {
        Some((i, line)) => Place::line(path, i + 1)
            .problem(format!("`{}`: expected f with at least 3 indices of the {vertices} vertices", line.trim())),
        None => Place::file(path).problem(format!("is no OBJ file: {error}")),
    }
}

/// The first lines that name something.
fn named_lines(text: &str) -> HashMap<(String, String), usize> {
    let mut lines = HashMap::new();
    for (i, line) in text.lines().enumerate() {
        let (keyword, name) = line.trim().split_once(char::is_whitespace).unwrap_or_default();
        if ["o", "g", "usemtl", "mtllib"].contains(&keyword) {
            lines.entry((keyword.into(), name.trim().into())).or_insert(i + 1);
        }
    }
    lines
}

/// The first line that starts with `keyword`, and the rest of it.
fn find_line(text: &str, keyword: &str) -> Option<(usize, String)> {
    text.lines().enumerate().find_map(|(i, line)| {
        let (first, rest) = line.trim().split_once(char::is_whitespace)?;
        (first == keyword).then(|| (i + 1, rest.trim().into()))
    })
}

impl File {
    /// A footprint around the centre of all parts.
    fn patch(&self, size: DVec2) -> Patch {
        let bounds = self.parts.iter().fold(Aabb::EMPTY, |all, part| all.union(part.mesh.bounds()));
        Patch { size, center: bounds.center().truncate() }
    }

    /// The file and its material libraries.
    fn files(&self) -> Vec<PathBuf> {
        let beside = self.path.parent().unwrap_or(Path::new(""));
        let mut libraries: Vec<_> = self.lines.iter().filter(|((keyword, _), _)| keyword == "mtllib").collect();
        libraries.sort_by_key(|(_, line)| **line);
        std::iter::once(self.path.clone()).chain(libraries.iter().map(|((_, name), _)| beside.join(name))).collect()
    }

    /// The line that says `keyword name` for one of the keywords.
    fn line_of(&self, keywords: &[&str], name: &str) -> Option<usize> {
        let line = |k: &&str| self.lines.get(&((*k).into(), name.trim().into())).copied();
        keywords.iter().filter_map(line).min()
    }

    fn place_of_part(&self, part: &Part) -> Place {
        let line = self.line_of(&["o", "g"], &part.name);
        Place { file: Some(self.path.as_path().into()), line }
    }

    fn check_extent(&self) -> Result<(), Problem> {
        for part in &self.parts {
            let b = part.mesh.bounds();
            if b.max.max(-b.min).max_element() > LARGEST {
                return Err(self.place_of_part(part).problem(format!(
                    "`{}` reaches {:.3e} µm from the origin: at most 10 m is taken; is --unit right?",
                    part.name,
                    b.max.max(-b.min).max_element()
                )));
            }
        }
        Ok(())
    }

    /// The medium of a part: as given, else built in under the material's name, else from `Ni`.
    fn medium(&self, part: &Part, options: &Options) -> Result<Medium, Problem> {
        let Some(material) = part.material.map(|i| &self.materials[i]) else {
            let message = format!("`{}` has no material; add a usemtl line and a material with Ni", part.name);
            return Err(self.place_of_part(part).problem(message));
        };
        let place = Place { file: Some(self.path.as_path().into()), line: self.line_of(&["usemtl"], &material.name) };
        let given = options.media.iter().find(|(name, _)| *name == material.name);
        let dispersion = match (given, builtin(&material.name), material.optical_density) {
            (Some((_, dispersion)), _, _) => dispersion.clone(),
            (None, Some(known), _) => Builtin::dispersion(known),
            (None, None, Some(ni)) => {
                let index = C64::new(ni, 0.0);
                media::check_index(index)
                    .map_err(|e| place.problem(format!("material `{}`: Ni {ni}: {e}", material.name)))?;
                Dispersion::Constant(index)
            }
            (None, None, None) => {
                let name = &material.name;
                let known: HashSet<_> = media::builtins().iter().flat_map(|b| b.names.iter().copied()).collect();
                let hint = suggestion(name, known);
                return Err(place.problem(format!(
                    "unknown medium `{name}`{hint}; give --medium {name}=1.5, or a line `Ni 1.5` in the material library"
                )));
            }
        };
        Ok(Medium { name: material.name.clone(), dispersion, place })
    }
}

/// Lets a body that lies within others win over them.
fn nest(objects: &mut [Object]) {
    let meshes: Vec<Mesh> = objects
        .iter()
        .map(|o| match &o.body {
            // What is not closed is refused later.
            Body::Solid(Shape::Mesh(m), _) => m.closed().unwrap_or_default(),
            _ => Mesh::default(),
        })
        .collect();
    let bounds: Vec<_> = meshes.iter().map(Mesh::bounds).collect();
    for (i, object) in objects.iter_mut().enumerate() {
        let Some(&[a, b, c]) = meshes[i].triangles.first() else { continue };
        let [a, b, c] = meshes[i].corners([a, b, c]);
        // A point just inside the body, so that a face it shares with its shell does not matter.
        let inward = (c - a).cross(b - a).normalize_or_zero() * bounds[i].size().max_element() * 1e-6;
        let probe = (a + b + c) / 3.0 + inward;
        object.nesting = (0..meshes.len())
            .filter(|&j| j != i && bounds[j].contains(bounds[i].min) && bounds[j].contains(bounds[i].max))
            .filter(|&j| bounds[j] != bounds[i] && meshes[j].encloses(probe))
            .count() as u32;
    }
}
