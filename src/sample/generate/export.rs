//! Generated bodies as files: meshes for other programs, and objects one by one for the sample file.

use std::fmt::Write as _;
use std::sync::Arc;

use glam::{DMat3, DVec3};
use rustc_hash::FxHashMap;

use super::super::description::{Body, Fibre, Fill, Named, Object, Shape};
use super::super::mesh::{CUBOID_FACES, Mesh};
use super::prism::Form;
use crate::media::Dispersion;
use crate::sample::description::Medium;

/// How curved bodies become meshes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fineness {
    /// Sides of the prism that stands for a cylinder; a sphere has 20 · 4^k faces, with k the nearest to log₂(sides / 5).
    pub sides: usize,
    /// Whether meshes have the volume of what they stand for; else their corners lie on its surface, so that bodies that
    /// are apart stay so.
    pub same_volume: bool,
}

/// Bodies as an OBJ file in micrometres, with a title, which refers to the material library `library`.
///
/// # Errors
/// What cannot be a mesh with a material.
pub fn to_obj(title: &str, objects: &[Object], library: &str, fineness: Fineness) -> Result<String, String> {
    let mut out = format!("# {title}\nmtllib {library}\n");
    let mut first = 1;
    for (name, shape, medium) in parts(objects)? {
        let _ = writeln!(out, "o {}\nusemtl {}", name.replace(' ', "_"), medium.name);
        let (vertices, faces) = faces(&shape, fineness)?;
        for p in &vertices {
            let [x, y, z] = p.to_array().map(decimal);
            let _ = writeln!(out, "v {x} {y} {z}");
        }
        for face in faces {
            let corners: Vec<String> = face.iter().map(|v| (first + v).to_string()).collect();
            let _ = writeln!(out, "f {}", corners.join(" "));
        }
        first += vertices.len() as u32;
    }
    Ok(out)
}

/// The material library for [`to_obj`]: indices of refraction where they are single real numbers; other media go by
/// their names.
pub fn to_mtl(objects: &[Object], media: &[Medium]) -> Result<String, String> {
    let mut used: Vec<Arc<str>> = Vec::new();
    for (_, _, medium) in parts(objects)? {
        if !used.contains(&medium.name) {
            used.push(medium.name);
        }
    }
    let material = |name: &Arc<str>| match media.iter().find(|m| *m.name == **name).map(|m| &m.dispersion) {
        Some(Dispersion::Constant(n)) if n.im == 0.0 => format!("newmtl {name}\nNi {}\n", n.re),
        _ => format!("newmtl {name}\n"),
    };
    Ok(used.iter().map(material).collect::<Vec<_>>().join("\n"))
}

/// A body with one surface and one medium; a hollow cylinder is two.
type Part = (Arc<str>, Shape, Named);

fn parts(objects: &[Object]) -> Result<Vec<Part>, String> {
    let mut parts = Vec::new();
    for object in objects {
        let Body::Solid(shape, Fill::Medium(medium)) = &object.body else {
            return Err(format!("`{}` has no medium: only bodies that light enters become meshes", object.name));
        };
        parts.push((object.name.clone(), shape.clone(), medium.clone()));
        if let Shape::Cylinder(fibre) = shape
            && let Some((radius, medium)) = &fibre.lumen
        {
            let inner = Fibre { radius: *radius, lumen: None, ..(**fibre).clone() };
            parts.push((format!("lumen of {}", object.name).into(), inner.into(), medium.clone()));
        }
    }
    Ok(parts)
}

/// Corners, and faces by numbers of corners.
type Faces = (Vec<DVec3>, Vec<Vec<u32>>);

