//! Files of refractiveindex.info: YAML with formulas and tables under `DATA`.
//!
//! ```yaml
//! REFERENCES: |        # whose numbers these are; with COMMENTS, CONDITIONS, ... in any order
//!     Schott
//! DATA:
//!   - type: formula 2
//!     wavelength_range: 0.3 2.5      # µm
//!     coefficients: 0 1.03961212 0.00600069867 0.231792344 0.0200179144 1.01046945 103.560653
//!   - type: tabulated k
//!     data: |
//!         0.300 2.8607E-06
//!         0.310 1.3679E-06
//! ```

use super::curve::Rows;
use super::yaml::{Pieces, Text, Wrong};
use super::{Curve, Dispersion, Formula};

/// What a file says.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Page {
    pub(super) dispersion: Dispersion,
    /// As it is in the file, with its tags of HTML or Markdown.
    pub(super) references: String,
}

const DATA: &str = "a list under DATA, of entries such as `- type: tabulated nk` with `data: |` and lines below it";

/// Reads the text of a file.
///
/// # Errors
/// The first thing that is wrong, and its line.
pub(super) fn parse(text: &str) -> Result<Page, Wrong> {
    let mut references = String::new();
    let mut data: Option<Vec<(usize, Entry<'_>)>> = None;
    let mut pieces = Pieces::new(text);
    pieces.map("a file of refractiveindex.info, with keys such as DATA", |pieces, key| {
        match &*key.text {
            "DATA" if data.is_some() => return Err(Wrong::at(key.line, "DATA comes twice; leave one out")),
            "DATA" => data = Some(pieces.maps(DATA, Entry::read)?),
            "REFERENCES" => references = pieces.text("REFERENCES")?.text.trim().into(),
            _ => pieces.skip()?,
        }
        Ok(())
    })?;
    let data = data.filter(|data| !data.is_empty()).ok_or_else(|| Wrong::at(1, format!("expected {DATA}")))?;
    Ok(Page { dispersion: dispersion(&data)?, references })
}

/// An entry under `DATA`, as written.
#[derive(Debug, Default)]
struct Entry<'a> {
    kind: Option<Text<'a>>,
    data: Option<Text<'a>>,
    range: Option<Text<'a>>,
    coefficients: Option<Text<'a>>,
}

/// What an entry gives.
#[derive(Default)]
struct Given {
    n: Option<Curve>,
    k: Option<Curve>,
}

