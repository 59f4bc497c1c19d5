//! Solids of equal precedence that share space: which medium would be there? They may touch.
//!
//! An overlap is reported only with a point found well inside both bodies, so touching bodies never are. Convex
//! bodies and layers are compared exactly; of meshes a few points per triangle are tried, which slivers at their
//! edges and corners can escape: rays that meet those end in the ledger as lost.

mod columns;
mod convex;
#[cfg(test)]
mod tests;
mod triangles;

use std::sync::OnceLock;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use self::columns::Columns;
use self::convex::{Convex, common_point};
use self::triangles::{below, clip, middle_of_meeting};
use super::problem::{Place, Problem};
use super::solid::{Base, Solid};
use super::tiling::Cell;
use crate::geometry::{Aabb, COINCIDENT, Cuboid, Layer, Pairs};

/// Overlaps told one by one; of the others only the number.
const MOST_TOLD: usize = 5;

/// After so many overlaps the search ends.
const ENOUGH: usize = 1000;

/// Bodies that are searched at once before it is asked whether there are enough.
const AT_ONCE: usize = 1 << 8;

/// Two solids and a point inside both, µm.
type Overlap = ([u32; 2], DVec3);

/// All pairs of solids that overlap though neither has the higher precedence.
pub(super) fn problems(shapes: &[(Base, u32)], solids: &[Solid], cell: &Cell) -> Vec<Problem> {
    let scene = Scene::new(shapes, solids, cell);
    let mut found = scene.overlapping_bodies();
    found.extend(scene.overlapping_layers());
    found.sort_by_key(|(owners, _)| *owners);
    found.dedup_by_key(|(owners, _)| *owners);
    let place = |&(owners, _): &Overlap| owners.map(|i| solids[i as usize].place.clone());
    found.sort_by_key(place);
    let mut problems: Vec<Problem> = found.iter().take(MOST_TOLD).map(|o| report(o, solids, cell)).collect();
    if found.len() > MOST_TOLD {
        let more = found.len() - MOST_TOLD;
        let all: Vec<Place> = found.iter().flat_map(place).collect();
        let last = all.into_iter().max().unwrap_or_default();
        problems
            .push(last.problem(format!("... and at least {more} more pairs of solids of equal `priority` overlap")));
    }
    problems
}

fn report(&([a, b], point): &Overlap, solids: &[Solid], cell: &Cell) -> Problem {
    let [first, second] = [a, b].map(|i| &solids[i as usize]);
    let period = if cell.periodic { cell.size } else { DVec2::INFINITY };
    let shift = (point.truncate() / period).round() * cell.size;
    let [x, y, z] = (point - shift.extend(0.0) + cell.center).to_array().map(|x| crate::units::significant(x, 5));
    let near = format!("near ({x} {y} {z}) µm");
    if a == b {
        return first.place.problem(format!(
            "`{}` overlaps its own repetition {near}: enlarge the patch, or give the object a smaller extent across",
            first.name
        ));
    }
    let (first, second) = if first.place <= second.place { (first, second) } else { (second, first) };
    let line = match first.place.line {
        Some(line) if first.place != second.place => format!(" of line {line}"),
        _ => String::new(),
    };
    second.place.problem(format!(
        "`{}` and `{}`{line} overlap {near}: give one of them a higher `priority`, or move them apart until they touch",
        second.name, first.name
    ))
}

/// A body or one of its repetitions.
struct Body {
    shape: usize,
    owner: u32,
    offset: DVec3,
    bounds: Aabb,
}

struct Scene<'a> {
    shapes: &'a [(Base, u32)],
    solids: &'a [Solid],
    /// Of each shape that is a mesh, once it is needed.
    columns: Vec<OnceLock<Box<Columns<'a>>>>,
    bodies: Vec<Body>,
    layers: Vec<(Layer, u32)>,
    /// Endless bodies are cut off here.
    far: Aabb,
    /// How deep a point must lie in both bodies, µm.
    depth: f64,
}

