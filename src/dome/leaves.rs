//! The adaptive dome: facets merged where nothing distinguishes them.

use super::geodesic::Facet;
use super::statistics::{Estimate, Measurement};

/// Facets hit by fewer trees have no standard error worth the name: "unresolved", not exact.
pub const RESOLVED: u64 = 20;

/// When the four parts of a facet are told apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rule {
    /// Chance that the parts of one facet, of equal radiance, are told apart by noise, over all wavelengths. A
    /// dome has thousands of facets, and each false alarm also divides all facets above it.
    pub false_alarm: f64,
    /// A facet hit by fewer trees is never divided.
    pub fewest_trees: u64,
    /// Without such proof, parts are told apart where that lowers the square of the estimated error: what a facet hides of its
    /// parts, and the variance of its mean times this. With 2 the estimate is unbiased (Mallows, Technometrics 15, 1973); with
    /// more there are fewer facets, which hide more.
    pub penalty: f64,
}

impl Default for Rule {
    fn default() -> Self {
        Self { false_alarm: 1e-3, fewest_trees: 4 * RESOLVED, penalty: 2.0 }
    }
}

/// A facet of the adaptive dome.
#[derive(Clone, Debug, PartialEq)]
pub struct Leaf {
    /// Which.
    pub facet: Facet,
    /// Trees that hit it.
    pub trees: u64,
    /// Share of the incident power per lane.
    pub power: Vec<Estimate>,
    /// Mueller matrices per lane, by rows, whose first element is that power; none if only power was measured.
    pub mueller: Vec<[Estimate; 16]>,
}

/// What is known of a facet, whole or divided.
struct Refined {
    /// Whether some parts certainly differ.
    firm: bool,
    /// Estimated square of the error, up to what does not depend on how it is divided: of the better of both, whole or divided.
    risk: f64,
    /// What the facet would hide if it were whole.
    hidden: f64,
}

impl Measurement {
    /// The facets of the adaptive dome: they cover the sphere once, from level 1 on (so that none sees both
    /// sides), ascending along the dome.
    pub fn leaves(&self, rule: &Rule) -> Vec<Leaf> {
        let z = critical(rule.false_alarm / (4 * self.shape().lanes) as f64, self.batches());
        let mut leaves = Vec::new();
        for facet in Facet::all(self.finest().min(1)) {
            self.refine(facet, rule, z, &mut leaves);
        }
        leaves
    }

    /// Adds `facet`, or its parts, to `leaves`.
    fn refine(&self, facet: Facet, rule: &Rule, z: f64, leaves: &mut Vec<Leaf>) -> Refined {
        let first = leaves.len();
        let mut refined = Refined { firm: false, risk: rule.penalty * self.noise(facet), hidden: 0.0 };
        if facet.level < self.finest() && self.facet_trees(facet) >= rule.fewest_trees {
            let parts = facet.children().map(|c| self.refine(c, rule, z, leaves));
            let firm = parts.iter().any(|p| p.firm) || self.parts_differ(facet, z);
            let divided: f64 = parts.iter().map(|p| p.risk).sum();
            refined.hidden = self.hidden(facet) + parts.iter().map(|p| p.hidden).sum::<f64>();
            refined.risk += refined.hidden;
            if firm || divided < refined.risk {
                return Refined { firm, risk: divided, ..refined };
            }
        }
        leaves.truncate(first);
        leaves.push(self.leaf(facet));
        refined
    }

    /// All facets of a level as they were measured, none put together.
    pub fn grid(&self, level: u8) -> Vec<Leaf> {
        Facet::all(level).map(|facet| self.leaf(facet)).collect()
    }

    fn leaf(&self, facet: Facet) -> Leaf {
        let power = (0..self.shape().lanes).map(|lane| self.facet(facet, lane)).collect();
        let matrix = |lane| std::array::from_fn(|i| self.component(facet, lane, i));
        let with_matrices = if self.shape().components > 1 { self.shape().lanes } else { 0 };
        let mueller = (0..with_matrices).map(matrix).collect();
        Leaf { facet, trees: self.facet_trees(facet), power, mueller }
    }

    /// Square of the standard error of the radiance of a facet, all lanes together, integrated over its solid angle.
    fn noise(&self, facet: Facet) -> f64 {
        let (solid, projected) = (facet.solid_angle(), facet.projected_solid_angle());
        let square: f64 = (0..self.shape().lanes).map(|lane| self.facet(facet, lane).se.powi(2)).sum();
        square * solid / (projected * projected)
    }

    /// Square of the difference of the radiance of the parts of a facet from its own, all lanes together, integrated over
    /// their solid angles.
    fn hidden(&self, facet: Facet) -> f64 {
        let radiance = |f: Facet, lane| self.facet(f, lane).value / f.projected_solid_angle();
        let of_part = |part: Facet| {
            let lanes = (0..self.shape().lanes).map(|lane| radiance(part, lane) - radiance(facet, lane));
            part.solid_angle() * lanes.map(|d| d * d).sum::<f64>()
        };
        facet.children().map(of_part).iter().sum()
    }

    /// Whether the radiance of some part differs from the mean of all four by more than `z` standard errors.
    fn parts_differ(&self, facet: Facet, z: f64) -> bool {
        let parts = facet.children();
        let angles = parts.map(Facet::projected_solid_angle);
        let whole: f64 = angles.iter().sum();
        (0..self.shape().lanes).any(|lane| {
            let power = parts.map(|p| self.facet(p, lane));
            let sum: f64 = power.iter().map(|e| e.value).sum();
            let noise: f64 = power.iter().map(|e| e.se * e.se).sum();
            power.iter().zip(angles).any(|(e, angle)| {
                let share = angle / whole;
                let own = e.se * e.se;
                // Of e − share · sum, the parts being independent.
                let variance = (1.0 - 2.0 * share) * own + share * share * noise;
                let difference = e.value - share * sum;
                difference * difference > z * z * variance && difference.abs() > 1e-12 * sum
            })
        })
    }
}

