//! Many results as one table: a row per measurement, incidence and wavelength.

use std::fmt::Write as _;

use netcdf_writer::{NcAttrValue, NcFileBuilder, NcWriteOptions};

use super::measured::Measured;
use super::netcdf::NetcdfError;
use crate::bsdf::Ledger;
use crate::dome::Estimate;

/// Results of measurements of which something is varied.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sweep {
    /// What is varied, in any of them.
    pub keys: Vec<String>,
    /// All rows.
    pub rows: Vec<Row>,
}

/// A row of the table.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// What the measurement is called.
    pub name: String,
    /// Values of what is varied, in the order of the keys; none where it is not.
    pub values: Vec<Option<String>>,
    /// Direction towards the source, degrees.
    pub theta_deg: f64,
    /// Its azimuth.
    pub phi_deg: f64,
    /// Vacuum wavelength, nm.
    pub wavelength_nm: f64,
    /// Trees traced at this incidence.
    pub trees: u64,
    /// Shares of the incident power, in the order of [`names`].
    pub shares: Vec<Estimate>,
}

/// Names of the shares.
pub fn names() -> Vec<&'static str> {
    let mut names: Vec<&str> = Ledger::default().entries().into_iter().map(|(name, _)| name).collect();
    names.truncate(SHARES);
    names
}

/// Entries of the ledger that are told: reflected, transmitted, absorbed, side, specular and undeflected.
const SHARES: usize = 6;

impl Sweep {
    /// Adds a result; `varied` are keys with their values.
    pub fn add(&mut self, name: &str, varied: &[(String, String)], measured: &Measured) {
        for (key, _) in varied {
            if !self.keys.contains(key) {
                self.keys.push(key.clone());
            }
        }
        let value = |key: &String| varied.iter().find(|(k, _)| k == key).map(|(_, v)| v.clone());
        let values: Vec<Option<String>> = self.keys.iter().map(value).collect();
        for s in &measured.bsdf.incidences {
            let entries = s.ledger.entries();
            for (w, &wavelength_nm) in measured.bsdf.wavelength_nm.iter().enumerate() {
                self.rows.push(Row {
                    name: name.into(),
                    values: values.clone(),
                    theta_deg: s.incidence.theta_deg,
                    phi_deg: s.incidence.phi_deg,
                    wavelength_nm,
                    trees: s.trees,
                    shares: entries[..SHARES].iter().map(|(_, e)| e[w]).collect(),
                });
            }
        }
    }

    /// The value of a key in a row, if it is varied there.
    pub fn value<'r>(&self, row: &'r Row, key: usize) -> Option<&'r str> {
        // Keys that came later are none of earlier rows.
        row.values.get(key).and_then(Option::as_deref)
    }

    /// Values of a key as numbers, if all are.
    pub fn numbers(&self, key: usize) -> Option<Vec<f64>> {
        self.rows.iter().map(|row| self.value(row, key)?.parse().ok().filter(|x: &f64| x.is_finite())).collect()
    }

    /// A line per row, shares as fractions.
    pub fn csv(&self) -> String {
        let mut out = String::from("measurement");
        self.keys.iter().for_each(|key| out += &format!(",{}", quoted(key)));
        out += ",theta_i_deg,phi_i_deg,wavelength_nm,trees";
        names().iter().for_each(|name| out += &format!(",{name},{name}_se"));
        out.push('\n');
        for row in &self.rows {
            out += &quoted(&row.name);
            (0..self.keys.len())
                .for_each(|key| out += &format!(",{}", quoted(self.value(row, key).unwrap_or_default())));
            let _ = write!(out, ",{},{},{},{}", row.theta_deg, row.phi_deg, row.wavelength_nm, row.trees);
            row.shares.iter().for_each(|e| {
                let _ = write!(out, ",{},{}", e.value, e.se);
            });
            out.push('\n');
        }
        out
    }

    /// The same as a NetCDF file with one dimension, `row`: what is varied is a number where all its values are, else a code
    /// whose meanings are an attribute.
    ///
    /// # Errors
    /// When there is more data than the format can hold.
    pub fn netcdf(&self) -> Result<Vec<u8>, NetcdfError> {
        let mut file = NcFileBuilder::new();
        let row = file.add_dimension("row", self.rows.len() as u64)?;
        for (name, value) in
            [("Conventions", "CF-1.8"), ("title", "Measurements of a batch"), ("schema", "gonio-sweep-1")]
        {
            file.add_attribute(name, NcAttrValue::Chars(value.into()))?;
        }
        let mut put = |name: &str, values: &[f64], unit: &str, meanings: Option<String>| -> Result<(), NetcdfError> {
            let variable = file.add_variable::<f64>(name, &[row])?;
            let meanings = meanings.map(|text| ("flag_meanings", text));
            for (name, value) in [("units", unit.to_string())].into_iter().chain(meanings) {
                file.add_variable_attribute(variable, name, NcAttrValue::Chars(value))?;
            }
            Ok(file.write_variable(variable, values)?)
        };
        let texts = self.rows.iter().map(|r| r.name.clone()).collect();
        let (codes, meanings) = coded(texts);
        put("measurement", &codes, "1", Some(meanings))?;
        for (i, key) in self.keys.iter().enumerate() {
            let name = identifier(key);
            if let Some(numbers) = self.numbers(i) {
                put(&name, &numbers, "1", None)?;
                continue;
            }
            let texts = self.rows.iter().map(|r| self.value(r, i).unwrap_or_default().into()).collect();
            let (codes, meanings) = coded(texts);
            put(&name, &codes, "1", Some(meanings))?;
        }
        let of = |f: &dyn Fn(&Row) -> f64| -> Vec<f64> { self.rows.iter().map(f).collect() };
        put("theta_i", &of(&|r| r.theta_deg), "degree", None)?;
        put("phi_i", &of(&|r| r.phi_deg), "degree", None)?;
        put("wavelength_nm", &of(&|r| r.wavelength_nm), "nm", None)?;
        put("trees", &of(&|r| r.trees as f64), "1", None)?;
        for (i, name) in names().into_iter().enumerate() {
            put(name, &of(&|r| r.shares[i].value), "1", None)?;
            put(&format!("{name}_se"), &of(&|r| r.shares[i].se), "1", None)?;
        }
        Ok(file.to_vec(NcWriteOptions::offset64())?.1)
    }
}

