//! All primitives of a sample in flat lists, and what each says to a ray.

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::plane::PlaneSet;
use super::triangle::meet;
use super::{
    Aabb, COINCIDENT, Chord, Crossing, Cuboid, Cylinder, Layer, Order, Plane, Query, Ray, Shear, Sink, Sphere,
    SurfaceId, Triangle,
};

/// Index of a primitive: triangles first, then spheres, cylinders, cuboids, layers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct PrimId(pub u32);

/// What a primitive is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// See [`Triangle`].
    Triangle,
    /// See [`Sphere`].
    Sphere,
    /// See [`Cylinder`].
    Cylinder,
    /// See [`Cuboid`].
    Cuboid,
    /// See [`Layer`].
    Layer,
}

impl Kind {
    /// The kinds that have bounds and so go into an accelerator, in order of [`PrimId`].
    pub const BOUNDED: [Self; 4] = [Self::Triangle, Self::Sphere, Self::Cylinder, Self::Cuboid];
}

/// A shape as it is handed to the [`Builder`].
#[derive(Clone, Copy, Debug)]
pub enum Shape {
    /// Corners are indices of [`Builder::vertex`].
    Triangle(Triangle),
    /// A sphere.
    Sphere(Sphere),
    /// A cylinder.
    Cylinder(Cylinder),
    /// A box.
    Cuboid(Cuboid),
    /// An infinite layer.
    Layer(Layer),
}

/// Keeps the first crossing only.
struct First(Option<(Order, Crossing)>);

impl Sink for First {
    #[inline]
    fn offer(&mut self, t: f64, surface: SurfaceId, crossing: Crossing) {
        let order = Order { t, surface };
        if self.0.is_none_or(|(first, _)| order < first) {
            self.0 = Some((order, crossing));
        }
    }

    fn horizon(&self) -> f64 {
        f64::INFINITY
    }
}

/// One list of equal shapes. What only matters once a shape is met lies apart, so that a sphere is half a cache
/// line to a ray that passes it.
#[derive(Clone, Debug)]
struct List<T, const FACES: usize> {
    shapes: Vec<T>,
    tags: Vec<Tag<FACES>>,
}

/// The surfaces of a shape's faces, and the solid it belongs to.
#[derive(Clone, Copy, Debug)]
struct Tag<const FACES: usize> {
    surfaces: [SurfaceId; FACES],
    owner: u32,
}

impl<T, const FACES: usize> Default for List<T, FACES> {
    fn default() -> Self {
        Self { shapes: Vec::new(), tags: Vec::new() }
    }
}

impl<T, const FACES: usize> List<T, FACES> {
    fn push(&mut self, shape: T, owner: u32) {
        self.shapes.push(shape);
        self.tags.push(Tag { surfaces: [SurfaceId::NONE; FACES], owner });
    }

    fn find_surfaces(&mut self, mut surfaces: impl FnMut(&T) -> [SurfaceId; FACES]) {
        for (shape, tag) in self.shapes.iter().zip(&mut self.tags) {
            tag.surfaces = surfaces(shape);
        }
    }

    fn len(&self) -> usize {
        self.shapes.len()
    }

    fn is_empty(&self) -> bool {
        self.shapes.is_empty()
    }
}

/// A height at which layers begin or end.
#[derive(Clone, Debug)]
struct Level {
    z: f64,
    surface: SurfaceId,
    faces: Vec<(PrimId, u8)>,
}

/// The geometry of a sample: immutable, shared by all backends.
#[derive(Clone, Debug, Default)]
pub struct Primitives {
    vertices: Vec<DVec3>,
    triangles: List<Triangle, 1>,
    spheres: List<Sphere, 1>,
    cylinders: List<Cylinder, 3>,
    cuboids: List<Cuboid, 6>,
    layers: List<Layer, 2>,
    levels: Vec<Level>,
    planes: Vec<Plane>,
}

/// Collects shapes; [`Builder::finish`] finds out which faces coincide.
#[derive(Default)]
pub struct Builder {
    /// Without surfaces.
    primitives: Primitives,
}

