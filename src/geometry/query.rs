//! What a ray asks of the geometry, and the answer.

use std::cmp::Ordering;

use glam::DVec3;

use super::{PrimId, Shear};

/// The identity of a geometric surface: a plane (shared by all faces in it), a sphere, a cylinder's mantle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct SurfaceId(pub u32);

impl SurfaceId {
    /// No surface; orders before all others.
    pub const NONE: Self = Self(0);
    /// Orders after all surfaces.
    pub const LAST: Self = Self(u32::MAX);
}

/// A half-line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Start, µm.
    pub origin: DVec3,
    /// Direction, unit length.
    pub dir: DVec3,
}

impl Ray {
    /// The point at distance `t` µm.
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + t * self.dir
    }
}

/// A place along a ray: total order of crossings.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Order {
    /// Distance from the origin, µm.
    pub t: f64,
    /// Tie-break between surfaces met at one distance.
    pub surface: SurfaceId,
}

/// A ray with the part of it that counts; made by [`super::Primitives::query`].
#[derive(Clone, Copy, Debug)]
pub struct Query {
    /// The ray.
    pub ray: Ray,
    /// Crossings count only after this place.
    pub from: Order,
    /// Crossings count up to this distance, inclusive, µm.
    pub limit: f64,
    /// The surface the origin lies on.
    pub last: SurfaceId,
    /// The ray's projection, if there are triangles.
    pub(super) shear: Shear,
}

impl Query {
    /// The same ray after a place on it.
    #[must_use]
    pub fn after(self, from: Order) -> Self {
        Self { from, ..self }
    }

    /// The same ray up to a distance, µm.
    #[must_use]
    pub fn within(self, limit: f64) -> Self {
        Self { limit, ..self }
    }

    /// Whether a crossing at `t` with the curved `surface` counts.
    #[inline]
    pub fn admits(&self, t: f64, surface: SurfaceId) -> bool {
        t <= self.limit && (t > self.from.t || (t == self.from.t && surface > self.from.surface))
    }

    /// Whether a crossing at `t` with the plane `surface` counts: a line meets a plane once.
    #[inline]
    pub fn admits_plane(&self, t: f64, surface: SurfaceId) -> bool {
        surface != self.last && self.admits(t, surface)
    }
}

/// Who listens to proposed crossings.
pub trait Sink {
    /// Takes a crossing into account.
    fn offer(&mut self, t: f64, surface: SurfaceId, crossing: Crossing);
    /// Distance up to which proposals still matter, µm.
    fn horizon(&self) -> f64;
}

/// One face of one primitive, met by a ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Crossing {
    /// The primitive.
    pub prim: PrimId,
    /// The solid it belongs to.
    pub owner: u32,
    /// Which of its faces.
    pub face: u8,
    /// Whether the ray goes into the solid here.
    pub enters: bool,
}

/// A crossing with its place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hit {
    /// Where.
    pub order: Order,
    /// What.
    pub crossing: Crossing,
}

/// Faces that can coincide at one point and still be told apart; a corner of touching bricks has 8.
const COINCIDING: usize = 8;

/// The nearest interface of a ray: all crossings at the first (distance, surface) that counts.
#[derive(Clone, Copy, Debug)]
pub struct Nearest {
    order: Order,
    count: u8,
    overflow: bool,
    crossings: [Crossing; COINCIDING],
}

impl Nearest {
    const NO_CROSSING: Crossing = Crossing { prim: PrimId(u32::MAX), owner: 0, face: 0, enters: false };

    /// Nothing found yet, up to `limit`.
    pub fn none(limit: f64) -> Self {
        Self {
            order: Order { t: limit, surface: SurfaceId::LAST },
            count: 0,
            overflow: false,
            crossings: [Self::NO_CROSSING; COINCIDING],
        }
    }

    /// Nothing found yet, up to `limit`; what was found before is forgotten.
    #[inline]
    pub fn reset(&mut self, limit: f64) {
        self.order = Order { t: limit, surface: SurfaceId::LAST };
        self.count = 0;
        self.overflow = false;
    }

