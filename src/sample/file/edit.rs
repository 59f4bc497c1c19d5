//! Values of a sample file replaced before it is read: what a sweep varies.

use std::fmt;
use std::str::FromStr;

use toml_edit::{ArrayOfTables, DocumentMut, Item, Table, TableLike, Value};

use super::super::problem::suggestion;

/// A value in place of what stands in a sample file, given as `objects.fibre.radius=0.4` or `sample.above=water`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Replacement {
    path: Vec<String>,
    value: String,
}

impl FromStr for Replacement {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = "expected KEY=VALUE such as objects.fibre.radius=0.4";
        let (path, value) = text.split_once('=').ok_or(expected)?;
        let path: Vec<String> = path.split('.').map(|s| s.trim().to_string()).collect();
        if path.len() < 2 || path.iter().any(String::is_empty) || value.trim().is_empty() {
            return Err(expected.into());
        }
        Ok(Self { path, value: value.trim().into() })
    }
}

impl fmt::Display for Replacement {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}={}", self.path.join("."), self.value)
    }
}

/// The text of a sample file with some values replaced. Lines keep their numbers.
///
/// # Errors
/// When there is no such place; a text that is no TOML is given back as it is, for its reader to complain.
pub fn replace(text: &str, replacements: &[Replacement]) -> Result<String, String> {
    let Ok(mut document) = text.parse::<DocumentMut>() else { return Ok(text.into()) };
    for replacement in replacements {
        put(document.as_table_mut(), replacement).map_err(|e| format!("--set {replacement}: {e}"))?;
    }
    Ok(document.to_string())
}

fn put(root: &mut Table, replacement: &Replacement) -> Result<(), String> {
    let [first, rest @ ..] = &replacement.path[..] else { return Ok(()) };
    let first = if first == "objects" { list_of_bodies(root, rest.first()) } else { first };
    let known: Vec<String> = root.iter().map(|(key, _)| key.to_string()).collect();
    let item = root.get_mut(first).ok_or_else(|| missing(first, &known))?;
    let (item, rest) = match item {
        Item::ArrayOfTables(tables) => {
            let [which, rest @ ..] = rest else { return Err(format!("say which {first}: its name, or its number")) };
            (element(tables, which)? as &mut dyn TableLike, rest)
        }
        other => (other.as_table_like_mut().ok_or_else(|| format!("`{first}` is no table"))?, rest),
    };
    within(item, rest, &replacement.value)
}

/// What people call objects are [[object]] and, if none of them is meant, [[generate]].
fn list_of_bodies(root: &mut Table, which: Option<&String>) -> &'static str {
    let mut has = |list: &str| match (root.get_mut(list), which) {
        (Some(Item::ArrayOfTables(tables)), Some(which)) => element(tables, which).is_ok(),
        _ => false,
    };
    if !has("object") && has("generate") { "generate" } else { "object" }
}

/// The table that has this name, or is the only one of this shape or kind, or has this number, counted from 1.
fn element<'t>(tables: &'t mut ArrayOfTables, which: &str) -> Result<&'t mut Table, String> {
    let of = |key: &'static str| move |t: &Table| t.get(key).and_then(Item::as_str).map(String::from);
    let names: Vec<String> =
        tables.iter().flat_map(|t| [of("name")(t), of("shape")(t), of("kind")(t)]).flatten().collect();
    let found: Vec<usize> = ["name", "shape", "kind"]
        .into_iter()
        .map(|key| (0..tables.len()).filter(|&i| tables.get(i).and_then(of(key)).as_deref() == Some(which)).collect())
        .find(|found: &Vec<usize>| !found.is_empty())
        .unwrap_or_else(|| which.parse().ok().and_then(|n: usize| n.checked_sub(1)).into_iter().collect());
    match found[..] {
        [i] if i < tables.len() => tables.get_mut(i).ok_or_else(String::new),
        [] | [_] => Err(missing(which, &names)),
        _ => Err(format!("there are {} called `{which}`: give them names, or say which by its number", found.len())),
    }
}

fn missing(name: &str, known: &[String]) -> String {
    let hint = suggestion(name, known.iter().map(String::as_str));
    let hint = if hint.is_empty() { format!("; there is: {}", known.join(", ")) } else { hint };
    format!("there is no `{name}`{hint}")
}