impl Builder {
    /// Adds a corner for triangles; returns its index.
    pub fn vertex(&mut self, p: DVec3) -> u32 {
        let vertices = &mut self.primitives.vertices;
        vertices.push(p);
        u32::try_from(vertices.len() - 1).expect("fewer than 2^32 vertices")
    }

    /// Adds a shape that belongs to solid number `owner`.
    pub fn add(&mut self, shape: Shape, owner: u32) {
        let Primitives { triangles, spheres, cylinders, cuboids, layers, .. } = &mut self.primitives;
        match shape {
            Shape::Triangle(t) => triangles.push(t, owner),
            Shape::Sphere(s) => spheres.push(s, owner),
            Shape::Cylinder(c) => cylinders.push(c, owner),
            Shape::Cuboid(b) => cuboids.push(b, owner),
            Shape::Layer(l) => layers.push(l, owner),
        }
    }

    /// Gives coincident faces one [`SurfaceId`]. Primitives are numbered by kind and, within a kind, in the order they were
    /// added.
    pub fn finish(self) -> Primitives {
        let mut out = self.primitives;
        let mut planes = PlaneSet::with_capacity(out.triangles.len());
        let vertices = &out.vertices;
        out.triangles.find_surfaces(|t| {
            let corners = t.corners.map(|i| vertices[i as usize]);
            [plane_id(planes.add(triangle_normal(corners), &corners).0)]
        });
        let mut spheres = FxHashMap::default();
        out.spheres.find_surfaces(|s| {
            let [x, y, z] = s.center.to_array();
            [curved_id(&mut spheres, 0, [x, y, z, s.radius])]
        });
        let (before, mut mantles) = (spheres.len(), FxHashMap::default());
        drop(spheres);
        out.cylinders.find_surfaces(|c| {
            let [from, axis, u] = [c.from, c.axis, c.u].map(|v| v.to_array());
            let form = [from, axis, u, [c.radii[0], c.radii[1], 0.0]];
            let form: [f64; 12] = form.as_flattened().try_into().expect("four times three numbers");
            let [first, second] = c.ends().map_or([SurfaceId::NONE; 2], |ends| {
                ends.map(|p| plane_id(planes.add(p.normal, &end_points(c, &p)).0))
            });
            [curved_id(&mut mantles, before, form), first, second]
        });
        out.cuboids.find_surfaces(|b| {
            std::array::from_fn(|f| plane_id(planes.add(Cuboid::normal(f as u8), &[b.corner(f as u8)]).0))
        });
        out.layers.find_surfaces(|l| {
            let mut level = |z: f64| plane_id(planes.add(DVec3::Z, &[z * DVec3::Z]).0);
            [l.bottom, l.top].map(|z| if z.is_finite() { level(z) } else { SurfaceId::NONE })
        });
        out.planes = planes.into_planes();
        out.number_curved_surfaces_after_planes();
        out.settle_on_planes();
        out.levels = out.collect_levels();
        out
    }
}

/// The normal of a triangle. One without area still closes its mesh, so it gets some normal across its longest
/// edge.
fn triangle_normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    let longest = [b - a, c - b, a - c].into_iter().max_by(|p, q| p.length_squared().total_cmp(&q.length_squared()));
    let along = longest.and_then(DVec3::try_normalize).unwrap_or(DVec3::X);
    (b - a).cross(c - a).try_normalize().unwrap_or_else(|| along.any_orthonormal_vector())
}

/// Points of a cylinder's end that fix its plane.
fn end_points(c: &Cylinder, end: &Plane) -> [DVec3; 3] {
    let center = end.project(c.from);
    [center, center + c.radii[0] * c.u, center + c.radii[1] * c.v()]
}

/// Surface of plane `index`.
fn plane_id(index: u32) -> SurfaceId {
    SurfaceId(index + 1)
}

/// Curved surfaces are numbered from 1 while planes are still being found; `before` others have been.
fn curved_id<const N: usize>(known: &mut FxHashMap<[u64; N], u32>, before: usize, form: [f64; N]) -> SurfaceId {
    let next = u32::try_from(before + known.len() + 1).expect("fewer than 2^32 surfaces");
    SurfaceId(*known.entry(form.map(f64::to_bits)).or_insert(next))
}

