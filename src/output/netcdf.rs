//! The result file: NetCDF (classic, 64-bit offsets), which `xarray.open_dataset` opens in one line.
//!
//! Dimensions: `incidence`, `wavelength`, and `facet`, which runs over the facets of the adaptive domes of all
//! incidences, one dome after the other. Shares of the incident power have dimensions (incidence, wavelength) and
//! the names of [`Ledger::entries`]; `bsdf` (1/sr) has (facet, wavelength): a BRDF where `theta_o` is below 90°, a
//! BTDF where it is above. Every quantity with statistics has a partner `_se`. Numbers are doubles and come back
//! as they were; how the result came about is the attribute `provenance` (JSON).

use std::fmt;

use netcdf_reader::NcFile;
use netcdf_writer::{DimensionId, NcAttrValue, NcFileBuilder, NcWriteOptions, VariableId};

use super::measured::{Measured, Provenance};
use crate::bsdf::{Bsdf, FacetValue, Ledger, Scattering};
use crate::dome::{Estimate, FINEST_LEVEL, Facet, count};
use crate::light::Incidence;

/// Name and version of the layout.
const SCHEMA: &str = "gonio-bsdf-1";

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

/// The bytes of the file.
///
/// # Errors
/// When there is more data than the format can hold.
pub fn to_bytes(measured: &Measured) -> Result<Vec<u8>, NetcdfError> {
    let mut file = Writer::new(&measured.bsdf)?;
    file.describe(&measured.provenance)?;
    file.put_incidences(&measured.bsdf)?;
    file.put_facets(&measured.bsdf)?;
    Ok(file.builder.to_vec(NcWriteOptions::offset64())?.1)
}

struct Writer {
    builder: NcFileBuilder,
    incidence: DimensionId,
    wavelength: DimensionId,
    facet: DimensionId,
}

type Written = Result<(), NetcdfError>;

impl Writer {
    fn new(bsdf: &Bsdf) -> Result<Self, NetcdfError> {
        let mut builder = NcFileBuilder::new();
        let incidence = builder.add_dimension("incidence", bsdf.incidences.len() as u64)?;
        let wavelength = builder.add_dimension("wavelength", bsdf.wavelength_nm.len() as u64)?;
        let facets: usize = bsdf.incidences.iter().map(|s| s.facets.len()).sum();
        let facet = builder.add_dimension("facet", facets as u64)?;
        Ok(Self { builder, incidence, wavelength, facet })
    }

    fn describe(&mut self, provenance: &Provenance) -> Written {
        let json = serde_json::to_string(provenance).expect("plain numbers and texts");
        for (name, value) in [
            ("Conventions", "CF-1.8"),
            ("title", "Spectral BSDF by ray tracing"),
            ("source", &format!("gonio-embree {}", provenance.version)),
            ("history", &provenance.command),
            ("schema", SCHEMA),
            ("provenance", &json),
        ] {
            self.builder.add_attribute(name, NcAttrValue::Chars(value.into()))?;
        }
        Ok(())
    }

    fn note(&mut self, variable: VariableId, unit: &str, meaning: &str, coordinates: &str) -> Written {
        for (name, value) in [("units", unit), ("long_name", meaning), ("coordinates", coordinates)] {
            if !value.is_empty() {
                self.builder.add_variable_attribute(variable, name, NcAttrValue::Chars(value.into()))?;
            }
        }
        Ok(())
    }

    fn put(&mut self, name: &str, dims: &[DimensionId], values: &[f64], about: [&str; 3]) -> Written {
        let variable = self.builder.add_variable::<f64>(name, dims)?;
        self.note(variable, about[0], about[1], about[2])?;
        Ok(self.builder.write_variable(variable, values)?)
    }

    fn put_integers(&mut self, name: &str, values: &[i32], meaning: &str) -> Written {
        let variable = self.builder.add_variable::<i32>(name, &[self.facet])?;
        self.note(variable, "1", meaning, "")?;
        Ok(self.builder.write_variable(variable, values)?)
    }

    /// Values and standard errors over (`rows`, wavelength).
    fn put_estimates(&mut self, name: &str, rows: DimensionId, all: &[&[Estimate]], about: [&str; 3]) -> Written {
        let dims = [rows, self.wavelength];
        let values: Vec<f64> = all.iter().copied().flatten().map(|e| e.value).collect();
        let errors: Vec<f64> = all.iter().copied().flatten().map(|e| e.se).collect();
        self.put(name, &dims, &values, about)?;
        let meaning = format!("standard error of {name}");
        self.put(&format!("{name}_se"), &dims, &errors, [about[0], &meaning, about[2]])
    }