/// Two-sided critical value of Student's t for `batches` batches: of one less degrees of freedom (Abramowitz and Stegun 26.7.5, 26.2.23).
pub fn critical(false_alarm: f64, batches: usize) -> f64 {
    let t = (-2.0 * (0.5 * false_alarm).ln()).sqrt();
    let z = t - (2.515517 + t * (0.802853 + t * 0.010328)) / (1.0 + t * (1.432788 + t * (0.189269 + t * 0.001308)));
    let nu = (batches as f64 - 1.0).max(1.0);
    let z2 = z * z;
    z + z * (z2 + 1.0) / (4.0 * nu) + z * (5.0 * z2 * z2 + 16.0 * z2 + 3.0) / (96.0 * nu * nu)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use rand::rngs::Xoshiro256PlusPlus;
    use rand::{RngExt, SeedableRng};

    use super::super::{Apart, Apertures, Detector, Locator, Round, Shape, Tally};
    use super::*;
    use crate::optics::field::{Field, Stokes};
    use crate::trace::{Detect, testing};

    fn vertical() -> Vec<Apart> {
        vec![Apart { specular: DVec3::Z, undeflected: vec![DVec3::NEG_Z], apertures: Apertures::default() }]
    }

    /// Fills a dome with `batches` × `trees` exits drawn by `sample`.
    fn fill(batches: usize, trees: u32, mut sample: impl FnMut(&mut Xoshiro256PlusPlus) -> DVec3) -> Measurement {
        let locator = Locator::new(4);
        let apart = vertical();
        let mut detector = Detector::new(&locator, Shape::of_power(1), &apart);
        let mut round = Round::new(Shape::of_power(1), 4, 0);
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(11);
        for _ in 0..batches {
            for tree in 0..trees {
                let dir = sample(&mut rng);
                testing::exit(&mut detector, tree, dir, Stokes::incident([1.0, 1.0, 0.0, 0.0]));
            }
            round.add(&Detect::<Stokes>::finish(&mut detector, u64::from(trees)));
        }
        round.close()
    }

    fn lambert(rng: &mut Xoshiro256PlusPlus) -> DVec3 {
        let r2: f64 = rng.random();
        let (s, c) = (std::f64::consts::TAU * rng.random::<f64>()).sin_cos();
        DVec3::new(r2.sqrt() * c, r2.sqrt() * s, (1.0 - r2).sqrt())
    }

    #[test]
    fn critical_values_are_those_of_student() {
        // t for 31 degrees of freedom: 2.0395 (5 %), 3.6335 (0.1 %).
        assert!((critical(0.05, 32) - 2.0395).abs() < 2e-3);
        assert!((critical(0.001, 32) - 3.6335).abs() < 2e-2);
    }

    #[test]
    fn leaves_cover_the_sphere_once() {
        let m = fill(16, 2000, |rng| {
            let d = lambert(rng);
            if rng.random::<f64>() < 0.5 { DVec3::new(0.1 * d.x + 0.5, 0.1 * d.y, 0.7).normalize() } else { d }
        });
        let leaves = m.leaves(&Rule::default());
        let solid: f64 = leaves.iter().map(|l| l.facet.solid_angle()).sum();
        assert!((solid - 4.0 * std::f64::consts::PI).abs() < 1e-9);
        let power: f64 = leaves.iter().map(|l| l.power[0].value).sum();
        assert!((power - 1.0).abs() < 1e-12, "nothing is lost by merging: {power}");
        let finest = leaves.iter().filter(|l| l.facet.level == 4).count();
        assert!(finest > 4 && leaves.iter().any(|l| l.facet.level == 1), "fine at the lobe, coarse elsewhere");
    }

    #[test]
    fn a_lambertian_stays_coarse_and_a_spike_stays_sharp() {
        let flat = fill(32, 4000, lambert).leaves(&Rule::default());
        // Each of 840 divisions lowers the estimated error by chance with 11 % (χ² of 3 degrees beyond 6), and adds three.
        assert!(flat.len() <= 80 + 840 * 11 / 100 * 3, "{}", flat.len());
        let spike = fill(32, 100, |_| DVec3::new(0.3, 0.2, 0.8).normalize()).leaves(&Rule::default());
        assert!(spike.iter().any(|l| l.facet.level == 4 && l.power[0] == Estimate { value: 1.0, se: 0.0 }));
    }

    #[test]
    fn the_whole_is_the_sum_of_its_batches_in_any_grouping() {
        let locator = Locator::new(3);
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(3);
        let tallies: Vec<Tally> = (0..6)
            .map(|_| {
                let apart = vertical();
                let mut d = Detector::new(&locator, Shape::of_power(1), &apart);
                for tree in 0..50 {
                    testing::exit(&mut d, tree, lambert(&mut rng), Stokes::incident([1.0, 1.0, 0.0, 0.0]));
                }
                Detect::<Stokes>::finish(&mut d, 50)
            })
            .collect();
        let sum = |order: &[usize]| {
            let mut t = Tally::new(Shape::of_power(1));
            order.iter().for_each(|&i| t.merge(&tallies[i]));
            t
        };
        // Powers of 1 add exactly, so any order gives the same bits.
        assert_eq!(sum(&[0, 1, 2, 3, 4, 5]), sum(&[5, 3, 1, 0, 2, 4]));
        let mut halves = sum(&[0, 1, 2]);
        halves.merge(&sum(&[3, 4, 5]));
        assert_eq!(halves, sum(&[0, 1, 2, 3, 4, 5]));
    }
}
