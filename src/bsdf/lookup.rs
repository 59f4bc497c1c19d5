//! The result as a function of any two directions: between the incidences that were measured it is interpolated from the
//! four nearest, as in Schramm, Gondek and Meyer (1997), section 3.

use glam::DVec3;

use super::{Bsdf, FacetValue, Ledger, Scattering};
use crate::dome::{Estimate, FINEST_LEVEL, Facet, Locator};
use crate::light::Incidence;

/// Finds values of a result.
#[derive(Clone, Debug)]
pub struct Lookup<'a> {
    bsdf: &'a Bsdf,
    locator: Locator,
    rings: Vec<Ring>,
    isotropic: bool,
    /// Number of the facet that holds each of the finest level, per incidence; none if that level is too fine.
    holders: Vec<Vec<u32>>,
}

/// Finest level of which all facets are listed: 80 kB per incidence.
const LISTED_LEVEL: u8 = 5;

/// Incidences of one polar angle.
#[derive(Clone, Debug)]
struct Ring {
    theta_deg: f64,
    /// Azimuths in degrees, 0..360, ascending, with the number of the incidence.
    members: Vec<(f64, usize)>,
}

/// A measured incidence that stands for a part of the one that is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Part {
    /// Its number.
    pub incidence: usize,
    /// How much it counts; those of a [`Blend`] add up to 1.
    pub weight: f64,
    /// Its azimuth less the one asked for, degrees, if the sample is isotropic: what it sent towards φ goes to φ − turn. Of
    /// other samples exits are taken as they are.
    pub turn_deg: f64,
}

/// The measured incidences around the one that is asked for.
#[derive(Clone, Debug)]
pub struct Blend<'a> {
    lookup: &'a Lookup<'a>,
    incidence: Incidence,
    parts: Vec<Part>,
}

impl<'a> Lookup<'a> {
    /// For a result of at least one incidence. A sample that was measured from one azimuth only is taken to be isotropic.
    pub fn new(bsdf: &'a Bsdf) -> Self {
        let finest = bsdf.incidences.iter().flat_map(|s| &s.facets).map(|f| f.facet.level).max().unwrap_or(0);
        let mut rings: Vec<Ring> = Vec::new();
        for (i, s) in bsdf.incidences.iter().enumerate() {
            let Incidence { theta_deg, phi_deg } = s.incidence;
            let member = (phi_deg.rem_euclid(360.0), i);
            match rings.iter_mut().find(|r| r.theta_deg == theta_deg) {
                Some(ring) => ring.members.push(member),
                None => rings.push(Ring { theta_deg, members: vec![member] }),
            }
        }
        rings.sort_by(|a, b| a.theta_deg.total_cmp(&b.theta_deg));
        rings.iter_mut().for_each(|r| r.members.sort_by(|a, b| a.0.total_cmp(&b.0)));
        let isotropic = rings.iter().all(|r| r.members.len() == 1);
        let level = finest.min(FINEST_LEVEL);
        let listed = bsdf.incidences.iter().filter(|_| level <= LISTED_LEVEL);
        let holders = listed.map(|s| holders(s, level)).collect();
        Self { bsdf, locator: Locator::new(level), rings, isotropic, holders }
    }

    /// The result.
    pub fn bsdf(&self) -> &'a Bsdf {
        self.bsdf
    }

    /// Whether the sample was measured from one azimuth only, so that it counts as isotropic.
    pub fn is_isotropic(&self) -> bool {
        self.isotropic
    }

    /// Greatest polar angle that was measured, degrees. What comes more grazing gets its values.
    pub fn greatest_theta_deg(&self) -> f64 {
        self.rings.last().map_or(0.0, |r| r.theta_deg)
    }

    /// The measured incidences around this one.
    pub fn at(&'a self, incidence: &Incidence) -> Blend<'a> {
        let after = self.rings.partition_point(|r| r.theta_deg < incidence.theta_deg);
        let upper = after.min(self.rings.len() - 1);
        let lower = after.saturating_sub(1);
        let [low, high] = [&self.rings[lower], &self.rings[upper]];
        let share = share(low.theta_deg, high.theta_deg, incidence.theta_deg);
        let mut parts = Vec::with_capacity(4);
        low.add(incidence.phi_deg, 1.0 - share, &mut parts);
        high.add(incidence.phi_deg, share, &mut parts);
        if !self.isotropic {
            parts.iter_mut().for_each(|p| p.turn_deg = 0.0);
        }
        Blend { lookup: self, incidence: *incidence, parts }
    }

    /// Facet of a measured incidence that holds a facet of the finest level.
    fn facet(&self, incidence: usize, code: u32) -> Option<&'a FacetValue> {
        let scattering = &self.bsdf.incidences[incidence];
        let at = match self.holders.get(incidence) {
            Some(holders) => holders[code as usize] as usize,
            None => scattering.facet_holding(Facet { level: self.locator.level(), code })?,
        };
        scattering.facets.get(at)
    }
}

fn holders(s: &Scattering, level: u8) -> Vec<u32> {
    let holder = |facet: Facet| s.facet_holding(facet).map_or(u32::MAX, |at| at as u32);
    Facet::all(level).map(holder).collect()
}

