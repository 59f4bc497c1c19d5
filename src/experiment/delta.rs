//! Where a flat sample sends all its light.

use glam::DVec3;

use crate::dome::Delta;
use crate::light::Incidence;
use crate::optics::fresnel;
use crate::plan::Plan;
use crate::sample::{MediumId, Sample};

/// The mirror direction, and the straight one behind the sample per lane; unreachable where refraction is total.
pub fn delta(sample: &Sample, plan: &Plan, incidence: &Incidence) -> Delta {
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
    Delta { specular: d.with_z(-d.z), undeflected: plan.lanes.iter().map(straight).collect() }
}
