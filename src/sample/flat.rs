//! The sample as the tracer needs it: solids by number, media by number, primitives in one flat list, moved to
//! the origin and repeated as far as rays can see.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{DVec2, DVec3};

use super::description::{Body, Description, Fibre, Fill, Named, Object, Shape, Sides};
use super::mesh::Mesh;
use super::problem::{Place, Problem, Problems, suggestion};
use super::tiling::{Cell, Placed, Tiling};
use super::{limits, lonely, overlap};
use crate::geometry::{self, Aabb, Builder, Cuboid, Cylinder, Layer, PrimId, Primitives, Sphere, Triangle};
use crate::light::Wavelengths;
use crate::media::{Dispersion, builtin, builtins, check_index};
use crate::optics::C64;

/// Number of a medium in [`Sample::media`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct MediumId(pub u16);

/// A medium at the wavelengths of the light.
#[derive(Clone, Debug, PartialEq)]
pub struct MediumTable {
    /// Its name; of several that are equal, the first.
    pub name: String,
    /// Complex index per wavelength.
    pub index: Vec<C64>,
}

impl MediumTable {
    /// Whether the real part is the same at all wavelengths.
    pub fn is_dispersive(&self) -> bool {
        self.index.iter().any(|n| n.re != self.index[0].re)
    }

    /// Whether it absorbs at any wavelength.
    pub fn absorbs(&self) -> bool {
        self.index.iter().any(|n| n.im > 0.0)
    }
}

/// What a solid does to light that meets it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Matter {
    /// Light enters.
    Medium(MediumId),
    /// Lambert reflection of this share; the rest is absorbed.
    Diffuse(f64),
    /// Mirror reflection of this share; the rest is absorbed.
    Mirror(f64),
}

/// A body.
#[derive(Clone, Debug, PartialEq)]
pub struct Solid {
    /// What people call it.
    pub name: String,
    /// Where it is described.
    pub place: Place,
    /// What it does to light.
    pub matter: Matter,
    /// Where solids overlap the greater wins: (priority, nesting).
    pub precedence: (i32, u32),
    /// Whether it has an inside; only opaque meshes may have none.
    pub closed: bool,
    /// Whether it is one convex primitive whose inside no other surface enters.
    pub lonely: bool,
}

/// A checked sample.
#[derive(Clone, Debug)]
pub struct Sample {
    /// Media, each with a different table.
    pub media: Vec<MediumTable>,
    /// Solids, by owner number of the primitives.
    pub solids: Vec<Solid>,
    /// Medium above everything.
    pub above: MediumId,
    /// Medium below everything.
    pub below: MediumId,
    /// Footprint of the beam and what lies beside it.
    pub cell: Cell,
    /// The geometry; the footprint's centre is at x = y = 0.
    pub primitives: Arc<Primitives>,
    /// Which primitives repeat which.
    pub tiling: Tiling,
    /// Bounds of all points a ray can reach, µm.
    pub domain: Aabb,
}

/// A shape before repetition, with its owner.
#[derive(Clone, Debug)]
pub(super) enum Base {
    Triangles(Mesh),
    Shape(geometry::Shape),
}

impl Sample {
    /// Checks and flattens a description for the wavelengths of the light. Waves are coherent over
    /// `coherence_length` µm, which says how far stacks of films can reach.
    ///
    /// # Errors
    /// Everything that is wrong.
    pub fn new(description: &Description, wavelengths: &Wavelengths, coherence_length: f64) -> Result<Self, Problems> {
        let mut problems = Problems::default();
        let mut media = MediaList::new(description, wavelengths);
        let above = media.resolve(&description.above, &mut problems);
        let below = media.resolve(&description.below, &mut problems);
        let mut parts = Parts::default();
        for object in &description.objects {
            parts.add(object, &mut media, &mut problems);
        }
        parts.add_half_space(description, above, below, &mut problems);
        if let Some(id) = above
            && media.tables[usize::from(id.0)].absorbs()
        {
            let Named { name, place } = &description.above;
            problems.push(place.problem(format!(
                "above = \"{name}\": light must come through a medium that does not absorb; choose one with k = 0"
            )));
        }
        limits::sizes(&parts.shapes, &parts.solids).into_iter().for_each(|p| problems.push(p));
        let cell = parts.cell(description, coherence_length, &mut problems);
        problems.or(())?;
        // What is missing has been reported.
        let (Some(above), Some(below), Some(cell)) = (above, below, cell) else { return Err(Problems::default()) };
        parts.into_sample(description, media.tables, above, below, cell)
    }
}

/// Media in use, without duplicates.
struct MediaList<'a> {
    description: &'a Description,
    wavelengths: &'a Wavelengths,
    tables: Vec<MediumTable>,
    known: HashMap<String, Option<MediumId>>,
}

impl<'a> MediaList<'a> {
    fn new(description: &'a Description, wavelengths: &'a Wavelengths) -> Self {
        Self { description, wavelengths, tables: Vec::new(), known: HashMap::new() }
    }

