//! Options as the text of a sample file.

use std::fmt::Write as _;

use gonio_embree::media;
use gonio_embree::sample::Description;

use super::keys::{Form, Given, Kind};

/// What stands before the bodies: the surroundings and the media.
pub fn head<K: Kind>(given: &Given<K>) -> String {
    let sides = if given.open { "open" } else { "periodic" };
    let mut out = format!("[sample]\nabove = \"air\"\nbelow = \"air\"\npatch = {{ sides = \"{sides}\" }}\n\n[media]\n");
    for (key, value) in &given.values {
        let (name, index) = match key.form {
            Form::Value | Form::File => continue,
            Form::Index(name) => (name, value.as_str()),
            Form::Medium => match value.split_once('=') {
                Some((name, index)) => (name.trim(), index.trim()),
                None => continue,
            },
        };
        let _ = writeln!(out, "{name:?} = {}", definition(index));
    }
    out.push('\n');
    out
}

/// The table of the generator, every key with what it means.
pub fn table<K: Kind>(given: &Given<K>) -> String {
    let (table, key) = K::TABLE;
    let mut out = format!("[[{table}]]\n{key} = \"{}\"\n", K::NAME);
    for (key, value) in &given.values {
        let value = match key.form {
            Form::Value => literal(value),
            Form::Medium => format!("{:?}", value.split_once('=').map_or(value.as_str(), |(name, _)| name).trim()),
            Form::File => format!("{:?}", std::path::absolute(value).unwrap_or_else(|_| value.into())),
            Form::Index(_) => continue,
        };
        let entry = format!("{} = {value}", key.name.replace('-', "_"));
        // The first sentence is enough here.
        let help = ["; ", ". ", ": ", " ["].iter().fold(key.help, |help, end| help.split(end).next().unwrap_or(help));
        let _ = writeln!(out, "{entry:40} # {help}");
    }
    out
}

/// The size of the patch, for a file in which no generator says it.
pub fn patch(description: &Description) -> String {
    description.patch.map_or_else(String::new, |p| format!("size = [{:?}, {:?}]", p.size.x, p.size.y))
}

/// An index, or the file it is in.
fn definition(text: &str) -> String {
    if !media::is_file(text) {
        return literal(text);
    }
    let key = if text.to_lowercase().ends_with(".csv") { "csv" } else { "file" };
    format!("{{ {key} = {text:?} }}")
}

/// A number as such, with commas a list, anything else as a text.
fn literal(text: &str) -> String {
    let text = text.trim();
    if text.contains(',') {
        return format!("[{}]", text.split(',').map(literal).collect::<Vec<_>>().join(", "));
    }
    match (text.parse::<i64>(), text.parse::<f64>()) {
        (Ok(n), _) => n.to_string(),
        (_, Ok(x)) if x.is_finite() => format!("{x:?}"),
        _ => format!("{text:?}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_typed_becomes_what_is_written_in_a_file() {
        for (typed, written) in [
            ("7", "7"),
            (".5", "0.5"),
            ("1e-3", "0.001"),
            ("15 deg", "\"15 deg\""),
            ("nan", "\"nan\""),
            ("3mm, 4", "[\"3mm\", 4]"),
            ("a\"b", "\"a\\\"b\""),
        ] {
            assert_eq!(literal(typed), written);
        }
        assert_eq!(definition("N-BK7.yml"), "{ file = \"N-BK7.yml\" }");
        assert_eq!(definition("2.0+0.01i"), "\"2.0+0.01i\"");
    }
}
