//! `[media]`.

use toml::de::DeValue;

use super::super::description::Medium;
use super::super::problem::{Place, suggestion};
use super::super::reader::Table;
use crate::media::{self, Dispersion};
use crate::optics::C64;

pub(super) fn read_media(t: &Table<'_>) -> Vec<Medium> {
    let mut media: Vec<Medium> = Vec::new();
    for (name, value) in t.named() {
        let place = t.source().place(&value.span());
        if let Some(dispersion) = read_medium(t, name, value, &place) {
            media.push(Medium { name: name.into(), dispersion, place });
        }
    }
    media
}

/// Forms of a medium in the file, for messages.
const MEDIUM_FORMS: &str = "1.5, \"2.0+0.01i\", { n = 1.5, k = 0.01 }, { cauchy_nm = [1.517, 8800] }, \
                            { csv = \"file\" } or { material = \"keratin\" }";

fn read_medium(t: &Table<'_>, name: &str, value: &toml::Spanned<DeValue<'_>>, place: &Place) -> Option<Dispersion> {
    let note = |message: String| -> Option<Dispersion> {
        t.source().note(place.problem(format!("{name}: {message}")));
        None
    };
    let constant = |text: &str| match media::parse_index(text) {
        Ok(n) => Some(Dispersion::Constant(n)),
        Err(e) => note(e),
    };
    match value.get_ref() {
        DeValue::Integer(i) => constant(&i.as_str().replace('_', "")),
        DeValue::Float(f) => constant(&f.as_str().replace('_', "")),
        DeValue::String(s) => constant(s),
        DeValue::Table(_) => {
            let m = t.named_table(value)?;
            let dispersion = read_medium_table(&m, name);
            m.refuse_unknown_keys();
            dispersion
        }
        _ => note(format!("expected {MEDIUM_FORMS}")),
    }
}

/// Keys of [`MEDIUM_FORMS`] that exclude one another.
const MEDIUM_KEYS: [&str; 4] = ["n", "cauchy_nm", "material", "csv"];

fn read_medium_table(m: &Table<'_>, name: &str) -> Option<Dispersion> {
    let n = m.number("n");
    let k = m.number("k");
    let material = m.text("material");
    let csv = m.text("csv");
    let cauchy = m.numbers::<2>("cauchy_nm", "two numbers such as [1.517, 8800]");
    let given: Vec<&str> = MEDIUM_KEYS.into_iter().filter(|key| m.get(key).is_some()).collect();
    if given.len() > 1 {
        m.complain(format!("{name}: {} exclude one another; keep one of them", given.join(" and ")));
        return None;
    }
    if m.get("k").is_some() && m.get("n").is_none() {
        m.complain(format!("{name}: k belongs to an index n; write for example {{ n = 1.5, k = 0.01 }}"));
        return None;
    }
    if given.first().is_some_and(|_| n.is_none() && cauchy.is_none() && material.is_none() && csv.is_none()) {
        // What is wrong with the value has been noted.
        return None;
    }
    if let Some(re) = n {
        let index = C64::new(re, k.unwrap_or(0.0));
        return match media::check_index(index) {
            Ok(()) => Some(Dispersion::Constant(index)),
            Err(e) => {
                m.complain(format!("{name}: {e}"));
                None
            }
        };
    }
    if let Some([a, b]) = cauchy {
        return Some(Dispersion::Cauchy { a, b });
    }
    if let Some(material) = material {
        let found = media::builtin(material);
        if found.is_none() {
            let all = media::builtins();
            let hint = suggestion(material, all.iter().flat_map(|b| b.names.iter().copied()));
            m.complain(format!("{name}: no built-in material `{material}`{hint}"));
        }
        return found.map(|b| b.dispersion);
    }
    if let Some(csv) = csv {
        return media::read_csv(&m.source().beside(csv)).map_err(|e| m.complain(format!("{name}: {e}"))).ok();
    }
    m.complain(format!("{name}: expected {MEDIUM_FORMS}"));
    None
}
