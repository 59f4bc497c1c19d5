//! Backend for packings of spheres: cubic cells, through which a ray goes one by one (Amanatides and
//! Woo, *A Fast Voxel Traversal Algorithm for Ray Tracing*, Eurographics 1987). Where the next sphere is only some radii away, a
//! hierarchy takes longer to find where to begin than this takes to arrive.

use std::f64::consts::PI;
use std::hint::select_unpredictable;

use glam::{DVec3, I64Vec3, IVec3, Vec3};
use pulp::{Arch, Simd, WithSimd};

use super::proxy;
use crate::geometry::{Aabb, Kind, Nearest, PrimId, Primitives, Query, Sink};

/// A cell is so large that about so many spheres reach into it: one [`Block`].
const CROWD: f64 = 6.0;
/// A sphere is in all cells from which it is away by this part of an edge, far more than rounding can move a ray.
const PAD: f64 = 1e-6;
/// Spheres are taken to be larger by this part of the greatest extent of all, some times what single precision can err.
const MARGIN: f64 = 4e-6;
/// Fewest spheres, greatest ratio of their radii, least share of their room that they fill, and how much more of them are around
/// one of them than around a place of the room, for this to be the fastest: measured from as fast as a hierarchy, where they are
/// that few, to 1.5 times as fast (of 14,000 equal ones: `cargo bench --bench end_to_end`).
const FEWEST: usize = 64;
const MOST_UNLIKE: f64 = 20.0;
const LEAST_FILLED: f64 = 0.002;
const MOST_BUNCHED: f64 = 2.0;

/// A built grid.
pub struct Grid {
    /// Lowest corner, µm.
    low: DVec3,
    /// Edge of a cell, µm, and its inverse.
    edge: f64,
    per_edge: f64,
    count: IVec3,
    /// For each cell where its spheres begin in `blocks`; one more at the end.
    first: Vec<u32>,
    blocks: Vec<Block>,
    arch: Arch,
}

/// Spheres of a block.
const SIDE_BY_SIDE: usize = 8;
type Row = [f32; SIDE_BY_SIDE];
/// The number of no sphere.
const NOBODY: u32 = u32::MAX;

/// Spheres of a cell, somewhat enlarged, from the lowest corner of the grid: all are asked at once, for whether one of them is
/// met nobody can foretell, and a processor that guesses wrong waits longer than it takes to ask. In single precision, which is
/// half as much to fetch.
#[derive(Clone, Copy)]
struct Block {
    x: Row,
    y: Row,
    z: Row,
    /// Squares of the radii; negative where there is no sphere.
    squares: Row,
    members: [u32; SIDE_BY_SIDE],
}

/// A ray from where it enters the grid, in the same coordinates.
struct Path {
    origin: Vec3,
    dir: Vec3,
}

/// A row of numbers. Only loops as plain as this one are turned into instructions for whole registers.
#[inline(always)]
fn row(f: impl Fn(usize) -> f32) -> Row {
    let mut out = [0.0; SIDE_BY_SIDE];
    for (i, x) in out.iter_mut().enumerate() {
        *x = f(i);
    }
    out
}

impl Block {
    const EMPTY: Self = Self {
        x: [0.0; SIDE_BY_SIDE],
        y: [0.0; SIDE_BY_SIDE],
        z: [0.0; SIDE_BY_SIDE],
        squares: [-1.0; SIDE_BY_SIDE],
        members: [NOBODY; SIDE_BY_SIDE],
    };

    fn put(&mut self, i: usize, member: u32, center: Vec3, radius: f32) {
        [self.x[i], self.y[i], self.z[i]] = center.to_array();
        (self.squares[i], self.members[i]) = (radius * radius, member);
    }

    /// Which spheres may be met: a bit each.
    #[inline(always)]
    fn may_be_met(&self, path: &Path) -> u32 {
        let (o, d) = (path.origin, path.dir);
        let [fx, fy, fz] = [row(|i| o.x - self.x[i]), row(|i| o.y - self.y[i]), row(|i| o.z - self.z[i])];
        let b = row(|i| fx[i] * d.x + fy[i] * d.y + fz[i] * d.z);
        let [px, py, pz] = [row(|i| fx[i] - b[i] * d.x), row(|i| fy[i] - b[i] * d.y), row(|i| fz[i] - b[i] * d.z)];
        let line = row(|i| px[i] * px[i] + py[i] * py[i] + pz[i] * pz[i] - self.squares[i]);
        let start = row(|i| fx[i] * fx[i] + fy[i] * fy[i] + fz[i] * fz[i] - self.squares[i]);
        // All but those past which the line goes, and those on the way off, from outside.
        let near = row(|i| if b[i] < start[i] { b[i] } else { start[i] });
        let miss = row(|i| if line[i] > near[i] { line[i] } else { near[i] });
        let mut bits = 0;
        for (i, miss) in miss.iter().enumerate() {
            bits |= (miss.to_bits() >> 31) << i;
        }
        bits
    }
}

