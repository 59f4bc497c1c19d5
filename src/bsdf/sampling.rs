//! Directions drawn from a result, for programs that render with it.

use glam::DVec3;

use super::lookup::turned;
use super::{Blend, FacetValue, Lookup, Part};
use crate::dome::Facet;
use crate::light::Incidence;

/// Draws exits of one incidence, at one wavelength, in proportion to the light that leaves.
#[derive(Clone, Debug)]
pub struct Sampler<'a> {
    blend: Blend<'a>,
    wavelength: usize,
    /// What is drawn, and the share of the incident power up to it, itself included.
    choices: Vec<(Choice, f64)>,
}

#[derive(Clone, Copy, Debug)]
enum Choice {
    /// A facet of a dome that was measured from an azimuth greater by this many degrees.
    Facet(Facet, f64),
    Delta(DVec3),
}

/// An exit that was drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Drawn {
    /// Where the light goes.
    pub exit: DVec3,
    /// What a path that takes it is multiplied by: BSDF times |cos θ| over the density, or for the specular and undeflected
    /// parts their share over the chance that they were drawn.
    pub weight: f64,
    /// Density, 1/sr; none for the specular and undeflected parts, which go to one direction exactly.
    pub density: Option<f64>,
}

impl<'a> Sampler<'a> {
    /// For light of an incidence and a wavelength, by its number.
    pub fn new(lookup: &'a Lookup<'a>, incidence: &Incidence, wavelength: usize) -> Self {
        let blend = lookup.at(incidence);
        let facets = blend.fluxes(wavelength).map(|(part, f, flux)| (Choice::Facet(f.facet, part.turn_deg), flux));
        let specular = blend.share(|l| &l.specular, wavelength).value;
        let undeflected = blend.share(|l| &l.undeflected, wavelength).value;
        let straight = blend.straight(wavelength).map(|exit| (Choice::Delta(exit), undeflected));
        let all = facets.chain([(Choice::Delta(blend.mirror()), specular)]).chain(straight);
        let mut sum = 0.0;
        let choices = all
            .filter(|(_, flux)| *flux > 0.0)
            .map(|(choice, flux)| {
                sum += flux;
                (choice, sum)
            })
            .collect();
        Self { blend, wavelength, choices }
    }

    /// Share of the incident power that leaves: the albedo.
    pub fn albedo(&self) -> f64 {
        self.choices.last().map_or(0.0, |c| c.1)
    }

    /// An exit from three numbers of 0 to 1; none if no light leaves.
    pub fn draw(&self, [which, u, v]: [f64; 3]) -> Option<Drawn> {
        let albedo = self.albedo();
        let at = self.choices.partition_point(|c| c.1 <= which * albedo).min(self.choices.len().checked_sub(1)?);
        match self.choices[at].0 {
            Choice::Delta(exit) => Some(Drawn { exit, weight: albedo, density: None }),
            Choice::Facet(facet, turn_deg) => {
                let exit = turned(inside(facet, u, v), -turn_deg);
                let density = self.density(exit);
                let value = self.blend.value(exit, self.wavelength).value;
                Some(Drawn { exit, weight: value * exit.z.abs() / density, density: Some(density) })
            }
        }
    }

    /// Density of [`Self::draw`] at an exit, 1/sr, the specular and undeflected parts apart.
    pub fn density(&self, exit: DVec3) -> f64 {
        let albedo = self.albedo();
        if albedo == 0.0 {
            return 0.0;
        }
        let of_facet = |(part, f): (&Part, &FacetValue)| {
            let flux = part.weight * f.value[self.wavelength].value * f.facet.projected_solid_angle();
            flux.max(0.0) / f.facet.solid_angle()
        };
        self.blend.facets(exit).map(of_facet).sum::<f64>() / albedo
    }
}

/// A direction drawn evenly from the solid angle of a facet (Arvo, Stratified Sampling of Spherical Triangles, SIGGRAPH
/// 1995).
fn inside(facet: Facet, u: f64, v: f64) -> DVec3 {
    let [a, b, c] = facet.corners();
    let across = |p: DVec3, q: DVec3| p.cross(q).normalize();
    let (ab, bc, ca) = (across(a, b), across(b, c), across(c, a));
    let angle = |p: DVec3, q: DVec3| (-p.dot(q)).clamp(-1.0, 1.0).acos();
    let (alpha, beta, gamma) = (angle(ca, ab), angle(ab, bc), angle(bc, ca));
    let area = u * (alpha + beta + gamma - std::f64::consts::PI);
    let ((sin, cos), (sin_a, cos_a)) = ((area - alpha).sin_cos(), alpha.sin_cos());
    let (p, q) = (cos - cos_a, sin + sin_a * a.dot(b));
    let along = ((q * cos - p * sin) * cos_a - q) / ((q * sin + p * cos) * sin_a);
    let along = if along.is_finite() { along.clamp(-1.0, 1.0) } else { 1.0 };
    let to = |from: DVec3, to: DVec3, cos: f64| {
        let side = (to - to.dot(from) * from).normalize_or_zero();
        cos * from + (1.0 - cos * cos).max(0.0).sqrt() * side
    };
    let edge = to(a, c, along);
    to(b, edge, 1.0 - v * (1.0 - edge.dot(b))).normalize()
}
