//! Spheres in a slab by random sequential insertion, the largest first.

use std::f64::consts::PI;

use glam::DVec3;
use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};
use rayon::prelude::*;

use super::super::description::{Body, Fill, Object, Shape};
use super::super::fill::read_fill;
use super::super::problem::Place;
use super::super::reader::Table;
use super::common::{Common, Setting};
pub use super::insertion::PackingError;
use super::insertion::{Ball, Balls, Slab};
use super::sizes::Sizes;
use crate::units::significant;

/// A packing of equal spheres.
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

/// Largest number of spheres in one packing.
const MOST_SPHERES: usize = 20_000_000;

/// Beyond this share of the volume random insertion never gets: trying would only take time.
const DENSEST: f64 = 0.4;

/// The same for spheres of many sizes: small ones find room between large ones.
const DENSEST_UNEQUAL: f64 = 0.6;

/// Tries per sphere before a packing counts as jammed.
const TRIES: usize = 200_000;

/// Tries that are judged at once, at most, and how many are work for all threads.
const AT_ONCE: usize = 1 << 22;
const MANY: usize = 1 << 8;

const ADVICE: &str = "random insertion ends near 0.38; use fewer or smaller spheres";
const ADVICE_UNEQUAL: &str = "random insertion of equal spheres ends near 0.38, of a wide spread somewhat later; use \
                              fewer or smaller spheres";

impl Packing {
    /// The centres, in order of insertion.
    ///
    /// # Errors
    /// When the spheres do not fit.
    pub fn centers(&self) -> Result<Vec<DVec3>, PackingError> {
        check_count(self.count as f64)?;
        insert(&Slab { size: self.size, periodic: self.periodic }, &vec![self.radius; self.count], self.seed)
    }
}

/// Centres of spheres of these radii (µm, the largest first), in this order.
///
/// # Errors
/// When the spheres do not fit.
pub fn insert(slab: &Slab, radii: &[f64], seed: u64) -> Result<Vec<DVec3>, PackingError> {
    check(slab, radii)?;
    let mut balls = Balls::new(slab, radii);
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    // Tries since the last ball.
    let mut failed = 0;
    while let Some(&radius) = radii.get(balls.placed().len()) {
        let placed = balls.placed().len();
        let low = DVec3::new(-0.5 * slab.size.x, -0.5 * slab.size.y, radius);
        let span = DVec3::new(slab.size.x, slab.size.y, slab.size.z - 2.0 * radius);
        let rest = &radii[placed..];
        let equal = rest.partition_point(|&r| r == radius);
        let most = if equal == rest.len() { AT_ONCE } else { equal };
        let count = (2 * placed + 1).min(most);
        let tries: Vec<DVec3> =
            (0..count).map(|_| low + span * DVec3::new(rng.random(), rng.random(), rng.random())).collect();
        let mut begin = 0;
        for i in free(slab, &balls, radius, &tries) {
            let may = failed + (i - begin) < TRIES && balls.placed().len() < radii.len();
            if may && !balls.any_near(tries[i], placed, meets(slab, tries[i], radius)) {
                balls.push(tries[i]);
                (failed, begin) = (0, i + 1);
            }
        }
        failed += count - begin;
        if failed >= TRIES && balls.placed().len() < radii.len() {
            let placed = balls.placed().len();
            let advice = if is_equal(radii) { ADVICE } else { ADVICE_UNEQUAL };
            let fraction = fraction(slab, &radii[..placed]);
            return Err(PackingError::Jammed { what: "sphere", placed, fraction, advice });
        }
    }
    Ok(balls.placed().to_vec())
}

/// Whether a ball is met by one of this radius at `p`.
fn meets(slab: &Slab, p: DVec3, radius: f64) -> impl Fn(&Ball) -> bool {
    move |ball| slab.distance_squared(p, ball.place) < (radius + ball.radius).powi(2)
}

/// Which of these places are free for a ball of this radius, ascending. What is taken now will not be free later, so this can
/// be asked of many tries before the first of them is placed.
fn free(slab: &Slab, balls: &Balls<'_>, radius: f64, tries: &[DVec3]) -> Vec<usize> {
    let is_free = |p: DVec3| !balls.any_near(p, 0, meets(slab, p, radius));
    if tries.len() < MANY {
        return (0..tries.len()).filter(|&i| is_free(tries[i])).collect();
    }
    // Neighbours one after another, for what one asks of the memory the next one asks, too.
    let mut sorted: Vec<(u32, u32, DVec3)> =
        tries.par_iter().enumerate().map(|(i, &p)| (balls.order(p) as u32, i as u32, p)).collect();
    sorted.par_sort_unstable_by_key(|(order, ..)| *order);
    let mut free: Vec<usize> = sorted.par_iter().filter(|t| is_free(t.2)).map(|t| t.1 as usize).collect();
    free.par_sort_unstable();
    free
}

/// Part of the slab's volume that the spheres fill.
pub fn fraction(slab: &Slab, radii: &[f64]) -> f64 {
    4.0 / 3.0 * PI * radii.iter().map(|r| r.powi(3)).sum::<f64>() / slab.size.element_product()
}

