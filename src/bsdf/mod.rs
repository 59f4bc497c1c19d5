//! The result: spectral BRDF and BTDF with standard errors, and the energy ledger.

pub mod compare;
mod derived;
mod lookup;
mod overlay;
mod reciprocity;
mod sampling;
mod scan;

use crate::dome::{BATCHES, Entry, Estimate, Facet, Leaf, Measurement, RESOLUTION, RESOLVED, Rule, critical};
use crate::light::{Incidence, Light};
use crate::plan::Plan;

pub use derived::Derived;
pub use lookup::{Blend, Lookup, Part, turned};
pub use overlay::{Overlay, Point};
pub use reciprocity::Reciprocity;
pub use sampling::{Drawn, Sampler};
pub use scan::{Arm, Reading, Scan};

/// Bidirectional scattering distribution function of a sample under a light.
#[derive(Clone, Debug, PartialEq)]
pub struct Bsdf {
    /// Vacuum wavelengths, nm.
    pub wavelength_nm: Vec<f64>,
    /// Names of the bodies whose absorbed power is told apart; empty if nothing absorbs.
    pub groups: Vec<String>,
    /// One entry per incidence.
    pub incidences: Vec<Scattering>,
}

/// What one incidence gave.
#[derive(Clone, Debug, PartialEq)]
pub struct Scattering {
    /// Direction towards the source.
    pub incidence: Incidence,
    /// Angle from the normal, degrees, at which undeflected light leaves below, per wavelength; NaN where none can.
    pub straight_deg: Vec<f64>,
    /// Trees traced.
    pub trees: u64,
    /// Segments traced.
    pub segments: u64,
    /// Where the incident power went, per wavelength.
    pub ledger: Ledger,
    /// What each group of bodies has absorbed, per wavelength.
    pub absorbed_by: Vec<Vec<Estimate>>,
    /// Matrices of the mirror direction and of the straight one, if Mueller matrices were measured.
    pub deltas: Option<DeltaMatrices>,
    /// The facets of the adaptive dome, without the deltas. They cover the sphere once.
    pub facets: Vec<FacetValue>,
    /// Errors of the whole, ratios and colours.
    pub derived: Derived,
}

/// A Mueller matrix by rows, per wavelength. Stokes vectors are (I, Q, U, V) with Q = |Eₓ|² − |E_y|² and
/// U + iV = 2 Eₓ E_y*. Of light that comes x̂ is p̂ of the incidence, of light that goes the direction θ̂ of growing polar
/// angle (p again); ŷ = k̂ × x̂.
pub type Matrices = Vec<[Estimate; 16]>;

/// Matrices of what leaves in exactly one direction, as shares of the incident power.
#[derive(Clone, Debug, PartialEq)]
pub struct DeltaMatrices {
    /// Of the mirror direction.
    pub specular: Matrices,
    /// Straight through.
    pub undeflected: Matrices,
}

/// Shares of the incident power per wavelength. `reflected + transmitted + absorbed + side + lost = 1`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ledger {
    /// Upwards; contains `specular`.
    pub reflected: Vec<Estimate>,
    /// Downwards; contains `undeflected`.
    pub transmitted: Vec<Estimate>,
    /// In the sample.
    pub absorbed: Vec<Estimate>,
    /// Guided sideways.
    pub side: Vec<Estimate>,
    /// In the mirror direction, exactly.
    pub specular: Vec<Estimate>,
    /// Straight through, exactly.
    pub undeflected: Vec<Estimate>,
    /// Met faces so narrow that ray optics is in doubt; contained in the others.
    pub doubtful: Vec<Estimate>,
    /// Met films so near to an edge that light in them would get there; contained in the others.
    pub edge: Vec<Estimate>,
    /// Lost because media contradicted themselves.
    pub lost_medium: Vec<Estimate>,
    /// Lost beyond the depth limit.
    pub lost_depth: Vec<Estimate>,
    /// Lost to numbers.
    pub lost_numeric: Vec<Estimate>,
}

