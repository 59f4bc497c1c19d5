//! What a body is made of: `medium` or `surface`.

use super::description::{Fill, Named};
use super::reader::Table;

/// A name and its place.
pub(super) fn named(t: &Table<'_>, key: &'static str) -> Option<Named> {
    t.text(key).map(|name| Named { name: name.into(), place: t.place_of(key) })
}

/// `medium = "name"` or `surface = { diffuse = 0.8 }`.
pub fn read_fill(t: &Table<'_>) -> Option<Fill> {
    let medium = named(t, "medium");
    let Some(surface) = t.table("surface") else {
        let wrong = t.get("surface").is_some();
        return medium
            .map(Fill::Medium)
            .or_else(|| if wrong { None } else { t.missing_if_absent("medium", "\"glass\"") });
    };
    let share = |key| {
        let share = surface.number(key)?;
        if (0.0..=1.0).contains(&share) {
            return Some(share);
        }
        surface.complain(format!("{key} = {share}: expected a share of the light, 0 to 1"));
        None
    };
    let (diffuse, mirror) = (share("diffuse").map(Fill::Diffuse), share("mirror").map(Fill::Mirror));
    surface.refuse_unknown_keys();
    if medium.is_some() {
        t.complain("an object has a `medium` or a `surface`, not both; leave one out");
    }
    match (diffuse, mirror) {
        (Some(fill), None) | (None, Some(fill)) => Some(fill),
        // What is wrong with the share has been noted.
        (None, None) if surface.get("diffuse").or(surface.get("mirror")).is_some() => None,
        _ => {
            surface.complain("surface: expected { diffuse = 0.8 } or { mirror = 0.95 }");
            None
        }
    }
}
