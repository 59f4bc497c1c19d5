//! The geodesic dome: an icosahedron with vertices at the poles, its faces divided into four at the middles of
//! their edges, again and again. From level 1 on the equator is a union of edges, so no facet sees both
//! reflection and transmission.

use std::hint::select_unpredictable;

use glam::DVec3;

/// A facet: its level and its number there, `20·4^level` in all. The children of `code` are `4·code + 0..4`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Facet {
    /// Number of divisions.
    pub level: u8,
    /// Number among its level.
    pub code: u32,
}

/// Finest level taken.
pub const FINEST_LEVEL: u8 = 9;

impl Facet {
    /// The facet that was divided to make this one.
    pub fn parent(self) -> Option<Self> {
        (self.level > 0).then(|| Self { level: self.level - 1, code: self.code / 4 })
    }

    /// The four parts of this facet.
    pub fn children(self) -> [Self; 4] {
        [0, 1, 2, 3].map(|i| Self { level: self.level + 1, code: 4 * self.code + i })
    }

    /// All facets of a level.
    pub fn all(level: u8) -> impl Iterator<Item = Self> {
        (0..count(level)).map(move |code| Self { level, code })
    }

    /// Corners on the unit sphere, counter-clockwise seen from outside.
    pub fn corners(self) -> [DVec3; 3] {
        let mut corners = roots()[(self.code >> (2 * self.level)) as usize];
        for step in (0..self.level).rev() {
            corners = divide(corners)[(self.code >> (2 * step) & 3) as usize];
        }
        corners
    }

    /// Direction of the centre.
    pub fn center(self) -> DVec3 {
        self.corners().into_iter().sum::<DVec3>().normalize()
    }

    /// Solid angle, sr (Van Oosterom and Strackee, IEEE Trans. Biomed. Eng. 30, 125 (1983), eq. 8).
    pub fn solid_angle(self) -> f64 {
        let [a, b, c] = self.corners();
        2.0 * a.dot(b.cross(c)).atan2(1.0 + a.dot(b) + b.dot(c) + c.dot(a))
    }

    /// Projected solid angle ∫ |cos θ| dω, sr (Lambert's formula for spherical polygons). Exact from level 1 on,
    /// where no facet reaches over the equator.
    pub fn projected_solid_angle(self) -> f64 {
        let [a, b, c] = self.corners();
        let edge = |p: DVec3, q: DVec3| {
            let n = p.cross(q);
            // The angle from both sine and cosine: small angles keep their digits.
            0.5 * n.length().atan2(p.dot(q)) * n.z / n.length()
        };
        (edge(a, b) + edge(b, c) + edge(c, a)).abs()
    }
}

/// Number of facets of a level.
pub fn count(level: u8) -> u32 {
    20 << (2 * level)
}

/// The faces of the icosahedron.
fn roots() -> [[DVec3; 3]; 20] {
    let z = 1.0 / 5f64.sqrt();
    let r = 2.0 * z;
    let ring = |k: usize, up: bool| {
        // Built from one half by mirroring, so that the two rings have exactly opposite heights.
        let angle =
            std::f64::consts::PI / 5.0 * (2 * (k % 5)) as f64 + if up { 0.0 } else { std::f64::consts::PI / 5.0 };
        DVec3::new(r * angle.cos(), r * angle.sin(), if up { z } else { -z })
    };
    let (north, south) = (DVec3::Z, DVec3::NEG_Z);
    let mut faces = [[DVec3::ZERO; 3]; 20];
    for k in 0..5 {
        let (u0, u1, d0, d1) = (ring(k, true), ring(k + 1, true), ring(k, false), ring(k + 1, false));
        faces[k] = [north, u0, u1];
        faces[5 + k] = [u0, d0, u1];
        faces[10 + k] = [d0, d1, u1];
        faces[15 + k] = [south, d1, d0];
    }
    faces
}

