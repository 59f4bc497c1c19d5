//! The values of a result one by one, for long tables.

use super::Source;
use crate::bsdf::{FacetValue, Scattering};
use crate::dome::Estimate;

/// A value. Angles are in degrees, the wavelength in nm, `bsdf` in 1/sr for facets; of the delta parts it is the share of
/// the incident power, and they have no solid angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    pub theta_i: f64,
    pub phi_i: f64,
    pub theta_o: f64,
    pub phi_o: f64,
    pub wavelength: f64,
    pub bsdf: f64,
    pub se: f64,
    pub solid_angle: f64,
    pub projected_solid_angle: f64,
    pub trees: u64,
    /// 0 a facet, 1 the specular part, 2 the undeflected one.
    pub part: u8,
}

/// The values of all facets and delta parts.
pub fn rows(source: &Source<'_>) -> impl Iterator<Item = Row> {
    let bsdf = source.bsdf();
    let wavelengths = source.wavelengths();
    bsdf.incidences.iter().flat_map(move |s| {
        let (of_facets, of_deltas) = (wavelengths.clone(), wavelengths.clone());
        let facets = s.facets.iter().flat_map(move |f| {
            let all = of_facets.clone().into_iter();
            all.map(move |w| facet(s, f, bsdf.wavelength_nm[w], f.value[w]))
        });
        facets.chain(of_deltas.into_iter().flat_map(move |w| delta(s, w, bsdf.wavelength_nm[w])))
    })
}

fn facet(s: &Scattering, f: &FacetValue, wavelength: f64, e: Estimate) -> Row {
    let center = f.facet.center();
    Row {
        theta_i: s.incidence.theta_deg,
        phi_i: s.incidence.phi_deg,
        theta_o: center.z.clamp(-1.0, 1.0).acos().to_degrees(),
        phi_o: center.y.atan2(center.x).to_degrees(),
        wavelength,
        bsdf: e.value,
        se: e.se,
        solid_angle: f.facet.solid_angle(),
        projected_solid_angle: f.facet.projected_solid_angle(),
        trees: f.trees,
        part: 0,
    }
}

fn delta(s: &Scattering, w: usize, wavelength: f64) -> impl Iterator<Item = Row> + use<> {
    let (specular, undeflected) = (s.ledger.specular[w], s.ledger.undeflected[w]);
    let parts = [(1, specular, s.incidence.theta_deg), (2, undeflected, 180.0 - s.straight_deg[w])];
    let (incidence, trees) = (s.incidence, s.trees);
    parts.into_iter().filter(|(_, e, _)| e.value > 0.0).map(move |(part, e, theta_o)| Row {
        theta_i: incidence.theta_deg,
        phi_i: incidence.phi_deg,
        theta_o,
        phi_o: incidence.phi_deg.rem_euclid(360.0) - 180.0,
        wavelength,
        bsdf: e.value,
        se: e.se,
        solid_angle: 0.0,
        projected_solid_angle: 0.0,
        trees,
        part,
    })
}
