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

/// So many faces are work for a thread.
const ENOUGH: usize = 256;

/// Faces with their bounds.
#[derive(Default)]
struct Group<'f> {
    faces: Vec<Face<'f>>,
    boxes: Vec<Aabb>,
}

impl<'f> Group<'f> {
    fn new(faces: Vec<Face<'f>>) -> Self {
        let boxes = faces.par_iter().map(|face| face.seen(0.0, 0.0)).collect();
        Self { faces, boxes }
    }
}

/// A cell of directions.
type Cell = [i16; 3];

/// Faces by direction: plane ones sorted by the cell of their normals, and all curved ones.
pub struct Groups<'f> {
    plane: Group<'f>,
    /// Which of the plane faces are in a cell.
    cells: Vec<(Cell, Range<usize>)>,
    curved: Group<'f>,
    /// All faces, where there are curved and plane ones.
    all: Option<Group<'f>>,
}

impl<'f> Groups<'f> {
    /// Sorts faces.
    pub fn new(mut faces: Vec<Face<'f>>) -> Self {
        let of_face = |face: &Face<'f>| face.normal().map(|normal| (cell(normal), *face));
        let mut sorted: Vec<(Cell, Face)> = faces.par_iter().filter_map(of_face).collect();
        sorted.par_sort_by_key(|(cell, _)| *cell);
        let mut cells = Vec::new();
        let mut begin = 0;
        for part in sorted.chunk_by(|a, b| a.0 == b.0) {
            cells.push((part[0].0, begin..begin + part.len()));
            begin += part.len();
        }
        let mixed = !sorted.is_empty() && sorted.len() < faces.len();
        let all = mixed.then(|| Group::new(faces.clone()));
        let plane = sorted.into_iter().map(|(_, face)| face).collect();
        faces.retain(|face| face.normal().is_none());
        faces.shrink_to_fit();
        let [plane, curved] = [plane, faces].map(Group::new);
        Self { plane, cells, curved, all }
    }

    /// All faces.
    pub fn faces(&self) -> impl Iterator<Item = &Face<'f>> {
        self.plane.faces.iter().chain(&self.curved.faces)
    }

    /// Which faces have a parallel one within `reach` µm.
    pub fn parallel(&self, reach: f64, wavelength: f64) -> Vec<Face<'f>> {
        let Self { plane, cells, curved, all } = self;
        let parts: Vec<Search> = cells.par_iter().map(|(_, part)| Search::new(plane, part.clone())).collect();
        let number: FxHashMap<Cell, usize> = cells.iter().enumerate().map(|(i, (cell, _))| (*cell, i)).collect();
        let beside = |cell| -> Vec<(Cell, &Search)> {
            around(cell).filter_map(|cell| Some((cell, &parts[*number.get(&cell)?]))).collect()
        };
        let whole = |group| Search::new(group, 0..group.faces.len());
        let (curved, all) = (&whole(curved), all.as_ref().map(whole));
        let in_cell = |(cell, part): &(Cell, Range<usize>)| {
            // Planes have two normals.
            let (along, against) = (beside(*cell), beside(cell.map(|x| -1 - x)));
            let has = move |face: &Face| {
                let question = Question::new(face, reach, wavelength);
                let normal = face.normal().expect("plane faces have one");
                question.any_near(normal, &along) || question.any_near(-normal, &against) || question.any(curved)
            };
            plane.faces[part.clone()].par_iter().with_min_len(ENOUGH).copied().filter(has)
        };
        let mut found: Vec<Face> = cells.par_iter().flat_map(in_cell).collect();
        let all = all.as_ref().unwrap_or(curved);
        let has = |face: &Face| Question::new(face, reach, wavelength).any(all);
        found.par_extend(self.curved.faces.par_iter().copied().filter(has));
        found
    }
}

fn cell(normal: DVec3) -> Cell {
    (normal / CELL).floor().to_array().map(|x| x as i16)
}

/// A cell and those beside it.
fn around([x, y, z]: Cell) -> impl Iterator<Item = Cell> {
    let beside = |at: i16| at - 1..=at + 1;
    beside(x).flat_map(move |x| beside(y).flat_map(move |y| beside(z).map(move |z| [x, y, z])))
}

/// Some of a group, ready to be searched by place.
struct Search<'g, 'f> {
    faces: &'g [Face<'f>],
    boxes: &'g [Aabb],
    /// None for few faces, which are compared one by one.
    pairs: Option<Pairs<'g>>,
}

impl<'g, 'f> Search<'g, 'f> {
    fn new(group: &'g Group<'f>, part: Range<usize>) -> Self {
        let boxes = &group.boxes[part.clone()];
        Self { faces: &group.faces[part], boxes, pairs: (boxes.len() > FEW).then(|| Pairs::new(boxes)) }
    }
}

/// Whether a face has a parallel one.
struct Question<'q, 'f> {
    face: &'q Face<'f>,
    seen: Aabb,
    reach: f64,
    wavelength: f64,
}

impl<'q, 'f> Question<'q, 'f> {
    fn new(face: &'q Face<'f>, reach: f64, wavelength: f64) -> Self {
        Self { face, seen: face.seen(reach, wavelength), reach, wavelength }
    }

    /// Among plane faces whose normals are nearly this one.
    fn any_near(&self, normal: DVec3, cells: &[(Cell, &Search)]) -> bool {
        let [low, high] = [-1.0, 1.0].map(|side| cell(normal + side * (TILT + ROUNDING)));
        let is_near = |cell: &Cell| (0..3).all(|i| low[i] <= cell[i] && cell[i] <= high[i]);
        cells.iter().any(|(cell, faces)| is_near(cell) && self.any(faces))
    }

    fn any(&self, search: &Search) -> bool {
        let Search { faces, boxes, pairs } = search;
        let is_parallel = |j: usize| self.face.parallel_to(&faces[j], self.reach, self.wavelength);
        let Some(pairs) = pairs else {
            return (0..faces.len()).any(|j| boxes[j].overlaps(self.seen) && is_parallel(j));
        };
        let mut found = false;
        pairs.overlapping(&self.seen, |j| found = found || is_parallel(j));
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
        let groups = Groups::new(all.clone());
        let (reach, wavelength) = (3.0, 0.2);
        let sorted = |faces: Vec<Face>| {
            let mut numbers: Vec<(u32, u8)> = faces.iter().map(|f| (f.prim.0, f.number)).collect();
            numbers.sort_unstable();
            numbers
        };
        let has = |face: &Face| all.iter().any(|other| face.parallel_to(other, reach, wavelength));
        let expected = sorted(all.iter().copied().filter(has).collect());
        assert_eq!(sorted(groups.parallel(reach, wavelength)), expected);
        assert!(expected.len() > 30 && expected.len() < all.len() - 30, "{} of {}", expected.len(), all.len());
    }
}
