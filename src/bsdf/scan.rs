//! Scans in the plane of incidence: what a detector on the arm of a goniometer reads.

use super::{Bsdf, Scattering, turned};
use crate::dome::{Apertures, Estimate, FINEST_LEVEL, Facet, Locator, Measurement};
use crate::light::Incidence;
use crate::plan::Plan;

/// Where the detector goes.
#[derive(Clone, Debug, PartialEq)]
pub struct Arm {
    /// Signed exit angles from the normal, degrees, −90 to 90: positive on the side of the mirror direction (behind the
    /// sample, of the straight one), negative on that of the source.
    pub angles_deg: Vec<f64>,
    /// Full width of the detector's aperture, degrees.
    pub aperture_deg: f64,
    /// Whether it goes below the sample.
    pub below: bool,
    /// How far its plane is turned from the plane of incidence about the normal of the sample, degrees.
    pub turn_deg: f64,
}

/// Readings under one incidence.
#[derive(Clone, Debug, PartialEq)]
pub struct Scan {
    /// Direction towards the source.
    pub incidence: Incidence,
    /// Vacuum wavelengths, nm.
    pub wavelength_nm: Vec<f64>,
    /// Ascending along the arm's angles.
    pub readings: Vec<Reading>,
}

/// What the detector reads in one place.
#[derive(Clone, Debug, PartialEq)]
pub struct Reading {
    /// Signed exit angle, degrees.
    pub angle_deg: f64,
    /// Mean BRDF (below the sample BTDF) over the aperture per wavelength, 1/sr: flux in it over incident flux and projected
    /// solid angle. What leaves in the mirror direction or straight on is in it.
    pub value: Vec<Estimate>,
    /// Trees that it has seen; of a stored result, those of the facets under the aperture.
    pub trees: u64,
}

/// Points at which the facets under an aperture are looked up.
const POINTS: u32 = 4096;

impl Arm {
    /// Whether it can be set up.
    ///
    /// # Errors
    /// What is wrong.
    pub fn check(&self) -> Result<(), String> {
        if let Some(bad) = self.angles_deg.iter().find(|a| !(-90.0..=90.0).contains(*a)) {
            return Err(format!("exit angle {bad}°: expected −90 to 90"));
        }
        if !(self.aperture_deg > 0.0 && self.aperture_deg <= 90.0) {
            return Err(format!("aperture {}°: expected more than 0 and at most 90", self.aperture_deg));
        }
        if !self.turn_deg.is_finite() {
            return Err(format!("turn of the arm {}°: expected a number", self.turn_deg));
        }
        Ok(())
    }

    /// Its apertures for light of this incidence.
    pub fn apertures(&self, incidence: &Incidence) -> Apertures {
        let axis = |&a: &f64| turned(incidence.in_plane(a, self.below), self.turn_deg);
        let normal = turned(incidence.s_direction(), self.turn_deg);
        Apertures::new(self.angles_deg.iter().map(axis).collect(), normal, self.aperture_deg.to_radians(), self.below)
    }
}

impl Scan {
    /// From a dome that had the apertures. Wavelengths that shared a lane get the same numbers.
    fn measured(
        arm: &Arm,
        incidence: Incidence,
        wavelength_nm: &[f64],
        measurement: &Measurement,
        lane_of: &[usize],
    ) -> Self {
        let apertures = arm.apertures(&incidence);
        let reading = |(i, &angle_deg): (usize, &f64)| {
            let angle = apertures.projected_solid_angle(apertures.axes()[i]);
            let of_lane = |&lane: &usize| per(measurement.aperture(i, lane), angle);
            Reading { angle_deg, value: lane_of.iter().map(of_lane).collect(), trees: measurement.aperture_trees(i) }
        };
        let readings = arm.angles_deg.iter().enumerate().map(reading).collect();
        Self { incidence, wavelength_nm: wavelength_nm.to_vec(), readings }
    }
}

impl Scan {
    /// The same at some of its wavelengths.
    #[must_use]
    pub fn only(mut self, wavelength_nm: &[f64]) -> Self {
        let keep: Vec<bool> = self.wavelength_nm.iter().map(|nm| wavelength_nm.contains(nm)).collect();
        let kept = |values: &mut Vec<Estimate>| {
            let mut keep = keep.iter();
            values.retain(|_| keep.next() == Some(&true));
        };
        self.readings.iter_mut().for_each(|r| kept(&mut r.value));
        self.wavelength_nm.retain(|nm| wavelength_nm.contains(nm));
        self
    }
}

