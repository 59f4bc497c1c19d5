//! Triangles of meshes that may overlap: points near them that would be inside both.

use glam::DVec3;

use crate::geometry::Aabb;

/// Points `depth` below a triangle: under `p`, and a little towards the middle, off an edge `p` may lie on.
pub(super) fn below([a, b, c]: [DVec3; 3], p: DVec3, depth: f64) -> Vec<DVec3> {
    let Some(normal) = (b - a).cross(c - a).try_normalize() else { return Vec::new() };
    let middle = (a + b + c) / 3.0;
    [p, p.move_towards(middle, 4.0 * depth)].map(|p| p - depth * normal).to_vec()
}

/// The middle of the part of a triangle within bounds, with the width of that part.
pub(super) fn clip(triangle: [DVec3; 3], bounds: Aabb) -> Option<(DVec3, f64)> {
    let mut polygon = triangle.to_vec();
    for axis in 0..3 {
        polygon = keep(&polygon, |p| p[axis] - bounds.min[axis]);
        polygon = keep(&polygon, |p| bounds.max[axis] - p[axis]);
    }
    let center = polygon.iter().sum::<DVec3>() / polygon.len() as f64;
    let width = polygon.iter().map(|p| p.distance(center)).fold(0.0, f64::max);
    (!polygon.is_empty()).then_some((center, width))
}

/// The part of a convex polygon where `height` is not negative.
fn keep(polygon: &[DVec3], height: impl Fn(DVec3) -> f64) -> Vec<DVec3> {
    let next = polygon.iter().cycle().skip(1);
    let side = polygon.iter().zip(next).flat_map(|(&p, &q)| {
        let (hp, hq) = (height(p), height(q));
        let corner = (hp >= 0.0).then_some(p);
        let cut = (hp * hq < 0.0).then(|| p.lerp(q, hp / (hp - hq)));
        corner.into_iter().chain(cut)
    });
    side.collect()
}

/// A point below both of two triangles that pass through one another, beside the middle of their common line.
pub(super) fn middle_of_meeting(t: [DVec3; 3], u: [DVec3; 3]) -> Option<DVec3> {
    let points: Vec<DVec3> = pierced(t, u).into_iter().chain(pierced(u, t)).collect();
    let middle = points.iter().sum::<DVec3>() / points.len().max(1) as f64;
    let half = points.iter().map(|p| p.distance(middle)).fold(0.0, f64::max);
    let outward = (normal(t) + normal(u)).try_normalize()?;
    (half > 0.0).then_some(middle - 0.05 * half * outward)
}

fn normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a).normalize_or_zero()
}

/// Where edges of `u` pass through `t`.
fn pierced(t: [DVec3; 3], u: [DVec3; 3]) -> Vec<DVec3> {
    let n = normal(t);
    let edges = (0..3).map(|i| (u[i], u[(i + 1) % 3]));
    let points = edges.filter_map(|(p, q)| {
        let (hp, hq) = (n.dot(p - t[0]), n.dot(q - t[0]));
        (hp * hq < 0.0).then(|| p.lerp(q, hp / (hp - hq)))
    });
    let within = |x: &DVec3| (0..3).all(|i| (t[(i + 1) % 3] - t[i]).cross(*x - t[i]).dot(n) >= 0.0);
    points.filter(within).collect()
}
