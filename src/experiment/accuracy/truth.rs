//! Samples whose answer is a formula: films without an end.

use super::grid::Values;
use crate::light::{Coherence, Light, Polarization};
use crate::optics::C64;
use crate::optics::film::{Incidence, Layer, solve};
use crate::sample::description::Body;
use crate::sample::{Description, Sample};

/// Reflectance and transmittance, if the sample is nothing but films that are coherent all through.
pub fn of(description: &Description, sample: &Sample, light: &Light) -> Option<Values> {
    let [object] = &description.objects[..] else { return None };
    let Body::Films { layers, .. } = &object.body else { return None };
    let share = match light.polarization {
        Polarization::Unpolarized => 0.5,
        _ => return None,
    };
    let table = |name: &str| sample.media.iter().find(|m| m.name == name).map(|m| &m.index);
    let (above, below) =
        (&sample.media[usize::from(sample.above.0)].index, &sample.media[usize::from(sample.below.0)].index);
    let stack: Vec<(&Vec<C64>, f64)> =
        layers.iter().map(|(medium, thickness)| Some((table(&medium.name)?, *thickness))).collect::<Option<_>>()?;
    let (mut reflected, mut transmitted) = (Vec::new(), Vec::new());
    for incidence in &light.incidences {
        for (w, um) in light.wavelengths.um().enumerate() {
            let layers: Vec<Layer> = stack.iter().map(|(n, d)| Layer { index: n[w], thickness: *d }).collect();
            let path: f64 = 2.0 * stack.iter().map(|(n, d)| n[w].re * d).sum::<f64>();
            let full = match light.coherence() {
                Coherence::Endless => f64::INFINITY,
                Coherence::Falling(full, _) => full,
                Coherence::Gaussian(_) => 0.0,
            };
            if path > full || above[w].im != 0.0 {
                return None;
            }
            let at = Incidence::from_angle(above[w].re, incidence.theta_deg.to_radians());
            let both = solve(&at, &layers, below[w], um);
            reflected.push(share * (both.s.reflectance() + both.p.reflectance()));
            transmitted.push(share * (both.s.transmittance() + both.p.transmittance()));
        }
    }
    Some(Values::exact(reflected, transmitted))
}
