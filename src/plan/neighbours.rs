//! Which faces could be parallel to a face: plane ones by their normals, then by their place. A mesh has many faces near
//! each, and few of its direction.

use std::ops::Range;

use glam::DVec3;
use rayon::prelude::*;
use rustc_hash::FxHashMap;

use super::face::{Face, TILT};
use crate::geometry::{Aabb, Pairs};

/// Width of a cell of directions: what is parallel is in one of two cells along each axis.
const CELL: f64 = 2.0 * TILT;

/// Above rounding of unit normals.
const ROUNDING: f64 = 1e-9;

/// So few faces are compared one by one.
const FEW: usize = 32;

/// Faces with their bounds.
#[derive(Default)]
struct Group<'f> {
    faces: Vec<&'f Face>,
    boxes: Vec<Aabb>,
}

impl<'f> FromIterator<&'f Face> for Group<'f> {
    fn from_iter<I: IntoIterator<Item = &'f Face>>(faces: I) -> Self {
        let faces: Vec<&Face> = faces.into_iter().collect();
        let boxes = faces.iter().map(|face| face.seen(0.0, 0.0)).collect();
        Self { faces, boxes }
    }
}

/// Faces by direction: plane ones sorted by the cell of their normals, and all curved ones.
pub struct Groups<'f> {
    plane: Group<'f>,
    /// Which of the plane faces are in a cell.
    cells: FxHashMap<[i16; 3], Range<usize>>,
    curved: Group<'f>,
    /// All faces, where there are curved ones.
    all: Group<'f>,
}

impl<'f> Groups<'f> {
    /// Sorts faces.
    pub fn new(faces: &'f [Face]) -> Self {
        let cell_of = |face: &'f Face| face.normal().map(|n| ((n / CELL).floor().to_array().map(|x| x as i16), face));
        let mut sorted: Vec<_> = faces.par_iter().filter_map(cell_of).collect();
        sorted.par_sort_by_key(|(cell, _)| *cell);
        let mut cells: FxHashMap<[i16; 3], Range<usize>> = FxHashMap::default();
        let mut begin = 0;
        for part in sorted.chunk_by(|a, b| a.0 == b.0) {
            cells.insert(part[0].0, begin..begin + part.len());
            begin += part.len();
        }
        let curved: Group = faces.iter().filter(|face| face.normal().is_none()).collect();
        let all = if curved.faces.is_empty() { Group::default() } else { faces.iter().collect() };
        Self { plane: sorted.into_iter().map(|(_, face)| face).collect(), cells, curved, all }
    }

    /// Which faces have a parallel one within `reach` µm.
    pub fn parallel(&self, reach: f64, wavelength: f64) -> Vec<&'f Face> {
        let Self { plane, cells, curved, all } = self;
        let parts: FxHashMap<[i16; 3], Search> =
            cells.par_iter().map(|(cell, part)| (*cell, Search::new(plane, part.clone()))).collect();
        let whole = |group| Search::new(group, 0..group.faces.len());
        let (curved, all) = (whole(curved), whole(all));
        let has = |face: &Face| {
            let seen = face.seen(reach, wavelength);
            let any = |search: &Search| search.any(face, &seen, reach, wavelength);
            let Some(normal) = face.normal() else { return any(&all) };
            let near = [normal, -normal].into_iter().flat_map(near);
            near.filter_map(|cell| parts.get(&cell)).any(any) || any(&curved)
        };
        // In the order of their directions, so that what is compared is at hand.
        self.plane.faces.par_iter().chain(&self.curved.faces).copied().filter(|face| has(face)).collect()
    }
}

/// The cells of what is parallel to a normal.
fn near(normal: DVec3) -> impl Iterator<Item = [i16; 3]> {
    let cells = |by: f64| ((normal + by) / CELL).floor().to_array().map(|x| x as i16);
    let (low, high) = (cells(-TILT - ROUNDING), cells(TILT + ROUNDING));
    let along = move |axis: usize| low[axis]..=high[axis];
    along(0).flat_map(move |x| along(1).flat_map(move |y| along(2).map(move |z| [x, y, z])))
}

/// Some of a group, ready to be searched by place.
struct Search<'g, 'f> {
    faces: &'g [&'f Face],
    boxes: &'g [Aabb],
    /// None for few faces, which are compared one by one.
    pairs: Option<Pairs<'g>>,
}

impl<'g, 'f> Search<'g, 'f> {
    fn new(group: &'g Group<'f>, part: Range<usize>) -> Self {
        let boxes = &group.boxes[part.clone()];
        Self { faces: &group.faces[part], boxes, pairs: (boxes.len() > FEW).then(|| Pairs::new(boxes)) }
    }

    fn any(&self, face: &Face, seen: &Aabb, reach: f64, wavelength: f64) -> bool {
        let is_parallel = |j: usize| face.parallel_to(self.faces[j], reach, wavelength);
        let Some(pairs) = &self.pairs else {
            return (0..self.faces.len()).any(|j| self.boxes[j].overlaps(*seen) && is_parallel(j));
        };
        let mut found = false;
        pairs.overlapping(seen, |j| found = found || is_parallel(j));
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Builder, Cuboid, PrimId, Shape, Sphere, Triangle};
    use crate::plan::face::faces;
    use rand::rngs::Xoshiro256PlusPlus;
    use rand::{RngExt, SeedableRng};

    /// The same as by comparing all faces, for parallel and nearly parallel ones of all directions.
    #[test]
    fn no_neighbour_is_missed() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
        let mut number = |size: f64| size * (2.0 * rng.random::<f64>() - 1.0);
        let mut builder = Builder::default();
        for i in 0..300 {
            let center = DVec3::new(number(8.0), number(8.0), number(8.0));
            let shape = match i % 10 {
                0 => Shape::Sphere(Sphere {
                    center: DVec3::splat(f64::from(i / 50)),
                    radius: 3.0 + 0.01 * f64::from(i % 50),
                }),
                1 => Shape::Cuboid(Cuboid { min: center - 0.5, max: center + 0.5 }),
                _ => {
                    // Some directions, each with some tilt.
                    let turn = f64::from(i % 7);
                    let (u, v) = DVec3::new(turn.cos(), turn.sin(), 0.3 * turn).normalize().any_orthonormal_pair();
                    let tilt = DVec3::new(number(1e-3), number(1e-3), number(1e-3));
                    let corners = [center, center + u + tilt, center + v];
                    Shape::Triangle(Triangle { corners: corners.map(|p| builder.vertex(p)) })
                }
            };
            builder.add(shape, i);
        }
        let primitives = builder.finish();
        let all: Vec<Face> = (0..primitives.len() as u32).flat_map(|i| faces(&primitives, PrimId(i))).collect();
        let groups = Groups::new(&all);
        let (reach, wavelength) = (3.0, 0.2);
        let sorted = |faces: Vec<&Face>| {
            let mut numbers: Vec<(u32, u8)> = faces.iter().map(|f| (f.prim.0, f.number)).collect();
            numbers.sort_unstable();
            numbers
        };
        let has = |face: &&Face| all.iter().any(|other| face.parallel_to(other, reach, wavelength));
        let expected = sorted(all.iter().filter(has).collect());
        assert_eq!(sorted(groups.parallel(reach, wavelength)), expected);
        assert!(expected.len() > 30 && expected.len() < all.len() - 30, "{} of {}", expected.len(), all.len());
    }
}