fn faces(shape: &Shape, fineness: Fineness) -> Result<Faces, String> {
    let mesh = match shape {
        Shape::Cuboid { min, max } => {
            let quads = CUBOID_FACES.iter().map(|f| f.to_vec()).collect();
            return Ok((Mesh::cuboid(*min, *max).vertices, quads));
        }
        Shape::Sphere { center, radius } => sphere(*center, *radius, fineness),
        Shape::Cylinder(fibre) => cylinder(fibre, fineness),
        Shape::Mesh(mesh) => mesh.clone(),
        Shape::Relief(relief) => relief.block(),
        Shape::Slab { .. } => return Err("a slab has no sides: it cannot be a mesh".into()),
    };
    Ok((mesh.vertices, mesh.triangles.iter().map(|t| t.to_vec()).collect()))
}

/// A prism with elliptic outline. One without ends reaches as far as its axis was given: a period.
fn cylinder(fibre: &Fibre, fineness: Fineness) -> Mesh {
    let c = fibre.cylinder(fibre.radius);
    let form = Form { sides: fineness.sides, radius: 1.0, half: 0.5 * (fibre.to - fibre.from).length() };
    let area = form.volume() / (2.0 * form.half);
    let grown = if fineness.same_volume { (std::f64::consts::PI / area).sqrt() } else { 1.0 };
    let turn = DMat3::from_cols(grown * c.radii[0] * c.u, grown * c.radii[1] * c.v(), c.axis);
    form.mesh(turn).map(|p| 0.5 * (fibre.from + fibre.to) + p)
}

/// An icosahedron whose edges are halved again and again.
fn sphere(center: DVec3, radius: f64, fineness: Fineness) -> Mesh {
    let mut mesh = icosahedron();
    for _ in 0..(fineness.sides as f64 / 5.0).log2().round().max(0.0) as u32 {
        mesh = halved(mesh);
    }
    let full = 4.0 / 3.0 * std::f64::consts::PI;
    let grown = if fineness.same_volume { (full / mesh.volume()).cbrt() } else { 1.0 };
    mesh.map(|p| center + grown * radius * p)
}

fn icosahedron() -> Mesh {
    let golden = 0.5 * (1.0 + 5.0_f64.sqrt());
    let signs = [(-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0), (1.0, 1.0)];
    let corner = |(a, b): (f64, f64)| DVec3::new(0.0, a, b * golden).normalize();
    let vertices: Vec<DVec3> = (0..3)
        .flat_map(|turn| signs.map(corner).map(|p| [p, DVec3::new(p.z, p.x, p.y), DVec3::new(p.y, p.z, p.x)][turn]))
        .collect();
    // Its faces are the triples of neighbours.
    let near = |i: usize, j: usize| vertices[i].dot(vertices[j]) > 0.4;
    let mut triangles = Vec::with_capacity(20);
    for a in 0..12 {
        for b in (a + 1..12).filter(|&b| near(a, b)) {
            for c in (b + 1..12).filter(|&c| near(a, c) && near(b, c)) {
                let outward = (vertices[b] - vertices[a]).cross(vertices[c] - vertices[a]).dot(vertices[a]) > 0.0;
                triangles.push(if outward { [a, b, c] } else { [a, c, b] }.map(|i| i as u32));
            }
        }
    }
    Mesh { vertices, triangles }
}

fn halved(mut mesh: Mesh) -> Mesh {
    let mut middles: FxHashMap<(u32, u32), u32> = FxHashMap::default();
    let mut triangles = Vec::with_capacity(4 * mesh.triangles.len());
    for [a, b, c] in std::mem::take(&mut mesh.triangles) {
        let mut middle = |i: u32, j: u32| {
            *middles.entry((i.min(j), i.max(j))).or_insert_with(|| {
                mesh.vertices.push((mesh.vertices[i as usize] + mesh.vertices[j as usize]).normalize());
                mesh.vertices.len() as u32 - 1
            })
        };
        let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
        triangles.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
    }
    Mesh { triangles, ..mesh }
}

/// A coordinate in a text file: to a femtometre, so that sums of decimal lengths come out as people write them.
fn decimal(um: f64) -> String {
    let text = format!("{um:.9}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0" } else { text }.to_string()
}

