//! Parts of a facet within ranges of polar angle and azimuth, exactly: for tables that have patches of their own.

use std::f64::consts::PI;

use glam::DVec3;

use super::geodesic::Facet;

/// A patch of a hemisphere between two polar angles and two azimuths, radians; it is less than half a turn wide, or a whole
/// one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Patch {
    /// Least and greatest angle from the pole of the hemisphere, 0 to π/2.
    pub theta: [f64; 2],
    /// First and last azimuth; none for the whole circle.
    pub phi: Option<[f64; 2]>,
}

impl Patch {
    /// Projected solid angle ∫ |cos θ| dω, sr.
    pub fn projected_solid_angle(&self) -> f64 {
        let [from, to] = self.theta.map(|t| t.sin().powi(2));
        let turn = self.phi.map_or(2.0 * PI, |[from, to]| to - from);
        0.5 * (to - from) * turn
    }

    /// Projected solid angle of the part of a facet that lies in the patch, sr; the facet is turned about z by `turn`
    /// (radians) first. Facets of the lower hemisphere are seen as their mirror images above the horizon.
    pub fn covers(&self, facet: Facet, turn: f64) -> f64 {
        let (sin, cos) = turn.sin_cos();
        let up = |c: DVec3| DVec3::new(cos * c.x - sin * c.y, sin * c.x + cos * c.y, c.z.abs());
        let mut polygon: Vec<DVec3> = facet.corners().map(up).to_vec();
        if facet.center().z < 0.0 {
            polygon.reverse();
        }
        if let Some([from, to]) = self.phi {
            // The sides of a meridian plane: what lies counter-clockwise of the first, clockwise of the last.
            polygon = clipped(&polygon, DVec3::new(-from.sin(), from.cos(), 0.0));
            polygon = clipped(&polygon, DVec3::new(to.sin(), -to.cos(), 0.0));
        }
        let [inner, outer] = self.theta;
        (within(&polygon, outer) - within(&polygon, inner)).max(0.0)
    }
}

/// The part of a spherical polygon on the positive side of a plane through the centre (Sutherland and Hodgman).
fn clipped(polygon: &[DVec3], normal: DVec3) -> Vec<DVec3> {
    let mut kept = Vec::with_capacity(polygon.len() + 2);
    for (i, &to) in polygon.iter().enumerate() {
        let from = polygon[(i + polygon.len() - 1) % polygon.len()];
        let (a, b) = (normal.dot(from), normal.dot(to));
        if (a < 0.0) != (b < 0.0) {
            kept.push((from * b - to * a).normalize() * (b - a).signum());
        }
        if b >= 0.0 {
            kept.push(to);
        }
    }
    kept
}

/// A circle as low as this is the horizon, below which no polygon reaches.
const HORIZON: f64 = 1e-12;
/// Arcs shorter than this, radians, are none, nor are polygons of a lesser solid angle.
const SLIVER: f64 = 1e-9;

/// Projected solid angle of a spherical polygon, counter-clockwise seen from outside (Lambert).
fn whole(polygon: &[DVec3]) -> f64 {
    let edge = |(i, from): (usize, &DVec3)| {
        let to = polygon[(i + 1) % polygon.len()];
        let normal = from.cross(to);
        let sine = normal.length();
        if sine > 0.0 { 0.5 * sine.atan2(from.dot(to)) * normal.z / sine } else { 0.0 }
    };
    polygon.iter().enumerate().map(edge).sum()
}