/// Whether a grid is the fastest for what is in `domain`.
pub fn is_best(primitives: &Primitives, domain: Aabb) -> bool {
    let count = primitives.count(Kind::Sphere);
    if count < FEWEST || count != primitives.bounded_count() {
        return false;
    }
    let radii = boxes(primitives).map(|b| radius(&b));
    let (least, most) = radii.fold((f64::INFINITY, 0.0f64), |(least, most), r| (least.min(r), most.max(r)));
    most <= MOST_UNLIKE * least
        && Crowd::new(primitives, domain).filled() >= LEAST_FILLED
        && bunched(primitives, domain) <= MOST_BUNCHED
}

/// The boxes around the spheres, in order.
fn boxes(primitives: &Primitives) -> impl Iterator<Item = Aabb> {
    proxy::ids(primitives, Kind::Sphere).map(|id| primitives.bounds(id))
}

fn radius(bounds: &Aabb) -> f64 {
    0.5 * bounds.size().x
}

/// Spheres per cell when it is judged whether they are everywhere alike.
const SAMPLED: f64 = 32.0;

/// The spheres of a sample as a whole.
struct Crowd {
    /// How many, per µm³ of the room they are in.
    density: f64,
    /// Means of the radius, of its square, and of its cube.
    radius: [f64; 3],
}

/// The room the spheres are in.
fn room(primitives: &Primitives, domain: Aabb) -> Aabb {
    boxes(primitives).fold(Aabb::EMPTY, Aabb::union).intersection(domain)
}

/// How many spheres are around one of them, over how many are around a place of the room: 1 if they are everywhere alike.
fn bunched(primitives: &Primitives, domain: Aabb) -> f64 {
    let room = room(primitives, domain);
    let edge = (room.size().element_product() * SAMPLED / primitives.count(Kind::Sphere) as f64).cbrt();
    let cells = (room.size() / edge).ceil().max(DVec3::ONE).as_usizevec3();
    let per_size = cells.as_dvec3() / room.size();
    let mut spheres = vec![0u32; cells.element_product()];
    for center in boxes(primitives).map(|b| b.center()).filter(|&c| room.contains(c)) {
        let cell = ((center - room.min) * per_size).as_usizevec3().min(cells - 1);
        spheres[(cell.z * cells.y + cell.y) * cells.x + cell.x] += 1;
    }
    let sum = |power| spheres.iter().map(|&n| f64::from(n).powi(power)).sum::<f64>();
    sum(2) * spheres.len() as f64 / sum(1).powi(2)
}

impl Crowd {
    fn new(primitives: &Primitives, domain: Aabb) -> Self {
        let room = room(primitives, domain);
        let count = primitives.count(Kind::Sphere) as f64;
        let mean = |power| boxes(primitives).map(|b| radius(&b).powi(power)).sum::<f64>() / count;
        Self { density: count / room.size().element_product(), radius: [1, 2, 3].map(mean) }
    }

    /// Share of the room that they take.
    fn filled(&self) -> f64 {
        4.0 / 3.0 * PI * self.density * self.radius[2]
    }

    /// The edge of a cell, µm, into which [`CROWD`] of them reach: their centres are in the cell, grown by a radius.
    fn edge(&self) -> f64 {
        let [r, r2, r3] = self.radius;
        let places = |e: f64| e.powi(3) + 6.0 * e.powi(2) * r + 3.0 * PI * e * r2 + 4.0 / 3.0 * PI * r3;
        let mut edge = r;
        while self.density * places(edge) < CROWD {
            edge *= 1.05;
        }
        edge
    }
}