impl<'a> Scene<'a> {
    fn new(shapes: &'a [(Base, u32)], solids: &'a [Solid], cell: &Cell) -> Self {
        let zone = cell.tile();
        let mut bodies = Vec::new();
        let mut layers = Vec::new();
        for (number, (base, owner)) in shapes.iter().enumerate() {
            match base.bounds() {
                Some(bounds) if solids[*owner as usize].closed => {
                    let body = |shift| {
                        let offset = cell.offset(shift);
                        Body { shape: number, owner: *owner, offset, bounds: bounds.translate(offset) }
                    };
                    bodies.extend(cell.shifts(Some(bounds), zone).into_iter().map(body));
                }
                Some(_) => {}
                None => layers.extend(base.layer().map(|l| (l, *owner))),
            }
        }
        layers.sort_by(|(a, _), (b, _)| a.bottom.total_cmp(&b.bottom));
        let columns = shapes.iter().map(|_| OnceLock::new()).collect();
        let coordinates = reach_of(&bodies);
        let reach = (Cell::FAR * cell.size.max_element()).max(2.0 * coordinates);
        let far = Aabb { min: DVec3::splat(-reach), max: DVec3::splat(reach) };
        // What is far from the origin is known to its rounding only.
        let depth = 4.0 * COINCIDENT.max(coordinates * 2.0_f64.powi(-46));
        Self { shapes, solids, columns, bodies, layers, far, depth }
    }

    fn rivals(&self, a: u32, b: u32) -> bool {
        self.solids[a as usize].precedence == self.solids[b as usize].precedence
    }

    fn overlapping_bodies(&self) -> Vec<Overlap> {
        let bounds: Vec<Aabb> = self.bodies.iter().map(|b| b.bounds).collect();
        let grid = Pairs::new(&bounds);
        let mut found = Vec::new();
        let count = self.bodies.len();
        for first in (0..count).step_by(AT_ONCE) {
            let some = (first..count.min(first + AT_ONCE)).into_par_iter();
            found.par_extend(some.flat_map_iter(|i| self.overlapping(i, &grid)));
            if found.len() >= ENOUGH {
                break;
            }
        }
        found
    }

    /// Overlaps of a body with later ones, as many as are enough.
    fn overlapping(&self, i: usize, grid: &Pairs<'_>) -> Vec<Overlap> {
        let a = &self.bodies[i];
        let mut rivals = Vec::new();
        grid.overlapping(&a.bounds, |j| {
            let b = &self.bodies[j];
            if j > i && self.rivals(a.owner, b.owner) && self.share_bounds(a.bounds, b.bounds) {
                rivals.push(j);
            }
        });
        rivals.sort_unstable();
        rivals.dedup();
        let owners = |b: &Body| [a.owner.min(b.owner), a.owner.max(b.owner)];
        let overlap = |b: &Body| Some((owners(b), self.common(a, b)?));
        rivals.into_iter().filter_map(|j| overlap(&self.bodies[j])).take(ENOUGH).collect()
    }

    /// Whether bounds overlap and do not only touch.
    fn share_bounds(&self, a: Aabb, b: Aabb) -> bool {
        a.intersection(b).size().min_element() > 2.0 * self.depth
    }

    /// A point inside both bodies.
    fn common(&self, a: &Body, b: &Body) -> Option<DVec3> {
        let shared = a.bounds.intersection(b.bounds).intersection(self.far);
        // Hulls that are apart need no closer look.
        let [p, q] = [a, b].map(|body| self.hull(body, shared));
        let hardly = common_point(&p?, &q?, self.depth)?;
        match [a, b].map(|body| self.convex(body, shared)) {
            [Some(p), Some(q)] => {
                // People rather see a point well inside.
                let extent = shared.size().min_element();
                let well = [0.3, 0.1, 0.03].into_iter().find_map(|part| common_point(&p, &q, part * extent));
                Some(well.unwrap_or(hardly))
            }
            [Some(p), None] => self.mesh_and_convex(b, &p, shared),
            [None, Some(q)] => self.mesh_and_convex(a, &q, shared),
            [None, None] => self.mesh_in_mesh(a, b, shared).or_else(|| self.mesh_in_mesh(b, a, shared)),
        }
    }