    /// Adds a coinciding crossing, kept sorted so that the answer does not depend on who proposed first.
    #[cold]
    fn insert(&mut self, crossing: Crossing) {
        let n = usize::from(self.count);
        let at = self.crossings[..n].partition_point(|c| *c < crossing);
        if at < n && self.crossings[at] == crossing {
            return;
        }
        if n == COINCIDING {
            self.overflow = true;
            return;
        }
        self.crossings.copy_within(at..n, at + 1);
        self.crossings[at] = crossing;
        self.count += 1;
    }

    /// Where the interface lies, or `None` if nothing was met.
    #[inline]
    pub fn order(&self) -> Option<Order> {
        (self.count > 0).then_some(self.order)
    }

    /// The crossings that make up the interface, sorted by primitive.
    #[inline]
    pub fn crossings(&self) -> &[Crossing] {
        &self.crossings[..usize::from(self.count)]
    }

    /// Whether more faces coincide here than can be told apart.
    pub fn overflow(&self) -> bool {
        self.overflow
    }
}

impl Sink for Nearest {
    #[inline]
    fn offer(&mut self, t: f64, surface: SurfaceId, crossing: Crossing) {
        let order = Order { t, surface };
        if order < self.order {
            self.order = order;
            self.crossings[0] = crossing;
            self.count = 1;
            self.overflow = false;
        } else if order == self.order {
            self.insert(crossing);
        }
    }

    #[inline]
    fn horizon(&self) -> f64 {
        self.order.t
    }
}

/// All crossings of a ray up to its limit.
#[derive(Clone, Debug, Default)]
pub struct All {
    hits: Vec<Hit>,
    limit: f64,
}

impl All {
    /// Empties the list for a new query.
    pub fn restart(&mut self, limit: f64) {
        self.hits.clear();
        self.limit = limit;
    }

    /// The crossings by (distance, surface, primitive), each once.
    pub fn sorted(&mut self) -> &[Hit] {
        if self.hits.len() <= FEW {
            insert_in_order(&mut self.hits);
        } else {
            self.hits.sort_unstable_by(by_place);
        }
        self.hits.dedup();
        &self.hits
    }
}

/// So few hits come nearly in order: an accelerator looks at what is near first.
const FEW: usize = 64;

fn by_place(a: &Hit, b: &Hit) -> Ordering {
    let key = |h: &Hit| (h.order.surface, h.crossing);
    a.order.t.total_cmp(&b.order.t).then_with(|| key(a).cmp(&key(b)))
}

/// Sorts by insertion, which is the fastest for what is nearly in order.
fn insert_in_order(hits: &mut [Hit]) {
    for i in 1..hits.len() {
        let hit = hits[i];
        let mut at = i;
        while at > 0 && by_place(&hit, &hits[at - 1]) == Ordering::Less {
            hits[at] = hits[at - 1];
            at -= 1;
        }
        hits[at] = hit;
    }
}

impl Sink for All {
    fn offer(&mut self, t: f64, surface: SurfaceId, crossing: Crossing) {
        self.hits.push(Hit { order: Order { t, surface }, crossing });
    }

    fn horizon(&self) -> f64 {
        self.limit
    }
}

#[cfg(test)]
mod tests {
    use rand::rngs::Xoshiro256PlusPlus;
    use rand::{RngExt, SeedableRng};

    use super::*;

    #[test]
    fn few_and_many_hits_are_put_in_the_same_order() {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
        for count in [0, 1, 2, 5, FEW, FEW + 1, 3 * FEW] {
            let mut all = All::default();
            all.restart(f64::INFINITY);
            for _ in 0..count {
                let mut small = |n: u32| rng.random_range(0..n);
                let (t, surface) = (f64::from(small(9)), SurfaceId(small(3)));
                let crossing = Crossing { prim: PrimId(small(3)), owner: 0, face: 0, enters: small(2) == 1 };
                all.offer(t, surface, crossing);
            }
            let mut expected = all.hits.clone();
            expected.sort_by(by_place);
            expected.dedup();
            assert_eq!(all.sorted(), expected);
        }
    }
}
