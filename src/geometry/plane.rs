//! Planes, and which faces share one.

use glam::DVec3;
use rustc_hash::FxHashMap;

use super::Ray;

/// Faces closer than this lie in one plane, µm (a picometre of a micrometre: far above rounding, far below
/// any film).
pub const COINCIDENT: f64 = 1e-9;

/// The plane n·x = offset.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Unit normal.
    pub normal: DVec3,
    /// Signed distance from the origin, µm.
    pub offset: f64,
}

impl Plane {
    /// Distance along the ray; infinite or NaN when parallel. The one formula for every planar face, so that
    /// coincident faces are met at bit-equal distances.
    #[inline]
    pub fn distance(&self, ray: &Ray) -> f64 {
        (self.offset - self.normal.dot(ray.origin)) / self.normal.dot(ray.dir)
    }

    /// The nearest point of the plane to `p`.
    pub fn project(&self, p: DVec3) -> DVec3 {
        p + (self.offset - self.normal.dot(p)) * self.normal
    }

    /// Whether the normal is a coordinate axis, exactly.
    pub fn is_axis_aligned(&self) -> bool {
        self.normal.max_element() == 1.0
    }

    fn height(&self, p: DVec3) -> f64 {
        self.normal.dot(p) - self.offset
    }
}

/// Collects planes, giving coplanar faces the same index.
pub(super) struct PlaneSet {
    planes: Vec<Plane>,
    /// The latest plane of a cell.
    cells: FxHashMap<[i64; 4], u32>,
    /// For each plane, the one before it in its cell.
    before: Vec<Option<u32>>,
}

impl PlaneSet {
    /// Cell sizes of the look-up: direction, and offset in µm.
    const CELL: [f64; 4] = [1e-5, 1e-5, 1e-5, 1e-3];

    /// How far two planes that could be one lie apart in these at most.
    const REACH: [f64; 4] = [1e-6, 1e-6, 1e-6, 1e-4];

    /// Planes of a cell that are compared, the latest: a gentle relief has thousands that are nearly, not quite, one.
    const MOST: usize = 256;

    /// Room for so many planes.
    pub fn with_capacity(planes: usize) -> Self {
        let cells = FxHashMap::with_capacity_and_hasher(planes, Default::default());
        Self { planes: Vec::with_capacity(planes), cells, before: Vec::with_capacity(planes) }
    }

    /// The index of the plane through `points` with unit normal `normal`, and whether `normal` points against
    /// the normal of the stored plane.
    pub fn add(&mut self, normal: DVec3, points: &[DVec3]) -> (u32, bool) {
        let flipped = points_down(normal);
        let normal = if flipped { -normal } else { normal };
        let normal = level_axis(points).filter(|a| a.dot(normal) > 0.5).unwrap_or(normal);
        let plane = Plane { normal, offset: normal.dot(points[0]) };
        let index = self.find(&plane, points).unwrap_or_else(|| self.push(plane));
        (index, flipped)
    }

    /// All planes, by index.
    pub fn into_planes(self) -> Vec<Plane> {
        self.planes
    }

    fn push(&mut self, plane: Plane) -> u32 {
        let index = u32::try_from(self.planes.len()).expect("fewer than 2^32 planes");
        self.planes.push(plane);
        self.before.push(self.cells.insert(cell(&plane, [0.0; 4]), index));
        index
    }

    /// Looks in the cell of `plane` and, where it lies close to a border, in the neighbouring cells.
    fn find(&self, plane: &Plane, points: &[DVec3]) -> Option<u32> {
        let [low, high] = [-1.0, 1.0].map(|side| cell(plane, Self::REACH.map(|reach| side * reach)));
        // Which of the two along each axis, and both only where they differ.
        let corners = (0..16).filter(|corner| (0..4).all(|i| corner >> i & 1 == 0 || low[i] != high[i]));
        let mut cells = corners.map(|corner| std::array::from_fn(|i| if corner >> i & 1 == 0 { low } else { high }[i]));
        cells.find_map(|cell| {
            let latest = std::iter::successors(self.cells.get(&cell), |&&i| self.before[i as usize].as_ref());
            latest.take(Self::MOST).copied().find(|&i| {
                let other = &self.planes[i as usize];
                other.is_axis_aligned() == plane.is_axis_aligned()
                    && other.normal.dot(plane.normal) > 0.999_999
                    && points.iter().all(|&p| other.height(p).abs() <= COINCIDENT)
            })
        })
    }
}

/// The coordinate axis along which all `points` lie at one height, if there is one: such planes get exactly
/// that normal, so that every shape meets them at the same distance.
fn level_axis(points: &[DVec3]) -> Option<DVec3> {
    DVec3::AXES.into_iter().find(|a| points.iter().all(|p| a.dot(*p - points[0]).abs() <= COINCIDENT))
}

fn cell(plane: &Plane, nudge: [f64; 4]) -> [i64; 4] {
    let v = [plane.normal.x, plane.normal.y, plane.normal.z, plane.offset];
    std::array::from_fn(|i| ((v[i] + nudge[i]) / PlaneSet::CELL[i]).round() as i64)
}

/// Picks one of the two normals of a plane. The bound is no cosine of a common angle, so that rounding does not
/// make two coplanar faces choose differently.
fn points_down(n: DVec3) -> bool {
    const CLEARLY: f64 = 0.437_11;
    [n.z, n.y, n.x].into_iter().find(|c| c.abs() > CLEARLY).is_some_and(|c| c < 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coplanar_faces_share_a_plane_and_others_do_not() {
        let mut set = PlaneSet::with_capacity(0);
        let n = DVec3::new(0.3, -0.5, 0.81).normalize();
        let (u, v) = n.any_orthonormal_pair();
        let base = 7.0 * n;
        let tri = |o: DVec3| [o, o + u, o + v];
        let (a, _) = set.add(n, &tri(base));
        // The same plane, far off, from the other side, with rounding in its normal.
        let (b, flipped) = set.add((-n + 1e-16 * u).normalize(), &tri(base + 3.0 * u - 2.0 * v));
        assert_eq!(a, b);
        assert!(flipped);
        // A picometre away: another plane.
        let (c, _) = set.add(n, &tri(base + 1e-6 * n));
        assert_ne!(a, c);
    }
}
