//! Which faces could be parallel to a face: plane ones by their normals, then by their place. A mesh has many faces near
//! each, and few of its direction.

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::face::{Face, TILT};
use crate::geometry::{Aabb, Pairs};

/// Width of a cell of directions: what is parallel is in the same cell or in one beside it.
const CELL: f64 = 2.0 * TILT;

/// Faces with their bounds.
#[derive(Default)]
struct Group<'f> {
    faces: Vec<&'f Face>,
    boxes: Vec<Aabb>,
}

impl<'f> Group<'f> {
    fn push(&mut self, face: &'f Face) {
        self.faces.push(face);
        self.boxes.push(face.seen(0.0, 0.0));
    }
}

/// Faces by direction: those of one cell of normals together, and all curved ones.
pub struct Groups<'f> {
    plane: Vec<Group<'f>>,
    cells: FxHashMap<[i32; 3], usize>,
    curved: Group<'f>,
    all: Group<'f>,
}

impl<'f> Groups<'f> {
    /// Sorts faces.
    pub fn new(faces: &'f [Face]) -> Self {
        let mut groups =
            Self { plane: Vec::new(), cells: FxHashMap::default(), curved: Group::default(), all: Group::default() };
        for face in faces {
            let Some(normal) = face.normal() else {
                groups.curved.push(face);
                continue;
            };
            let at = *groups.cells.entry(cell(normal)).or_insert_with(|| {
                groups.plane.push(Group::default());
                groups.plane.len() - 1
            });
            groups.plane[at].push(face);
        }
        if !groups.curved.faces.is_empty() {
            faces.iter().for_each(|face| groups.all.push(face));
        }
        groups
    }

    /// Ready to be searched.
    pub fn searches(&self) -> Searches<'_, 'f> {
        Searches {
            plane: self.plane.iter().map(Search::new).collect(),
            cells: &self.cells,
            curved: Search::new(&self.curved),
            all: Search::new(&self.all),
        }
    }
}

fn cell(normal: DVec3) -> [i32; 3] {
    (normal / CELL).round().to_array().map(|x| x as i32)
}

struct Search<'g, 'f> {
    group: &'g Group<'f>,
    /// None for few faces, which are compared one by one.
    pairs: Option<Pairs<'g>>,
}

/// So few faces are compared one by one.
const FEW: usize = 16;

impl<'g, 'f> Search<'g, 'f> {
    fn new(group: &'g Group<'f>) -> Self {
        Self { group, pairs: (group.faces.len() > FEW).then(|| Pairs::new(&group.boxes)) }
    }

    fn any(&self, face: &Face, seen: &Aabb, reach: f64, wavelength: f64) -> bool {
        let Group { faces, boxes } = self.group;
        let is_parallel = |j: usize| face.parallel_to(faces[j], reach, wavelength);
        let Some(pairs) = &self.pairs else {
            return (0..faces.len()).any(|j| boxes[j].overlaps(*seen) && is_parallel(j));
        };
        let mut found = false;
        pairs.overlapping(seen, |j| found = found || is_parallel(j));
        found
    }
}

/// Faces that can be searched by direction and place.
pub struct Searches<'g, 'f> {
    plane: Vec<Search<'g, 'f>>,
    cells: &'g FxHashMap<[i32; 3], usize>,
    curved: Search<'g, 'f>,
    all: Search<'g, 'f>,
}

impl Searches<'_, '_> {
    /// Whether a face has a parallel one within `reach` µm.
    pub fn any(&self, face: &Face, reach: f64, wavelength: f64) -> bool {
        let seen = face.seen(reach, wavelength);
        let Some(normal) = face.normal() else { return self.all.any(face, &seen, reach, wavelength) };
        let near = |n: DVec3| {
            let [x, y, z] = cell(n);
            let around = move |c: i32| c - 1..=c + 1;
            around(x).flat_map(move |x| around(y).flat_map(move |y| around(z).map(move |z| [x, y, z])))
        };
        let groups = near(normal).chain(near(-normal)).filter_map(|cell| self.cells.get(&cell));
        groups.into_iter().any(|&at| self.plane[at].any(face, &seen, reach, wavelength))
            || self.curved.any(face, &seen, reach, wavelength)
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
        let searches = groups.searches();
        let mut found = 0;
        for face in &all {
            let (reach, wavelength) = (3.0, 0.2);
            let expected = all.iter().any(|other| face.parallel_to(other, reach, wavelength));
            assert_eq!(searches.any(face, reach, wavelength), expected);
            found += usize::from(expected);
        }
        assert!(found > 30 && found < all.len() - 30, "{found} of {}", all.len());
    }
}