/// A field of a CSV file.
fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.into() }
}

/// What can be the name of a variable, and is none of the others.
fn identifier(key: &str) -> String {
    let name: String = key.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
    let is_taken = names().contains(&&name[..]) || ["measurement", "trees", "row"].contains(&&name[..]);
    if is_taken { name + "_asked" } else { name }
}

/// Numbers from 0 for texts, and what they mean, one per line.
fn coded(texts: Vec<String>) -> (Vec<f64>, String) {
    let mut known: Vec<String> = Vec::new();
    let mut code = |text: String| {
        let at = known.iter().position(|k| *k == text).unwrap_or_else(|| {
            known.push(text);
            known.len() - 1
        });
        at as f64
    };
    let codes = texts.into_iter().map(&mut code).collect();
    (codes, known.join("\n"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sweep() -> Sweep {
        let shares = vec![Estimate { value: 0.25, se: 0.01 }; SHARES];
        let row = |name: &str, values: Vec<Option<String>>| Row {
            name: name.into(),
            values,
            theta_deg: 30.0,
            phi_deg: 0.0,
            wavelength_nm: 550.0,
            trees: 32,
            shares: shares.clone(),
        };
        Sweep {
            keys: vec!["seed".into(), "objects.fibre.flatten".into(), "sample.below".into()],
            rows: vec![
                row("a", vec![Some("1".into()), Some("0.5".into())]),
                row("b, too", vec![Some("2".into()), Some("1.0".into()), Some("water".into())]),
            ],
        }
    }

    #[test]
    fn a_line_of_csv_has_all_there_is() {
        let csv = sweep().csv();
        let lines: Vec<&str> = csv.lines().collect();
        assert!(lines[0].starts_with("measurement,seed,objects.fibre.flatten,sample.below,theta_i_deg,"), "{csv}");
        assert!(lines[1].starts_with("a,1,0.5,,30,0,550,32,0.25,0.01,"), "{csv}");
        assert!(lines[2].starts_with("\"b, too\",2,1.0,water,30,"), "{csv}");
        assert!(lines.iter().all(|l| l.matches(',').count() >= 7 + 2 * SHARES));
    }

    #[test]
    fn numbers_are_numbers_and_texts_have_codes() {
        let sweep = sweep();
        assert_eq!(sweep.numbers(1), Some(vec![0.5, 1.0]));
        assert_eq!(sweep.numbers(2), None);
        let file = netcdf_reader::NcFile::from_bytes(&sweep.netcdf().unwrap()).unwrap();
        let text = format!("{:?}", file.variable("sample_below").unwrap().attributes());
        assert!(text.contains("water"), "{text}");
        assert!(file.variable("objects_fibre_flatten").is_ok() && file.variable("reflected_se").is_ok());
    }
}
