//! Polarization ray tracing in global coordinates: a plain tracer of its own that follows whole trees.
//!
//! Each ray has a 3×3 matrix that takes the electric field of the incident wave to its own (Yun, McClain and Chipman,
//! Appl. Opt. 50, 2855 (2011)): power-normalised, without the phase of the way. No ray has a frame.

use glam::DVec3;
use num_complex::Complex;

pub type C64 = Complex<f64>;

/// A complex electric field.
pub type Field = [C64; 3];

/// Rows of a matrix that acts on fields.
pub type Matrix = [[C64; 3]; 3];

pub const IDENTITY: Matrix = {
    let (o, i) = (C64::ZERO, C64::ONE);
    [[i, o, o], [o, i, o], [o, o, i]]
};

/// A body of transparent matter.
pub struct Solid {
    pub form: Form,
    pub index: f64,
    /// The highest decides where solids overlap.
    pub priority: i32,
}

pub enum Form {
    Ball {
        center: DVec3,
        radius: f64,
    },
    /// What lies behind all of its planes: outward normals, and where they are along them.
    Convex(Vec<(DVec3, f64)>),
}

/// Solids in a medium.
pub struct World {
    pub around: f64,
    pub solids: Vec<Solid>,
}

/// A ray that has left.
pub struct Exit {
    /// A point of its line.
    pub at: DVec3,
    pub dir: DVec3,
    /// From the field of the incident wave to that of this one.
    pub matrix: Matrix,
    /// Interfaces on its way.
    pub depth: u32,
}

/// Crossings nearer than this are the one where the ray starts, µm.
const NEAR: f64 = 1e-9;
/// How far before and behind a crossing its media are looked for, µm.
const STEP: f64 = 1e-7;
/// Interfaces in a row; what meets more is given up.
pub const DEEPEST: u32 = 100;

/// A field of two real directions: a·u + b·v.
pub fn field(a: C64, u: DVec3, b: C64, v: DVec3) -> Field {
    std::array::from_fn(|i| a * u[i] + b * v[i])
}

/// The field behind a matrix.
pub fn apply(m: &Matrix, e: &Field) -> Field {
    m.map(|row| row.iter().zip(e).map(|(a, b)| a * b).sum())
}

/// The component of a field along a real direction.
pub fn along(e: &Field, u: DVec3) -> C64 {
    e[0] * u.x + e[1] * u.y + e[2] * u.z
}

pub fn power(e: &Field) -> f64 {
    e.iter().map(C64::norm_sqr).sum()
}

fn times(a: &Matrix, b: &Matrix) -> Matrix {
    a.map(|row| std::array::from_fn(|j| (0..3).map(|k| row[k] * b[k][j]).sum()))
}

impl Form {
    pub fn contains(&self, p: DVec3) -> bool {
        match self {
            Self::Ball { center, radius } => p.distance(*center) < *radius,
            Self::Convex(planes) => planes.iter().all(|(normal, d)| normal.dot(p) < *d),
        }
    }

    /// Distances along a ray, with outward normals there.
    fn crossings(&self, from: DVec3, dir: DVec3) -> Vec<(f64, DVec3)> {
        match self {
            Self::Ball { center, radius } => {
                let middle = dir.dot(center - from);
                let off = from + middle * dir - center;
                let half2 = (radius - off.length()) * (radius + off.length());
                let half = if half2 > 0.0 { half2.sqrt() } else { return Vec::new() };
                [middle - half, middle + half].map(|t| (t, (from + t * dir - center) / radius)).to_vec()
            }
            Self::Convex(planes) => {
                let (mut first, mut last) = ((f64::NEG_INFINITY, DVec3::ZERO), (f64::INFINITY, DVec3::ZERO));
                for &(normal, d) in planes {
                    let (t, slope) = ((d - normal.dot(from)) / normal.dot(dir), normal.dot(dir));
                    if slope < 0.0 && t > first.0 {
                        first = (t, normal);
                    } else if slope > 0.0 && t < last.0 {
                        last = (t, normal);
                    }
                }
                if first.0 < last.0 { vec![first, last] } else { Vec::new() }
            }
        }
    }
}