/// Projected solid angle of a convex spherical polygon, counter-clockwise seen from outside, within the angle `theta` of the
/// pole: ½∮ (r × dr)·z along what remains of its edges and along the circle between them.
fn within(polygon: &[DVec3], theta: f64) -> f64 {
    if polygon.len() < 3 || theta <= 0.0 {
        return 0.0;
    }
    let height = theta.cos();
    if height < HORIZON {
        return whole(polygon);
    }
    let mut area = 0.0;
    // Where edges leave the circle, and where they come back, in their order.
    let mut crossings: Vec<(DVec3, bool)> = Vec::new();
    let mut any_inside = false;
    for (i, &from) in polygon.iter().enumerate() {
        let to = polygon[(i + 1) % polygon.len()];
        let normal = from.cross(to);
        let sine = normal.length();
        if sine == 0.0 {
            continue;
        }
        let (length, normal) = (sine.atan2(from.dot(to)), normal / sine);
        // Height along the edge: A cos t + B sin t.
        let (a, b) = (from.z, normal.cross(from).z);
        let point = |t: f64| t.cos() * from + t.sin() * normal.cross(from);
        let (most, middle) = (a.hypot(b), b.atan2(a));
        let half = if most > height { (height / most).clamp(-1.0, 1.0).acos() } else { 0.0 };
        let (enters, leaves) = (middle - half, middle + half);
        // Told by the corners, so that one on the circle is in or out for both of its edges.
        let (first, last) = match (from.z >= height, to.z >= height) {
            (true, true) => (0.0, length),
            (true, false) => (0.0, leaves.clamp(0.0, length)),
            (false, true) => (enters.clamp(0.0, length), length),
            (false, false) if enters > 0.0 && leaves < length && enters < leaves => (enters, leaves),
            (false, false) => continue,
        };
        any_inside = true;
        area += 0.5 * normal.z * (last - first);
        if from.z < height {
            crossings.push((point(first), false));
        }
        if to.z < height {
            crossings.push((point(last), true));
        }
    }
    let circle = 0.5 * theta.sin().powi(2);
    if crossings.is_empty() {
        let left = |(i, from): (usize, &DVec3)| from.cross(polygon[(i + 1) % polygon.len()]).z >= 0.0;
        let holds_pole = || polygon.iter().enumerate().all(left) && whole(polygon) > SLIVER;
        return match any_inside {
            true => area,
            false if holds_pole() => circle * 2.0 * PI,
            false => 0.0,
        };
    }
    // From each place where an edge leaves, the circle goes on to where the next one comes back.
    for (i, (out, _)) in crossings.iter().enumerate().filter(|(_, c)| c.1) {
        let (back, _) = crossings[(i + 1) % crossings.len()];
        let turn = (out.x * back.y - out.y * back.x).atan2(out.x * back.x + out.y * back.y);
        // Slivers have ends that are the same but for rounding.
        area += circle * if turn < -SLIVER { turn + 2.0 * PI } else { turn };
    }
    area
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rings of 15 and 20 patches and a cap: every facet is divided among them without remainder.
    fn patches() -> Vec<Patch> {
        let ring = |theta: [f64; 2], n: u32| {
            let step = 2.0 * PI / f64::from(n);
            (0..n).map(move |k| {
                let middle = f64::from(k) * step;
                Patch { theta, phi: Some([middle - 0.5 * step, middle + 0.5 * step]) }
            })
        };
        let cap = Patch { theta: [0.0, 0.1], phi: None };
        [cap].into_iter().chain(ring([0.1, 0.7], 15)).chain(ring([0.7, 0.5 * PI], 20)).collect()
    }

    #[test]
    fn patches_share_each_facet() {
        let all = patches();
        let whole: f64 = all.iter().map(Patch::projected_solid_angle).sum();
        assert!((whole - PI).abs() < 1e-12);
        for level in 1..=4 {
            let mut of_patch = vec![[0.0; 2]; all.len()];
            for facet in Facet::all(level) {
                let side = usize::from(facet.center().z < 0.0);
                let parts: Vec<f64> = all.iter().map(|p| p.covers(facet, 0.3)).collect();
                let sum: f64 = parts.iter().sum();
                let whole = facet.projected_solid_angle();
                assert!((sum - whole).abs() < 1e-12, "{facet:?}: {sum} of {whole}");
                of_patch.iter_mut().zip(parts).for_each(|(sum, part)| sum[side] += part);
            }
            for (patch, sums) in all.iter().zip(of_patch) {
                assert!(sums.iter().all(|s| (s - patch.projected_solid_angle()).abs() < 1e-12), "{patch:?} {sums:?}");
            }
        }
    }

    /// Turned by parts of the circle, corners of facets come to lie on the sides of patches.
    #[test]
    fn corners_on_sides_do_no_harm() {
        let step = 2.0 * PI / 12.0;
        let side = |k: f64| Patch { theta: [0.5, 1.1], phi: Some([(k - 0.5) * step, (k + 0.5) * step]) };
        let ring: Vec<Patch> = (0..12).map(|k| side(f64::from(k))).collect();
        for facet in (1..=3).flat_map(Facet::all) {
            for turn in (0..60).map(|i| f64::from(6 * i).to_radians()) {
                let whole = Patch { theta: [0.5, 1.1], phi: None }.covers(facet, turn);
                let sum: f64 = ring.iter().map(|p| p.covers(facet, turn)).sum();
                assert!((sum - whole).abs() < 1e-12, "{facet:?} {turn}: {sum} of {whole}");
                assert!(whole <= facet.projected_solid_angle() + 1e-12, "{facet:?} {turn}");
            }
        }
    }

    /// Against counting of points, on a facet that holds the pole of the patches' circles and on others.
    #[test]
    fn overlaps_are_those_of_points() {
        let patch = Patch { theta: [0.2, 0.6], phi: Some([-0.4, 0.9]) };
        for facet in Facet::all(1).filter(|f| f.center().z > 0.3) {
            let mut fine = vec![facet];
            for _ in 0..6 {
                fine = fine.into_iter().flat_map(Facet::children).collect();
            }
            let inside = |d: DVec3| {
                let (theta, phi) = (d.z.acos(), d.y.atan2(d.x));
                (0.2..0.6).contains(&theta) && (-0.4..0.9).contains(&phi)
            };
            let counted: f64 = fine.iter().filter(|f| inside(f.center())).map(|f| f.projected_solid_angle()).sum();
            assert!((counted - patch.covers(facet, 0.0)).abs() < 2e-3, "{facet:?}: {counted}");
        }
    }
}