impl Primitives {
    fn number_curved_surfaces_after_planes(&mut self) {
        let planes = self.planes.len() as u32;
        let spheres = self.spheres.tags.iter_mut().map(|t| &mut t.surfaces[0]);
        let mantles = self.cylinders.tags.iter_mut().map(|t| &mut t.surfaces[0]);
        spheres.chain(mantles).for_each(|s| s.0 += planes);
    }

    /// Moves faces (by less than [`super::COINCIDENT`]) onto the plane they share with others.
    fn settle_on_planes(&mut self) {
        let offset = |s: SurfaceId| self.planes[s.0 as usize - 1].offset;
        for (b, Tag { surfaces: faces, .. }) in self.cuboids.shapes.iter_mut().zip(&self.cuboids.tags) {
            b.min = DVec3::new(offset(faces[0]), offset(faces[2]), offset(faces[4]));
            b.max = DVec3::new(offset(faces[1]), offset(faces[3]), offset(faces[5]));
        }
        for (l, Tag { surfaces: faces, .. }) in self.layers.shapes.iter_mut().zip(&self.layers.tags) {
            if faces[0] != SurfaceId::NONE {
                l.bottom = offset(faces[0]);
            }
            l.top = offset(faces[1]);
        }
    }

    fn collect_levels(&self) -> Vec<Level> {
        let first = self.bounded_count() as u32;
        let mut levels: Vec<Level> = Vec::new();
        let mut known: FxHashMap<SurfaceId, usize> = FxHashMap::default();
        for (i, (layer, Tag { surfaces, .. })) in self.layers.shapes.iter().zip(&self.layers.tags).enumerate() {
            for (face, z) in [(Layer::BOTTOM, layer.bottom), (Layer::TOP, layer.top)] {
                let surface = surfaces[usize::from(face)];
                if surface == SurfaceId::NONE {
                    continue;
                }
                let at = *known.entry(surface).or_insert_with(|| {
                    levels.push(Level { z, surface, faces: Vec::new() });
                    levels.len() - 1
                });
                levels[at].faces.push((PrimId(first + i as u32), face));
            }
        }
        levels.sort_by(|a, b| a.z.total_cmp(&b.z));
        levels
    }

    /// Number of primitives of a kind.
    pub fn count(&self, kind: Kind) -> usize {
        match kind {
            Kind::Triangle => self.triangles.len(),
            Kind::Sphere => self.spheres.len(),
            Kind::Cylinder => self.cylinders.len(),
            Kind::Cuboid => self.cuboids.len(),
            Kind::Layer => self.layers.len(),
        }
    }

    /// Number of primitives with bounds.
    pub fn bounded_count(&self) -> usize {
        Kind::BOUNDED.iter().map(|&k| self.count(k)).sum()
    }