/// Part of the way from `from` to `to` at which `at` lies, 0 to 1.
fn share(from: f64, to: f64, at: f64) -> f64 {
    if to > from { ((at - from) / (to - from)).clamp(0.0, 1.0) } else { 0.0 }
}

impl Ring {
    /// Adds its two nearest azimuths.
    fn add(&self, phi_deg: f64, weight: f64, parts: &mut Vec<Part>) {
        let phi = phi_deg.rem_euclid(360.0);
        let mut put = |(azimuth, incidence): (f64, usize), weight: f64| {
            if weight > 0.0 {
                parts.push(Part { incidence, weight, turn_deg: azimuth - phi });
            }
        };
        let [first, .., last] = self.members[..] else { return put(self.members[0], weight) };
        let after = self.members.partition_point(|m| m.0 < phi);
        // Beyond the last azimuth comes the first again.
        let low = after.checked_sub(1).map_or((last.0 - 360.0, last.1), |before| self.members[before]);
        let high = self.members.get(after).copied().unwrap_or((first.0 + 360.0, first.1));
        let share = share(low.0, high.0, phi);
        put(low, weight * (1.0 - share));
        put(high, weight * share);
    }
}

impl<'a> Blend<'a> {
    /// What it is made of.
    pub fn parts(&self) -> &[Part] {
        &self.parts
    }

    fn scattering(&self, part: &Part) -> &'a Scattering {
        &self.lookup.bsdf.incidences[part.incidence]
    }

    /// The facets that stand for this exit direction.
    pub fn facets(&self, exit: DVec3) -> impl Iterator<Item = (&Part, &'a FacetValue)> {
        // Most parts have the same turn.
        let mut last = (f64::NAN, 0);
        self.parts.iter().filter_map(move |p| {
            if p.turn_deg != last.0 {
                last = (p.turn_deg, self.lookup.locator.code(turned(exit, p.turn_deg)));
            }
            self.lookup.facet(p.incidence, last.1).map(|f| (p, f))
        })
    }

    /// BRDF (above the horizon) or BTDF (below) of the exit direction at a wavelength, by its number; 1/sr, without the
    /// specular and undeflected parts.
    pub fn value(&self, exit: DVec3, wavelength: usize) -> Estimate {
        mean(self.facets(exit).map(|(p, f)| (p.weight, f.value[wavelength])))
    }

    /// The same for all wavelengths, without errors, added to `sum` with a weight.
    pub fn add_values(&self, exit: DVec3, weight: f64, sum: &mut [f64]) {
        for (part, facet) in self.facets(exit) {
            sum.iter_mut().zip(&facet.value).for_each(|(s, e)| *s += weight * part.weight * e.value);
        }
    }

    /// An entry of the ledger at a wavelength: `reflected` is the directional-hemispherical reflectance, specular part
    /// included, `transmitted` the transmittance.
    pub fn share(&self, entry: fn(&Ledger) -> &Vec<Estimate>, wavelength: usize) -> Estimate {
        mean(self.parts.iter().map(|p| (p.weight, entry(&self.scattering(p).ledger)[wavelength])))
    }

    /// Where the specular part goes.
    pub fn mirror(&self) -> DVec3 {
        self.incidence.in_plane(self.incidence.theta_deg, false)
    }

    /// Where the undeflected part goes at a wavelength; none if refraction is total, or nothing is known of it.
    pub fn straight(&self, wavelength: usize) -> Option<DVec3> {
        let sine = |deg: f64| deg.to_radians().sin();
        let measured = self.lookup.bsdf.incidences.iter();
        // Snell's law; at normal incidence 0 / 0 tells nothing of it.
        let slope = measured
            .map(|s| sine(s.straight_deg[wavelength]) / sine(s.incidence.theta_deg))
            .find(|slope| slope.is_finite());
        let sin = if self.incidence.theta_deg == 0.0 { 0.0 } else { slope? * sine(self.incidence.theta_deg) };
        (sin <= 1.0).then(|| self.incidence.in_plane(sin.asin().to_degrees(), true))
    }

    /// What leaves through each facet of the blended domes, as shares of the incident power at a wavelength: the facets of
    /// every part, which overlap, with what each adds.
    pub fn fluxes(&self, wavelength: usize) -> impl Iterator<Item = (&Part, &'a FacetValue, f64)> {
        self.parts.iter().flat_map(move |p| {
            let facets = self.scattering(p).facets.iter();
            facets.map(move |f| (p, f, p.weight * f.value[wavelength].value * f.facet.projected_solid_angle()))
        })
    }
}

/// Weighted mean of independent estimates.
fn mean(parts: impl Iterator<Item = (f64, Estimate)>) -> Estimate {
    let (value, variance) =
        parts.fold((0.0, 0.0), |(value, variance), (w, e)| (value + w * e.value, variance + (w * e.se).powi(2)));
    Estimate { value, se: variance.sqrt() }
}

/// A direction turned about +z by an angle in degrees.
pub fn turned(dir: DVec3, by_deg: f64) -> DVec3 {
    if by_deg == 0.0 {
        return dir;
    }
    let (sin, cos) = by_deg.to_radians().sin_cos();
    DVec3::new(cos * dir.x - sin * dir.y, sin * dir.x + cos * dir.y, dir.z)
}
