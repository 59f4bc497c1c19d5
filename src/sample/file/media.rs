//! `[media]`.

use toml::de::DeValue;

use super::super::description::Medium;
use super::super::problem::{Place, suggestion};
use super::super::reader::Table;
use crate::media::{self, Builtin, Dispersion};
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
                            { file = \"N-BK7.yml\" }, { csv = \"file\" } or { material = \"keratin\" }";

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
const MEDIUM_KEYS: [&str; 5] = ["n", "cauchy_nm", "material", "csv", "file"];

fn read_medium_table(m: &Table<'_>, name: &str) -> Option<Dispersion> {
    // Every key is asked for, so that none of them is unknown.
    let (k, extrapolate) = (m.number("k"), m.boolean("extrapolate"));
    let given: Vec<&str> = MEDIUM_KEYS.into_iter().filter(|key| m.get(key).is_some()).collect();
    let key = match given[..] {
        [key] => key,
        [] => {
            m.complain(match m.get("k") {
                Some(_) => format!("{name}: k belongs to an index n; write for example {{ n = 1.5, k = 0.01 }}"),
                None => format!("{name}: expected {MEDIUM_FORMS}"),
            });
            return None;
        }
        _ => {
            m.complain(format!("{name}: {} exclude one another; keep one of them", given.join(" and ")));
            return None;
        }
    };
    if m.get("k").is_some() && key != "n" {
        m.complain(format!("{name}: k belongs to an index n, not to {key}; leave it out"));
        return None;
    }
    if extrapolate.is_some() && ["n", "cauchy_nm"].contains(&key) {
        m.complain(format!("{name}: extrapolate is for data of some wavelengths, not for {key}; leave it out"));
        return None;
    }
    let dispersion = match key {
        "n" => constant(m, name, m.number("n")?, k.unwrap_or(0.0)),
        "cauchy_nm" => {
            let [a, b] = m.numbers("cauchy_nm", "two numbers such as [1.517, 8800]")?;
            Some(Dispersion::Cauchy { a, b })
        }
        "material" => material(m, name, m.text("material")?),
        _ => file(m, name, key),
    }?;
    Some(if extrapolate == Some(true) { Dispersion::Extrapolated(Box::new(dispersion)) } else { dispersion })
}

fn constant(m: &Table<'_>, name: &str, n: f64, k: f64) -> Option<Dispersion> {
    let index = C64::new(n, k);
    media::check_index(index).map_err(|e| m.complain(format!("{name}: {e}"))).ok()?;
    Some(Dispersion::Constant(index))
}

fn material(m: &Table<'_>, name: &str, material: &str) -> Option<Dispersion> {
    let found = media::builtin(material);
    if found.is_none() {
        let hint = suggestion(material, media::builtins().iter().flat_map(|b| b.names.iter().copied()));
        m.complain(format!("{name}: no built-in material `{material}`{hint}; `gonio-embree materials` lists them"));
    }
    found.map(Builtin::dispersion)
}

fn file(m: &Table<'_>, name: &str, key: &'static str) -> Option<Dispersion> {
    let path = m.source().beside(m.text(key)?);
    let read = if key == "csv" { media::read_csv(&path) } else { media::read_file(&path) };
    read.map(|read| read.dispersion).map_err(|e| m.complain(format!("{name}: {e}"))).ok()
}