    /// Number of all primitives.
    pub fn len(&self) -> usize {
        self.bounded_count() + self.layers.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Number of distinct surfaces; ids are `1..=surface_count`.
    pub fn surface_count(&self) -> usize {
        let curved =
            self.spheres.tags.iter().map(|t| t.surfaces[0]).chain(self.cylinders.tags.iter().map(|t| t.surfaces[0]));
        curved.map(|s| s.0 as usize).max().unwrap_or(0).max(self.planes.len())
    }

    /// The first primitive of a kind.
    pub fn first(&self, kind: Kind) -> PrimId {
        let before = Kind::BOUNDED.iter().take_while(|&&k| k != kind).map(|&k| self.count(k)).sum::<usize>();
        PrimId(before as u32)
    }

    /// Kind and index within the kind.
    #[inline]
    pub fn locate(&self, prim: PrimId) -> (Kind, usize) {
        let mut i = prim.0 as usize;
        for kind in Kind::BOUNDED {
            let n = self.count(kind);
            if i < n {
                return (kind, i);
            }
            i -= n;
        }
        (Kind::Layer, i)
    }

    /// The solid a primitive belongs to.
    #[inline]
    pub fn owner(&self, prim: PrimId) -> u32 {
        match self.locate(prim) {
            (Kind::Triangle, i) => self.triangles.tags[i].owner,
            (Kind::Sphere, i) => self.spheres.tags[i].owner,
            (Kind::Cylinder, i) => self.cylinders.tags[i].owner,
            (Kind::Cuboid, i) => self.cuboids.tags[i].owner,
            (Kind::Layer, i) => self.layers.tags[i].owner,
        }
    }

    /// Bounds of a primitive, µm.
    pub fn bounds(&self, prim: PrimId) -> Aabb {
        match self.locate(prim) {
            (Kind::Triangle, i) => Aabb::around(self.corners(self.triangles.shapes[i])),
            (Kind::Sphere, i) => self.spheres.shapes[i].bounds(),
            (Kind::Cylinder, i) => self.cylinders.shapes[i].bounds(),
            (Kind::Cuboid, i) => self.cuboids.shapes[i].bounds(),
            (Kind::Layer, i) => {
                let Layer { bottom, top } = self.layers.shapes[i];
                Aabb { min: DVec3::NEG_INFINITY.with_z(bottom), max: DVec3::INFINITY.with_z(top) }
            }
        }
    }

    /// The faces of a primitive: their surfaces.
    pub fn faces(&self, prim: PrimId) -> &[SurfaceId] {
        match self.locate(prim) {
            (Kind::Triangle, i) => &self.triangles.tags[i].surfaces,
            (Kind::Sphere, i) => &self.spheres.tags[i].surfaces,
            (Kind::Cylinder, i) => &self.cylinders.tags[i].surfaces,
            (Kind::Cuboid, i) => &self.cuboids.tags[i].surfaces,
            (Kind::Layer, i) => &self.layers.tags[i].surfaces,
        }
    }

    /// The plane of a surface, or `None` if it is curved.
    #[inline]
    pub fn plane(&self, surface: SurfaceId) -> Option<&Plane> {
        self.planes.get((surface.0 as usize).wrapping_sub(1))
    }

    /// A corner of triangles.
    pub fn vertex(&self, index: u32) -> DVec3 {
        self.vertices[index as usize]
    }

    /// The corners of a triangle.
    #[inline]
    pub fn corners(&self, triangle: Triangle) -> [DVec3; 3] {
        triangle.corners.map(|v| self.vertices[v as usize])
    }

    /// The shape of a primitive.
    pub fn shape(&self, prim: PrimId) -> Shape {
        match self.locate(prim) {
            (Kind::Triangle, i) => Shape::Triangle(self.triangles.shapes[i]),
            (Kind::Sphere, i) => Shape::Sphere(self.spheres.shapes[i]),
            (Kind::Cylinder, i) => Shape::Cylinder(self.cylinders.shapes[i]),
            (Kind::Cuboid, i) => Shape::Cuboid(self.cuboids.shapes[i]),
            (Kind::Layer, i) => Shape::Layer(self.layers.shapes[i]),
        }
    }

    /// All primitives.
    pub fn ids(&self) -> impl Iterator<Item = PrimId> + use<> {
        (0..self.len() as u32).map(PrimId)
    }

    /// A ray that starts in free space: everything at `t >= 0` counts.
    #[inline]
    pub fn query(&self, ray: Ray) -> Query {
        Query {
            ray,
            from: Order { t: 0.0, surface: SurfaceId::NONE },
            limit: f64::INFINITY,
            last: SurfaceId::NONE,
            shear: if self.triangles.is_empty() { Shear::UNUSED } else { Shear::new(&ray) },
        }
    }

    /// A ray that starts on the surface `last`: that surface, and everything at `t <= 0`, does not count.
    #[inline]
    pub fn query_leaving(&self, ray: Ray, last: SurfaceId) -> Query {
        Query { from: Order { t: 0.0, surface: SurfaceId::LAST }, last, ..self.query(ray) }
    }

    /// Offers the crossings of `query` with one bounded primitive.
    #[inline]
    pub fn propose(&self, query: &Query, prim: PrimId, sink: &mut impl Sink) {
        match self.locate(prim) {
            (Kind::Triangle, i) => self.propose_triangle(query, i, prim, sink),
            (Kind::Sphere, i) => self.propose_sphere(query, i, prim, sink),
            (Kind::Cylinder, i) => self.propose_cylinder(query, i, prim, sink),
            (Kind::Cuboid, i) => self.propose_cuboid(query, i, prim, sink),
            (Kind::Layer, _) => {}
        }
    }

    /// Where a ray that starts on a convex primitive meets that primitive next, if it does.
    #[inline]
    pub fn other_side(&self, query: &Query, prim: PrimId) -> Option<(Order, Crossing)> {
        let (kind, i) = self.locate(prim);
        if kind == Kind::Sphere {
            let Tag { surfaces: [surface], owner } = self.spheres.tags[i];
            let t = self.spheres.shapes[i].other_root(&query.ray)?;
            let crossing = Crossing { prim, owner, face: 0, enters: false };
            return query.admits(t, surface).then_some((Order { t, surface }, crossing));
        }
        let mut first = First(None);
        self.propose(query, prim, &mut first);
        first.0
    }

    /// A sphere with this surface: its index and id. There may be others, equal to it; then it may not be found.
    #[inline]
    pub fn sphere_with(&self, surface: SurfaceId) -> Option<(usize, PrimId)> {
        let i = (surface.0 as usize).wrapping_sub(self.planes.len() + 1);
        self.spheres.tags.get(i).filter(|tag| tag.surfaces == [surface]).map(|_| (i, self.sphere(i)))
    }

    /// The id of sphere `i`.
    #[inline]
    pub fn sphere(&self, i: usize) -> PrimId {
        PrimId((self.triangles.len() + i) as u32)
    }

    /// Offers the crossing with triangle `i`, whose id is `prim`.
    #[inline]
    pub fn propose_triangle(&self, query: &Query, i: usize, prim: PrimId, sink: &mut impl Sink) {
        let Some(met) = meet(&query.shear, &query.ray, self.corners(self.triangles.shapes[i])) else { return };
        let [surface] = self.triangles.tags[i].surfaces;
        let t = self.planes[surface.0 as usize - 1].distance(&query.ray);
        // Seen edge-on the plane says little about the distance; the corners bound it. They may lie off the plane, on
        // which all coplanar faces must be met at one distance.
        let (near, far) = (met.range.0 - COINCIDENT, met.range.1 + COINCIDENT);
        let t = if t >= near && t <= far { t } else { met.t };
        if query.admits_plane(t, surface) {
            sink.offer(t, surface, Crossing { prim, owner: self.triangles.tags[i].owner, face: 0, enters: met.enters });
        }
    }

    /// Offers the crossings with sphere `i`, whose id is `prim`.
    #[inline]
    pub fn propose_sphere(&self, query: &Query, i: usize, prim: PrimId, sink: &mut impl Sink) {
        let sphere = &self.spheres.shapes[i];
        let chord = sphere.chord(&query.ray);
        if chord == Chord::None {
            return;
        }
        let Tag { surfaces: [surface], owner } = self.spheres.tags[i];
        let mut offer = |t, enters| {
            if query.admits(t, surface) {
                sink.offer(t, surface, Crossing { prim, owner, face: 0, enters });
            }
        };
        if surface == query.last {
            if let Some(t) = sphere.other_root(&query.ray) {
                offer(t, false);
            }
        } else if let Chord::Through(enter, leave) = chord {
            offer(enter, true);
            offer(leave, false);
        }
    }

    /// Offers the crossings with cylinder `i`, whose id is `prim`.
    #[inline]
    pub fn propose_cylinder(&self, query: &Query, i: usize, prim: PrimId, sink: &mut impl Sink) {
        let cylinder = &self.cylinders.shapes[i];
        let Tag { surfaces, owner } = self.cylinders.tags[i];
        let mantle = if surfaces[0] == query.last {
            cylinder.mantle_interval_from_surface(&query.ray)
        } else {
            cylinder.mantle_interval(&query.ray)
        };
        let Some((t0, t1)) = mantle else { return };
        let (mut enter, mut leave) = ((t0, Cylinder::MANTLE), (t1, Cylinder::MANTLE));
        if cylinder.length.is_finite() {
            let Some([near, far]) = self.between_ends(query, cylinder, surfaces) else { return };
            if near.0 > enter.0 {
                enter = near;
            }
            if far.0 < leave.0 {
                leave = far;
            }
        }
        if enter.0 >= leave.0 {
            return;
        }
        for ((t, face), enters) in [(enter, true), (leave, false)] {
            let surface = surfaces[usize::from(face)];
            let admitted =
                if face == Cylinder::MANTLE { query.admits(t, surface) } else { query.admits_plane(t, surface) };
            if admitted {
                sink.offer(t, surface, Crossing { prim, owner, face, enters });
            }
        }
    }

    /// Where the line is between the ends of a cylinder: (distance, face) of entering and leaving.
    #[inline]
    fn between_ends(&self, query: &Query, cylinder: &Cylinder, surfaces: [SurfaceId; 3]) -> Option<[(f64, u8); 2]> {
        let ends = [Cylinder::FIRST_END, Cylinder::SECOND_END];
        let planes = ends.map(|f| &self.planes[surfaces[usize::from(f)].0 as usize - 1]);
        let along = query.ray.dir.dot(cylinder.axis);
        if along == 0.0 || planes[0].normal.dot(query.ray.dir) == 0.0 {
            let height = (query.ray.origin - cylinder.from).dot(cylinder.axis);
            let unbounded = [(f64::NEG_INFINITY, ends[0]), (f64::INFINITY, ends[1])];
            return (height > 0.0 && height < cylinder.length).then_some(unbounded);
        }
        let [first, second] = [(planes[0].distance(&query.ray), ends[0]), (planes[1].distance(&query.ray), ends[1])];
        Some(if along > 0.0 { [first, second] } else { [second, first] })
    }

    /// Offers the crossings with box `i`, whose id is `prim`.
    #[inline]
    pub fn propose_cuboid(&self, query: &Query, i: usize, prim: PrimId, sink: &mut impl Sink) {
        let Some(interval) = self.cuboids.shapes[i].interval(&query.ray) else { return };
        for ((t, face), enters) in interval.into_iter().zip([true, false]) {
            let surface = self.cuboids.tags[i].surfaces[usize::from(face)];
            if query.admits_plane(t, surface) {
                sink.offer(t, surface, Crossing { prim, owner: self.cuboids.tags[i].owner, face, enters });
            }
        }
    }

    /// Offers the first (or, for a sink that wants all, every) crossing with an infinite layer.
    #[inline]
    pub fn propose_layers(&self, query: &Query, sink: &mut impl Sink) {
        if !self.levels.is_empty() {
            self.propose_levels(query, sink);
        }
    }

    fn propose_levels(&self, query: &Query, sink: &mut impl Sink) {
        let (o, d) = (query.ray.origin.z, query.ray.dir.z);
        let split = self.levels.partition_point(|l| l.z < o);
        if d > 0.0 {
            self.offer_levels(query, self.levels[split..].iter(), sink);
        } else if d < 0.0 {
            let ahead = self.levels.partition_point(|l| l.z <= o);
            self.offer_levels(query, self.levels[..ahead].iter().rev(), sink);
        }
    }

    fn offer_levels<'a>(&self, query: &Query, levels: impl Iterator<Item = &'a Level>, sink: &mut impl Sink) {
        let down = query.ray.dir.z < 0.0;
        for level in levels {
            let t = (level.z - query.ray.origin.z) / query.ray.dir.z;
            if t > query.limit || t > sink.horizon() {
                break;
            }
            if query.admits_plane(t, level.surface) {
                for &(prim, face) in &level.faces {
                    let enters = (face == Layer::TOP) == down;
                    sink.offer(t, level.surface, Crossing { prim, owner: self.owner(prim), face, enters });
                }
            }
        }
    }