    fn put_incidences(&mut self, bsdf: &Bsdf) -> Written {
        self.put("wavelength", &[self.wavelength], &bsdf.wavelength_nm, ["nm", "vacuum wavelength", ""])?;
        let per_incidence = |f: fn(&Scattering) -> f64| -> Vec<f64> { bsdf.incidences.iter().map(f).collect() };
        for (name, unit, meaning, f) in [
            ("theta_i", "degree", "polar angle of the source", (|s| s.incidence.theta_deg) as fn(&Scattering) -> f64),
            ("phi_i", "degree", "azimuth of the source", |s| s.incidence.phi_deg),
            ("trees", "1", "ray trees traced", |s| s.trees as f64),
            ("segments", "1", "ray segments traced", |s| s.segments as f64),
        ] {
            self.put(name, &[self.incidence], &per_incidence(f), [unit, meaning, ""])?;
        }
        for (i, (name, _)) in Ledger::default().entries().into_iter().enumerate() {
            let rows: Vec<&[Estimate]> = bsdf.incidences.iter().map(|s| &s.ledger.entries()[i].1[..]).collect();
            let about = ["1", "share of the incident power", "theta_i phi_i"];
            self.put_estimates(name, self.incidence, &rows, about)?;
        }
        Ok(())
    }

    fn put_facets(&mut self, bsdf: &Bsdf) -> Written {
        let facets = || bsdf.incidences.iter().flat_map(|s| &s.facets);
        let owner = bsdf.incidences.iter().enumerate().flat_map(|(i, s)| vec![i as i32; s.facets.len()]);
        self.put_integers("facet_incidence", &owner.collect::<Vec<_>>(), "number of the incidence, from 0")?;
        let level: Vec<i32> = facets().map(|f| i32::from(f.facet.level)).collect();
        self.put_integers("facet_level", &level, "divisions of the icosahedron")?;
        let code: Vec<i32> = facets().map(|f| f.facet.code as i32).collect();
        self.put_integers("facet_code", &code, "number of the facet at its level")?;
        let theta = |f: &FacetValue| f.facet.center().z.clamp(-1.0, 1.0).acos().to_degrees();
        let phi = |f: &FacetValue| f.facet.center().y.atan2(f.facet.center().x).to_degrees();
        for (name, unit, meaning, f) in [
            ("theta_o", "degree", "polar angle of the facet's centre", &theta as &dyn Fn(&FacetValue) -> f64),
            ("phi_o", "degree", "azimuth of the facet's centre", &phi),
            ("solid_angle", "sr", "solid angle", &|f| f.facet.solid_angle()),
            ("projected_solid_angle", "sr", "projected solid angle", &|f| f.facet.projected_solid_angle()),
            ("facet_trees", "1", "ray trees that hit the facet", &|f| f.trees as f64),
        ] {
            let values: Vec<f64> = facets().map(f).collect();
            self.put(name, &[self.facet], &values, [unit, meaning, ""])?;
        }
        let rows: Vec<&[Estimate]> = facets().map(|f| &f.value[..]).collect();
        let meaning = "BRDF (theta_o < 90) or BTDF (theta_o > 90), without the specular and undeflected parts";
        self.put_estimates("bsdf", self.facet, &rows, ["sr-1", meaning, "theta_o phi_o facet_incidence"])
    }
}

/// Reads a result back.
///
/// # Errors
/// When the bytes are no result of this program.
pub fn from_bytes(bytes: &[u8]) -> Result<Measured, NetcdfError> {
    let file = NcFile::from_bytes(bytes).map_err(|e| broken(e.to_string()))?;
    let reader = Reader { file };
    let schema = reader.text("schema")?;
    if schema != SCHEMA {
        return Err(broken(format!("its schema is `{schema}`, expected `{SCHEMA}`")));
    }
    let provenance = serde_json::from_str(&reader.text("provenance")?).map_err(|e| broken(e.to_string()))?;
    Ok(Measured { bsdf: reader.bsdf()?, provenance })
}

struct Reader {
    file: NcFile,
}

impl Reader {
    fn text(&self, name: &str) -> Result<String, NetcdfError> {
        let attribute = self.file.global_attribute(name).map_err(|e| broken(e.to_string()))?;
        match &attribute.value {
            NcAttrValue::Chars(text) => Ok(text.clone()),
            _ => Err(broken(format!("attribute {name} is no text"))),
        }
    }

    /// All values of a variable, of which there must be `expected`.
    fn numbers(&self, name: &str, expected: usize) -> Result<Vec<f64>, NetcdfError> {
        let array = self.file.read_variable_as_f64(name).map_err(|e| broken(e.to_string()))?;
        if array.len() != expected {
            return Err(broken(format!("{name} has {} values, expected {expected}", array.len())));
        }
        Ok(array.into_iter().collect())
    }

