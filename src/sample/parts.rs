//! Solids with their shapes, in the making.

use glam::{DVec2, DVec3};

use super::description::{Body, Description, Fibre, Fill, Named, Object, Patch, Shape, Sides};
use super::media_list::{MediaList, MediumId};
use super::mesh::Mesh;
use super::problem::Problems;
use super::relief::Relief;
use super::repeats::Repeats;
use super::solid::{Base, Matter, Solid};
use super::tiling::{Cell, Tiling};
use super::{limits, lonely, overlap};
use crate::geometry::{self, Aabb, Cuboid, Cylinder, Layer, Primitives, Sphere};
use crate::light::Coherence;
use crate::units;

/// Solids with their shapes, in the user's coordinates.
#[derive(Default)]
pub(super) struct Parts {
    /// By number.
    pub(super) solids: Vec<Solid>,
    /// Shapes with the number of their solid.
    pub(super) shapes: Vec<(Base, u32)>,
}

impl Parts {
    pub(super) fn add(
        &mut self,
        object: &Object,
        description: &Description,
        media: &mut MediaList<'_>,
        problems: &mut Problems,
    ) {
        match &object.body {
            Body::Films { top, layers } => self.add_films(object, *top, layers, media, problems),
            Body::Solid(shape, fill) => {
                let matter = match fill {
                    Fill::Medium(named) => media.resolve(named, problems).map(Matter::Medium),
                    Fill::Diffuse(share) => Some(Matter::Diffuse(*share)),
                    Fill::Mirror(share) => Some(Matter::Mirror(*share)),
                };
                match (matter, shape) {
                    (Some(matter), Shape::Relief(relief)) => {
                        self.add_relief(object, relief, matter, description, problems);
                    }
                    (Some(matter), _) => self.add_solid(object, shape, matter, media, problems),
                    (None, _) => {}
                }
            }
        }
    }

    fn push(&mut self, object: &Object, matter: Matter, nesting: u32, shape: Base) {
        let owner = self.solids.len() as u32;
        self.solids.push(Solid {
            name: object.name.clone(),
            place: object.place.clone(),
            matter,
            precedence: (object.priority, nesting),
            closed: true,
            lonely: false,
        });
        self.shapes.push((shape, owner));
    }

    fn add_films(
        &mut self,
        object: &Object,
        top: f64,
        layers: &[(Named, f64)],
        media: &mut MediaList<'_>,
        problems: &mut Problems,
    ) {
        let mut depth = 0.0;
        for (named, thickness) in layers {
            let Some(id) = media.resolve(named, problems) else { continue };
            let upper = top - depth;
            depth += thickness;
            if *thickness > 0.0 {
                let layer = Layer { bottom: top - depth, top: upper };
                self.push(object, Matter::Medium(id), object.nesting, Base::Shape(geometry::Shape::Layer(layer)));
            }
        }
    }

    fn add_solid(
        &mut self,
        object: &Object,
        shape: &Shape,
        matter: Matter,
        media: &mut MediaList<'_>,
        problems: &mut Problems,
    ) {
        use geometry::Shape as Flat;
        let flat = match shape {
            Shape::Sphere { center, radius } => Flat::Sphere(Sphere { center: *center, radius: *radius }),
            Shape::Cuboid { min, max } => Flat::Cuboid(Cuboid { min: *min, max: *max }),
            Shape::Slab { top, bottom } => Flat::Layer(Layer { bottom: *bottom, top: *top }),
            Shape::Cylinder(fibre) => {
                let lumen = fibre.lumen.as_ref().map(|(r, named)| (*r, media.resolve(named, problems)));
                self.push(object, matter, object.nesting, Base::Shape(Flat::Cylinder(fibre.cylinder(fibre.radius))));
                if let Some((radius, Some(id))) = lumen {
                    let inner = Base::Shape(Flat::Cylinder(fibre.cylinder(radius)));
                    self.push(object, Matter::Medium(id), object.nesting + 1, inner);
                }
                return;
            }
            Shape::Mesh(mesh) => return self.add_mesh(object, mesh, matter, problems),
            Shape::Relief(_) => return,
        };
        self.push(object, matter, object.nesting, Base::Shape(flat));
    }

    /// A body under heights: without sides where it repeats, else a block.
    fn add_relief(
        &mut self,
        object: &Object,
        relief: &Relief,
        matter: Matter,
        description: &Description,
        problems: &mut Problems,
    ) {
        let period = relief.field.period();
        let base = match description.footprint().filter(|_| description.sides == Sides::Periodic) {
            None => Base::Triangles(relief.block()),
            Some(Patch { size, .. }) if (size - period).abs().cmple(1e-6 * period).all() => {
                let (mesh, wrap) = relief.periodic(size);
                Base::Relief(mesh, wrap)
            }
            Some(Patch { size, .. }) => {
                let [w, d] = period.to_array().map(|x| units::significant(x, 9));
                return problems.push(object.place.problem(format!(
                    "`{}` repeats every {w} x {d} µm, all its pixels, and the patch every {} x {} µm: give patch.size = \
                     [{w}, {d}], or leave it out; or sides = \"open\" for a block that stands alone",
                    object.name, size.x, size.y
                )));
            }
        };
        self.push(object, matter, object.nesting, base);
    }