    /// Outward normal of a face at `p` on it.
    #[inline]
    pub fn normal(&self, prim: PrimId, face: u8, p: DVec3) -> DVec3 {
        match self.locate(prim) {
            (Kind::Triangle, i) => {
                let [a, b, c] = self.corners(self.triangles.shapes[i]);
                let plane = &self.planes[self.triangles.tags[i].surfaces[0].0 as usize - 1];
                if (b - a).cross(c - a).dot(plane.normal) < 0.0 { -plane.normal } else { plane.normal }
            }
            (Kind::Sphere, i) => self.spheres.shapes[i].normal(p),
            (Kind::Cylinder, i) => {
                let c = &self.cylinders.shapes[i];
                match face {
                    Cylinder::MANTLE => c.mantle_normal(p),
                    Cylinder::FIRST_END => self.outward_end(i, face, -c.axis),
                    _ => self.outward_end(i, face, c.axis),
                }
            }
            (Kind::Cuboid, _) => Cuboid::normal(face),
            (Kind::Layer, _) => {
                if face == Layer::TOP {
                    DVec3::Z
                } else {
                    -DVec3::Z
                }
            }
        }
    }

    /// Largest curvature of a face at `p` on it, 1/µm; 0 where it is flat.
    pub fn curvature(&self, prim: PrimId, face: u8, p: DVec3) -> f64 {
        match self.locate(prim) {
            (Kind::Sphere, i) => 1.0 / self.spheres.shapes[i].radius,
            (Kind::Cylinder, i) if face == Cylinder::MANTLE => self.cylinders.shapes[i].curvature(p),
            _ => 0.0,
        }
    }

