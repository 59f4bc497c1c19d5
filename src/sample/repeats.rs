//! Shapes with their repetitions, as primitives.

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::limits;
use super::mesh::Mesh;
use super::relief::Wrap;
use super::solid::{Base, translated};
use super::tiling::{Cell, Placed, Tiling};
use crate::geometry::{self, Aabb, Builder, Primitives, Triangle};

/// Collects shapes and their repetitions.
#[derive(Default)]
pub(super) struct Repeats {
    builder: Builder,
    placed: [Vec<Placed>; 5],
    count: usize,
}

impl Repeats {
    pub(super) fn add(&mut self, shape: &Base, number: u32, owner: u32, cell: &Cell, zone: Aabb) -> Result<(), String> {
        match shape {
            Base::Shape(flat) => {
                for shift in cell.shifts(shape.bounds(), zone) {
                    self.push(translated(*flat, cell.offset(shift)), owner, Placed { base: (number, 0), shift });
                }
            }
            Base::Relief(mesh, wrap) => {
                self.add_relief(mesh, wrap, number, owner, cell, zone)?;
            }
            Base::Triangles(mesh) => {
                for shift in cell.shifts(Some(mesh.bounds()), zone) {
                    self.add_triangles(mesh, number, owner, shift, cell.offset(shift), zone);
                    limits::check_count(self.count as f64)?;
                }
            }
        }
        limits::check_count(self.count as f64)
    }

    fn add_triangles(&mut self, mesh: &Mesh, number: u32, owner: u32, shift: [i32; 2], offset: DVec3, zone: Aabb) {
        let mut moved: Vec<Option<u32>> = vec![None; mesh.vertices.len()];
        for (i, t) in mesh.triangles.iter().enumerate() {
            let corners = mesh.corners(*t).map(|p| p + offset);
            if !Aabb::around(corners).overlaps(zone) {
                continue;
            }
            let mut corner = |k: usize| *moved[t[k] as usize].get_or_insert_with(|| self.builder.vertex(corners[k]));
            let triangle = Triangle { corners: [corner(0), corner(1), corner(2)] };
            self.push(geometry::Shape::Triangle(triangle), owner, Placed { base: (number, i as u32), shift });
        }
    }

    /// Triangles of one period and of the next share their corners, bit for bit.
    fn add_relief(
        &mut self,
        mesh: &Mesh,
        wrap: &Wrap,
        number: u32,
        owner: u32,
        cell: &Cell,
        zone: Aabb,
    ) -> Result<(), String> {
        let mut known: FxHashMap<(u32, [i32; 2]), u32> = FxHashMap::default();
        let corner = |(corner, by): (u32, [i32; 2])| mesh.vertices[corner as usize] + cell.offset(by);
        let faces: Vec<[u32; 3]> = wrap.faces(mesh).collect();
        let bounds = |t: &[u32; 3]| Aabb::around(t.map(|c| corner(wrap.origin(c, [0, 0]))));
        let bounds: Vec<Aabb> = faces.iter().map(bounds).collect();
        for shift in cell.shifts(Some(mesh.bounds()), zone) {
            // Most of a repetition is out of sight: what is left is decided by where it is to the last bit.
            let (offset, rounding) = (cell.offset(shift), 1e-9 * zone.size().max_element());
            let near = Aabb { min: zone.min - offset, max: zone.max - offset }.inflate(rounding);
            for (i, t) in faces.iter().enumerate().filter(|(i, _)| bounds[*i].overlaps(near)) {
                let origins = t.map(|corner| wrap.origin(corner, shift));
                let corners = origins.map(corner);
                if !Aabb::around(corners).overlaps(zone) {
                    continue;
                }
                let corners = std::array::from_fn(|k| {
                    *known.entry(origins[k]).or_insert_with(|| self.builder.vertex(corners[k]))
                });
                let triangle = geometry::Shape::Triangle(Triangle { corners });
                self.push(triangle, owner, Placed { base: (number, i as u32), shift });
            }
            limits::check_count(self.count as f64)?;
        }
        Ok(())
    }

    fn push(&mut self, shape: geometry::Shape, owner: u32, placed: Placed) {
        let kind = match shape {
            geometry::Shape::Triangle(_) => 0,
            geometry::Shape::Sphere(_) => 1,
            geometry::Shape::Cylinder(_) => 2,
            geometry::Shape::Cuboid(_) => 3,
            geometry::Shape::Layer(_) => 4,
        };
        self.builder.add(shape, owner);
        self.placed[kind].push(placed);
        self.count += 1;
    }

    /// [`Builder::finish`] numbers primitives by kind, in order.
    pub(super) fn finish(self) -> (Primitives, Tiling) {
        (self.builder.finish(), Tiling::new(self.placed.concat()))
    }
}