impl Grid {
    /// Builds over the spheres, of which there are some.
    pub fn new(primitives: &Primitives, domain: Aabb) -> Self {
        let seen = boxes(primitives).map(|b| b.intersection(domain));
        let bounds = seen.filter(|b| !b.is_empty()).fold(Aabb::EMPTY, Aabb::union);
        let edge = Crowd::new(primitives, domain).edge();
        let pad = PAD * edge;
        let (low, high) =
            if bounds.is_empty() { (DVec3::ZERO, DVec3::ZERO) } else { (bounds.min - pad, bounds.max + pad) };
        let count = ((high - low) / edge).ceil().as_ivec3().max(IVec3::ONE);
        let mut grid =
            Self { low, edge, per_edge: 1.0 / edge, count, first: Vec::new(), blocks: Vec::new(), arch: Arch::new() };
        grid.fill(primitives, domain, pad + MARGIN * (high - low).max_element());
        grid
    }

    fn fill(&mut self, primitives: &Primitives, domain: Aabb, margin: f64) {
        let cells = self.count.as_i64vec3().element_product() as usize;
        let mut waiting = vec![0u32; cells];
        self.for_each_pair(primitives, domain, |cell, _| waiting[cell] += 1);
        self.first = Vec::with_capacity(cells + 1);
        let mut blocks = 0;
        for &spheres in &waiting {
            self.first.push(blocks);
            blocks += spheres.div_ceil(SIDE_BY_SIDE as u32);
        }
        self.first.push(blocks);
        let (mut filled, low) = (vec![Block::EMPTY; blocks as usize], self.low);
        let first = primitives.first(Kind::Sphere).0;
        self.for_each_pair(primitives, domain, |cell, member| {
            waiting[cell] -= 1;
            let i = waiting[cell] as usize;
            let bounds = primitives.bounds(PrimId(first + member));
            let (center, radius) = ((bounds.center() - low).as_vec3(), (radius(&bounds) + margin) as f32);
            filled[self.first[cell] as usize + i / SIDE_BY_SIDE].put(i % SIDE_BY_SIDE, member, center, radius);
        });
        self.blocks = filled;
    }

    /// Calls `visit` for each sphere and each cell into which it reaches.
    fn for_each_pair(&self, primitives: &Primitives, domain: Aabb, mut visit: impl FnMut(usize, u32)) {
        let pad = PAD * self.edge;
        for (member, whole) in boxes(primitives).enumerate() {
            let (center, radius) = (whole.center(), radius(&whole) + pad);
            let seen = whole.intersection(domain);
            if seen.is_empty() {
                continue;
            }
            let [from, to] = [seen.min - pad, seen.max + pad].map(|p| self.cell(p));
            for z in from.z..=to.z {
                for y in from.y..=to.y {
                    for x in from.x..=to.x {
                        let cell = IVec3::new(x, y, z);
                        let corner = self.low + self.edge * cell.as_dvec3();
                        let nearest = center.clamp(corner - pad, corner + self.edge + pad);
                        if nearest.distance_squared(center) <= radius * radius {
                            visit(self.number(cell), member as u32);
                        }
                    }
                }
            }
        }
    }

    /// The cell of a point, or the nearest one.
    #[inline(always)]
    fn cell(&self, p: DVec3) -> IVec3 {
        ((p - self.low) * self.per_edge).max(DVec3::ZERO).as_ivec3().min(self.count - 1)
    }

    #[inline(always)]
    fn number(&self, cell: IVec3) -> usize {
        ((cell.z as usize * self.count.y as usize) + cell.y as usize) * self.count.x as usize + cell.x as usize
    }

    /// Answers the queries whose numbers are in `which`.
    pub fn nearest(&self, primitives: &Primitives, queries: &[Query], which: &[usize], answers: &mut [Nearest]) {
        self.arch.dispatch(Search { grid: self, primitives, queries, which, answers });
    }

