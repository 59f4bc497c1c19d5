//! Backend for dense packings of spheres of similar size: cubic cells, through which a ray goes one by one (Amanatides and
//! Woo, *A Fast Voxel Traversal Algorithm for Ray Tracing*, Eurographics 1987). Where the next sphere is only some radii away, a
//! hierarchy takes longer to find where to begin than this takes to arrive.

use glam::{DVec3, IVec3};

use super::proxy;
use crate::geometry::{Aabb, Kind, PrimId, Primitives, Query, Ray, Sink};

/// Edge of a cell, in mean radii.
const EDGE: f64 = 1.5;
/// Spheres are taken to be larger by this part of an edge, far more than rounding can move a ray.
const PAD: f64 = 1e-6;
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
    /// For each cell where its balls begin in `members`; one more at the end.
    first: Vec<u32>,
    members: Vec<u32>,
    /// By cell, so that what is near is near in memory.
    balls: Vec<Ball>,
}

/// A sphere, somewhat enlarged.
struct Ball {
    center: DVec3,
    square: f64,
    prim: PrimId,
}

impl Ball {
    #[inline(always)]
    fn may_be_met(&self, ray: &Ray) -> bool {
        let f = ray.origin - self.center;
        let b = f.dot(ray.dir);
        // Past it, or outside of it and on the way off.
        (f - b * ray.dir).length_squared() <= self.square && (b <= 0.0 || f.length_squared() <= self.square)
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
        let mut grid =
            Self { low, edge, per_edge: 1.0 / edge, count, first: Vec::new(), members: Vec::new(), balls: Vec::new() };
        let mut order: Vec<(usize, PrimId)> =
            ids().map(|id| (grid.number(grid.cell(primitives.bounds(id).center())), id)).collect();
        order.sort_unstable();
        grid.fill(order.into_iter().map(|(_, id)| (id, primitives.bounds(id))), domain, pad);
        grid
    }

    fn fill(&mut self, spheres: impl Iterator<Item = (PrimId, Aabb)>, domain: Aabb, pad: f64) {
        let cells = self.count.as_i64vec3().element_product() as usize;
        let mut pairs: Vec<(u32, u32)> = Vec::new();
        for (prim, whole) in spheres {
            let (center, radius) = (whole.center(), 0.5 * whole.size().x + pad);
            let (square, member) = (radius * radius, self.balls.len() as u32);
            self.balls.push(Ball { center, square, prim });
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
                        if nearest.distance_squared(center) <= square {
                            pairs.push((self.number(cell) as u32, member));
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
        ((p - self.low) * self.per_edge).floor().as_ivec3().clamp(IVec3::ZERO, self.count - 1)
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
        let leave = a.max(b).min_element().min(sink.horizon());
        if enter > leave || enter.is_nan() || leave.is_nan() {
            return;
        }
        let mut cell = self.cell(ray.at(enter));
        let forward = ray.dir.cmpgt(DVec3::ZERO);
        let step =
            IVec3::new(if forward.x { 1 } else { -1 }, if forward.y { 1 } else { -1 }, if forward.z { 1 } else { -1 });
        let ahead = DVec3::select(forward, DVec3::ONE, DVec3::ZERO);
        let is_along = ray.dir.cmpeq(DVec3::ZERO);
        let border = self.low + self.edge * (cell.as_dvec3() + ahead);
        let mut next = DVec3::select(is_along, DVec3::INFINITY, (border - ray.origin) * inverse);
        let pace = DVec3::select(is_along, DVec3::INFINITY, self.edge * inverse.abs());
        let stride = [
            step.x as isize,
            step.y as isize * self.count.x as isize,
            step.z as isize * self.count.x as isize * self.count.y as isize,
        ];
        let mut number = self.number(cell) as isize;
        loop {
            let at = number as usize;
            for &member in &self.members[self.first[at] as usize..self.first[at + 1] as usize] {
                // Most are missed, which is quickly seen.
                let ball = &self.balls[member as usize];
                if ball.may_be_met(ray) {
                    primitives.propose(query, ball.prim, sink);
                }
            }
            let axis = if next.x < next.y {
                if next.x < next.z { 0 } else { 2 }
            } else if next.y < next.z {
                1
            } else {
                2
            };
            if next[axis] >= sink.horizon() {
                return;
            }
            next[axis] += pace[axis];
            cell[axis] += step[axis];
            if cell[axis] < 0 || cell[axis] >= self.count[axis] {
                return;
            }
            number += stride[axis];
        }
    }
}
