//! The body under a relief as triangles: a block with walls, or one period of a surface without end.

use glam::{DVec2, DVec3};

use super::HeightField;
use crate::sample::mesh::Mesh;

/// A body with a relief on it and a flat floor.
#[derive(Clone, Debug, PartialEq)]
pub struct Relief {
    /// Its upper face; heights are in the user's coordinates.
    pub field: HeightField,
    /// Middle of the field, µm.
    pub center: DVec2,
    /// Height of the floor, below all heights, µm.
    pub floor: f64,
}

/// How one period of a surface goes on in the next.
#[derive(Clone, Debug)]
pub(in crate::sample) struct Wrap {
    /// The first triangles of the mesh are the relief; the others only close the body for who wants to know its inside.
    relief: usize,
    /// The floor.
    floor: [[u32; 3]; 2],
    /// The corner that each corner repeats, and by how many periods it is moved.
    twins: Vec<(u32, [i32; 2])>,
}

impl Wrap {
    /// The triangles that light meets.
    pub fn faces<'a>(&'a self, mesh: &'a Mesh) -> impl Iterator<Item = [u32; 3]> + 'a {
        mesh.triangles[..self.relief].iter().chain(&self.floor).copied()
    }

    /// Where a corner of a repetition comes from: the same for all triangles that meet there, in whatever repetition.
    pub fn origin(&self, corner: u32, shift: [i32; 2]) -> (u32, [i32; 2]) {
        let (twin, by) = self.twins[corner as usize];
        (twin, [shift[0] + by[0], shift[1] + by[1]])
    }
}

impl Relief {
    /// The body alone, with walls at its outermost heights.
    pub(in crate::sample) fn block(&self) -> Mesh {
        Sheet::new(self, None).closed(self.floor)
    }

    /// One period of the body, whose size is `period` µm.
    pub(in crate::sample) fn periodic(&self, period: DVec2) -> (Mesh, Wrap) {
        let sheet = Sheet::new(self, Some(period));
        let mesh = sheet.closed(self.floor);
        let relief = 2 * (sheet.columns - 1) * (sheet.rows - 1);
        let ring = sheet.ring();
        let first = sheet.points.len() as u32;
        let twin = |point: u32| {
            let (c, r) = (point as usize % sheet.columns, point as usize / sheet.columns);
            let (columns, rows) = (self.field.columns, self.field.rows);
            // Rows follow one another towards −y.
            ((r % rows * sheet.columns + c % columns) as u32, [(c / columns) as i32, -((r / rows) as i32)])
        };
        let below: Vec<u32> = (0..ring.len() as u32).map(|i| first + i).collect();
        let under = |point: u32| below[ring.iter().position(|&p| p == point).unwrap_or(0)];
        let own = |corner: u32| (corner, [0, 0]);
        let mut twins: Vec<_> = (0..first).map(twin).chain((first..mesh.vertices.len() as u32).map(own)).collect();
        let [a, b, c, d] = sheet.corners().map(under);
        let home = twin(sheet.corners()[3]).0;
        for (point, corner) in sheet.corners().into_iter().zip([a, b, c, d]) {
            twins[corner as usize] = (under(home), twin(point).1);
        }
        (mesh, Wrap { relief, floor: [[a, c, b], [a, d, c]], twins })
    }
}

/// The upper face: points by rows, that of largest y first.
struct Sheet {
    columns: usize,
    rows: usize,
    points: Vec<DVec3>,
}

impl Sheet {
    /// All heights; where the relief repeats also the first column and row again, one period on.
    fn new(relief: &Relief, period: Option<DVec2>) -> Self {
        let Relief { field, center, .. } = relief;
        let (nx, ny) = (field.columns, field.rows);
        let more = usize::from(period.is_some());
        let period = period.unwrap_or_default();
        let x = |c: usize| {
            center.x + ((c % nx) as f64 + 0.5 - 0.5 * nx as f64) * field.pixel.x + (c / nx) as f64 * period.x
        };
        let y = |r: usize| {
            center.y - ((r % ny) as f64 + 0.5 - 0.5 * ny as f64) * field.pixel.y - (r / ny) as f64 * period.y
        };
        let point = |c: usize, r: usize| DVec3::new(x(c), y(r), field.at(c % nx, r % ny));
        let (columns, rows) = (nx + more, ny + more);
        let points = (0..rows).flat_map(|r| (0..columns).map(move |c| (c, r))).map(|(c, r)| point(c, r)).collect();
        Self { columns, rows, points }
    }

    fn index(&self, column: usize, row: usize) -> u32 {
        (row * self.columns + column) as u32
    }

    /// The outermost corners, counter-clockwise seen from above, from −x −y.
    fn corners(&self) -> [u32; 4] {
        let (c, r) = (self.columns - 1, self.rows - 1);
        [self.index(0, r), self.index(c, r), self.index(c, 0), self.index(0, 0)]
    }

    /// Two triangles per cell, which meet along the diagonal from −x −y to +x +y.
    fn triangles(&self) -> Vec<[u32; 3]> {
        let cell = |c: usize, r: usize| {
            let [low, right] = [self.index(c, r + 1), self.index(c + 1, r + 1)];
            let [left, high] = [self.index(c, r), self.index(c + 1, r)];
            [[low, right, high], [low, high, left]]
        };
        (0..self.rows - 1).flat_map(|r| (0..self.columns - 1).flat_map(move |c| cell(c, r))).collect()
    }

    /// The points of the rim, counter-clockwise seen from above.
    fn ring(&self) -> Vec<u32> {
        let (c, r) = (self.columns - 1, self.rows - 1);
        let front = (0..c).map(|i| self.index(i, r));
        let right = (0..r).map(|i| self.index(c, r - i));
        let back = (0..c).map(|i| self.index(c - i, 0));
        let left = (0..r).map(|i| self.index(0, i));
        front.chain(right).chain(back).chain(left).collect()
    }

    /// The closed body: the relief, walls, and the floor around its middle.
    fn closed(&self, floor: f64) -> Mesh {
        let ring = self.ring();
        let mut mesh = Mesh { vertices: self.points.clone(), triangles: self.triangles() };
        let first = mesh.vertices.len() as u32;
        mesh.vertices.extend(ring.iter().map(|&i| self.points[i as usize].with_z(floor)));
        let [a, _, c, _] = self.corners().map(|i| self.points[i as usize]);
        let middle = mesh.vertices.len() as u32;
        mesh.vertices.push((0.5 * (a + c)).with_z(floor));
        for i in 0..ring.len() {
            let next = (i + 1) % ring.len();
            let (top, top_next) = (ring[i], ring[next]);
            let (low, low_next) = (first + i as u32, first + next as u32);
            mesh.triangles.extend([[low, low_next, top_next], [low, top_next, top], [middle, low_next, low]]);
        }
        mesh
    }
}
