//! Surfaces of triangles: whether they are closed, which side is out, what lies within what.

use std::collections::{HashMap, HashSet};

use glam::DVec3;

use crate::geometry::Aabb;

/// A surface of triangles.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Corners, µm.
    pub vertices: Vec<DVec3>,
    /// Indices of corners, counter-clockwise seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

/// Why a surface encloses no body.
#[derive(Clone, Debug, PartialEq)]
pub enum NotClosed {
    /// Edges that belong to an odd number of triangles.
    Open {
        /// How many.
        edges: usize,
        /// The first of them.
        first: [DVec3; 2],
    },
    /// Neighbouring triangles that cannot be turned the same way round.
    Inconsistent {
        /// An edge between two such triangles.
        edge: [DVec3; 2],
    },
    /// No triangle at all.
    Empty,
}

impl std::fmt::Display for NotClosed {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let show = |p: DVec3| format!("({} {} {})", p.x, p.y, p.z);
        match self {
            Self::Open { edges, first: [a, b] } => {
                let edges = if *edges == 1 { "1 edge belongs".into() } else { format!("{edges} edges belong") };
                write!(f, "{edges} to one triangle only, the first from {} to {}", show(*a), show(*b))
            }
            Self::Inconsistent { edge: [a, b] } => {
                write!(f, "triangles are wound differently at the edge from {} to {}", show(*a), show(*b))
            }
            Self::Empty => f.write_str("it has no triangles"),
        }
    }
}

impl Mesh {
    /// Every corner mapped.
    #[must_use]
    pub fn map(mut self, f: impl Fn(DVec3) -> DVec3) -> Self {
        self.vertices.iter_mut().for_each(|v| *v = f(*v));
        self
    }

    /// A box; its six faces are two triangles each.
    pub fn cuboid(min: DVec3, max: DVec3) -> Self {
        let corner = |i: usize| DVec3::new([min, max][i & 1].x, [min, max][i >> 1 & 1].y, [min, max][i >> 2].z);
        let triangles = CUBOID_FACES.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
        Self { vertices: (0..8).map(corner).collect(), triangles }
    }

    /// Adds the triangles of another surface.
    pub fn append(&mut self, other: &Self) {
        let first = self.vertices.len() as u32;
        self.vertices.extend(&other.vertices);
        self.triangles.extend(other.triangles.iter().map(|t| t.map(|i| i + first)));
    }

    /// Bounds, µm.
    pub fn bounds(&self) -> Aabb {
        self.bounds_of(&self.triangles)
    }

    fn bounds_of(&self, part: &[[u32; 3]]) -> Aabb {
        Aabb::around(part.iter().flatten().map(|&i| self.vertices[i as usize]))
    }

    /// The corners of a triangle.
    pub fn corners(&self, triangle: [u32; 3]) -> [DVec3; 3] {
        triangle.map(|i| self.vertices[i as usize])
    }

    /// The same surface with corners at equal positions made one, closed, and wound so that every part encloses
    /// a body (a part within another of the same mesh may be wound the other way: a cavity).
    ///
    /// # Errors
    /// When it encloses none.
    pub fn closed(&self) -> Result<Self, NotClosed> {
        if self.triangles.is_empty() {
            return Err(NotClosed::Empty);
        }
        let mut mesh = self.welded();
        mesh.check_edges()?;
        if mesh.first_unbalanced_edge().is_some() {
            mesh.wind_consistently();
            if let Some(edge) = mesh.first_unbalanced_edge() {
                return Err(NotClosed::Inconsistent { edge });
            }
        }
        mesh.turn_outwards();
        Ok(mesh)
    }

    /// Corners at bit-equal positions made one; triangles that lost a corner left out.
    fn welded(&self) -> Self {
        let mut known = HashMap::new();
        let mut out = Self::default();
        let index: Vec<u32> = self
            .vertices
            .iter()
            .map(|v| {
                // + 0.0 makes one zero of both.
                let key = (*v + 0.0).to_array().map(f64::to_bits);
                *known.entry(key).or_insert_with(|| {
                    out.vertices.push(*v);
                    out.vertices.len() as u32 - 1
                })
            })
            .collect();
        let triangles = self.triangles.iter().map(|t| t.map(|i| index[i as usize]));
        out.triangles = triangles.filter(|[a, b, c]| a != b && b != c && c != a).collect();
        out
    }