/// The parts of a facet: one at each corner, then the middle.
fn divide([a, b, c]: [DVec3; 3]) -> [[DVec3; 3]; 4] {
    let middle = |p: DVec3, q: DVec3| (p + q).normalize();
    let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
    [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
}

/// Finds the facet of a direction.
#[derive(Clone, Debug)]
pub struct Locator {
    level: u8,
    centers: [DVec3; 20],
    /// For each facet above the finest level, by level and code: normals of the planes that cut off its corners,
    /// towards the corners.
    cuts: Vec<[DVec3; 3]>,
}

impl Locator {
    /// For facets of `level`.
    pub fn new(level: u8) -> Self {
        let mut cuts = Vec::with_capacity((0..level).map(|l| count(l) as usize).sum());
        let mut facets = roots().to_vec();
        let centers = roots().map(|r| (r[0] + r[1] + r[2]).normalize());
        for _ in 0..level {
            let mut next = Vec::with_capacity(4 * facets.len());
            for corners in facets {
                let parts = divide(corners);
                cuts.push([0, 1, 2].map(|i| cut(corners[i], &parts[3], i)));
                next.extend(parts);
            }
            facets = next;
        }
        Self { level, centers, cuts }
    }

    /// The level of the facets found.
    pub fn level(&self) -> u8 {
        self.level
    }

    /// Number of the facet that holds a direction (of any length).
    pub fn code(&self, dir: DVec3) -> u32 {
        let mut code = self.root(dir);
        let mut first = 0;
        for level in 0..self.level {
            let beyond = self.cuts[(first + code) as usize].map(|n| n.dot(dir) > 0.0);
            let part = select_unpredictable(
                beyond[0],
                0,
                select_unpredictable(beyond[1], 1, select_unpredictable(beyond[2], 2, 3)),
            );
            first += count(level);
            code = 4 * code + part;
        }
        code
    }

    /// The facet of level 0 whose centre is nearest, or the first of them.
    #[inline(always)]
    fn root(&self, dir: DVec3) -> u32 {
        // Neighbours first, then the winners: few comparisons wait for each other.
        let nearer = |a: (f64, u32), b: (f64, u32)| select_unpredictable(b.0 > a.0, b, a);
        let at = |i: usize| (self.centers[i].dot(dir), i as u32);
        let pairs: [_; 10] = std::array::from_fn(|i| nearer(at(2 * i), at(2 * i + 1)));
        let fours: [_; 5] = std::array::from_fn(|i| nearer(pairs[2 * i], pairs[2 * i + 1]));
        fours.into_iter().fold((f64::NEG_INFINITY, 0), nearer).1
    }
}

/// Normal of the plane through the two middles next to corner `i`, towards it.
fn cut(corner: DVec3, [ab, bc, ca]: &[DVec3; 3], i: usize) -> DVec3 {
    let n = match i {
        0 => ab.cross(*ca),
        1 => bc.cross(*ab),
        _ => ca.cross(*bc),
    };
    if n.dot(corner) < 0.0 { -n } else { n }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use rand::rngs::Xoshiro256PlusPlus;
    use rand::{RngExt, SeedableRng};

    use super::*;

    fn random(rng: &mut Xoshiro256PlusPlus) -> DVec3 {
        loop {
            let v = DVec3::from_array(std::array::from_fn(|_| 2.0 * rng.random::<f64>() - 1.0));
            if v.length_squared() < 1.0 {
                return v.normalize();
            }
        }
    }

    #[test]
    fn solid_angles_fill_the_sphere() {
        for level in 0..=5 {
            let sum: f64 = Facet::all(level).map(Facet::solid_angle).sum();
            assert!((sum - 4.0 * PI).abs() < 1e-9, "{level}: {sum}");
            if level > 0 {
                let projected: f64 = Facet::all(level).map(Facet::projected_solid_angle).sum();
                assert!((projected - 2.0 * PI).abs() < 1e-9, "{level}: {projected}");
            }
        }
    }

    #[test]
    fn children_fill_their_parent() {
        for parent in Facet::all(2) {
            let children = parent.children();
            let sum = |f: fn(Facet) -> f64| children.map(f).iter().sum::<f64>();
            assert!((sum(Facet::solid_angle) - parent.solid_angle()).abs() < 1e-14);
            assert!((sum(Facet::projected_solid_angle) - parent.projected_solid_angle()).abs() < 1e-14);
            assert!(children.iter().all(|c| c.parent() == Some(parent)));
        }
    }

    #[test]
    fn no_facet_sees_both_sides() {
        for level in 1..=5 {
            for facet in Facet::all(level) {
                let z = facet.corners().map(|c| c.z);
                assert!(z.iter().all(|&z| z >= 0.0) || z.iter().all(|&z| z <= 0.0), "{facet:?} {z:?}");
            }
        }
    }

    #[test]
    fn directions_lie_in_their_facet() {
        let locator = Locator::new(5);
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(5);
        for i in 0..20_000 {
            let mut dir = random(&mut rng);
            if i % 4 == 0 {
                dir.z *= 1e-17;
            }
            let facet = Facet { level: 5, code: locator.code(dir) };
            let [a, b, c] = facet.corners();
            for (p, q) in [(a, b), (b, c), (c, a)] {
                assert!(p.cross(q).dot(dir) > -1e-15, "{dir} is not in {facet:?}");
            }
            assert!(facet.center().z * dir.z > 0.0);
        }
    }

    #[test]
    fn a_uniform_source_fills_facets_by_solid_angle() {
        // χ² over 320 facets of level 2 with 10⁶ directions: 319 degrees of freedom exceed 402 with
        // probability 0.1 %.
        let locator = Locator::new(2);
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(6);
        let mut hits = vec![0f64; count(2) as usize];
        for _ in 0..1_000_000 {
            hits[locator.code(random(&mut rng)) as usize] += 1.0;
        }
        let chi2: f64 = Facet::all(2)
            .map(|f| {
                let expected = 1e6 * f.solid_angle() / (4.0 * PI);
                (hits[f.code as usize] - expected).powi(2) / expected
            })
            .sum();
        assert!(chi2 < 402.0, "{chi2}");
    }
}