    fn add_mesh(&mut self, object: &Object, mesh: &Mesh, matter: Matter, problems: &mut Problems) {
        match (mesh.closed(), matter) {
            (Ok(closed), _) => self.push(object, matter, object.nesting, Base::Triangles(closed)),
            (Err(_), Matter::Diffuse(_) | Matter::Mirror(_)) if !mesh.triangles.is_empty() => {
                self.push(object, matter, object.nesting, Base::Triangles(mesh.clone()));
                self.solids.last_mut().expect("just pushed").closed = false;
            }
            (Err(why), _) => problems.push(object.place.problem(format!(
                "`{}` is not closed: {why}; a body that light enters must be closed: mend the mesh, or make it opaque \
                 with surface = {{ diffuse = 0.8 }}",
                object.name
            ))),
        }
    }

    /// What lies under the lowest infinite body, where that differs from what lies above.
    pub(super) fn add_half_space(
        &mut self,
        description: &Description,
        above: Option<MediumId>,
        below: Option<MediumId>,
        problems: &mut Problems,
    ) {
        let (Some(above), Some(below)) = (above, below) else { return };
        if above == below {
            return;
        }
        let floors = description.reliefs().map(|(_, relief)| relief.floor);
        let Some(top) = self.layers().map(|l| l.bottom).reduce(f64::min).or_else(|| floors.reduce(f64::min)) else {
            problems.push(description.below.place.problem(format!(
                "below = \"{}\" differs from above = \"{}\", but nothing says where it begins; add films or a slab",
                description.below.name, description.above.name
            )));
            return;
        };
        let owner = self.solids.len() as u32;
        self.solids.push(Solid {
            name: "below".into(),
            place: description.below.place.clone(),
            matter: Matter::Medium(below),
            precedence: (i32::MIN, 0),
            closed: true,
            lonely: false,
        });
        self.shapes.push((Base::Shape(geometry::Shape::Layer(Layer { bottom: f64::NEG_INFINITY, top })), owner));
    }

    fn layers(&self) -> impl Iterator<Item = Layer> + '_ {
        self.shapes.iter().filter_map(|(base, _)| base.layer())
    }

    /// Bounds of the bodies that have an end; infinite cylinders count with their width only.
    fn bounds(&self) -> Aabb {
        let finite = |b: Aabb| {
            let unbounded = b.size().map(|e| if e.is_finite() { 0.0 } else { 1.0 }).cmpgt(DVec3::splat(0.5));
            Aabb {
                min: DVec3::select(unbounded, DVec3::ZERO, b.min),
                max: DVec3::select(unbounded, DVec3::ZERO, b.max),
            }
        };
        self.shapes.iter().filter_map(|(base, _)| base.bounds()).fold(Aabb::EMPTY, |all, b| all.union(finite(b)))
    }

    /// Heights between which everything lies, µm.
    fn heights(&self) -> (f64, f64) {
        let bodies = self.bounds();
        let ends = self.layers().flat_map(|l| [l.bottom, l.top]).chain([bodies.min.z, bodies.max.z]);
        let ends: Vec<f64> = ends.filter(|z| z.is_finite()).collect();
        (ends.iter().copied().fold(f64::INFINITY, f64::min), ends.iter().copied().fold(f64::NEG_INFINITY, f64::max))
    }

    pub(super) fn cell(
        &self,
        description: &Description,
        coherence: Coherence,
        problems: &mut Problems,
    ) -> Option<Cell> {
        let bodies = self.bounds();
        let around = if bodies.is_empty() { Aabb { min: DVec3::ZERO, max: DVec3::ZERO } } else { bodies };
        let footprint = description.footprint();
        let (size, center) = match footprint {
            Some(patch) => (patch.size, patch.center),
            None => (around.size().truncate(), around.center().truncate()),
        };
        let (bottom, top) = self.heights();
        // Films and slabs alone are the same everywhere: any footprint will do, and as wide as high takes few periods.
        let alone = bodies.is_empty() && footprint.is_none();
        let size = if alone { DVec2::splat((top - bottom).max(1.0)) } else { size };
        if size.min_element() <= 0.0 {
            problems.push(description.place.problem(format!(
                "the sample has no extent across ({} x {} µm); give patch = {{ size = [10, 10] }}",
                size.x, size.y
            )));
            return None;
        }
        if bottom > top {
            return None;
        }
        let center = DVec3::new(center.x, center.y, middle((bottom, top)));
        // A stack reaches as far down as waves are coherent and the sample goes, its last interface included.
        let reach = coherence.depth().min(top - bottom + geometry::COINCIDENT);
        Some(Cell::new(size, center, description.sides == Sides::Periodic, (bottom - center.z, top - center.z), reach))
    }
}