/// Bodies as `[[object]]` tables of a sample file, in µm to the last bit. Cores have a higher priority than their shells.
///
/// # Errors
/// What the sample file has no words for.
pub fn to_toml(objects: &[Object]) -> Result<String, String> {
    let mut out = String::new();
    for object in objects {
        let Body::Solid(shape, fill) = &object.body else { return Err("films cannot be written".into()) };
        let point = |p: DVec3| format!("[{:?}, {:?}, {:?}]", p.x, p.y, p.z);
        let (kind, form) = match shape {
            Shape::Sphere { center, radius } => {
                ("sphere", format!("center = {}\nradius = {radius:?}\n", point(*center)))
            }
            Shape::Cuboid { min, max } => ("box", format!("min = {}\nmax = {}\n", point(*min), point(*max))),
            Shape::Cylinder(f) => ("cylinder", cylinder_keys(f)),
            Shape::Mesh(_) | Shape::Relief(_) => {
                let name = &object.name;
                return Err(format!(
                    "`{name}` is a mesh, which a sample file only names: leave out --explode, or write FILE.obj"
                ));
            }
            Shape::Slab { top, bottom } => ("slab", format!("top = {top:?}\nbottom = {bottom:?}\n")),
        };
        let fill = match fill {
            Fill::Medium(medium) => format!("medium = {:?}\n", medium.name),
            Fill::Diffuse(share) => format!("surface = {{ diffuse = {share:?} }}\n"),
            Fill::Mirror(share) => format!("surface = {{ mirror = {share:?} }}\n"),
        };
        let _ = write!(out, "[[object]]\nname = {:?}\nshape = \"{kind}\"\n{form}{fill}", object.name);
        match object.priority.saturating_add(object.nesting as i32) {
            0 => {}
            priority => drop(writeln!(out, "priority = {priority}")),
        }
        out.push('\n');
    }
    Ok(out)
}

fn cylinder_keys(f: &Fibre) -> String {
    let point = |p: DVec3| format!("[{:?}, {:?}, {:?}]", p.x, p.y, p.z);
    let mut out = format!("from = {}\nto = {}\nradius = {:?}\n", point(f.from), point(f.to), f.radius);
    if let Some((radius, medium)) = &f.lumen {
        let _ = write!(out, "inner_radius = {radius:?}\ninner_medium = {:?}\n", medium.name);
    }
    if let Some((axis, ratio)) = f.flatten {
        let _ = writeln!(out, "flatten = {{ axis = {}, ratio = {ratio:?} }}", point(axis));
    }
    if !f.caps {
        out.push_str("caps = false\n");
    }
    out
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    #[test]
    fn meshes_are_closed_and_keep_their_volume_if_asked() {
        let fibre = Fibre {
            from: DVec3::new(1.0, 2.0, 3.0),
            to: DVec3::new(4.0, 6.0, 3.0),
            radius: 0.7,
            lumen: None,
            flatten: Some((DVec3::Z, 0.5)),
            caps: true,
        };
        for sides in [3, 12, 24, 40] {
            for same_volume in [false, true] {
                let fineness = Fineness { sides, same_volume };
                let ball = sphere(DVec3::ONE, 2.0, fineness);
                let rod = cylinder(&fibre, fineness);
                for (mesh, full) in [(ball, 32.0 / 3.0 * PI), (rod, PI * 0.49 * 0.5 * 5.0)] {
                    assert_eq!(mesh.closed().unwrap(), mesh, "closed, and wound outwards");
                    let part = mesh.volume() / full;
                    let expected = if same_volume { (part - 1.0).abs() < 1e-12 } else { part < 1.0 };
                    assert!(expected && (sides < 12 || part > 0.87), "{sides}: {part}");
                }
            }
        }
        assert_eq!(sphere(DVec3::ZERO, 1.0, Fineness { sides: 24, same_volume: false }).triangles.len(), 320);
    }
}