fn dispersion(data: &[(usize, Entry<'_>)]) -> Result<Dispersion, Wrong> {
    let mut all = Given::default();
    for (line, entry) in data {
        let given = entry.given(*line)?;
        for (name, old, new) in [("n", &mut all.n, given.n), ("k", &mut all.k, given.k)] {
            if old.is_some() && new.is_some() {
                return Err(Wrong::at(*line, format!("{name} is given twice; leave one of the entries out")));
            }
            *old = new.or(old.take());
        }
    }
    let first = data.first().map_or(1, |(line, _)| *line);
    let n = all.n.ok_or_else(|| Wrong::at(first, "there is no n; expected a formula, tabulated n or tabulated nk"))?;
    let k = all.k.unwrap_or(Curve::Constant(0.0));
    let (of_n, of_k) = (n.range(), k.range());
    if of_n.1 < of_k.0 || of_k.1 < of_n.0 {
        return Err(Wrong::at(first, "n and k are known at no wavelength in common; take data that overlap"));
    }
    Ok(Dispersion::Curves { n, k })
}

impl<'a> Entry<'a> {
    fn read(pieces: &mut Pieces<'a>, entry: &mut Self, key: &Text<'a>) -> Result<(), Wrong> {
        let name = &*key.text;
        let field = match name {
            "type" => &mut entry.kind,
            "data" => &mut entry.data,
            // The name it had in the first years of the database.
            "wavelength_range" | "range" => &mut entry.range,
            "coefficients" => &mut entry.coefficients,
            _ => return pieces.skip(),
        };
        if field.is_some() {
            return Err(Wrong::at(key.line, format!("{name} comes twice; leave one out")));
        }
        *field = Some(pieces.text(name)?);
        Ok(())
    }

    fn given(&self, line: usize) -> Result<Given, Wrong> {
        let kind = present(&self.kind, line, "type", "tabulated nk")?;
        let words: Vec<&str> = kind.text.split_whitespace().collect();
        match words[..] {
            ["tabulated", "n"] => Ok(Given { n: Some(self.table(line, "λ n")?.0), k: None }),
            ["tabulated", "k"] => Ok(Given { n: None, k: Some(self.table(line, "λ k")?.1) }),
            ["tabulated", "nk"] => {
                let (n, k) = self.table(line, "λ n k")?;
                Ok(Given { n: Some(n), k: Some(k) })
            }
            // Nonlinear optics is none of ours.
            ["tabulated", "n2"] => Ok(Given::default()),
            ["formula", number] => Ok(Given { n: Some(self.formula(line, kind, number)?), k: None }),
            _ => Err(Wrong::at(kind.line, unknown_type(&kind.text))),
        }
    }

    /// n and k of a table with these columns.
    fn table(&self, line: usize, columns: &str) -> Result<(Curve, Curve), Wrong> {
        let data = present(&self.data, line, "data", "| and lines of λ in µm and the values")?;
        let mut rows = Rows::default();
        for (line, row) in data.lines() {
            let wrong = |message: String| Wrong::at(line, format!("`{row:.80}`: {message}"));
            let values = numbers(row).map_err(wrong)?;
            let pushed = match (columns, &values[..]) {
                ("λ n", &[um, n]) => rows.push(um, Some(n), None),
                ("λ k", &[um, k]) => rows.push(um, None, Some(k)),
                ("λ n k", &[um, n, k]) => rows.push(um, Some(n), Some(k)),
                _ => Err(format!("expected {columns}, λ in µm")),
            };
            pushed.map_err(wrong)?;
        }
        if rows.n.is_empty() && rows.k.is_empty() {
            return Err(Wrong::at(data.line, format!("data: expected lines of {columns}, λ in µm")));
        }
        Ok((Curve::Table(rows.n), Curve::Table(rows.k)))
    }

    fn formula(&self, line: usize, kind: &Text<'_>, number: &str) -> Result<Curve, Wrong> {
        let number = number.parse().map_err(|_| Wrong::at(kind.line, unknown_type(&kind.text)))?;
        let range = present(&self.range, line, "wavelength_range", "0.3 2.5")?;
        let coefficients = present(&self.coefficients, line, "coefficients", "0 1.124 0.011087")?;
        let read = |key: &str, text: &Text<'_>| {
            numbers(&text.text).map_err(|message| Wrong::at(text.line, format!("{key}: {message}")))
        };
        let &[low, high] = &read("wavelength_range", range)?[..] else {
            return Err(Wrong::at(range.line, "wavelength_range: expected two wavelengths in µm, such as 0.3 2.5"));
        };
        let formula = Formula::new(number, read("coefficients", coefficients)?, (low, high));
        Ok(Curve::Formula(formula.map_err(|message| Wrong::at(kind.line, message))?))
    }
}

fn unknown_type(found: &str) -> String {
    format!("type `{found:.80}`: expected formula 1 to formula 9, tabulated n, tabulated k or tabulated nk")
}

fn present<'t, 'a>(field: &'t Option<Text<'a>>, line: usize, key: &str, example: &str) -> Result<&'t Text<'a>, Wrong> {
    field.as_ref().ok_or_else(|| Wrong::at(line, format!("`{key}` is missing; write for example {key}: {example}")))
}

/// Finite numbers between blanks.
fn numbers(text: &str) -> Result<Vec<f64>, String> {
    let number = |word: &str| {
        let x = word.parse().ok().filter(|x: &f64| x.is_finite());
        x.ok_or_else(|| format!("`{word:.40}` is no number"))
    };
    text.split_whitespace().map(number).collect()
}