    /// Distance of two surfaces that are parallel to the last bit: planes of one normal, or, by primitives whose faces
    /// they are, spheres of one centre and round mantles of one axis; µm.
    #[inline]
    pub fn separation(&self, a: (SurfaceId, PrimId), b: (SurfaceId, PrimId)) -> Option<f64> {
        match (self.plane(a.0), self.plane(b.0)) {
            (Some(p), Some(q)) if q.normal == p.normal => Some((p.offset - q.offset).abs()),
            (Some(p), Some(q)) if q.normal == -p.normal => Some((p.offset + q.offset).abs()),
            (None, None) => self.separation_of_curved(a.1, b.1),
            _ => None,
        }
    }

    fn separation_of_curved(&self, a: PrimId, b: PrimId) -> Option<f64> {
        match (self.shape(a), self.shape(b)) {
            (Shape::Sphere(s), Shape::Sphere(t)) if s.center == t.center => Some((s.radius - t.radius).abs()),
            (Shape::Cylinder(s), Shape::Cylinder(t))
                if s.is_round() && t.is_round() && (s.from, s.axis) == (t.from, t.axis) =>
            {
                Some((s.radii[0] - t.radii[0]).abs())
            }
            _ => None,
        }
    }

    /// The stored plane normal of a cylinder's end, turned outwards.
    fn outward_end(&self, i: usize, face: u8, outward: DVec3) -> DVec3 {
        let plane = &self.planes[self.cylinders.tags[i].surfaces[usize::from(face)].0 as usize - 1];
        if plane.normal.dot(outward) < 0.0 { -plane.normal } else { plane.normal }
    }

    /// The point of a face next to `p`, which is off by rounding only, and the outward normal there.
    #[inline]
    pub fn settle(&self, crossing: Crossing, surface: SurfaceId, p: DVec3) -> (DVec3, DVec3) {
        if let (Kind::Sphere, i) = self.locate(crossing.prim) {
            return self.spheres.shapes[i].settle(p);
        }
        let point = self.snap(crossing, surface, p);
        (point, self.normal(crossing.prim, crossing.face, point))
    }

    /// `p`, known to lie on the face up to rounding, moved onto it.
    #[inline]
    pub fn snap(&self, crossing: Crossing, surface: SurfaceId, p: DVec3) -> DVec3 {
        if let Some(plane) = self.plane(surface) {
            return plane.project(p);
        }
        match self.locate(crossing.prim) {
            (Kind::Sphere, i) => self.spheres.shapes[i].settle(p).0,
            (Kind::Cylinder, i) => self.cylinders.shapes[i].snap_to_mantle(p),
            _ => p,
        }
    }
}
