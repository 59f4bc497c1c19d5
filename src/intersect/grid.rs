//! Backend for dense packings of spheres of similar size: cubic cells, through which a ray goes one by one (Amanatides and
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
/// Fewest and most spheres, greatest ratio of their radii, and least share of their box that they fill, for this to be the fastest
/// (`cargo bench --bench end_to_end`): 1.1 to 1.5 times as fast as a hierarchy. Beyond, both are equal.
const FEWEST: usize = 200;
const MOST: usize = 100_000;
const MOST_UNLIKE: f64 = 3.0;
const LEAST_FILLED: f64 = 0.1;

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
/// met nobody can foretell, and a processor that guesses wrong waits longer than it takes to ask. In single precision, for all
/// should stay in the cache of a core.
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
    if !(FEWEST..=MOST).contains(&count) || count != primitives.bounded_count() {
        return false;
    }
    let radii = boxes(primitives).map(|b| radius(&b));
    let (least, most) = radii.fold((f64::INFINITY, 0.0f64), |(least, most), r| (least.min(r), most.max(r)));
    most <= MOST_UNLIKE * least && share_filled(primitives, domain) >= LEAST_FILLED
}

/// The boxes around the spheres, in order.
fn boxes(primitives: &Primitives) -> impl Iterator<Item = Aabb> {
    proxy::ids(primitives, Kind::Sphere).map(|id| primitives.bounds(id))
}

fn radius(bounds: &Aabb) -> f64 {
    0.5 * bounds.size().x
}

/// How much of the room they are in the spheres take.
fn share_filled(primitives: &Primitives, domain: Aabb) -> f64 {
    let room = boxes(primitives).fold(Aabb::EMPTY, Aabb::union).intersection(domain);
    let spheres: f64 = boxes(primitives).map(|b| 4.0 / 3.0 * PI * radius(&b).powi(3)).sum();
    spheres / room.size().element_product()
}

/// The edge of a cell, in radii, into which [`CROWD`] of equal spheres reach.
fn edge(share_filled: f64) -> f64 {
    let per_room = share_filled / (4.0 / 3.0 * PI);
    // The places of centres: the cell, grown by a radius.
    let crowd = |e: f64| per_room * (e.powi(3) + 6.0 * e.powi(2) + 3.0 * PI * e + 4.0 / 3.0 * PI);
    let mut edge = 1.0;
    while crowd(edge) < CROWD {
        edge *= 1.05;
    }
    edge
}

impl Grid {
    /// Builds over the spheres, of which there are some.
    pub fn new(primitives: &Primitives, domain: Aabb) -> Self {
        let mean = boxes(primitives).map(|b| radius(&b)).sum::<f64>() / primitives.count(Kind::Sphere) as f64;
        let seen = boxes(primitives).map(|b| b.intersection(domain));
        let bounds = seen.filter(|b| !b.is_empty()).fold(Aabb::EMPTY, Aabb::union);
        let edge = mean * edge(share_filled(primitives, domain));
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
        let pairs = self.pairs(primitives, domain);
        let cells = self.count.as_i64vec3().element_product() as usize;
        let first = primitives.first(Kind::Sphere).0;
        let mut pairs = pairs.into_iter().peekable();
        for cell in 0..cells as u32 {
            self.first.push(self.blocks.len() as u32);
            for i in 0.. {
                let Some((_, member)) = pairs.next_if(|p| p.0 == cell) else { break };
                if i % SIDE_BY_SIDE == 0 {
                    self.blocks.push(Block::EMPTY);
                }
                let bounds = primitives.bounds(PrimId(first + member));
                let center = (bounds.center() - self.low).as_vec3();
                let block = self.blocks.last_mut().expect("one has been begun");
                block.put(i % SIDE_BY_SIDE, member, center, (radius(&bounds) + margin) as f32);
            }
        }
        self.first.push(self.blocks.len() as u32);
    }

    /// Cells, and spheres that reach into them, by cell.
    fn pairs(&self, primitives: &Primitives, domain: Aabb) -> Vec<(u32, u32)> {
        let pad = PAD * self.edge;
        let mut pairs: Vec<(u32, u32)> = Vec::new();
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
                            pairs.push((self.number(cell) as u32, member as u32));
                        }
                    }
                }
            }
        }
        pairs.sort_unstable();
        pairs
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