    /// The number of a medium; each unknown name is reported at its first use only.
    fn resolve(&mut self, named: &Named, problems: &mut Problems) -> Option<MediumId> {
        if let Some(id) = self.known.get(&named.name) {
            return *id;
        }
        let id = self.look_up(named).and_then(|table| self.add(table, named)).map_err(|p| problems.push(p)).ok();
        self.known.insert(named.name.clone(), id);
        id
    }

    fn look_up(&self, named: &Named) -> Result<MediumTable, Problem> {
        let defined = self.description.media.iter().find(|m| m.name == named.name);
        let (dispersion, place) = match defined {
            Some(medium) => (medium.dispersion.clone(), &medium.place),
            None => (self.built_in(named)?, &named.place),
        };
        let index: Result<Vec<C64>, _> = self.wavelengths.um().map(|w| dispersion.index(w)).collect();
        let index = index.map_err(|e| {
            place.problem(format!("medium `{}`: {e}; choose --wavelengths within, or other data", named.name))
        })?;
        if let Some((nm, e)) =
            self.wavelengths.nm().iter().zip(&index).find_map(|(nm, n)| Some((nm, check_index(*n).err()?)))
        {
            return Err(place.problem(format!("medium `{}` at {nm} nm: {e}; correct its formula", named.name)));
        }
        Ok(MediumTable { name: named.name.clone(), index })
    }

    fn built_in(&self, named: &Named) -> Result<Dispersion, Problem> {
        builtin(&named.name).map(|b| b.dispersion).ok_or_else(|| {
            let own = self.description.media.iter().map(|m| m.name.as_str());
            let all = builtins();
            let hint = suggestion(&named.name, own.chain(all.iter().flat_map(|b| b.names.iter().copied())));
            let message =
                format!("unknown medium `{0}`{hint}; define it under [media], for example {0} = 1.5", named.name);
            named.place.problem(message)
        })
    }

    fn add(&mut self, table: MediumTable, named: &Named) -> Result<MediumId, Problem> {
        let known = self.tables.iter().position(|t| t.index == table.index);
        let at = known.unwrap_or(self.tables.len());
        if at == limits::MOST_MEDIA {
            let message = format!("medium `{}`: at most {at} different media are taken; use fewer", named.name);
            return Err(named.place.problem(message));
        }
        if known.is_none() {
            self.tables.push(table);
        }
        Ok(MediumId(at as u16))
    }
}

/// Solids with their shapes, in the user's coordinates.
#[derive(Default)]
struct Parts {
    solids: Vec<Solid>,
    shapes: Vec<(Base, u32)>,
}