    fn edge(&self, (a, b): (u32, u32)) -> [DVec3; 2] {
        [a, b].map(|i| self.vertices[i as usize])
    }

    fn check_edges(&self) -> Result<(), NotClosed> {
        let mut count: HashMap<(u32, u32), u32> = HashMap::new();
        for (a, b) in self.directed_edges() {
            *count.entry((a.min(b), a.max(b))).or_default() += 1;
        }
        let mut open: Vec<_> = count.into_iter().filter(|(_, n)| n % 2 == 1).map(|(e, _)| e).collect();
        open.sort_unstable();
        match open.first() {
            None => Ok(()),
            Some(&first) => Err(NotClosed::Open { edges: open.len(), first: self.edge(first) }),
        }
    }

    fn directed_edges(&self) -> impl Iterator<Item = (u32, u32)> + '_ {
        self.triangles.iter().flat_map(|&[a, b, c]| [(a, b), (b, c), (c, a)])
    }

    /// An edge passed more often in one direction than in the other.
    fn first_unbalanced_edge(&self) -> Option<[DVec3; 2]> {
        let mut balance: HashMap<(u32, u32), i32> = HashMap::new();
        for (a, b) in self.directed_edges() {
            *balance.entry((a.min(b), a.max(b))).or_default() += if a < b { 1 } else { -1 };
        }
        balance.into_iter().filter(|(_, n)| *n != 0).map(|(e, _)| e).min().map(|e| self.edge(e))
    }

    /// Turns triangles so that neighbours across an edge of two agree.
    fn wind_consistently(&mut self) {
        let mut at_edge: HashMap<(u32, u32), Vec<usize>> = HashMap::new();
        for (i, [a, b, c]) in self.triangles.iter().enumerate() {
            for (p, q) in [(a, b), (b, c), (c, a)] {
                at_edge.entry((*p.min(q), *p.max(q))).or_default().push(i);
            }
        }
        let mut done = vec![false; self.triangles.len()];
        for start in 0..self.triangles.len() {
            let mut queue = vec![start];
            while let Some(i) = queue.pop() {
                if std::mem::replace(&mut done[i], true) {
                    continue;
                }
                let [a, b, c] = self.triangles[i];
                for (p, q) in [(a, b), (b, c), (c, a)] {
                    if let [m, n] = at_edge[&(p.min(q), p.max(q))][..] {
                        let other = m + n - i;
                        if !done[other] {
                            let [x, y, z] = self.triangles[other];
                            let same_way = [(x, y), (y, z), (z, x)].contains(&(p, q));
                            self.triangles[other] = if same_way { [x, z, y] } else { [x, y, z] };
                            queue.push(other);
                        }
                    }
                }
            }
        }
    }

    /// Turns parts with negative volume round, unless they are cavities of another part.
    fn turn_outwards(&mut self) {
        let parts: Vec<Vec<[u32; 3]>> =
            self.parts().into_iter().map(|p| p.into_iter().map(|i| self.triangles[i]).collect()).collect();
        let bounds: Vec<Aabb> = parts.iter().map(|p| self.bounds_of(p)).collect();
        let inside_out: Vec<usize> = (0..parts.len()).filter(|&i| self.volume_of(&parts[i]) < 0.0).collect();
        let wrong = inside_out.into_iter().filter(|&i| {
            let probe = self.vertices[parts[i][0][0] as usize];
            let around = |j: usize| j != i && bounds[j].contains(probe) && self.part_encloses(&parts[j], probe);
            !(0..parts.len()).any(around)
        });
        let wrong: HashSet<[u32; 3]> = wrong.flat_map(|i| parts[i].iter().copied()).collect();
        self.triangles.iter_mut().filter(|t| wrong.contains(*t)).for_each(|t| t.swap(1, 2));
    }

    /// Triangles by connected part.
    fn parts(&self) -> Vec<Vec<usize>> {
        let mut root: Vec<u32> = (0..self.vertices.len() as u32).collect();
        fn find(root: &mut [u32], mut i: u32) -> u32 {
            while root[i as usize] != i {
                root[i as usize] = root[root[i as usize] as usize];
                i = root[i as usize];
            }
            i
        }
        for &[a, b, c] in &self.triangles {
            for other in [b, c] {
                let (x, y) = (find(&mut root, a), find(&mut root, other));
                root[x.max(y) as usize] = x.min(y);
            }
        }
        let mut parts: Vec<(u32, Vec<usize>)> = Vec::new();
        let mut place = HashMap::new();
        for (i, t) in self.triangles.iter().enumerate() {
            let r = find(&mut root, t[0]);
            let at = *place.entry(r).or_insert_with(|| {
                parts.push((r, Vec::new()));
                parts.len() - 1
            });
            parts[at].1.push(i);
        }
        parts.into_iter().map(|(_, p)| p).collect()
    }

    /// Enclosed volume, µm³; negative if wound inwards.
    pub fn volume(&self) -> f64 {
        self.volume_of(&self.triangles)
    }

    fn volume_of(&self, part: &[[u32; 3]]) -> f64 {
        let base = part.first().map_or(DVec3::ZERO, |t| self.vertices[t[0] as usize]);
        part.iter()
            .map(|&t| {
                let [a, b, c] = self.corners(t).map(|p| p - base);
                a.dot(b.cross(c)) / 6.0
            })
            .sum()
    }

    /// Whether `p` lies inside the closed surface: by the solid angle it fills (Van Oosterom and Strackee, IEEE
    /// Trans. Biomed. Eng. 30, 125 (1983), eq. 8).
    pub fn encloses(&self, p: DVec3) -> bool {
        self.part_encloses(&self.triangles, p)
    }

    fn part_encloses(&self, part: &[[u32; 3]], p: DVec3) -> bool {
        let solid_angle: f64 = part
            .iter()
            .map(|&t| {
                let [a, b, c] = self.corners(t).map(|q| q - p);
                let (la, lb, lc) = (a.length(), b.length(), c.length());
                let numerator = a.dot(b.cross(c));
                2.0 * numerator.atan2(la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb)
            })
            .sum();
        solid_angle.abs() > std::f64::consts::TAU
    }
}

