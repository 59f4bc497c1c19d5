//! Solids that are one convex primitive with nothing in it: a ray inside leaves through the other root, which
//! needs no search.

use rayon::prelude::*;

use super::solid::Solid;
use crate::geometry::{Aabb, COINCIDENT, Pairs, PrimId, Primitives, Shape};

/// Sets [`Solid::lonely`].
pub(super) fn mark(primitives: &Primitives, solids: &mut [Solid]) {
    let ids: Vec<PrimId> = primitives.ids().collect();
    let convex = |p: PrimId| !matches!(primitives.shape(p), Shape::Triangle(_) | Shape::Layer(_));
    for &p in &ids {
        solids[primitives.owner(p) as usize].lonely = convex(p);
    }
    if !ids.iter().any(|&p| convex(p)) {
        return;
    }
    let boxes: Vec<Aabb> = ids.iter().map(|&p| primitives.bounds(p)).collect();
    let pairs = Pairs::new(&boxes);
    let alone = |&p: &PrimId| {
        let mut alone = convex(p);
        if alone {
            pairs.overlapping(&boxes[p.0 as usize], |q| alone &= q == p.0 as usize || spares(primitives, p, ids[q]));
        }
        alone
    };
    let alone: Vec<bool> = ids.par_iter().map(alone).collect();
    for (&p, alone) in ids.iter().zip(alone) {
        solids[primitives.owner(p) as usize].lonely &= alone;
    }
}

/// Whether no surface of `b` enters the inside of `a`. May be falsely negative.
fn spares(primitives: &Primitives, a: PrimId, b: PrimId) -> bool {
    let (inside, outside) = (primitives.bounds(a), primitives.bounds(b));
    match (primitives.shape(a), primitives.shape(b)) {
        (Shape::Sphere(s), Shape::Sphere(t)) => {
            let d = s.center.distance(t.center);
            d >= s.radius + t.radius || d + s.radius <= t.radius
        }
        (_, Shape::Cuboid(_) | Shape::Layer(_)) => apart(inside, outside) || within(inside, outside),
        (Shape::Cylinder(s), Shape::Cylinder(t)) if s.axis == t.axis && s.from == t.from && s.u == t.u => {
            s.radii[0] < t.radii[0] && s.radii[1] < t.radii[1] && s.length <= t.length
        }
        _ => apart(inside, outside),
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