    /// Offers the crossings of the spheres in the cells that the ray goes through.
    #[inline(always)]
    pub fn propose(&self, primitives: &Primitives, query: &Query, sink: &mut impl Sink) {
        // The sphere that the ray comes from need not be looked for.
        let own = primitives.sphere_with(query.last);
        if let Some((order, crossing)) = own.and_then(|(_, prim)| primitives.other_side(query, prim)) {
            sink.offer(order.t, order.surface, crossing);
        }
        let own = own.map_or(NOBODY, |(i, _)| i as u32);
        let ray = &query.ray;
        let inverse = ray.dir.recip();
        let high = self.low + self.edge * self.count.as_dvec3();
        // Where the ray is within the grid; one along a side of it may give no number, and goes past.
        let (a, b) = ((self.low - ray.origin) * inverse, (high - ray.origin) * inverse);
        let enter = a.min(b).max_element().max(query.from.t).max(0.0);
        let leave = a.max(b).min_element();
        if enter > leave.min(sink.horizon()) || enter.is_nan() || leave.is_nan() {
            return;
        }
        let start = ray.at(enter);
        let path = Path { origin: (start - self.low).as_vec3(), dir: ray.dir.as_vec3() };
        let cell = self.cell(start);
        let forward = ray.dir.cmpgt(DVec3::ZERO);
        let is_along = ray.dir.cmpeq(DVec3::ZERO);
        let border = self.low + self.edge * (cell.as_dvec3() + DVec3::select(forward, DVec3::ONE, DVec3::ZERO));
        let mut next = DVec3::select(is_along, DVec3::INFINITY, (border - ray.origin) * inverse);
        let pace = DVec3::select(is_along, DVec3::INFINITY, self.edge * inverse.abs());
        let ways = I64Vec3::select(forward, I64Vec3::ONE, I64Vec3::NEG_ONE);
        let stride = ways * I64Vec3::new(1, i64::from(self.count.x), i64::from(self.count.x) * i64::from(self.count.y));
        let mut number = self.number(cell) as i64;
        // Spheres are in several cells; those just asked need not be asked again.
        let mut asked = [own, NOBODY, NOBODY];
        // Rounding can lead to a cell that is none, but only where the ray leaves.
        while let Some(&[from, to]) = self.first.get(number as usize..).and_then(<[u32]>::first_chunk) {
            for block in &self.blocks[from as usize..to as usize] {
                let mut met = block.may_be_met(&path);
                while met != 0 {
                    let member = block.members[met.trailing_zeros() as usize % SIDE_BY_SIDE];
                    met &= met - 1;
                    if !asked.contains(&member) {
                        asked = [own, member, asked[1]];
                        primitives.propose_sphere(query, member as usize, primitives.sphere(member as usize), sink);
                    }
                }
            }
            let t = next.min_element();
            if t >= leave || t >= sink.horizon() {
                return;
            }
            // Nobody can foretell which side it is.
            let (x, y) = (next.x == t, next.x != t && next.y == t);
            number += select_unpredictable(x, stride.x, select_unpredictable(y, stride.y, stride.z));
            next.x += select_unpredictable(x, pace.x, 0.0);
            next.y += select_unpredictable(y, pace.y, 0.0);
            next.z += select_unpredictable(x || y, 0.0, pace.z);
        }
    }
}

/// The work of [`Grid::nearest`], for the registers of the processor at hand.
struct Search<'a> {
    grid: &'a Grid,
    primitives: &'a Primitives,
    queries: &'a [Query],
    which: &'a [usize],
    answers: &'a mut [Nearest],
}

impl WithSimd for Search<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        for &i in self.which {
            self.grid.propose(self.primitives, &self.queries[i], &mut self.answers[i]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Builder, Shape, Sphere};

    /// A lattice of 10 × 10 × 10 spheres, every tenth of which has a radius of `radius`, and the others one of 0.4; all but one
    /// moved towards the corner.
    fn lattice(radius: f64, squeeze: f64) -> Primitives {
        let mut builder = Builder::default();
        for i in 0..1000 {
            let node = DVec3::new(f64::from(i % 10), f64::from(i / 10 % 10), f64::from(i / 100));
            let center = if i == 999 { node } else { squeeze * node };
            let radius = squeeze * if i % 10 == 5 { radius } else { 0.4 };
            builder.add(Shape::Sphere(Sphere { center, radius }), i as u32);
        }
        builder.finish()
    }

    #[test]
    fn is_chosen_where_spheres_are_everywhere_alike() {
        assert!(is_best(&lattice(0.4, 1.0), Aabb::INFINITE));
        assert!(is_best(&lattice(0.04, 1.0), Aabb::INFINITE));
        assert!(!is_best(&lattice(0.004, 1.0), Aabb::INFINITE), "radii of 1 : 100");
        assert!(!is_best(&lattice(0.4, 0.5), Aabb::INFINITE), "all but one in a corner");
    }

    #[test]
    fn most_cells_are_one_block() {
        for radius in [0.4, 0.04] {
            let grid = Grid::new(&lattice(radius, 1.0), Aabb::INFINITE);
            let (cells, blocks) = (grid.first.len() - 1, grid.blocks.len());
            assert!((0.8..1.6).contains(&(blocks as f64 / cells as f64)), "{blocks} blocks in {cells} cells");
        }
    }
}