impl Parts {
    fn add(&mut self, object: &Object, media: &mut MediaList<'_>, problems: &mut Problems) {
        match &object.body {
            Body::Films { top, layers } => self.add_films(object, *top, layers, media, problems),
            Body::Solid(shape, fill) => {
                let matter = match fill {
                    Fill::Medium(named) => media.resolve(named, problems).map(Matter::Medium),
                    Fill::Diffuse(share) => Some(Matter::Diffuse(*share)),
                    Fill::Mirror(share) => Some(Matter::Mirror(*share)),
                };
                if let Some(matter) = matter {
                    self.add_solid(object, shape, matter, media, problems);
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
        };
        self.push(object, matter, object.nesting, Base::Shape(flat));
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
    fn add_half_space(
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
        let Some(top) = self.layers().map(|l| l.bottom).reduce(f64::min) else {
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

    fn cell(&self, description: &Description, coherence_length: f64, problems: &mut Problems) -> Option<Cell> {
        let bodies = self.bounds();
        let around = if bodies.is_empty() { Aabb { min: DVec3::ZERO, max: DVec3::ZERO } } else { bodies };
        let (size, center) = match description.patch {
            Some(patch) => (patch.size, patch.center),
            None => (around.size().truncate(), around.center().truncate()),
        };
        let (bottom, top) = self.heights();
        // Films and slabs alone are the same everywhere: any footprint will do, and as wide as high takes few periods.
        let alone = bodies.is_empty() && description.patch.is_none();
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
        let center = DVec3::new(center.x, center.y, 0.5 * (bottom + top));
        // A stack reaches as far down as waves are coherent and the sample goes, its last interface included.
        let reach = (0.5 * coherence_length).min(top - bottom + geometry::COINCIDENT);
        Some(Cell::new(size, center, description.sides == Sides::Periodic, (bottom - center.z, top - center.z), reach))
    }

    fn into_sample(
        mut self,
        description: &Description,
        media: Vec<MediumTable>,
        above: MediumId,
        below: MediumId,
        mut cell: Cell,
    ) -> Result<Sample, Problems> {
        for (shape, _) in &mut self.shapes {
            shape.translate(-cell.center);
        }
        self.check_repetition(description, &cell)?;
        self.sort_by_place();
        overlap::problems(&self.shapes, &self.solids, &cell).into_iter().collect::<Problems>().or(())?;
        cell.place_seams(self.shapes.iter().flat_map(|(shape, _)| shape.walls()));
        let repeats = self.repeated(&cell).map_err(|why| description.place.problem(why))?;
        let (primitives, tiling) = repeats.finish();
        lonely::mark(&primitives, &mut self.solids);
        let domain = cell.domain(&primitives);
        Ok(Sample { media, solids: self.solids, above, below, cell, primitives: Arc::new(primitives), tiling, domain })
    }
}

impl Parts {
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

/// 21 bits of each coordinate (0 to 1), interleaved.
fn morton(p: [f64; 3]) -> u64 {
    let bits = p.map(|x| (x.clamp(0.0, 1.0) * 2_097_151.0) as u64);
    (0..21).fold(0, |key, b| (0..3).fold(key, |key, i| key | (bits[i] >> b & 1) << (3 * b + i as u32)))
}

impl Base {
    /// The layer, if it is one.
    pub(super) fn layer(&self) -> Option<Layer> {
        if let Self::Shape(geometry::Shape::Layer(layer)) = self { Some(*layer) } else { None }
    }

    /// Bounds, µm; `None` for layers.
    pub(super) fn bounds(&self) -> Option<Aabb> {
        match self {
            Self::Triangles(mesh) => Some(mesh.bounds()),
            Self::Shape(geometry::Shape::Sphere(s)) => Some(s.bounds()),
            Self::Shape(geometry::Shape::Cylinder(c)) => Some(c.bounds()),
            Self::Shape(geometry::Shape::Cuboid(b)) => Some(b.bounds()),
            Self::Shape(geometry::Shape::Layer(_) | geometry::Shape::Triangle(_)) => None,
        }
    }

    pub(super) fn translate(&mut self, by: DVec3) {
        *self = match std::mem::replace(self, Self::Triangles(Mesh::default())) {
            Self::Triangles(mesh) => Self::Triangles(mesh.map(|p| p + by)),
            Self::Shape(shape) => Self::Shape(translated(shape, by)),
        };
    }

    /// Planes x = const and y = const among the faces: (axis, coordinate).
    fn walls(&self) -> Vec<(usize, f64)> {
        match self {
            Self::Triangles(mesh) => {
                let corners = mesh.triangles.iter().map(|&t| mesh.corners(t));
                corners
                    .flat_map(|[a, b, c]| (0..2).filter(move |&i| a[i] == b[i] && b[i] == c[i]).map(move |i| (i, a[i])))
                    .collect()
            }
            Self::Shape(geometry::Shape::Cuboid(b)) => (0..2).flat_map(|i| [(i, b.min[i]), (i, b.max[i])]).collect(),
            Self::Shape(geometry::Shape::Cylinder(c)) if c.length.is_finite() => {
                let to = c.from + c.length * c.axis;
                (0..2).filter(|&i| c.axis[i].abs() > 0.999).flat_map(|i| [(i, c.from[i]), (i, to[i])]).collect()
            }
            Self::Shape(_) => Vec::new(),
        }
    }
}

fn translated(shape: geometry::Shape, by: DVec3) -> geometry::Shape {
    use geometry::Shape as Flat;
    match shape {
        Flat::Sphere(s) => Flat::Sphere(Sphere { center: s.center + by, ..s }),
        Flat::Cylinder(c) => Flat::Cylinder(Cylinder { from: c.from + by, ..c }),
        Flat::Cuboid(b) => Flat::Cuboid(Cuboid { min: b.min + by, max: b.max + by }),
        Flat::Layer(l) => Flat::Layer(Layer { bottom: l.bottom + by.z, top: l.top + by.z }),
        Flat::Triangle(t) => Flat::Triangle(t),
    }
}

impl Fibre {
    /// The cylinder of given radius before flattening.
    fn cylinder(&self, radius: f64) -> Cylinder {
        let axis = (self.to - self.from).normalize();
        let length = if self.caps { (self.to - self.from).length() } else { f64::INFINITY };
        let (u, ratio) = match self.flatten {
            Some((across, ratio)) => ((across - across.dot(axis) * axis).normalize(), ratio),
            None => (axis.any_orthonormal_vector(), 1.0),
        };
        Cylinder { from: self.from, axis, length, u, radii: [radius * ratio, radius] }
    }
}

/// Collects shapes and their repetitions.
#[derive(Default)]
struct Repeats {
    builder: Builder,
    placed: [Vec<Placed>; 5],
    count: usize,
}

impl Repeats {
    fn add(&mut self, shape: &Base, number: u32, owner: u32, cell: &Cell, zone: Aabb) -> Result<(), String> {
        match shape {
            Base::Shape(flat) => {
                for shift in cell.shifts(shape.bounds(), zone) {
                    self.push(translated(*flat, cell.offset(shift)), owner, Placed { base: (number, 0), shift });
                }
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
    fn finish(self) -> (Primitives, Tiling) {
        (self.builder.finish(), Tiling::new(self.placed.concat()))
    }
}

impl Sample {
    /// The solid a primitive belongs to.
    pub fn solid(&self, prim: PrimId) -> &Solid {
        &self.solids[self.primitives.owner(prim) as usize]
    }
}
