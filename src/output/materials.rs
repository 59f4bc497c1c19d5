//! Media by themselves: a table of all, the details of one, and both as JSON.

use std::fmt::Write as _;

use serde::Serialize;

use crate::media::{Builtin, Certainty, Dispersion, FromFile, NoIndex};
use crate::optics::C64;
use crate::units::significant;

/// A medium to be shown.
#[derive(Clone, Debug)]
pub struct Material {
    /// Its names, the first being the usual one; of a file, its path.
    pub names: Vec<String>,
    /// Where its numbers come from.
    pub source: String,
    /// How far they can be relied on; of a file the program does not know.
    pub certainty: Option<Certainty>,
    /// What else is to be known of it.
    pub remark: &'static str,
    /// The numbers.
    pub dispersion: Dispersion,
}

impl From<&Builtin> for Material {
    fn from(b: &Builtin) -> Self {
        Self {
            names: b.names.iter().map(|&name| name.into()).collect(),
            source: b.source.into(),
            certainty: Some(b.certainty),
            remark: b.remark,
            dispersion: b.dispersion(),
        }
    }
}

impl Material {
    /// That of a file.
    pub fn of_file(path: &str, file: FromFile) -> Self {
        let source = if file.source.is_empty() { "the file does not say".into() } else { file.source };
        Self { names: vec![path.into()], source, certainty: None, remark: "", dispersion: file.dispersion }
    }

    /// Where it is known, nm; none if everywhere.
    pub fn range_nm(&self) -> Option<(f64, f64)> {
        let (low, high) = self.dispersion.range();
        high.is_finite().then_some((low * 1e3, high * 1e3))
    }

    /// Its index at wavelengths in nm.
    ///
    /// # Errors
    /// The first wavelength at which it has none.
    pub fn indices(&self, nm: &[f64]) -> Result<Vec<C64>, NoIndex> {
        nm.iter().map(|nm| self.dispersion.index(nm / 1e3)).collect()
    }

    /// Every 20 nm of visible light where it is known, or a few wavelengths of its range where that is elsewhere.
    pub fn some_wavelengths(&self) -> Vec<f64> {
        let (low, high) = self.range_nm().unwrap_or((0.0, f64::INFINITY));
        let visible: Vec<f64> = (0..=20).map(|i| 380.0 + 20.0 * f64::from(i)).collect();
        let known: Vec<f64> = visible.into_iter().filter(|nm| (low..=high).contains(nm)).collect();
        if known.is_empty() { evenly(low, high, 11) } else { known }
    }

    /// Enough wavelengths for a curve: its range, of a wide one what is not far from visible light.
    pub fn curve_wavelengths(&self) -> Vec<f64> {
        let (low, high) = self.range_nm().unwrap_or((380.0, 780.0));
        let (a, b) = (low.max(200.0), high.min(2000.0));
        if a < b { evenly(a, b, 400) } else { evenly(low, high, 400) }
    }

    fn range_text(&self) -> String {
        self.range_nm().map_or("all".into(), |(low, high)| format!("{} to {}", shown(low), shown(high)))
    }
}

fn shown(nm: f64) -> String {
    significant(nm, 6)
}

/// `count` numbers from `low` to `high`, both among them.
fn evenly(low: f64, high: f64, count: u32) -> Vec<f64> {
    let count = if low < high { count } else { 1 };
    let at = |i: u32| low + (high - low) * f64::from(i) / f64::from((count - 1).max(1));
    // Rounding must not leave the range.
    (0..count).map(|i| at(i).clamp(low, high)).collect()
}

/// n and k for people.
fn digits(index: C64) -> (String, String) {
    let k = match index.im {
        0.0 => "0".into(),
        k if k < 1e-3 => format!("{k:.2e}"),
        k => format!("{k:.5}"),
    };
    (format!("{:.6}", index.re), k)
}

/// The wavelength at which media are compared, µm.
const GREEN: f64 = 0.55;

/// A line per medium.
pub fn table(materials: &[Material]) -> String {
    let uncertain = |m: &Material| matches!(m.certainty, Some(Certainty::Uncertain(_)));
    let names = |m: &Material| m.names.join(", ") + if uncertain(m) { " *" } else { "" };
    let width = materials.iter().map(|m| names(m).chars().count()).max().unwrap_or(0).max(4);
    let mut out = format!("{:<width$}  {:<18}{:>10}{:>10}  source\n", "name", "range/nm", "n(550)", "k(550)");
    for m in materials {
        let (n, k) = m.dispersion.index(GREEN).map_or(("-".into(), "-".into()), digits);
        let _ = writeln!(out, "{:<width$}  {:<18}{n:>10}{k:>10}  {}", names(m), m.range_text(), m.source);
    }
    out + "\n* not all of its numbers are certain: `gonio-embree materials NAME` says which\n"
}

/// All there is to say of one, with its index at wavelengths in nm.
pub fn details(m: &Material, nm: &[f64], index: &[C64]) -> String {
    let mut out = m.names.join(", ") + "\n";
    let mut say = |what: &str, text: &str| out += &paragraph(what, text);
    say("source", &plain(&m.source));
    match m.certainty {
        Some(Certainty::Published) => say("certainty", "All numbers are as published."),
        Some(Certainty::Uncertain(which)) => say("certainty", &format!("Not all numbers are certain. {which}")),
        None => {}
    }
    if !m.remark.is_empty() {
        say("remark", m.remark);
    }
    say("range", &(m.range_text() + if m.range_nm().is_some() { " nm" } else { " wavelengths" }));
    let (n, k) = described(&m.dispersion);
    say("n", &n);
    say("k", &k);
    let _ = writeln!(out, "\n{:>12}{:>12}{:>12}", "λ/nm", "n", "k");
    for (nm, index) in nm.iter().zip(index) {
        let (n, k) = digits(*index);
        let _ = writeln!(out, "{:>12}{n:>12}{k:>12}", shown(*nm));
    }
    out
}

