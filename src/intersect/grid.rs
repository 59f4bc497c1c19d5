//! Backend for dense packings of spheres of similar size: cubic cells, through which a ray goes one by one (Amanatides and
//! Woo, *A Fast Voxel Traversal Algorithm for Ray Tracing*, Eurographics 1987). Where the next sphere is only some radii away, a
//! hierarchy takes longer to find where to begin than this takes to arrive.

use std::hint::select_unpredictable;

use glam::{DVec3, I64Vec3, IVec3, Vec3};

use super::proxy;
use crate::geometry::{Aabb, Kind, PrimId, Primitives, Query, Sink};

/// Edge of a cell, in mean radii.
const EDGE: f64 = 1.5;
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
    /// The first sphere.
    sphere: u32,
    /// For each cell where its spheres begin in `members`; one more at the end.
    first: Vec<u32>,
    members: Vec<u32>,
    /// By number of the sphere.
    balls: Vec<Ball>,
}

/// A sphere, somewhat enlarged, from the lowest corner of the grid. In single precision, for all of them should stay in the
/// cache of a core: who goes through cells waits for memory most of the time.
#[derive(Clone, Copy)]
struct Ball {
    center: Vec3,
    square: f32,
}

/// A ray from where it enters the grid, in the same coordinates.
struct Path {
    origin: Vec3,
    dir: Vec3,
}

impl Ball {
    #[inline(always)]
    fn may_be_met(&self, path: &Path) -> bool {
        let f = path.origin - self.center;
        let b = f.dot(path.dir);
        // Past it, or outside of it and on the way off.
        (f - b * path.dir).length_squared() <= self.square && (b <= 0.0 || f.length_squared() <= self.square)
    }
}

/// Whether a grid is the fastest for what is in `domain`.
pub fn is_best(primitives: &Primitives, domain: Aabb) -> bool {
    let count = primitives.count(Kind::Sphere);
    if !(FEWEST..=MOST).contains(&count) || count != primitives.bounded_count() {
        return false;
    }
    let boxes = || proxy::ids(primitives, Kind::Sphere).map(|id| primitives.bounds(id));
    let radius = |b: &Aabb| 0.5 * b.size().x;
    let (least, most) = boxes().fold((f64::INFINITY, 0.0f64), |(l, m), b| (l.min(radius(&b)), m.max(radius(&b))));
    let all = boxes().fold(Aabb::EMPTY, Aabb::union).intersection(domain);
    let filled: f64 = boxes().map(|b| 4.0 / 3.0 * std::f64::consts::PI * radius(&b).powi(3)).sum();
    most <= MOST_UNLIKE * least && filled >= LEAST_FILLED * all.size().element_product()
}

impl Grid {
    /// Builds over the spheres.
    pub fn new(primitives: &Primitives, domain: Aabb) -> Self {
        let ids = || proxy::ids(primitives, Kind::Sphere);
        let count = primitives.count(Kind::Sphere);
        let mean = ids().map(|id| 0.5 * primitives.bounds(id).size().x).sum::<f64>() / count.max(1) as f64;
        let boxes = ids().map(|id| primitives.bounds(id).intersection(domain));
        let bounds = boxes.filter(|b| !b.is_empty()).fold(Aabb::EMPTY, Aabb::union);
        let edge = EDGE * mean;
        let pad = PAD * edge;
        let (low, high) =
            if bounds.is_empty() { (DVec3::ZERO, DVec3::ZERO) } else { (bounds.min - pad, bounds.max + pad) };
        let count = ((high - low) / edge).ceil().as_ivec3().max(IVec3::ONE);
        let mut grid = Self {
            low,
            edge,
            per_edge: 1.0 / edge,
            count,
            sphere: primitives.first(Kind::Sphere).0,
            first: Vec::new(),
            members: Vec::new(),
            balls: Vec::new(),
        };
        let margin = pad + MARGIN * (high - low).max_element();
        let ball = |whole: Aabb| {
            let radius = 0.5 * whole.size().x + margin;
            Ball { center: (whole.center() - low).as_vec3(), square: (radius * radius) as f32 }
        };
        grid.balls = ids().map(|id| ball(primitives.bounds(id))).collect();
        grid.fill(ids().map(|id| primitives.bounds(id)), domain, pad);
        grid
    }

    fn fill(&mut self, spheres: impl Iterator<Item = Aabb>, domain: Aabb, pad: f64) {
        let cells = self.count.as_i64vec3().element_product() as usize;
        let mut pairs: Vec<(u32, u32)> = Vec::new();
        for (member, whole) in spheres.enumerate() {
            let (center, radius) = (whole.center(), 0.5 * whole.size().x + pad);
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
        self.first = vec![0; cells + 1];
        pairs.iter().for_each(|p| self.first[p.0 as usize + 1] += 1);
        (0..cells).for_each(|i| self.first[i + 1] += self.first[i]);
        self.members = pairs.into_iter().map(|p| p.1).collect();
    }

    /// The cell of a point, or the nearest one.
    #[inline]
    fn cell(&self, p: DVec3) -> IVec3 {
        ((p - self.low) * self.per_edge).max(DVec3::ZERO).as_ivec3().min(self.count - 1)
    }

    #[inline]
    fn number(&self, cell: IVec3) -> usize {
        ((cell.z as usize * self.count.y as usize) + cell.y as usize) * self.count.x as usize + cell.x as usize
    }

    /// Offers the crossings of the spheres in the cells that the ray goes through.
    #[inline]
    pub fn propose(&self, primitives: &Primitives, query: &Query, sink: &mut impl Sink) {
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
        // Spheres are in several cells; those just asked need not be asked again.
        let mut asked = [u32::MAX; 2];
        let cell = self.cell(start);
        let forward = ray.dir.cmpgt(DVec3::ZERO);
        let is_along = ray.dir.cmpeq(DVec3::ZERO);
        let border = self.low + self.edge * (cell.as_dvec3() + DVec3::select(forward, DVec3::ONE, DVec3::ZERO));
        let mut next = DVec3::select(is_along, DVec3::INFINITY, (border - ray.origin) * inverse);
        let pace = DVec3::select(is_along, DVec3::INFINITY, self.edge * inverse.abs());
        let ways = I64Vec3::select(forward, I64Vec3::ONE, I64Vec3::NEG_ONE);
        let stride = ways * I64Vec3::new(1, i64::from(self.count.x), i64::from(self.count.x) * i64::from(self.count.y));
        let mut number = self.number(cell) as i64;
        // Rounding can lead to a cell that is none, but only where the ray leaves.
        while let Some(&[from, to]) = self.first.get(number as usize..).and_then(<[u32]>::first_chunk) {
            for &member in &self.members[from as usize..to as usize] {
                // Most are missed, which is quickly seen.
                if self.balls[member as usize].may_be_met(&path) && !asked.contains(&member) {
                    asked = [asked[1], member];
                    primitives.propose_sphere(query, member as usize, PrimId(self.sphere + member), sink);
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