    /// The body, if it is no mesh, as far as it can matter within `shared`.
    fn convex(&self, body: &Body, shared: Aabb) -> Option<Convex<'_>> {
        match &self.shapes[body.shape].0 {
            Base::Shape(shape) => Some(Convex::of(shape)?.translated(body.offset).clipped(shared)),
            Base::Triangles(_) | Base::Relief(..) => None,
        }
    }

    /// What the body spans; that of a mesh a little smaller, so that touching meshes are apart.
    fn hull(&self, body: &Body, shared: Aabb) -> Option<Convex<'_>> {
        let mesh = match &self.shapes[body.shape].0 {
            Base::Triangles(mesh) => mesh,
            // Its corners are many and, seen from afar, a box.
            Base::Relief(..) => return Some(Convex::Cuboid(Cuboid { min: body.bounds.min, max: body.bounds.max })),
            Base::Shape(_) => return self.convex(body, shared),
        };
        let bounds = mesh.bounds();
        let scale = 1.0 - self.depth / bounds.size().min_element();
        Some(Convex::Hull { corners: &mesh.vertices, center: bounds.center(), offset: body.offset, scale })
    }

    fn columns(&self, body: &Body) -> Option<&Columns<'a>> {
        let mesh = self.shapes[body.shape].0.mesh()?;
        Some(self.columns[body.shape].get_or_init(|| Box::new(Columns::new(mesh))))
    }

    /// A face of the mesh enters the other body, or that lies inside the mesh.
    fn mesh_and_convex(&self, mesh: &Body, other: &Convex<'_>, shared: Aabb) -> Option<DVec3> {
        let columns = self.columns(mesh)?;
        let inside_both = |p: &DVec3| {
            columns.contains(*p - mesh.offset, self.depth)
                && other.shrunk(self.depth).is_some_and(|inner| inner.contains(*p))
        };
        let near = columns.near(shared.translate(-mesh.offset)).into_iter().map(|t| t.map(|p| p + mesh.offset));
        let extent = shared.size().min_element();
        let mut entering = near.filter_map(|t| {
            let common = |depth| Some((common_point(&Convex::Triangle(t), other, depth)?, depth));
            let hardly = common(8.0 * self.depth)?;
            let well = [0.1, 1e-3, 1e-5].into_iter().filter_map(|part| common(part * extent));
            well.chain([hardly]).flat_map(|(p, depth)| below(t, p, 0.125 * depth)).find(inside_both)
        });
        entering.next().or_else(|| Some(other.center()).filter(inside_both))
    }

    /// A point inside both, near a face of `a`: below its middle, or beside where a face of `b` passes through it.
    fn mesh_in_mesh(&self, a: &Body, b: &Body, shared: Aabb) -> Option<DVec3> {
        let (from, into) = (self.columns(a)?, self.columns(b)?);
        let inside_both =
            |p: &DVec3| from.contains(*p - a.offset, self.depth) && into.contains(*p - b.offset, self.depth);
        let near = from.near(shared.translate(-a.offset)).into_iter().map(|t| t.map(|p| p + a.offset));
        near.flat_map(|t| {
            let middle = clip(t, shared).into_iter().flat_map(move |(center, width)| {
                [0.1 * width, 1e-3 * width, 2.0 * self.depth].into_iter().flat_map(move |d| below(t, center, d))
            });
            let bounds = Aabb::around(t).intersection(shared).translate(-b.offset);
            let others = into.near(bounds).into_iter().map(|u| u.map(|p| p + b.offset));
            middle.chain(others.filter_map(move |u| middle_of_meeting(t, u)))
        })
        .find(inside_both)
    }

    /// Layers over layers, and bodies that reach into layers.
    fn overlapping_layers(&self) -> Vec<Overlap> {
        let mut found = Vec::new();
        let mut precedences: Vec<_> = self.layers.iter().map(|(_, i)| self.solids[*i as usize].precedence).collect();
        precedences.sort_unstable();
        precedences.dedup();
        for precedence in precedences {
            let equal = |owner: u32| self.solids[owner as usize].precedence == precedence;
            let layers: Vec<_> = self.layers.iter().filter(|(_, owner)| equal(*owner)).copied().collect();
            found.extend(
                layers
                    .windows(2)
                    .filter_map(|w| self.layer_overlap(w[0], w[1].0.bottom, w[1].0.top, w[1].1, DVec2::ZERO)),
            );
            for body in self.bodies.iter().filter(|b| equal(b.owner)) {
                let Aabb { min, max } = body.bounds;
                // Layers that do not overlap ascend with their tops as well.
                let first = layers.partition_point(|(l, _)| l.top <= min.z + self.depth);
                let across = body.bounds.intersection(self.far).center().truncate();
                found.extend(layers.get(first).and_then(|&l| self.layer_overlap(l, min.z, max.z, body.owner, across)));
            }
        }
        found
    }

    /// The overlap of a layer with what reaches from `low` to `high`.
    fn layer_overlap(&self, (layer, a): (Layer, u32), low: f64, high: f64, b: u32, across: DVec2) -> Option<Overlap> {
        let (bottom, top) = (layer.bottom.max(low), layer.top.min(high));
        (top - bottom > self.depth).then(|| ([a.min(b), a.max(b)], across.extend(0.5 * (bottom + top))))
    }
}

/// Largest coordinate of bodies that have an end, µm.
fn reach_of(bodies: &[Body]) -> f64 {
    let ends = bodies.iter().flat_map(|b| [b.bounds.min, b.bounds.max]).flat_map(|p| p.to_array());
    ends.filter(|x| x.is_finite()).fold(0.0, |far, x| far.max(x.abs()))
}
