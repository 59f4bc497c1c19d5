//! Reads a result back.

use netcdf_reader::NcFile;
use netcdf_writer::NcAttrValue;

use super::super::measured::Measured;
use super::derived::{COLOURS, PRECISION, SHARES, precision_mut};
use super::{NetcdfError, SCHEMA, broken};
use crate::bsdf::{Bsdf, DeltaMatrices, Derived, FacetValue, Ledger, Matrices, Scattering};
use crate::dome::{Estimate, FINEST_LEVEL, Facet, count};
use crate::light::{Incidence, Wavelengths};

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
        Wavelengths::from_nm(wavelength_nm.clone()).map_err(broken)?;
        let per_incidence = |name| self.numbers(name, incidences);
        let (theta, phi) = (per_incidence("theta_i")?, per_incidence("phi_i")?);
        if incidences == 0 {
            return Err(broken("it has no incidence"));
        }
        let mut directions = theta.iter().zip(&phi).map(|(&theta_deg, &phi_deg)| Incidence { theta_deg, phi_deg });
        directions.try_for_each(|i| i.check()).map_err(|e| broken(format!("incidence {e}")))?;
        let (trees, segments) = (per_incidence("trees")?, per_incidence("segments")?);
        let straight = self.numbers("undeflected_theta", incidences * wavelengths)?;
        let straight: Vec<Vec<f64>> = straight.chunks(wavelengths.max(1)).map(<[f64]>::to_vec).collect();
        let mut scatterings: Vec<Scattering> = (0..incidences)
            .map(|i| Scattering {
                incidence: Incidence { theta_deg: theta[i], phi_deg: phi[i] },
                straight_deg: straight[i].clone(),
                trees: trees[i] as u64,
                segments: segments[i] as u64,
                ledger: Ledger::default(),
                absorbed_by: Vec::new(),
                deltas: None,
                facets: Vec::new(),
                derived: Derived::default(),
            })
            .collect();
        for (term, (name, _)) in Ledger::default().entries().into_iter().enumerate() {
            for (s, row) in scatterings.iter_mut().zip(self.estimates(name, incidences, wavelengths)?) {
                *s.ledger.entries_mut()[term].1 = row;
            }
        }
        self.derived(&mut scatterings, wavelengths)?;
        let groups = self.groups()?;
        for rows in
            self.estimates_or_none("absorbed_by", groups.len() * incidences, wavelengths)?.chunks(incidences.max(1))
        {
            scatterings.iter_mut().zip(rows).for_each(|(s, row)| s.absorbed_by.push(row.clone()));
        }
        let mut specular = self.matrices("specular_mueller", incidences, wavelengths)?.into_iter();
        let mut undeflected = self.matrices("undeflected_mueller", incidences, wavelengths)?.into_iter();
        for s in &mut scatterings {
            s.deltas = specular
                .next()
                .zip(undeflected.next())
                .map(|(specular, undeflected)| DeltaMatrices { specular, undeflected });
        }
        for (owner, facet) in self.facets(wavelengths)? {
            scatterings
                .get_mut(owner)
                .ok_or_else(|| broken(format!("there is no incidence {owner}")))?
                .facets
                .push(facet);
        }
        Ok(Bsdf { wavelength_nm, groups, incidences: scatterings })
    }

    /// Errors of the whole, ratios and colours; older files have none.
    fn derived(&self, scatterings: &mut [Scattering], wavelengths: usize) -> Result<(), NetcdfError> {
        for (i, (name, _)) in PRECISION.into_iter().enumerate().filter(|(_, (name, _))| self.has(name)) {
            let errors = self.numbers(name, scatterings.len())?;
            for (s, error) in scatterings.iter_mut().zip(errors) {
                *precision_mut(&mut s.derived.precision)[i] = error;
            }
        }
        let count = scatterings.len();
        let [specular, undeflected] = SHARES.map(|(name, _)| self.estimates_or_none(name, count, wavelengths));
        let [reflected, transmitted] = COLOURS.map(|(name, _)| self.estimates_or_none(name, count, 3));
        let (specular, undeflected, reflected, transmitted) = (specular?, undeflected?, reflected?, transmitted?);
        let lab = |rows: &[Vec<Estimate>], i: usize| rows.get(i).map(|row| [row[0], row[1], row[2]]);
        for (i, s) in scatterings.iter_mut().enumerate() {
            s.derived.specular_share = specular.get(i).cloned().unwrap_or_default();
            s.derived.undeflected_share = undeflected.get(i).cloned().unwrap_or_default();
            (s.derived.reflected_lab, s.derived.transmitted_lab) = (lab(&reflected, i), lab(&transmitted, i));
        }
        Ok(())
    }

    /// Names of the groups whose absorbed power is told apart.
    fn groups(&self) -> Result<Vec<String>, NetcdfError> {
        if !self.has("group") {
            return Ok(Vec::new());
        }
        let names = self.file.read_variable_as_strings("group").map_err(|e| broken(e.to_string()))?;
        Ok(names.iter().map(|name| name.trim_end_matches('\0').into()).collect())
    }

    fn has(&self, variable: &str) -> bool {
        self.file.variable(variable).is_ok()
    }

    fn estimates_or_none(&self, name: &str, rows: usize, columns: usize) -> Result<Vec<Vec<Estimate>>, NetcdfError> {
        if self.has(name) { self.estimates(name, rows, columns) } else { Ok(Vec::new()) }
    }

    /// Matrices per row and wavelength; none if there are none in the file.
    fn matrices(&self, name: &str, rows: usize, wavelengths: usize) -> Result<Vec<Matrices>, NetcdfError> {
        let all = self.estimates_or_none(name, rows, 16 * wavelengths)?;
        Ok(all.into_iter().map(|row| row.as_chunks().0.to_vec()).collect())
    }

    /// All facets, with the number of their incidence.
    fn facets(&self, wavelengths: usize) -> Result<Vec<(usize, FacetValue)>, NetcdfError> {
        let facets = self.length("facet")?;
        let column = |name| self.numbers(name, facets);
        let (owner, trees) = (column("facet_incidence")?, column("facet_trees")?);
        let (level, code) = (column("facet_level")?, column("facet_code")?);
        let values = self.estimates("bsdf", facets, wavelengths)?;
        let mut matrices = self.matrices("mueller", facets, wavelengths)?.into_iter();
        let facet = |(i, value): (usize, Vec<Estimate>)| {
            let facet = Facet { level: level[i] as u8, code: code[i] as u32 };
            if facet.level > FINEST_LEVEL || facet.code >= count(facet.level) {
                return Err(broken(format!("there is no facet {} of level {}", code[i], level[i])));
            }
            let mueller = matrices.next().unwrap_or_default();
            Ok((owner[i] as usize, FacetValue { facet, trees: trees[i] as u64, value, mueller }))
        };
        values.into_iter().enumerate().map(facet).collect()
    }
}
