//! Solids that are one convex primitive with nothing in it: a ray inside leaves through the other root, which
//! needs no search.

use super::flat::Solid;
use crate::geometry::{Aabb, COINCIDENT, Cuboid, Kind, Pairs, PrimId, Primitives, Sphere};

/// Sets [`Solid::lonely`].
pub(super) fn mark(primitives: &Primitives, solids: &mut [Solid]) {
    let ids: Vec<PrimId> = (0..primitives.len() as u32).map(PrimId).collect();
    let convex = |p: PrimId| !matches!(primitives.locate(p).0, Kind::Triangle | Kind::Layer);
    for &p in &ids {
        solids[primitives.owner(p) as usize].lonely = convex(p);
    }
    let boxes: Vec<Aabb> = ids.iter().map(|&p| primitives.bounds(p)).collect();
    let pairs = Pairs::new(&boxes);
    for &p in ids.iter().filter(|&&p| convex(p)) {
        let owner = primitives.owner(p) as usize;
        if solids[owner].lonely {
            let mut alone = true;
            pairs.overlapping(&boxes[p.0 as usize], |q| alone &= q == p.0 as usize || spares(primitives, p, ids[q]));
            solids[owner].lonely = alone;
        }
    }
}

/// Whether no surface of `b` enters the inside of `a`. May be falsely negative.
fn spares(primitives: &Primitives, a: PrimId, b: PrimId) -> bool {
    let inside = primitives.bounds(a);
    match (shape(primitives, a), shape(primitives, b)) {
        (Convex::Sphere(s), Convex::Sphere(t)) => {
            let d = s.center.distance(t.center);
            d >= s.radius + t.radius || d + s.radius <= t.radius
        }
        (_, Convex::Cuboid(b)) => apart(inside, b.bounds()) || within(inside, b.bounds()),
        (_, Convex::Layer(b)) => apart(inside, b) || within(inside, b),
        (Convex::Cylinder(s), Convex::Cylinder(t)) if s.axis == t.axis && s.from == t.from && s.u == t.u => {
            s.radii[0] < t.radii[0] && s.radii[1] < t.radii[1] && s.length <= t.length
        }
        _ => apart(inside, primitives.bounds(b)),
    }
}

enum Convex {
    Sphere(Sphere),
    Cylinder(crate::geometry::Cylinder),
    Cuboid(Cuboid),
    Layer(Aabb),
    Other,
}

fn shape(primitives: &Primitives, p: PrimId) -> Convex {
    match primitives.locate(p) {
        (Kind::Sphere, i) => Convex::Sphere(primitives.spheres()[i]),
        (Kind::Cylinder, i) => Convex::Cylinder(primitives.cylinders()[i]),
        (Kind::Cuboid, i) => Convex::Cuboid(primitives.cuboids()[i]),
        (Kind::Layer, _) => Convex::Layer(primitives.bounds(p)),
        (Kind::Triangle, _) => Convex::Other,
    }
}

/// Whether the insides of two boxes have nothing in common; they may touch.
fn apart(a: Aabb, b: Aabb) -> bool {
    (a.max - COINCIDENT).cmple(b.min).any() || (b.max - COINCIDENT).cmple(a.min).any()
}

/// Whether `a` lies in `b`; they may touch.
fn within(a: Aabb, b: Aabb) -> bool {
    a.min.cmpge(b.min - COINCIDENT).all() && a.max.cmple(b.max + COINCIDENT).all()
}
