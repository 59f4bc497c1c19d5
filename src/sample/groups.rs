//! Bodies by name: whose absorbed power is told apart.

use super::media_list::MediumTable;
use super::solid::{Matter, Solid};

/// Bodies that are told apart.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Groups {
    /// Name of each group.
    pub names: Vec<String>,
    /// Group of each solid.
    pub of_solid: Vec<u16>,
}

/// Most groups: more are no help to anybody.
const MOST: usize = 64;

impl Groups {
    /// By the names of the bodies; where these are too many without the numbers at their ends, and else by what the
    /// bodies are made of.
    pub(super) fn new(solids: &[Solid], media: &[MediumTable]) -> Self {
        let matter = |s: &Solid| match s.matter {
            Matter::Medium(id) => media[usize::from(id.0)].name.clone(),
            Matter::Diffuse(_) => "matt surfaces".into(),
            Matter::Mirror(_) => "mirrors".into(),
        };
        Self::by(solids, |s| s.name.to_string())
            .or_else(|| Self::by(solids, |s| without_number(&s.name).into()))
            .or_else(|| Self::by(solids, matter))
            .unwrap_or_else(|| Self { names: vec!["all bodies".into()], of_solid: vec![0; solids.len()] })
    }

    /// `None` if there are too many.
    fn by(solids: &[Solid], name: impl Fn(&Solid) -> String) -> Option<Self> {
        let mut groups = Self::default();
        for solid in solids {
            let name = name(solid);
            let known = groups.names.iter().position(|n| *n == name);
            if known.is_none() && groups.names.len() == MOST {
                return None;
            }
            groups.of_solid.push(known.unwrap_or(groups.names.len()) as u16);
            if known.is_none() {
                groups.names.push(name);
            }
        }
        Some(groups)
    }
}

fn without_number(name: &str) -> &str {
    name.trim_end_matches(|c: char| c.is_ascii_digit()).trim_end()
}

#[cfg(test)]
mod tests {
    use super::super::problem::Place;
    use super::*;
    use crate::sample::MediumId;

    fn solids(names: impl Iterator<Item = String>) -> Vec<Solid> {
        let solid = |name: String| Solid {
            name: name.into(),
            place: Place::default(),
            matter: Matter::Medium(MediumId(0)),
            precedence: (0, 0),
            closed: true,
            lonely: false,
        };
        names.map(solid).collect()
    }

    #[test]
    fn many_bodies_become_few_groups() {
        let glass = [MediumTable { name: "glass".into(), index: Vec::new() }];
        let few = Groups::new(&solids((0..3).map(|i| format!("sphere {i}"))), &glass);
        assert_eq!((few.names.len(), &few.of_solid[..]), (3, &[0, 1, 2][..]));
        let many = Groups::new(&solids((0..1000).map(|i| format!("sphere {i}"))), &glass);
        assert_eq!(many.names, ["sphere"]);
        let odd = Groups::new(&solids((0..1000).map(|i| format!("{i} sphere"))), &glass);
        assert_eq!(odd.names, ["glass"]);
    }
}