/// Longest title, characters.
const TITLE: usize = 130;

/// Its name and source in one line.
pub fn title(m: &Material) -> String {
    let name = m.names.first().map_or("", String::as_str);
    let doubt = if matches!(m.certainty, Some(Certainty::Uncertain(_))) { " (not all certain)" } else { "" };
    format!("{name}{doubt}: {}", plain(&m.source))
        .split_whitespace()
        .collect::<Vec<_>>()
        .join(" ")
        .chars()
        .take(TITLE)
        .collect()
}

/// What n and k are made of.
fn described(dispersion: &Dispersion) -> (String, String) {
    match dispersion {
        Dispersion::Constant(index) => (index.re.to_string(), index.im.to_string()),
        Dispersion::Cauchy { a, b } => (format!("{a} + {b}/λ², λ in nm"), "0".into()),
        Dispersion::Curves { n, k } => (n.description(), k.description()),
        Dispersion::Extrapolated(known) => described(known),
    }
}

/// Columns of a line, and of what stands before the text.
const LINE: usize = 100;
const INDENT: usize = 11;

/// A text of several lines behind what it is about.
fn paragraph(what: &str, text: &str) -> String {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let line = lines.last().map_or(0, |line| line.chars().count());
        if line > 0 && INDENT + line + 1 + word.chars().count() > LINE {
            lines.push(String::new());
        }
        if let Some(line) = lines.last_mut() {
            *line += if line.is_empty() { "" } else { " " };
            *line += word;
        }
    }
    let heads = std::iter::once(what).chain(std::iter::repeat(""));
    heads.zip(lines).map(|(head, line)| format!("{head:<INDENT$}{line}\n")).collect()
}

/// References without their tags of HTML.
fn plain(text: &str) -> String {
    const TAGS: [&str; 9] = ["a", "b", "br", "em", "i", "p", "strong", "sub", "sup"];
    let mut out = String::new();
    let mut rest = text;
    while let Some((before, behind)) = rest.split_once('<') {
        out += before;
        let inside = behind.split_once('>');
        let is_tag = |tag: &str| {
            let name = tag.trim_start_matches('/').split(|c: char| c.is_whitespace() || c == '/').next();
            TAGS.contains(&name.unwrap_or_default().to_lowercase().as_str())
        };
        match inside.filter(|(tag, _)| is_tag(tag)) {
            Some((_, after)) => rest = after,
            None => {
                out.push('<');
                rest = behind;
            }
        }
    }
    out + rest
}

#[derive(Serialize)]
struct Document<'a> {
    schema: &'static str,
    materials: Vec<Entry<'a>>,
}

#[derive(Serialize)]
struct Entry<'a> {
    names: &'a [String],
    source: &'a str,
    certainty: Option<&'static str>,
    uncertain: Option<&'static str>,
    remark: Option<&'static str>,
    range_nm: Option<(f64, f64)>,
    n_from: String,
    k_from: String,
    wavelength_nm: &'a [f64],
    n: Vec<f64>,
    k: Vec<f64>,
}

/// The document of schema `gonio-materials-1`: media with their indices at wavelengths in nm.
pub fn json(materials: &[(&Material, &[f64], &[C64])]) -> String {
    let materials = materials.iter().map(|(m, nm, index)| entry(m, nm, index)).collect();
    let document = Document { schema: "gonio-materials-1", materials };
    serde_json::to_string_pretty(&document).expect("plain numbers and texts") + "\n"
}

fn entry<'a>(m: &'a Material, nm: &'a [f64], index: &[C64]) -> Entry<'a> {
    let (n_from, k_from) = described(&m.dispersion);
    let (certainty, uncertain) = match m.certainty {
        Some(Certainty::Published) => (Some("published"), None),
        Some(Certainty::Uncertain(which)) => (Some("uncertain"), Some(which)),
        None => (None, None),
    };
    Entry {
        names: &m.names,
        source: &m.source,
        certainty,
        uncertain,
        remark: (!m.remark.is_empty()).then_some(m.remark),
        range_nm: m.range_nm().map(|(low, high)| (round(low), round(high))),
        n_from,
        k_from,
        wavelength_nm: nm,
        n: index.iter().map(|n| n.re).collect(),
        k: index.iter().map(|n| n.im).collect(),
    }
}

/// Nanometres without what the division into micrometres has left.
fn round(nm: f64) -> f64 {
    significant(nm, 12).parse().unwrap_or(nm)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn references_lose_their_tags_only() {
        let html =
            "<a href=\"https://doi.org/10\"><i>Appl.</i> <b>46</b>, 1 (2007)</a><br>\n n<111> < 2 & H<sub>2</sub>O";
        assert_eq!(plain(html), "Appl. 46, 1 (2007)\n n<111> < 2 & H2O");
        assert_eq!(plain("a < b"), "a < b");
    }

    #[test]
    fn lines_are_not_too_long() {
        let text = paragraph("source", &"word ".repeat(60));
        assert!(text.lines().count() > 3 && text.lines().all(|l| l.chars().count() <= LINE), "{text}");
        assert!(text.starts_with("source     word") && text.lines().nth(1).unwrap().starts_with("           word"));
        assert_eq!(paragraph("k", ""), "k          \n");
    }

    #[test]
    fn wavelengths_are_within_the_range() {
        for b in crate::media::builtins() {
            let m = Material::from(b);
            for nm in [m.some_wavelengths(), m.curve_wavelengths()] {
                assert!(nm.len() > 2 && nm.is_sorted() && m.indices(&nm).is_ok(), "{:?}", b.names);
            }
        }
    }
}