/// The faces of a box as quadrilaterals, outwards, for corners numbered by bits x, y, z.
pub const CUBOID_FACES: [[u32; 4]; 6] =
    [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_is_closed_and_any_damage_shows() {
        let cube = Mesh::cuboid(DVec3::ZERO, DVec3::ONE);
        assert_eq!(cube.closed().unwrap(), cube);
        assert!((cube.volume() - 1.0).abs() < 1e-15);
        assert!(cube.encloses(DVec3::splat(0.5)) && !cube.encloses(DVec3::splat(1.5)));

        let mut open = cube.clone();
        open.triangles.pop();
        assert!(matches!(open.closed(), Err(NotClosed::Open { edges: 3, .. })));

        let mut inside_out = cube.clone();
        inside_out.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        assert!((inside_out.closed().unwrap().volume() - 1.0).abs() < 1e-15);

        let mut muddled = cube.clone();
        muddled.triangles[3].swap(0, 1);
        muddled.triangles[8].swap(0, 1);
        assert!((muddled.closed().unwrap().volume() - 1.0).abs() < 1e-15);
    }

    #[test]
    fn cavities_stay_and_corners_are_welded() {
        let mut soup = Mesh::default();
        let cube = Mesh::cuboid(DVec3::ZERO, DVec3::splat(4.0));
        for &t in &cube.triangles {
            let corners = cube.corners(t);
            soup.append(&Mesh { vertices: corners.to_vec(), triangles: vec![[0, 1, 2]] });
        }
        let mut hole = Mesh::cuboid(DVec3::ONE, DVec3::splat(2.0));
        hole.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        soup.append(&hole);
        let closed = soup.closed().unwrap();
        assert_eq!(closed.vertices.len(), 16);
        assert!((closed.volume() - 63.0).abs() < 1e-12);
    }
}