fn within(table: &mut dyn TableLike, path: &[String], value: &str) -> Result<(), String> {
    let [key, rest @ ..] = path else { return Err("say which value of it".into()) };
    if rest.is_empty() {
        let mut new = read(value);
        match table.get_mut(key) {
            Some(Item::Value(old)) => {
                *new.decor_mut() = old.decor().clone();
                *old = new;
            }
            // One that has a usual value need not stand in the file.
            _ => drop(table.insert(key, Item::Value(new))),
        }
        return Ok(());
    }
    let known: Vec<String> = table.iter().map(|(key, _)| key.to_string()).collect();
    let item = table.get_mut(key).ok_or_else(|| missing(key, &known))?;
    if let Some(list) = item.as_array_mut() {
        let count = list.len();
        let number = rest[0].parse().ok().and_then(|n: usize| n.checked_sub(1)).filter(|&n| n < count);
        let entry = number.and_then(|n| list.get_mut(n));
        let entry = entry.ok_or_else(|| format!("`{key}` has no `{}`: say 1 to {count}", rest[0]))?;
        return match (&rest[1..], entry.as_inline_table_mut()) {
            ([], _) => {
                let new = read(value);
                *entry = new;
                Ok(())
            }
            (rest, Some(table)) => within(table, rest, value),
            _ => Err(format!("`{key}.{}` is no table", rest[0])),
        };
    }
    within(item.as_table_like_mut().ok_or_else(|| format!("`{key}` is no table"))?, rest, value)
}

/// TOML, or a text that needs no quotes.
fn read(value: &str) -> Value {
    value.parse().unwrap_or_else(|_| Value::from(value))
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = r#"
[sample]
above = "air"   # what the light comes through
patch = { size = [10, 10], sides = "open" }

[[object]]
shape = "sphere"
name = "core"
radius = 1.5

[[object]]
shape = "films"
layers = [{ medium = "air", thickness = "50 nm" }, { medium = "glass", thickness = "80 nm" }]

[[generate]]
kind = "web"
"#;

    fn edited(what: &str) -> Result<String, String> {
        replace(FILE, &[what.parse()?])
    }

    #[test]
    fn values_are_replaced_where_they_stand() {
        for (what, line) in [
            ("sample.above=water", r#"above = "water"   # what the light comes through"#),
            ("sample.patch.sides=periodic", r#"sides = "periodic""#),
            ("sample.patch.size=[5, 6]", "size = [5, 6]"),
            ("objects.core.radius=\"2 mm\"", "radius = \"2 mm\""),
            ("object.1.radius=2", "radius = 2"),
            ("object.films.layers.2.thickness=90 nm", "thickness = \"90 nm\""),
            ("sample.patch.size.1=7", "[7, 10]"),
            ("generate.web.flatten=0.5", "flatten = 0.5"),
            ("objects.web.flatten=0.5", "flatten = 0.5"),
        ] {
            let text = edited(what).unwrap();
            assert!(text.contains(line), "{what}: {text}");
            let place = |text: &str| text.lines().position(|l| l.contains("[[generate]]"));
            assert_eq!(place(&text), place(FILE), "{what}");
        }
    }

    #[test]
    fn places_that_are_not_there_are_named() {
        for (what, told) in [
            ("objects.kore.radius=2", "did you mean `core`?"),
            ("objects.sphere=2", "say which value"),
            ("sampel.above=water", "did you mean `sample`?"),
            ("object.3.radius=2", "there is no `3`"),
            ("object.films.layers.0.thickness=1", "say 1 to 2"),
            ("objects=2", "KEY=VALUE"),
            ("objects.core.radius", "KEY=VALUE"),
            ("object.core.radius.x=2", "`radius` is no table"),
        ] {
            let error = edited(what).unwrap_err();
            assert!(error.contains(told), "{what}: {error}");
        }
        let two = format!("{FILE}\n[[object]]\nshape = \"sphere\"\n");
        assert!(replace(&two, &["objects.sphere.radius=2".parse().unwrap()]).unwrap_err().contains("by its number"));
    }

    #[test]
    fn what_is_replaced_is_told_as_it_was_given() {
        let what: Replacement = " objects.core.radius = 2 ".parse().unwrap();
        assert_eq!(what.to_string(), "objects.core.radius=2");
        assert_eq!(replace("no toml =", &[what]).unwrap(), "no toml =");
    }
}