    fn length(&self, dimension: &str) -> Result<usize, NetcdfError> {
        self.file.dimension(dimension).map(|d| d.size as usize).map_err(|e| broken(e.to_string()))
    }

    fn estimates(&self, name: &str, rows: usize, columns: usize) -> Result<Vec<Vec<Estimate>>, NetcdfError> {
        let values = self.numbers(name, rows * columns)?;
        let errors = self.numbers(&format!("{name}_se"), rows * columns)?;
        let all: Vec<Estimate> = values.iter().zip(&errors).map(|(&value, &se)| Estimate { value, se }).collect();
        Ok(all.chunks(columns.max(1)).map(<[Estimate]>::to_vec).collect())
    }

    fn bsdf(&self) -> Result<Bsdf, NetcdfError> {
        let [incidences, wavelengths] = [self.length("incidence")?, self.length("wavelength")?];
        let wavelength_nm = self.numbers("wavelength", wavelengths)?;
        let per_incidence = |name| self.numbers(name, incidences);
        let (theta, phi) = (per_incidence("theta_i")?, per_incidence("phi_i")?);
        let (trees, segments) = (per_incidence("trees")?, per_incidence("segments")?);
        let mut scatterings: Vec<Scattering> = (0..incidences)
            .map(|i| Scattering {
                incidence: Incidence { theta_deg: theta[i], phi_deg: phi[i] },
                trees: trees[i] as u64,
                segments: segments[i] as u64,
                ledger: Ledger::default(),
                facets: Vec::new(),
            })
            .collect();
        for (term, (name, _)) in Ledger::default().entries().into_iter().enumerate() {
            for (s, row) in scatterings.iter_mut().zip(self.estimates(name, incidences, wavelengths)?) {
                *s.ledger.entries_mut()[term].1 = row;
            }
        }
        for (owner, facet) in self.facets(wavelengths)? {
            scatterings
                .get_mut(owner)
                .ok_or_else(|| broken(format!("there is no incidence {owner}")))?
                .facets
                .push(facet);
        }
        Ok(Bsdf { wavelength_nm, incidences: scatterings })
    }

    /// All facets, with the number of their incidence.
    fn facets(&self, wavelengths: usize) -> Result<Vec<(usize, FacetValue)>, NetcdfError> {
        let facets = self.length("facet")?;
        let column = |name| self.numbers(name, facets);
        let (owner, trees) = (column("facet_incidence")?, column("facet_trees")?);
        let (level, code) = (column("facet_level")?, column("facet_code")?);
        let values = self.estimates("bsdf", facets, wavelengths)?;
        let facet = |(i, value): (usize, Vec<Estimate>)| {
            let facet = Facet { level: level[i] as u8, code: code[i] as u32 };
            if facet.level > FINEST_LEVEL || facet.code >= count(facet.level) {
                return Err(broken(format!("there is no facet {} of level {}", code[i], level[i])));
            }
            Ok((owner[i] as usize, FacetValue { facet, trees: trees[i] as u64, value }))
        };
        values.into_iter().enumerate().map(facet).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::measured::{UsedBackend, Validity};
    use super::*;

    fn measured() -> Measured {
        let estimate =
            |x: f64| vec![Estimate { value: x, se: x / 7.0 }, Estimate { value: 1.0 / x, se: f64::MIN_POSITIVE }];
        let scattering = |theta_deg: f64| {
            let mut ledger = Ledger::default();
            for (i, (_, entry)) in ledger.entries_mut().into_iter().enumerate() {
                *entry = estimate(0.1 + i as f64 + theta_deg);
            }
            let facets = Facet::all(1).map(|facet| FacetValue { facet, trees: 3, value: estimate(0.3 + theta_deg) });
            let incidence = Incidence { theta_deg, phi_deg: 0.1 };
            Scattering { incidence, trees: 1 << 40, segments: 7, ledger, facets: facets.collect() }
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
        };
        Measured {
            bsdf: Bsdf { wavelength_nm: vec![400.0, 500.1], incidences: vec![scattering(0.0), scattering(33.3)] },
            provenance,
        }
    }

    #[test]
    fn what_is_written_is_read() {
        let measured = measured();
        assert_eq!(from_bytes(&to_bytes(&measured).unwrap()).unwrap(), measured);
    }

    #[test]
    fn damaged_files_are_refused_and_never_abort() {
        let bytes = to_bytes(&measured()).unwrap();
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
