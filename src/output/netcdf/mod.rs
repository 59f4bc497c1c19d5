//! The result file: NetCDF (classic, 64-bit offsets), which `xarray.open_dataset` opens in one line.
//!
//! Dimensions: `incidence`, `wavelength`, and `facet`, which runs over the facets of the adaptive domes of all
//! incidences, one dome after the other. Shares of the incident power have dimensions (incidence, wavelength) and
//! the names of [`Ledger::entries`](crate::bsdf::Ledger::entries); `bsdf` (1/sr) has (facet, wavelength): a BRDF where `theta_o` is below 90°, a
//! BTDF where it is above. If anything absorbs, `absorbed_by` has (group, incidence, wavelength): the share that each
//! `group` of bodies has absorbed. If Mueller matrices were measured, `mueller` (1/sr) has two more dimensions than `bsdf`,
//! `mueller_row` and `mueller_column`, and `specular_mueller` and `undeflected_mueller` are shares of the incident power;
//! their frames are those of [`crate::bsdf::Matrices`]. Every quantity with statistics has a partner `_se`. Numbers are doubles and come back
//! as they were; how the result came about is the attribute `provenance` (JSON).

mod derived;
mod read;
mod write;

use std::fmt;

pub use read::from_bytes;
pub use write::to_bytes;

/// Name and version of the layout.
const SCHEMA: &str = "gonio-bsdf-2";

/// Why a result could not be written or read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct NetcdfError(String);

impl fmt::Display for NetcdfError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for NetcdfError {}

impl From<netcdf_writer::Error> for NetcdfError {
    fn from(e: netcdf_writer::Error) -> Self {
        Self(e.to_string())
    }
}

fn broken(what: impl Into<String>) -> NetcdfError {
    NetcdfError(format!("this is no result of gonio-embree, or it is damaged: {}", what.into()))
}

#[cfg(test)]
mod tests {
    use super::super::measured::{Measured, Provenance, UsedBackend, Validity};
    use super::*;
    use crate::bsdf::{Bsdf, DeltaMatrices, Derived, FacetValue, Ledger, Matrices, Scattering};
    use crate::dome::{Estimate, Facet, Precision};
    use crate::light::Incidence;

    fn measured(groups: usize, mueller: bool) -> Measured {
        let estimate =
            |x: f64| vec![Estimate { value: x, se: x / 7.0 }, Estimate { value: 1.0 / x, se: f64::MIN_POSITIVE }];
        let scattering = |theta_deg: f64| {
            let mut ledger = Ledger::default();
            for (i, (_, entry)) in ledger.entries_mut().into_iter().enumerate() {
                *entry = estimate(0.1 + i as f64 + theta_deg);
            }
            let matrices = |x: f64| -> Matrices {
                let matrices =
                    (0..2).filter(|_| mueller).map(|w| [0; 16].map(|_| Estimate { value: x, se: f64::from(w) }));
                matrices.collect()
            };
            let facet = |facet| FacetValue {
                facet,
                trees: 3,
                value: estimate(0.3 + theta_deg),
                mueller: matrices(0.7 + theta_deg),
            };
            let facets = Facet::all(1).map(facet).collect();
            let derived = Derived {
                precision: Precision {
                    above: 0.1,
                    below: 0.2,
                    reflected: 0.3,
                    transmitted: 0.4,
                    whole: 0.5,
                    facet: f64::INFINITY,
                },
                specular_share: estimate(0.6),
                undeflected_share: estimate(0.7),
                reflected_lab: Some([50.0, theta_deg, -1.0].map(|value| Estimate { value, se: 0.1 })),
                transmitted_lab: Some([60.0, 2.0, theta_deg].map(|value| Estimate { value, se: 0.2 })),
            };
            let incidence = Incidence { theta_deg, phi_deg: 0.1 };
            let deltas = mueller.then(|| DeltaMatrices { specular: matrices(0.1), undeflected: matrices(0.2) });
            let absorbed_by = (0..groups).map(|g| estimate(0.2 + g as f64)).collect();
            Scattering {
                incidence,
                straight_deg: vec![theta_deg, theta_deg / 3.0],
                trees: 1 << 40,
                segments: 7,
                ledger,
                absorbed_by,
                deltas,
                facets,
                derived,
            }
        };
        let provenance = Provenance {
            version: "0".into(),
            command: "gonio-embree --mesh a.obj".into(),
            seed: u64::MAX,
            polarization: "s".into(),
            source_mode: "band".into(),
            sample_files: vec!["ä.obj".into()],
            sample_sha256: "00".into(),
            backend: UsedBackend { name: "obvhs".into(), version: "0.4".into() },
            effects: Vec::new(),
            validity: Validity {
                smallest_feature_um: None,
                small_feature_flux: 0.1,
                edge_flux: 0.0,
                edges: "column".into(),
            },
            stacks: Vec::new(),
            incomplete: None,
        };
        Measured {
            bsdf: Bsdf {
                wavelength_nm: vec![400.0, 500.1],
                groups: ["fibre ä", "a"].iter().take(groups).map(|&g| g.into()).collect(),
                incidences: vec![scattering(0.0), scattering(33.3)],
            },
            provenance,
        }
    }

    #[test]
    fn what_is_written_is_read() {
        for (groups, mueller) in [(0, false), (2, true)] {
            let measured = measured(groups, mueller);
            assert_eq!(from_bytes(&to_bytes(&measured).unwrap()).unwrap(), measured);
        }
    }

    #[test]
    fn damaged_files_are_refused_and_never_abort() {
        let bytes = to_bytes(&measured(1, true)).unwrap();
        assert!(from_bytes(b"").is_err());
        assert!(from_bytes(b"CDF\x02 and nothing more").is_err());
        for cut in [10, 100, 1000, bytes.len() - 1] {
            assert!(from_bytes(&bytes[..cut]).is_err(), "cut at {cut}");
        }
        // Whatever byte of the header changes, reading ends.
        for i in 0..2000 {
            let mut damaged = bytes.clone();
            damaged[i] ^= 0xa5;
            let _ = from_bytes(&damaged);
        }
    }
}