impl Parts {
    /// Moves everything to the origin and repeats it as far as rays can see.
    pub(super) fn flatten(
        &mut self,
        description: &Description,
        cell: &mut Cell,
    ) -> Result<(Primitives, Tiling), Problems> {
        for (shape, _) in &mut self.shapes {
            shape.translate(-cell.center);
        }
        // From the coordinates that rays will see.
        cell.heights = self.heights();
        self.check_repetition(description, cell)?;
        self.sort_by_place();
        overlap::problems(&self.shapes, &self.solids, cell).into_iter().collect::<Problems>().or(())?;
        cell.place_seams(self.shapes.iter().flat_map(|(shape, _)| shape.walls()));
        let repeats = self.repeated(cell).map_err(|why| description.place.problem(why))?;
        // They are as large as all the rest.
        self.shapes = Vec::new();
        let (primitives, tiling) = repeats.finish();
        lonely::mark(&primitives, &mut self.solids);
        Ok((primitives, tiling))
    }

    /// Whether the bodies can repeat as often as the patch demands.
    fn check_repetition(&self, description: &Description, cell: &Cell) -> Result<(), Problems> {
        let patch = limits::check_patch(cell).map_err(|why| description.place.problem(why));
        let refused = self.shapes.iter().filter_map(|(shape, owner)| {
            let solid = &self.solids[*owner as usize];
            Some(solid.place.problem(format!("`{}` {}", solid.name, cell.refuses(shape.bounds())?)))
        });
        patch.err().into_iter().chain(refused).collect::<Problems>().or(())?;
        let count = limits::primitives(&self.shapes, cell, cell.zone());
        Ok(limits::check_count(count).map_err(|why| description.place.problem(why))?)
    }

    /// All shapes with their repetitions.
    fn repeated(&self, cell: &Cell) -> Result<Repeats, String> {
        let mut repeats = Repeats::default();
        for (number, (shape, owner)) in self.shapes.iter().enumerate() {
            repeats.add(shape, number as u32, *owner, cell, cell.zone())?;
        }
        Ok(repeats)
    }

    /// Orders shapes, and their solids, along a space-filling curve: neighbours in space become neighbours in
    /// memory, which rays in a dense packing feel.
    fn sort_by_place(&mut self) {
        let all = self.bounds();
        let place = |base: &Base| {
            let center = base.bounds().map_or(all.min, Aabb::center);
            let part = (center - all.min) / all.size().max(DVec3::splat(f64::MIN_POSITIVE));
            morton(part.to_array().map(|x| if x.is_finite() { x } else { 0.0 }))
        };
        self.shapes.sort_by_cached_key(|(base, _)| place(base));
        let mut order: Vec<u32> = Vec::with_capacity(self.solids.len());
        let mut number = vec![u32::MAX; self.solids.len()];
        for (_, owner) in &mut self.shapes {
            if number[*owner as usize] == u32::MAX {
                number[*owner as usize] = order.len() as u32;
                order.push(*owner);
            }
            *owner = number[*owner as usize];
        }
        let mut solids: Vec<Option<Solid>> = std::mem::take(&mut self.solids).into_iter().map(Some).collect();
        self.solids = order.iter().filter_map(|&i| solids[i as usize].take()).collect();
    }
}

/// The middle of two heights, to a millionth of their distance: a number without the rounding that the ends of bodies have
/// far from the origin, so that a moved sample becomes the same numbers when it is moved back.
fn middle((bottom, top): (f64, f64)) -> f64 {
    let step = 2f64.powi(((top - bottom).log2().ceil() as i32).saturating_sub(20));
    let middle = 0.5 * (bottom + top);
    if step > 0.0 { (middle / step).round() * step } else { middle }
}

/// 21 bits of each coordinate (0 to 1), interleaved.
fn morton(p: [f64; 3]) -> u64 {
    let bits = p.map(|x| (x.clamp(0.0, 1.0) * 2_097_151.0) as u64);
    (0..21).fold(0, |key, b| (0..3).fold(key, |key, i| key | (bits[i] >> b & 1) << (3 * b + i as u32)))
}

impl Fibre {
    /// The cylinder of given radius before flattening.
    pub(super) fn cylinder(&self, radius: f64) -> Cylinder {
        let axis = (self.to - self.from).normalize();
        let length = if self.caps { (self.to - self.from).length() } else { f64::INFINITY };
        let (u, ratio) = match self.flatten {
            Some((across, ratio)) => ((across - across.dot(axis) * axis).normalize(), ratio),
            None => (axis.any_orthonormal_vector(), 1.0),
        };
        Cylinder { from: self.from, axis, length, u, radii: [radius * ratio, radius] }
    }
}
