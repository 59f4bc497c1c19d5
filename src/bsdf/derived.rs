//! What follows from a measurement that its values alone do not tell: errors of the whole, and those of ratios and colours,
//! whose parts vary together.

use crate::colour::{self, Illuminant};
use crate::dome::{Entry, Estimate, Measurement, Precision};

/// What follows from one incidence.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Derived {
    /// How far it may be from the truth, all in all.
    pub precision: Precision,
    /// What of the reflected light goes in the mirror direction, per wavelength; 0 where nothing is reflected.
    pub specular_share: Vec<Estimate>,
    /// What of the transmitted light goes straight through.
    pub undeflected_share: Vec<Estimate>,
    /// CIE L*, a* and b* (2 degree observer, D65, white = all is reflected) of the reflected light; none if the wavelengths
    /// make no colour.
    pub reflected_lab: Option<[Estimate; 3]>,
    /// The same of the transmitted light.
    pub transmitted_lab: Option<[Estimate; 3]>,
}

impl Derived {
    /// From what the dome measured, with the lane of each wavelength.
    pub(super) fn new(measurement: &Measurement, lane_of: &[usize], wavelength_nm: &[f64]) -> Self {
        let lanes = measurement.shape().lanes;
        let share = |part: Entry, whole: Entry| -> Vec<Estimate> {
            let at = |entry: Entry, lane: usize| entry as usize * lanes + lane;
            let ratio = |terms: &[f64], lane| match terms[at(whole, lane)] {
                0.0 => 0.0,
                all => terms[at(part, lane)] / all,
            };
            let of_lanes: Vec<Estimate> =
                (0..lanes).map(|lane| measurement.jackknife(|terms| ratio(terms, lane))).collect();
            lane_of.iter().map(|&lane| of_lanes[lane]).collect()
        };
        let weights = colour::weights(Illuminant::D65, wavelength_nm);
        let lab = |entry: Entry| {
            let weights = weights.as_ref()?;
            let of = |terms: &[f64]| {
                let values = lane_of.iter().map(|&lane| terms[entry as usize * lanes + lane]);
                colour::lab(colour::summed(weights, values), Illuminant::D65.white())
            };
            Some([0, 1, 2].map(|i| measurement.jackknife(|terms| of(terms)[i])))
        };
        Self {
            precision: measurement.precision(),
            specular_share: share(Entry::Specular, Entry::Reflected),
            undeflected_share: share(Entry::Undeflected, Entry::Transmitted),
            reflected_lab: lab(Entry::Reflected),
            transmitted_lab: lab(Entry::Transmitted),
        }
    }
}
