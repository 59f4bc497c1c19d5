//! What the dome tells apart from its facets: where a flat sample sends all its light, and what detectors see.

use glam::DVec3;

use crate::bsdf::Arm;
use crate::dome::{Apart, Apertures};
use crate::light::Incidence;
use crate::optics::fresnel;
use crate::plan::Plan;
use crate::sample::{MediumId, Sample};

/// The mirror direction, and the straight one behind the sample per lane (unreachable where refraction is total); the
/// apertures of a detector on its arm.
pub fn apart(sample: &Sample, plan: &Plan, incidence: &Incidence, arm: Option<&Arm>) -> Apart {
    let d = incidence.propagation();
    let index = |medium: MediumId, wavelength: usize| plan.media[usize::from(medium.0)].index[wavelength].re;
    let straight = |&wavelength: &usize| {
        let (n1, n2) = (index(sample.above, wavelength), index(sample.below, wavelength));
        if n1 == n2 {
            return d;
        }
        fresnel::refracted_cos(n1, n2, -d.z, fresnel::other_leg(-d.z))
            .map_or(DVec3::ZERO, |cos| (n1 / n2 * d).with_z(-cos))
    };
    Apart {
        specular: d.with_z(-d.z),
        undeflected: plan.lanes.iter().map(straight).collect(),
        apertures: arm.map_or_else(Apertures::default, |arm| arm.apertures(incidence)),
    }
}

/// Angle of the straight direction from the normal behind the sample, per wavelength, degrees; NaN where refraction is total.
pub fn straight_deg(sample: &Sample, plan: &Plan, incidence: &Incidence) -> Vec<f64> {
    let undeflected = apart(sample, plan, incidence, None).undeflected;
    let angle = |d: DVec3| if d == DVec3::ZERO { f64::NAN } else { d.truncate().length().atan2(-d.z).to_degrees() };
    plan.lane_of.iter().map(|&lane| angle(undeflected[lane])).collect()
}