/// An interface, met by a ray.
struct Hit {
    point: DVec3,
    /// Towards the ray.
    normal: DVec3,
    n1: f64,
    n2: f64,
}

/// Directions behind an interface, with what the field is multiplied by.
type Beams = Vec<(DVec3, Matrix)>;

impl Hit {
    /// Reflection and refraction, by Fresnel.
    fn beams(&self, k: DVec3) -> Beams {
        let Self { normal, n1, n2, .. } = *self;
        let c1 = -k.dot(normal);
        let s2 = n1 / n2 * k.cross(normal).length();
        let c2 = C64::from(1.0 - s2 * s2).sqrt();
        let r_s = (n1 * c1 - n2 * c2) / (n1 * c1 + n2 * c2);
        let r_p = (n2 * c1 - n1 * c2) / (n2 * c1 + n1 * c2);
        let s = k.cross(normal);
        let s = if s.length() > 1e-12 { s.normalize() } else { k.any_orthonormal_vector() };
        let to = |dir: DVec3, a_s: C64, a_p: C64| {
            let dir = dir.normalize();
            (dir, between([s, k.cross(s), k], [s, dir.cross(s), dir], [a_s, a_p, C64::ONE]))
        };
        let mut beams = vec![to(k + 2.0 * c1 * normal, r_s, r_p)];
        if c2.im == 0.0 {
            let c2 = c2.re;
            // Normalised to power.
            let part = 2.0 * n1 * c1 * (n2 * c2 / (n1 * c1)).sqrt();
            let (t_s, t_p) = (part / (n1 * c1 + n2 * c2), part / (n2 * c1 + n1 * c2));
            beams.push(to(n1 / n2 * k + (n1 / n2 * c1 - c2) * normal, t_s.into(), t_p.into()));
        }
        beams
    }
}

/// Takes each of three directions to another, times a number.
fn between(from: [DVec3; 3], to: [DVec3; 3], by: [C64; 3]) -> Matrix {
    let element = |i: usize, j: usize| (0..3).map(|c| by[c] * to[c][i] * from[c][j]).sum();
    std::array::from_fn(|i| std::array::from_fn(|j| element(i, j)))
}

impl World {
    fn index(&self, p: DVec3) -> f64 {
        let around = self.solids.iter().filter(|s| s.form.contains(p));
        around.max_by_key(|s| s.priority).map_or(self.around, |s| s.index)
    }

    fn next(&self, from: DVec3, dir: DVec3) -> Option<Hit> {
        let mut crossings: Vec<(f64, DVec3)> = self.solids.iter().flat_map(|s| s.form.crossings(from, dir)).collect();
        crossings.retain(|(t, _)| *t > NEAR);
        crossings.sort_by(|a, b| a.0.total_cmp(&b.0));
        let hit = |(t, normal): (f64, DVec3)| Hit {
            point: from + t * dir,
            normal: if normal.dot(dir) > 0.0 { -normal } else { normal },
            n1: self.index(from + (t - STEP) * dir),
            n2: self.index(from + (t + STEP) * dir),
        };
        crossings.into_iter().map(hit).find(|h| h.n1 != h.n2)
    }

    /// All exits of the tree of a ray, but for branches in which the incident fields, which do not interfere, have less
    /// than `faintest` power.
    pub fn tree(&self, from: DVec3, dir: DVec3, incident: &[Field], faintest: f64) -> Vec<Exit> {
        let mut exits = Vec::new();
        let mut rays = vec![Exit { at: from, dir, matrix: IDENTITY, depth: 0 }];
        while let Some(ray) = rays.pop() {
            let Some(hit) = self.next(ray.at, ray.dir) else {
                exits.push(ray);
                continue;
            };
            if ray.depth == DEEPEST {
                continue;
            }
            for (dir, by) in hit.beams(ray.dir) {
                let matrix = times(&by, &ray.matrix);
                if incident.iter().map(|e| power(&apply(&matrix, e))).sum::<f64>() >= faintest {
                    rays.push(Exit { at: hit.point, dir, matrix, depth: ray.depth + 1 });
                }
            }
        }
        exits
    }
}
