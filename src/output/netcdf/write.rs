//! Writes a result.

use netcdf_writer::{DimensionId, NcAttrValue, NcFileBuilder, NcWriteOptions, VariableId};

use super::super::measured::{Measured, Provenance};
use super::derived::{COLOURS, PRECISION, SHARES, precision_mut};
use super::{NetcdfError, SCHEMA};
use crate::bsdf::{Bsdf, FacetValue, Ledger, Matrices, Scattering};
use crate::dome::Estimate;

/// The bytes of the file.
///
/// # Errors
/// When there is more data than the format can hold.
pub fn to_bytes(measured: &Measured) -> Result<Vec<u8>, NetcdfError> {
    let mut file = Writer::new(&measured.bsdf)?;
    file.describe(&measured.provenance)?;
    file.put_incidences(&measured.bsdf)?;
    file.put_derived(&measured.bsdf)?;
    file.put_groups(&measured.bsdf)?;
    file.put_facets(&measured.bsdf)?;
    file.put_matrices(&measured.bsdf)?;
    Ok(file.builder.to_vec(NcWriteOptions::offset64())?.1)
}

struct Writer {
    builder: NcFileBuilder,
    incidence: DimensionId,
    wavelength: DimensionId,
    facet: DimensionId,
}

/// What the errors of a facet mean, and where they mean nothing.
const RESOLVED_MEANING: &str =
    "1: the 95 % interval is bsdf +- 2.04 bsdf_se; 0: too few trees have hit the facet to tell";

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

    /// Values and standard errors over `dims`.
    fn put_estimates<'e>(
        &mut self,
        name: &str,
        dims: &[DimensionId],
        all: impl Iterator<Item = &'e Estimate>,
        about: [&str; 3],
    ) -> Written {
        let (values, errors): (Vec<f64>, Vec<f64>) = all.map(|e| (e.value, e.se)).unzip();
        self.put(name, dims, &values, about)?;
        let meaning = format!("standard error of {name}");
        self.put(&format!("{name}_se"), dims, &errors, [about[0], &meaning, about[2]])
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
        let straight: Vec<f64> = bsdf.incidences.iter().flat_map(|s| s.straight_deg.iter().copied()).collect();
        let about = ["degree", "angle from the normal below at which undeflected light leaves", "theta_i phi_i"];
        self.put("undeflected_theta", &[self.incidence, self.wavelength], &straight, about)?;
        for (i, (name, _)) in Ledger::default().entries().into_iter().enumerate() {
            let all = bsdf.incidences.iter().flat_map(|s| s.ledger.entries()[i].1);
            let about = ["1", "share of the incident power", "theta_i phi_i"];
            self.put_estimates(name, &[self.incidence, self.wavelength], all, about)?;
        }
        Ok(())
    }

    /// Errors of the whole, ratios and colours.
    fn put_derived(&mut self, bsdf: &Bsdf) -> Written {
        let derived = || bsdf.incidences.iter().map(|s| &s.derived);
        for (i, (name, meaning)) in PRECISION.into_iter().enumerate() {
            let values: Vec<f64> = derived().map(|d| *precision_mut(&mut { d.precision })[i]).collect();
            self.put(name, &[self.incidence], &values, ["1", meaning, ""])?;
        }
        let [specular, undeflected]: [Vec<&Estimate>; 2] = [
            derived().flat_map(|d| &d.specular_share).collect(),
            derived().flat_map(|d| &d.undeflected_share).collect(),
        ];
        // Results of formulas have none.
        let told = specular.len() == bsdf.incidences.len() * bsdf.wavelength_nm.len();
        for ((name, meaning), all) in SHARES.into_iter().zip([specular, undeflected]).filter(|_| told) {
            let about = ["1", meaning, "theta_i phi_i"];
            self.put_estimates(name, &[self.incidence, self.wavelength], all.into_iter(), about)?;
        }
        let reflected: Option<Vec<[Estimate; 3]>> = derived().map(|d| d.reflected_lab).collect();
        let transmitted: Option<Vec<[Estimate; 3]>> = derived().map(|d| d.transmitted_lab).collect();
        let Some(colours) = reflected.zip(transmitted) else { return Ok(()) };
        let lab = self.builder.add_dimension("lab", 3)?;
        for ((name, meaning), all) in COLOURS.into_iter().zip([colours.0, colours.1]) {
            let about = ["1", meaning, "theta_i phi_i"];
            self.put_estimates(name, &[self.incidence, lab], all.iter().flatten(), about)?;
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
        let resolved: Vec<i32> = facets().map(|f| i32::from(f.is_resolved())).collect();
        self.put_integers("facet_resolved", &resolved, RESOLVED_MEANING)?;
        let meaning = "BRDF (theta_o < 90) or BTDF (theta_o > 90), without the specular and undeflected parts";
        let about = ["sr-1", meaning, "theta_o phi_o facet_incidence"];
        self.put_estimates("bsdf", &[self.facet, self.wavelength], facets().flat_map(|f| &f.value), about)
    }

    /// What each group of bodies has absorbed.
    fn put_groups(&mut self, bsdf: &Bsdf) -> Written {
        let Some(width) = bsdf.groups.iter().map(String::len).max() else { return Ok(()) };
        let group = self.builder.add_dimension("group", bsdf.groups.len() as u64)?;
        let letter = self.builder.add_dimension("group_letter", width as u64)?;
        let names = self.builder.add_char_variable("group", &[group, letter])?;
        self.note(names, "", "bodies whose absorbed power is told apart", "")?;
        self.builder.add_variable_attribute(names, "_Encoding", NcAttrValue::Chars("utf-8".into()))?;
        self.builder.write_char_variable_strings(names, &bsdf.groups)?;
        let all = (0..bsdf.groups.len()).flat_map(|g| bsdf.incidences.iter().flat_map(move |s| &s.absorbed_by[g]));
        let about = ["1", "share of the incident power that a group of bodies has absorbed", "theta_i phi_i"];
        self.put_estimates("absorbed_by", &[group, self.incidence, self.wavelength], all, about)
    }

    fn put_matrices(&mut self, bsdf: &Bsdf) -> Written {
        if bsdf.incidences.iter().all(|s| s.deltas.is_none()) {
            return Ok(());
        }
        let row = self.builder.add_dimension("mueller_row", 4)?;
        let column = self.builder.add_dimension("mueller_column", 4)?;
        let facets = bsdf.incidences.iter().flat_map(|s| &s.facets).flat_map(|f| &f.mueller).flatten();
        let meaning = "Mueller matrix of the BSDF for Stokes vectors (I, Q, U, V), Q = p - s, U + iV = 2 Ep Es*";
        let about = ["sr-1", meaning, "theta_o phi_o facet_incidence"];
        self.put_estimates("mueller", &[self.facet, self.wavelength, row, column], facets, about)?;
        let deltas = bsdf.incidences.iter().filter_map(|s| s.deltas.as_ref());
        let specular: Vec<&Matrices> = deltas.clone().map(|d| &d.specular).collect();
        let undeflected: Vec<&Matrices> = deltas.map(|d| &d.undeflected).collect();
        for (name, all) in [("specular_mueller", specular), ("undeflected_mueller", undeflected)] {
            let all = all.into_iter().flatten().flatten();
            let about = ["1", "Mueller matrix, share of the incident power", "theta_i phi_i"];
            self.put_estimates(name, &[self.incidence, self.wavelength, row, column], all, about)?;
        }
        Ok(())
    }
}