impl Ledger {
    /// Names and entries, in a fixed order.
    pub fn entries(&self) -> [(&'static str, &Vec<Estimate>); Entry::COUNT] {
        [
            ("reflected", &self.reflected),
            ("transmitted", &self.transmitted),
            ("absorbed", &self.absorbed),
            ("side", &self.side),
            ("specular", &self.specular),
            ("undeflected", &self.undeflected),
            ("small_feature_flux", &self.doubtful),
            ("edge_flux", &self.edge),
            ("lost_medium", &self.lost_medium),
            ("lost_depth", &self.lost_depth),
            ("lost_numeric", &self.lost_numeric),
        ]
    }

    /// The same, to be changed.
    pub fn entries_mut(&mut self) -> [(&'static str, &mut Vec<Estimate>); Entry::COUNT] {
        [
            ("reflected", &mut self.reflected),
            ("transmitted", &mut self.transmitted),
            ("absorbed", &mut self.absorbed),
            ("side", &mut self.side),
            ("specular", &mut self.specular),
            ("undeflected", &mut self.undeflected),
            ("small_feature_flux", &mut self.doubtful),
            ("edge_flux", &mut self.edge),
            ("lost_medium", &mut self.lost_medium),
            ("lost_depth", &mut self.lost_depth),
            ("lost_numeric", &mut self.lost_numeric),
        ]
    }

    /// All losses, per wavelength.
    pub fn lost(&self) -> Vec<f64> {
        let kinds = [&self.lost_medium, &self.lost_depth, &self.lost_numeric];
        (0..self.reflected.len()).map(|w| kinds.iter().map(|k| k[w].value).sum()).collect()
    }

    /// What the entries add up to, per wavelength: 1 but for rounding.
    pub fn sum(&self) -> Vec<f64> {
        let kept = [&self.reflected, &self.transmitted, &self.absorbed, &self.side];
        let sum = |w: usize| kept.iter().map(|k| k[w].value).sum::<f64>();
        self.lost().iter().enumerate().map(|(w, lost)| sum(w) + lost).collect()
    }
}

/// The value of one facet.
#[derive(Clone, Debug, PartialEq)]
pub struct FacetValue {
    /// Which.
    pub facet: Facet,
    /// Trees that hit it; below [`crate::dome::RESOLVED`] its standard error means little.
    pub trees: u64,
    /// BRDF (facets above the horizon) or BTDF (below), per wavelength, 1/sr: flux in the facet over incident
    /// flux and projected solid angle.
    pub value: Vec<Estimate>,
    /// The same for light of all polarizations, if that was measured, 1/sr. Rays of the facet are told in the frames that
    /// are carried from the pole of the hemisphere without a turn, all turned by the one angle that makes x̂ at the centre θ̂.
    pub mueller: Matrices,
}

impl Scattering {
    /// From what the dome measured. Wavelengths that shared a lane get the same numbers.
    fn new(
        (incidence, straight_deg): (Incidence, Vec<f64>),
        measurement: &Measurement,
        wavelength_nm: &[f64],
        plan: &Plan,
        rule: &Rule,
    ) -> Self {
        let spread =
            |term: usize| -> Vec<Estimate> { plan.lane_of.iter().map(|&lane| measurement.term(term, lane)).collect() };
        let mut ledger = Ledger::default();
        for (term, (_, entry)) in ledger.entries_mut().into_iter().enumerate() {
            *entry = spread(term);
        }
        let shape = measurement.shape();
        let absorbed_by = (0..shape.groups).map(|group| spread(shape.group(group))).collect();
        let matrices = |behind: bool| {
            let matrix = |lane: usize| std::array::from_fn(|i| measurement.term(shape.delta(behind, i), lane));
            plan.lane_of.iter().map(|&lane| matrix(lane)).collect()
        };
        let deltas =
            (shape.components > 1).then(|| DeltaMatrices { specular: matrices(false), undeflected: matrices(true) });
        let facets = measurement.leaves(rule).into_iter().map(|leaf| FacetValue::new(&leaf, &plan.lane_of)).collect();
        let (trees, segments) = (measurement.trees(), measurement.segments());
        let derived = Derived::new(measurement, &plan.lane_of, wavelength_nm);
        Self { incidence, straight_deg, trees, segments, ledger, absorbed_by, deltas, facets, derived }
    }
}

impl FacetValue {
    /// Whether enough trees have hit it for its standard errors to mean something.
    pub fn is_resolved(&self) -> bool {
        self.trees >= RESOLVED
    }

    /// The interval that holds the true value of a wavelength 95 times in 100, 1/sr; `trees` were traced in all. Where the
    /// facet is not resolved it goes from 0 to what as many trees as may have been missed by chance (Poisson) would bring
    /// if each had sent all its light there.
    pub fn interval(&self, wavelength: usize, trees: u64) -> [f64; 2] {
        let Estimate { value, se } = self.value[wavelength];
        if self.is_resolved() {
            let half = critical(0.05, BATCHES as usize) * se;
            return [value - half, value + half];
        }
        // Wilson and Hilferty.
        let k = self.trees as f64 + 1.0;
        let most = k * (1.0 - 1.0 / (9.0 * k) + 1.96 / (3.0 * k.sqrt())).powi(3);
        [0.0, most / trees as f64 / self.facet.projected_solid_angle()]
    }

    fn new(leaf: &Leaf, lane_of: &[usize]) -> Self {
        let angle = leaf.facet.projected_solid_angle();
        let per_steradian = |e: Estimate| Estimate { value: e.value / angle, se: e.se / angle };
        let value = lane_of.iter().map(|&lane| per_steradian(leaf.power[lane])).collect();
        let lanes = lane_of.iter().filter(|_| !leaf.mueller.is_empty());
        let mueller = lanes.map(|&lane| leaf.mueller[lane].map(per_steradian)).collect();
        Self { facet: leaf.facet, trees: leaf.trees, value, mueller }
    }
}

impl Bsdf {
    /// From one measurement per incidence of the light, and the angles of undeflected light.
    pub fn new(
        light: &Light,
        measurements: &[Measurement],
        straight_deg: &[Vec<f64>],
        plan: &Plan,
        groups: &[String],
        rule: &Rule,
    ) -> Self {
        let told = measurements.first().map_or(0, |m| m.shape().groups);
        let scatterings = light.incidences.iter().zip(straight_deg).zip(measurements);
        Self {
            wavelength_nm: light.wavelengths.nm().to_vec(),
            groups: groups[..told].to_vec(),
            incidences: scatterings
                .map(|((&i, s), m)| Scattering::new((i, s.clone()), m, light.wavelengths.nm(), plan, rule))
                .collect(),
        }
    }

    /// The BSDF of each incidence in all facets of [`RESOLUTION`] (or of the finest level, if that is coarser), as measured: none
    /// are put together.
    pub fn grids(measurements: &[Measurement], plan: &Plan) -> Vec<Vec<FacetValue>> {
        let level = |m: &Measurement| m.finest().min(RESOLUTION);
        let grid = |m: &Measurement| m.grid(level(m)).iter().map(|leaf| FacetValue::new(leaf, &plan.lane_of)).collect();
        measurements.iter().map(grid).collect()
    }

    /// The largest share of the power lost at any incidence and wavelength.
    pub fn largest_loss(&self) -> f64 {
        self.incidences.iter().flat_map(|s| s.ledger.lost()).fold(0.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn facets_that_few_trees_have_hit_have_an_upper_limit_only() {
        let facet = Facet { level: 2, code: 7 };
        let value = vec![Estimate { value: 0.5, se: 0.1 }];
        let mut hit = FacetValue { facet, trees: 100, value, mueller: Vec::new() };
        let [low, high] = hit.interval(0, 10_000);
        assert!((low - 0.296).abs() < 1e-3 && (high - 0.704).abs() < 1e-3, "{low} {high}");
        hit.trees = 0;
        // Of nothing seen, Poisson's 97.5 % limit is 3.69.
        let [low, high] = hit.interval(0, 10_000);
        assert!(low == 0.0 && (high * 10_000.0 * facet.projected_solid_angle() / 3.69 - 1.0).abs() < 0.01, "{high}");
    }
}
