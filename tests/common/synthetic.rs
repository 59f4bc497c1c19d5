//! Results made from formulas, to be looked at as if they were measured.

use glam::DVec3;
use gonio_embree::bsdf::{Bsdf, DeltaMatrices, Derived, FacetValue, Ledger, Scattering};
use gonio_embree::dome::{Estimate, Facet, theta_direction, turn};
use gonio_embree::light::Incidence;
use gonio_embree::optics::C64;
use gonio_embree::output::{Measured, Provenance, UsedBackend, Validity};

use super::matrices::{self, diagonal, product};

/// Standard error of everything, relative.
pub const NOISE: f64 = 0.01;

/// A result whose facets, all of one level, hold the means of `f`(incidence, exit, wavelength in nm) over the four parts of
/// their four parts; what does not leave is absorbed. `specular` is the share in the mirror direction.
pub fn result(
    level: u8,
    incidences: &[(f64, f64)],
    wavelength_nm: &[f64],
    specular: f64,
    f: impl Fn(&Incidence, DVec3, f64) -> f64,
) -> Bsdf {
    let facets: Vec<(Facet, Vec<(DVec3, f64)>)> = Facet::all(level).map(|facet| (facet, points(facet))).collect();
    let scattering = |&(theta_deg, phi_deg): &(f64, f64)| {
        let incidence = Incidence { theta_deg, phi_deg };
        let value = |points: &[(DVec3, f64)], nm: f64| {
            let mean: f64 = points.iter().map(|&(dir, weight)| weight * f(&incidence, dir, nm)).sum();
            Estimate { value: mean, se: NOISE * mean }
        };
        let facet = |(facet, points): &(Facet, Vec<(DVec3, f64)>)| FacetValue {
            facet: *facet,
            trees: 1000,
            value: wavelength_nm.iter().map(|&nm| value(points, nm)).collect(),
            mueller: Vec::new(),
        };
        let facets: Vec<FacetValue> = facets.iter().map(facet).collect();
        let straight_deg = vec![theta_deg; wavelength_nm.len()];
        let ledger = ledger(&facets, wavelength_nm.len(), specular);
        let (trees, segments) = (1000, 1000);
        Scattering {
            incidence,
            straight_deg,
            trees,
            segments,
            ledger,
            absorbed_by: Vec::new(),
            deltas: None,
            facets,
            derived: Derived::default(),
        }
    };
    let incidences = incidences.iter().map(scattering).collect();
    Bsdf { wavelength_nm: wavelength_nm.to_vec(), groups: Vec::new(), incidences }
}

/// Directions in a facet with their shares of its projected solid angle.
fn points(facet: Facet) -> Vec<(DVec3, f64)> {
    let parts = facet.children().into_iter().flat_map(Facet::children);
    let whole = facet.projected_solid_angle();
    parts.map(|part| (part.center(), part.projected_solid_angle() / whole)).collect()
}

fn ledger(facets: &[FacetValue], wavelengths: usize, specular: f64) -> Ledger {
    let exact = |value: f64| Estimate { value, se: 0.0 };
    let through = |up: bool, w: usize| {
        let side = facets.iter().filter(|f| (f.facet.center().z > 0.0) == up);
        side.map(|f| f.value[w].value * f.facet.projected_solid_angle()).sum::<f64>()
    };
    let mut ledger = Ledger::default();
    ledger.entries_mut().into_iter().for_each(|(_, entry)| *entry = vec![exact(0.0); wavelengths]);
    for w in 0..wavelengths {
        let (up, down) = (through(true, w) + specular, through(false, w));
        ledger.reflected[w] = exact(up);
        ledger.transmitted[w] = exact(down);
        ledger.specular[w] = exact(specular);
        ledger.absorbed[w] = exact(1.0 - up - down);
    }
    ledger
}