fn is_equal(radii: &[f64]) -> bool {
    radii.first() == radii.last()
}

fn check_count(count: f64) -> Result<(), PackingError> {
    if count <= MOST_SPHERES as f64 {
        return Ok(());
    }
    Err(PackingError::DoesNotFit(format!("{count:.1e} spheres: at most {MOST_SPHERES} are taken")))
}

fn check(slab: &Slab, radii: &[f64]) -> Result<(), PackingError> {
    let fits = |what: &str, ok: bool| if ok { Ok(()) } else { Err(PackingError::DoesNotFit(what.into())) };
    let largest = radii.first().copied().unwrap_or(0.0);
    let positive = |r: &f64| *r > 0.0 && r.is_finite();
    fits("the radius must be positive", radii.iter().all(positive))?;
    fits("the largest radius must come first", radii.is_sorted_by(|a, b| a >= b))?;
    fits("the slab's edges must be positive", slab.size.min_element() > 0.0 && slab.size.is_finite())?;
    fits("a sphere is thicker than the slab", 2.0 * largest <= slab.size.z)?;
    let across = slab.size.x.min(slab.size.y);
    fits("a sphere is wider than the repeated slab", !slab.periodic || 2.0 * largest <= across)?;
    let share = fraction(slab, radii);
    let (densest, advice) = if is_equal(radii) { (DENSEST, ADVICE) } else { (DENSEST_UNEQUAL, ADVICE_UNEQUAL) };
    fits(&format!("the spheres would fill {share:.3} of the slab: {advice}"), share <= densest)
}

/// A packing with what its spheres are made of.
#[derive(Clone, Debug, PartialEq)]
pub struct SpherePacking {
    /// The slab.
    pub slab: Slab,
    /// Radii of the spheres, µm, the largest first.
    pub radii: Vec<f64>,
    /// Material.
    pub fill: Fill,
    /// Seed, height and priority.
    pub common: Common,
}

impl SpherePacking {
    /// Of equal spheres, on z = 0.
    pub fn equal(packing: Packing, fill: Fill) -> Self {
        let Packing { count, radius, size, periodic, seed } = packing;
        let common = Common { seed, periodic, ..Common::default() };
        Self { slab: Slab { size, periodic }, radii: vec![radius; count], fill, common }
    }

    /// Reads a `[[generate]]` table.
    pub(super) fn read(t: &Table<'_>, setting: Setting) -> Option<Self> {
        let sizes = read_sizes(t);
        let size = t.point("size").or_else(|| t.missing_if_absent("size", "[20, 20, 10]"));
        let count = t.integer("count", 1..MOST_SPHERES as i64 + 1);
        let share = t.number("fraction");
        let common = Common::read(t, setting);
        let fill = read_fill(t);
        let (sizes, size, common) = (sizes?, size?, common?);
        let sphere = 4.0 / 3.0 * PI;
        let radii = match (count, share) {
            (Some(n), None) => sizes.draw(n as usize, common.seed),
            (None, Some(f)) if f > 0.0 && f < 1.0 => {
                let volume = f * size.element_product();
                let expected = volume / (sphere * sizes.mean_power(3));
                check_count(expected).map_err(|e| t.complain(e.to_string())).ok()?;
                sizes.draw_up_to(volume / sphere, 3, common.seed)
            }
            _ => {
                t.complain("expected either `count`, such as 1000, or `fraction`, the share of the volume from 0 to 1");
                return None;
            }
        };
        Some(Self { slab: Slab { size, periodic: common.periodic }, radii, fill: fill?, common })
    }

    /// What it is, in a line.
    pub fn title(&self) -> String {
        let [smallest, largest] =
            [self.radii.last(), self.radii.first()].map(|r| r.map_or_else(String::new, |r| significant(*r, 4)));
        let share = fraction(&self.slab, &self.radii);
        format!(
            "{} spheres of radius {smallest} to {largest} um in a slab {} um high, {share:.4} of its volume",
            self.radii.len(),
            self.slab.size.z
        )
    }

    /// The spheres.
    ///
    /// # Errors
    /// When they do not fit.
    pub fn objects(&self, place: &Place) -> Result<Vec<Object>, PackingError> {
        let sphere = |(i, (center, &radius)): (usize, (DVec3, &f64))| Object {
            name: format!("sphere {}", i + 1).into(),
            body: Body::Solid(
                Shape::Sphere { center: center + DVec3::Z * self.common.bottom, radius },
                self.fill.clone(),
            ),
            priority: self.common.priority,
            nesting: 0,
            place: place.clone(),
        };
        let centers = insert(&self.slab, &self.radii, self.common.seed)?;
        Ok(centers.into_iter().zip(&self.radii).enumerate().map(sphere).collect())
    }
}

