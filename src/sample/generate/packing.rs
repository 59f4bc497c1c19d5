//! Random sequential insertion of equal spheres in a slab.

use std::fmt;

use glam::DVec3;

use super::super::description::{Body, Fill, Object, Shape};
use super::super::fill::read_fill;
use super::super::problem::Place;
use super::super::reader::Table;
use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};

/// A packing to make.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Packing {
    /// Number of spheres.
    pub count: usize,
    /// Their radius, µm.
    pub radius: f64,
    /// Edge lengths of the slab, µm; centres lie in [−w/2, w/2] × [−d/2, d/2] × [radius, h − radius].
    pub size: DVec3,
    /// Whether the slab repeats in x and y.
    pub periodic: bool,
    /// Seed.
    pub seed: u64,
}

/// Why a packing cannot be made.
#[derive(Clone, Debug, PartialEq)]
pub enum PackingError {
    /// A length is not positive, or a sphere does not fit.
    DoesNotFit(String),
    /// No place was found for the next sphere.
    Jammed {
        /// Spheres placed so far.
        placed: usize,
        /// Volume fraction reached.
        fraction: f64,
    },
}

impl fmt::Display for PackingError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::DoesNotFit(why) => f.write_str(why),
            Self::Jammed { placed, fraction } => write!(
                f,
                "no room for sphere {} (volume fraction {fraction:.3}): random insertion ends near 0.38; \
                 use fewer or smaller spheres",
                placed + 1
            ),
        }
    }
}

/// Largest number of spheres in one packing.
const MOST_SPHERES: usize = 2_000_000;

/// Beyond this share of the volume random insertion never gets: trying would only take time.
const DENSEST: f64 = 0.4;

/// Cells of the grid per sphere, at most.
const CELLS_PER_SPHERE: f64 = 8.0;

/// Tries per sphere before a packing counts as jammed.
const TRIES: usize = 200_000;

impl Packing {
    /// The centres, in order of insertion.
    ///
    /// # Errors
    /// When the spheres do not fit.
    pub fn centers(&self) -> Result<Vec<DVec3>, PackingError> {
        self.check()?;
        let mut grid = Grid::new(self);
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(self.seed);
        let low = DVec3::new(-0.5 * self.size.x, -0.5 * self.size.y, self.radius);
        let span = DVec3::new(self.size.x, self.size.y, self.size.z - 2.0 * self.radius);
        let mut centers = Vec::with_capacity(self.count);
        while centers.len() < self.count {
            let free = (0..TRIES)
                .map(|_| low + span * DVec3::new(rng.random(), rng.random(), rng.random()))
                .find(|&p| grid.is_free(p, &centers));
            let Some(p) = free else {
                return Err(PackingError::Jammed { placed: centers.len(), fraction: self.fraction(centers.len()) });
            };
            grid.insert(p, centers.len());
            centers.push(p);
        }
        Ok(centers)
    }

    /// Part of the slab's volume that `count` spheres fill.
    pub fn fraction(&self, count: usize) -> f64 {
        4.0 / 3.0 * std::f64::consts::PI * self.radius.powi(3) * count as f64 / self.size.element_product()
    }

    fn check(&self) -> Result<(), PackingError> {
        let fits = |what: &str, ok: bool| if ok { Ok(()) } else { Err(PackingError::DoesNotFit(what.into())) };
        fits("the radius must be positive", self.radius > 0.0 && self.radius.is_finite())?;
        fits("the slab's edges must be positive", self.size.min_element() > 0.0 && self.size.is_finite())?;
        fits("a sphere is thicker than the slab", 2.0 * self.radius <= self.size.z)?;
        let across = self.size.x.min(self.size.y);
        fits("a sphere is wider than the repeated slab", !self.periodic || 2.0 * self.radius <= across)?;
        if self.count > MOST_SPHERES {
            let why = format!("{:.1e} spheres: at most {MOST_SPHERES} are taken", self.count as f64);
            return Err(PackingError::DoesNotFit(why));
        }
        let share = self.fraction(self.count);
        if share > DENSEST {
            let why = format!(
                "the spheres would fill {share:.3} of the slab: random insertion ends near 0.38; use fewer or smaller spheres"
            );
            return Err(PackingError::DoesNotFit(why));
        }
        Ok(())
    }
}

/// A packing with what its spheres are made of.
#[derive(Clone, Debug, PartialEq)]
pub struct SpherePacking {
    /// Where the spheres lie, if the slab stood on z = 0.
    pub packing: Packing,
    /// Height of the slab's lower face, µm.
    pub bottom: f64,
    /// Material.
    pub fill: Fill,
    /// Priority of the spheres.
    pub priority: i32,
}

