//! Which faces have a nearly parallel neighbour: only rays that meet such a face look for films.

use std::collections::BTreeSet;

use rayon::prelude::*;

use super::face::{Face, faces};
use super::neighbours::Groups;
use crate::geometry::{Layer, PrimId, Primitives, Shape};

/// A bit per face, per primitive.
#[derive(Clone, Debug, Default)]
pub struct Marks {
    bits: Vec<u8>,
    faces: usize,
    curved: BTreeSet<u64>,
}

impl Marks {
    /// Finds all faces with a nearly parallel neighbour within `reach` µm along their normal. A superset:
    /// whether there is a film at a point is decided there. `wavelength` (µm) is the smallest spot that counts.
    pub fn new(primitives: &Primitives, reach: f64, wavelength: f64) -> Self {
        let mut marks = Self { bits: vec![0; primitives.len()], ..Self::default() };
        if reach > 0.0 {
            marks.mark_layers(primitives, reach);
            marks.mark_bounded(primitives, reach, wavelength);
        }
        marks
    }

    /// Whether a film may begin at this face.
    #[inline]
    pub fn marked(&self, prim: PrimId, face: u8) -> bool {
        self.bits[prim.0 as usize] >> face & 1 == 1
    }

    /// Whether a film may begin anywhere.
    pub fn any(&self) -> bool {
        self.faces > 0
    }

    /// Number of faces where a film may begin.
    pub fn count(&self) -> usize {
        self.faces
    }

    /// Number of radii of curved faces where a film may begin.
    pub fn curved(&self) -> usize {
        self.curved.len()
    }

    fn set(&mut self, prim: PrimId, face: u8) {
        let bits = &mut self.bits[prim.0 as usize];
        self.faces += usize::from(*bits >> face & 1 == 0);
        *bits |= 1 << face;
    }

    /// Infinite layers among themselves: neighbours in height.
    fn mark_layers(&mut self, primitives: &Primitives, reach: f64) {
        let mut levels: Vec<(f64, PrimId, u8)> = Vec::new();
        for id in primitives.ids() {
            if let Shape::Layer(layer) = primitives.shape(id) {
                let ends = [(layer.bottom, id, Layer::BOTTOM), (layer.top, id, Layer::TOP)];
                levels.extend(ends.into_iter().filter(|l| l.0.is_finite()));
            }
        }
        levels.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (i, &(z, prim, face)) in levels.iter().enumerate() {
            let below = levels[..i].iter().rev().find(|l| l.0 < z);
            let above = levels[i..].iter().find(|l| l.0 > z);
            if [below, above].into_iter().flatten().any(|l| (l.0 - z).abs() <= reach) {
                self.set(prim, face);
            }
        }
    }

    fn mark_bounded(&mut self, primitives: &Primitives, reach: f64, wavelength: f64) {
        let count = primitives.bounded_count() as u32;
        let bounded: Vec<Face> = (0..count).into_par_iter().flat_map_iter(|i| faces(primitives, PrimId(i))).collect();
        let levels = (count..primitives.len() as u32).flat_map(|i| faces(primitives, PrimId(i)));
        let levels: Vec<Face> = levels.collect();
        let groups = Groups::new(bounded);
        for face in groups.parallel(reach, wavelength) {
            self.mark(&face);
        }
        for face in groups.faces().filter(|f| f.may_face_a_level(wavelength)) {
            for level in levels.iter().filter(|l| face.parallel_to(l, reach, wavelength)) {
                self.mark(face);
                self.mark(level);
            }
        }
    }

    fn mark(&mut self, face: &Face) {
        self.set(face.prim, face.number);
        self.curved.extend(face.radius().map(f64::to_bits));
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::geometry::{Builder, Cuboid, Sphere};

    fn marks(shapes: &[Shape], reach: f64) -> Vec<u8> {
        let mut builder = Builder::default();
        for (i, shape) in shapes.iter().enumerate() {
            builder.add(*shape, i as u32);
        }
        let primitives = builder.finish();
        Marks::new(&primitives, reach, 0.4).bits
    }

    fn cuboid(min: [f64; 3], max: [f64; 3]) -> Shape {
        Shape::Cuboid(Cuboid { min: min.into(), max: max.into() })
    }

    #[test]
    fn a_plate_marks_its_thin_direction_only() {
        let plate = cuboid([-5.0, -5.0, 0.0], [5.0, 5.0, 0.2]);
        assert_eq!(marks(&[plate], 1.0), [0b11_0000]);
        assert_eq!(marks(&[plate], 0.1), [0]);
        // Beside it, a plate that does not face it; above it, one that does.
        let beside = cuboid([8.0, -5.0, 0.0], [18.0, 5.0, 3.0]);
        assert_eq!(marks(&[plate, beside], 1.0), [0b11_0000, 0]);
        let above = cuboid([-1.0, -1.0, 0.9], [1.0, 1.0, 5.0]);
        assert_eq!(marks(&[plate, above], 1.0), [0b11_0000, 0b01_0000]);
    }

    #[test]
    fn shells_are_films_and_neighbours_are_not() {
        let ball = |x: f64, radius| Shape::Sphere(Sphere { center: DVec3::ZERO.with_x(x), radius });
        assert_eq!(marks(&[ball(0.0, 5.0), ball(0.0, 4.9)], 1.0), [1, 1]);
        assert_eq!(marks(&[ball(0.0, 5.0), ball(10.0, 5.0)], 1.0), [0, 0]);
        let layer = |bottom, top| Shape::Layer(Layer { bottom, top });
        assert_eq!(marks(&[layer(0.0, 0.1), layer(-10.0, 0.0)], 1.0), [0b11, 0b10]);
        assert_eq!(marks(&[ball(0.0, 5.0), layer(-10.0, -5.1)], 1.0), [0, 0]);
        // Newton's rings.
        assert_eq!(marks(&[ball(0.0, 5000.0), layer(-5010.0, -5000.1)], 1.0), [1, 0b10]);
    }
}