/// `radius` with `spread`, or `radii` with `shares`.
fn read_sizes(t: &Table<'_>) -> Option<Sizes> {
    if t.get("radii").is_none() && t.get("shares").is_none() {
        return Sizes::read(t, "radius", "0.5");
    }
    let radii = t.list_of_lengths("radii").or_else(|| t.missing_if_absent("radii", "[0.3, 0.5]"));
    let shares = t.list_of_numbers("shares").or_else(|| t.missing_if_absent("shares", "[0.8, 0.2]"));
    let others = [t.get("radius"), t.get("spread")];
    let (radii, shares) = (radii?, shares?);
    let sum: f64 = shares.iter().sum();
    let wrong = if others.iter().any(Option::is_some) {
        "`radii` and `shares` say all about the sizes: leave out `radius` and `spread`".into()
    } else if radii.len() != shares.len() || radii.is_empty() {
        format!("{} radii with {} shares: give each radius its share of the spheres", radii.len(), shares.len())
    } else if radii.iter().any(|r| *r <= 0.0) {
        "radii: expected lengths greater than 0".into()
    } else if shares.iter().any(|s| *s <= 0.0) || (sum - 1.0).abs() > 1e-6 {
        format!("shares: expected numbers greater than 0 whose sum is 1; it is {}", significant(sum, 6))
    } else {
        return Some(Sizes::Shares(radii.into_iter().zip(shares).collect()));
    };
    t.complain(wrong);
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    const SLAB: Slab = Slab { size: DVec3::new(10.0, 9.0, 8.0), periodic: true };

    /// Compares all with all, by all ways across the seams.
    fn assert_apart(slab: &Slab, centers: &[DVec3], radii: &[f64]) {
        for (i, &a) in centers.iter().enumerate() {
            assert!(a.z >= radii[i] && a.z <= slab.size.z - radii[i]);
            for (j, &b) in centers.iter().enumerate() {
                for (x, y) in (-1..=1).flat_map(|x| (-1..=1).map(move |y| (f64::from(x), f64::from(y)))) {
                    let image = b + DVec3::new(x * slab.size.x, y * slab.size.y, 0.0);
                    let itself = i == j && (x, y) == (0.0, 0.0);
                    assert!(itself || a.distance(image) >= radii[i] + radii[j] - 1e-12, "spheres {i} and {j}");
                }
            }
        }
    }

    #[test]
    fn spheres_keep_their_distance_across_the_seam() {
        let packing = Packing { count: 400, radius: 0.5, size: SLAB.size, periodic: true, seed: 3 };
        let centers = packing.centers().unwrap();
        assert_eq!(centers, packing.centers().unwrap(), "the same seed gives the same packing");
        assert_apart(&SLAB, &centers, &[0.5; 400]);
    }

    #[test]
    fn spheres_of_many_sizes_keep_their_distance() {
        let spread = Sizes::spread(0.3, 0.7).draw_up_to(0.3 * SLAB.size.element_product() / (4.0 / 3.0 * PI), 3, 5);
        let shares = Sizes::Shares(vec![(1.9, 0.01), (0.4, 0.39), (0.07, 0.6)]).draw(400, 1);
        for (radii, seed) in [(spread, 5), (shares, 6)] {
            assert!(radii[0] > 6.0 * radii[radii.len() - 1]);
            let centers = insert(&SLAB, &radii, seed).unwrap();
            assert_apart(&SLAB, &centers, &radii);
        }
    }

    /// Each try by itself, against all balls.
    fn one_after_another(slab: &Slab, radii: &[f64], seed: u64) -> Vec<DVec3> {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        let mut placed: Vec<DVec3> = Vec::new();
        while let Some(&radius) = radii.get(placed.len()) {
            let low = DVec3::new(-0.5 * slab.size.x, -0.5 * slab.size.y, radius);
            let span = DVec3::new(slab.size.x, slab.size.y, slab.size.z - 2.0 * radius);
            let p = low + span * DVec3::new(rng.random(), rng.random(), rng.random());
            let meets = |(&q, &r): (&DVec3, &f64)| slab.distance_squared(p, q) < (radius + r).powi(2);
            if !placed.iter().zip(radii).any(meets) {
                placed.push(p);
            }
        }
        placed
    }

    #[test]
    fn many_tries_at_once_place_what_one_after_another_does() {
        let shares = Sizes::Shares(vec![(0.6, 0.1), (0.25, 0.9)]).draw(2000, 1);
        let spread = Sizes::spread(0.2, 0.4).draw(500, 2);
        for radii in [vec![0.25; 3500], shares, spread] {
            assert_eq!(insert(&SLAB, &radii, 7).unwrap(), one_after_another(&SLAB, &radii, 7));
        }
    }

    #[test]
    fn impossible_packings_are_refused() {
        let base = Packing { count: 1000, radius: 0.5, size: DVec3::splat(10.0), periodic: true, seed: 1 };
        assert!(matches!(Packing { radius: 6.0, ..base }.centers(), Err(PackingError::DoesNotFit(_))));
        assert!(matches!(insert(&SLAB, &[0.1, 0.2], 1), Err(PackingError::DoesNotFit(_))));
        assert!(matches!(Packing { count: 2000, ..base }.centers(), Err(PackingError::DoesNotFit(_))));
        assert!(matches!(base.centers(), Err(PackingError::DoesNotFit(_))));
        assert!(matches!(Packing { count: 750, ..base }.centers(), Err(PackingError::Jammed { .. })));
    }
}