impl SpherePacking {
    /// Reads a `[[generate]]` table.
    pub(super) fn read(t: &Table<'_>) -> Option<Self> {
        let radius = t.positive_length("radius").or_else(|| t.missing_if_absent("radius", "0.5"));
        let size = t.point("size").or_else(|| t.missing_if_absent("size", "[20, 20, 10]"));
        let count = t.integer("count", 1..MOST_SPHERES as i64 + 1);
        let fraction = t.number("fraction");
        let seed = t.integer("seed", 0..i64::MAX).unwrap_or(1) as u64;
        let periodic = t.boolean("periodic").unwrap_or(true);
        let bottom = t.length("bottom").unwrap_or(0.0);
        let priority = t.integer("priority", -1_000_000..1_000_001).unwrap_or(0) as i32;
        let fill = read_fill(t);
        let mut packing = Packing { count: 0, radius: radius?, size: size?, periodic, seed };
        packing.count = match (count, fraction) {
            (Some(n), None) => n as usize,
            (None, Some(f)) if f > 0.0 && f < 1.0 => (f / packing.fraction(1)).round() as usize,
            _ => {
                t.complain("expected either `count`, such as 1000, or `fraction`, the share of the volume from 0 to 1");
                return None;
            }
        };
        Some(Self { packing, bottom, fill: fill?, priority })
    }

    /// The spheres.
    ///
    /// # Errors
    /// When they do not fit.
    pub fn objects(&self, place: &Place) -> Result<Vec<Object>, PackingError> {
        let sphere = |(i, center): (usize, DVec3)| Object {
            name: format!("sphere {}", i + 1),
            body: Body::Solid(
                Shape::Sphere { center: center + DVec3::Z * self.bottom, radius: self.packing.radius },
                self.fill.clone(),
            ),
            priority: self.priority,
            nesting: 0,
            place: place.clone(),
        };
        Ok(self.packing.centers()?.into_iter().enumerate().map(sphere).collect())
    }
}

/// Cells of at least one diameter: a sphere can only touch those in the 27 cells around it.
struct Grid<'a> {
    packing: &'a Packing,
    cells: [usize; 3],
    members: Vec<Vec<u32>>,
}

impl<'a> Grid<'a> {
    fn new(packing: &'a Packing) -> Self {
        let most = CELLS_PER_SPHERE * packing.count as f64 + 1.0;
        let mut fitting = (packing.size / (2.0 * packing.radius)).floor().max(DVec3::ONE);
        // In a dilute packing most cells would be empty.
        while fitting.element_product() > most {
            let longest = fitting.max_position();
            fitting[longest] = (0.5 * fitting[longest]).floor();
        }
        let cells = fitting.to_array().map(|n| n as usize);
        Self { packing, cells, members: vec![Vec::new(); cells.iter().product()] }
    }

    fn cell(&self, p: DVec3) -> [usize; 3] {
        let size = self.packing.size;
        let from_corner = p + DVec3::new(0.5 * size.x, 0.5 * size.y, 0.0);
        std::array::from_fn(|i| ((from_corner[i] / size[i] * self.cells[i] as f64) as usize).min(self.cells[i] - 1))
    }

    fn index(&self, [x, y, z]: [usize; 3]) -> usize {
        (z * self.cells[1] + y) * self.cells[0] + x
    }

    fn insert(&mut self, p: DVec3, number: usize) {
        let at = self.index(self.cell(p));
        self.members[at].push(number as u32);
    }

    fn is_free(&self, p: DVec3, centers: &[DVec3]) -> bool {
        let cell = self.cell(p);
        let closest = 4.0 * self.packing.radius.powi(2);
        let close = |n: &u32| self.distance_squared(p, centers[*n as usize]) < closest;
        !self.around(2, cell[2]).any(|z| {
            self.around(1, cell[1])
                .any(|y| self.around(0, cell[0]).any(|x| self.members[self.index([x, y, z])].iter().any(close)))
        })
    }

    /// The cells next to `c` along axis `i`; in a narrow periodic slab some twice.
    fn around(&self, i: usize, c: usize) -> impl Iterator<Item = usize> + use<> {
        let n = self.cells[i];
        let wraps = self.packing.periodic && i < 2;
        (0..3).filter_map(move |k| match (c + k).checked_sub(1) {
            Some(x) if x < n => Some(x),
            Some(_) => wraps.then_some(0),
            None => wraps.then_some(n - 1),
        })
    }

    fn distance_squared(&self, a: DVec3, b: DVec3) -> f64 {
        let mut d = (a - b).abs();
        if self.packing.periodic {
            d.x = d.x.min(self.packing.size.x - d.x);
            d.y = d.y.min(self.packing.size.y - d.y);
        }
        d.length_squared()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spheres_keep_their_distance_across_the_seam() {
        let packing = Packing { count: 400, radius: 0.5, size: DVec3::new(10.0, 9.0, 8.0), periodic: true, seed: 3 };
        let centers = packing.centers().unwrap();
        assert_eq!(centers, packing.centers().unwrap(), "the same seed gives the same packing");
        let grid = Grid::new(&packing);
        for (i, &a) in centers.iter().enumerate() {
            assert!(a.z >= 0.5 && a.z <= 7.5);
            for &b in &centers[..i] {
                assert!(grid.distance_squared(a, b) >= 1.0);
            }
        }
    }

    #[test]
    fn impossible_packings_are_refused() {
        let base = Packing { count: 1000, radius: 0.5, size: DVec3::splat(10.0), periodic: true, seed: 1 };
        assert!(matches!(Packing { radius: 6.0, ..base }.centers(), Err(PackingError::DoesNotFit(_))));
        assert!(matches!(Packing { count: 2000, ..base }.centers(), Err(PackingError::DoesNotFit(_))));
        assert!(matches!(base.centers(), Err(PackingError::DoesNotFit(_))));
        assert!(matches!(Packing { count: 750, ..base }.centers(), Err(PackingError::Jammed { .. })));
    }
}