fn per(e: Estimate, angle: f64) -> Estimate {
    Estimate { value: e.value / angle, se: e.se / angle }
}

impl Bsdf {
    /// What detectors have read that stood there while it was measured: one scan per incidence.
    pub fn scans(&self, arm: &Arm, measurements: &[Measurement], plan: &Plan) -> Vec<Scan> {
        let all = self.incidences.iter().zip(measurements);
        all.map(|(s, m)| Scan::measured(arm, s.incidence, &self.wavelength_nm, m, &plan.lane_of)).collect()
    }

    /// What a detector would read, from the facets of the adaptive dome under its aperture: these are flat, so nothing finer
    /// than they shows. Facets count as independent in the standard error.
    pub fn scan(&self, arm: &Arm, incidence: usize) -> Scan {
        let scattering = &self.incidences[incidence];
        let apertures = arm.apertures(&scattering.incidence);
        let finest = scattering.facets.iter().map(|f| f.facet.level).max().unwrap_or(0);
        let locator = Locator::new(finest.min(FINEST_LEVEL));
        let reading = |(i, &angle_deg): (usize, &f64)| {
            let weights = scattering.weights(&apertures, i, &locator);
            let value = (0..self.wavelength_nm.len()).map(|w| scattering.reading(&apertures, i, &weights, w)).collect();
            let trees = weights.iter().map(|&(at, _)| scattering.facets[at].trees).sum();
            Reading { angle_deg, value, trees }
        };
        let readings = arm.angles_deg.iter().enumerate().map(reading).collect();
        Scan { incidence: scattering.incidence, wavelength_nm: self.wavelength_nm.clone(), readings }
    }
}

impl Scattering {
    /// Facets under an aperture, with their shares of its projected solid angle.
    fn weights(&self, apertures: &Apertures, aperture: usize, locator: &Locator) -> Vec<(usize, f64)> {
        let axis = apertures.axes()[aperture];
        let mut weights: Vec<(usize, f64)> = Vec::new();
        let mut whole = 0.0;
        for dir in apertures.spread(axis, POINTS).filter(|&dir| apertures.sees(axis, dir)) {
            let fine = Facet { level: locator.level(), code: locator.code(dir) };
            let Some(at) = self.facet_holding(fine) else { continue };
            whole += dir.z.abs();
            match weights.iter_mut().find(|(facet, _)| *facet == at) {
                Some((_, weight)) => *weight += dir.z.abs(),
                None => weights.push((at, dir.z.abs())),
            }
        }
        weights.iter_mut().for_each(|(_, weight)| *weight /= whole);
        weights
    }

    /// Number of the facet of the adaptive dome that holds a facet at least as fine. They ascend along the dome.
    pub(super) fn facet_holding(&self, fine: Facet) -> Option<usize> {
        let first = |f: Facet| f.code << (2 * (fine.level - f.level));
        let after = self.facets.partition_point(|f| first(f.facet) <= fine.code);
        after.checked_sub(1)
    }

    fn reading(&self, apertures: &Apertures, aperture: usize, weights: &[(usize, f64)], w: usize) -> Estimate {
        let mut sum = Estimate::default();
        let mut variance = 0.0;
        for &(facet, weight) in weights {
            let e = self.facets[facet].value[w];
            sum.value += weight * e.value;
            variance += (weight * e.se).powi(2);
        }
        let axis = apertures.axes()[aperture];
        let mirror = self.incidence.in_plane(self.incidence.theta_deg, false);
        let straight = self.incidence.in_plane(self.straight_deg[w], true);
        for (direction, e) in [(mirror, self.ledger.specular[w]), (straight, self.ledger.undeflected[w])] {
            if apertures.sees(axis, direction) {
                let e = per(e, apertures.projected_solid_angle(axis));
                sum.value += e.value;
                variance += e.se * e.se;
            }
        }
        Estimate { se: variance.sqrt(), ..sum }
    }
}