/// Isotropic GGX reflection without Fresnel's factor (Walter et al., EGSR 2007, eqs. 20, 33, 34), 1/sr.
pub fn ggx(incidence: &Incidence, exit: DVec3, alpha: [f64; 2]) -> f64 {
    let source = -incidence.propagation();
    if exit.z <= 0.0 {
        return 0.0;
    }
    let m = (source + exit).normalize();
    let stretched = |v: DVec3| (v.x / alpha[0]).powi(2) + (v.y / alpha[1]).powi(2);
    let d = 1.0 / (std::f64::consts::PI * alpha[0] * alpha[1] * (stretched(m) + m.z * m.z).powi(2));
    let slope = |v: DVec3| ((v.x * alpha[0]).powi(2) + (v.y * alpha[1]).powi(2)) / (v.z * v.z);
    let g1 = |v: DVec3| 2.0 / (1.0 + (1.0 + slope(v)).sqrt());
    d * g1(source) * g1(exit) / (4.0 * source.z * exit.z)
}

/// The index of [`mueller_ggx`].
pub const METAL: C64 = C64::new(0.8, 3.0);

/// A rough metal with its Mueller matrices: GGX of microfacets that reflect by Fresnel's equations, told at the centres of
/// the facets.
pub fn mueller_ggx(level: u8, incidences: &[(f64, f64)], wavelength_nm: &[f64], alpha: f64) -> Bsdf {
    let n = wavelength_nm.len();
    let mut bsdf = result(level, incidences, wavelength_nm, 0.0, |_, _, _| 0.0);
    for s in &mut bsdf.incidences {
        for f in &mut s.facets {
            let exit = f.facet.center();
            let lobe = ggx(&s.incidence, exit, [alpha, alpha]);
            let matrix = if lobe > 0.0 { reflection(&s.incidence, exit) } else { [0.0; 16] };
            let estimates = matrix.map(|x| Estimate { value: lobe * x, se: 0.0 });
            f.mueller = vec![estimates; n];
            f.value = vec![estimates[0]; n];
        }
        s.ledger = ledger(&s.facets, n, 0.0);
        let none = vec![[Estimate::default(); 16]; n];
        s.deltas = Some(DeltaMatrices { specular: none.clone(), undeflected: none });
    }
    bsdf
}

/// The Mueller matrix of a mirror of [`METAL`] that sends the light to `exit`, from p of the incidence to θ̂ of the exit.
fn reflection(incidence: &Incidence, exit: DVec3) -> [f64; 16] {
    let k = incidence.propagation();
    let m = (exit - k).normalize();
    let cos = exit.dot(m);
    let q = (METAL * METAL - (1.0 - cos * cos)).sqrt();
    let (rs, rp) = ((cos - q) / (cos + q), (METAL * METAL * cos - q) / (METAL * METAL * cos + q));
    let s = k.cross(m).try_normalize().unwrap_or_else(|| incidence.s_direction());
    let into = turn(k, incidence.p_direction(), s.cross(k));
    let out = turn(exit, s.cross(exit), theta_direction(exit));
    let framed = |[cos, sin]: [f64; 2]| matrices::turn(cos, sin);
    product(&framed(out), &product(&diagonal(rp, rs), &framed(into)))
}

/// A result as if it had been measured.
pub fn measured(bsdf: Bsdf) -> Measured {
    let validity =
        Validity { smallest_feature_um: None, small_feature_flux: 0.0, edge_flux: 0.0, edges: "column".into() };
    let provenance = Provenance {
        version: "0.1.0".into(),
        command: "gonio-embree --sample formula.toml".into(),
        seed: 1,
        polarization: "unpolarized".into(),
        source_mode: "band".into(),
        sample_files: vec!["formula.toml".into()],
        sample_sha256: "00".into(),
        backend: UsedBackend { name: "none".into(), version: "0".into() },
        effects: Vec::new(),
        validity,
        stacks: Vec::new(),
        incomplete: None,
    };
    Measured { bsdf, provenance }
}
