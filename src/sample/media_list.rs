//! The media of a sample, by number.

use std::collections::HashMap;

use super::description::{Description, Named};
use super::problem::{Problem, Problems, suggestion};
use crate::light::Wavelengths;
use crate::media::{Builtin, Dispersion, NoIndex, TRANSPARENT, builtin, builtins};
use crate::optics::C64;

/// Largest number of media that differ.
const MOST_MEDIA: usize = 10_000;

/// Number of a medium in `Sample::media`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct MediumId(pub u16);

/// A medium at the wavelengths of the light.
#[derive(Clone, Debug, PartialEq)]
pub struct MediumTable {
    /// Its name; of several that are equal, the first.
    pub name: String,
    /// Complex index per wavelength.
    pub index: Vec<C64>,
}

impl MediumTable {
    /// Whether bodies of it are opaque: at some wavelength light is absorbed within a few wavelengths.
    pub fn is_opaque(&self) -> bool {
        /// Least k/n of such a medium.
        const OPAQUE: f64 = 0.05;
        self.index.iter().any(|n| n.im > OPAQUE * n.re)
    }

    /// Whether it absorbs at any wavelength.
    pub fn absorbs(&self) -> bool {
        self.index.iter().any(|n| n.im > 0.0)
    }
}

/// Media in use, without duplicates.
pub(super) struct MediaList<'a> {
    description: &'a Description,
    wavelengths: &'a Wavelengths,
    pub(super) tables: Vec<MediumTable>,
    known: HashMap<String, Option<MediumId>>,
}

impl<'a> MediaList<'a> {
    pub(super) fn new(description: &'a Description, wavelengths: &'a Wavelengths) -> Self {
        Self { description, wavelengths, tables: Vec::new(), known: HashMap::new() }
    }

    /// The number of a medium; each unknown name is reported at its first use only.
    pub(super) fn resolve(&mut self, named: &Named, problems: &mut Problems) -> Option<MediumId> {
        if let Some(id) = self.known.get(&*named.name) {
            return *id;
        }
        self.enter(named, self.look_up(named), problems)
    }

    /// The number of the medium that light comes through, before all others. Where it is clear but for the traces
    /// that are published of glasses, it is taken as clear everywhere: the way before the sample has no length.
    pub(super) fn resolve_above(&mut self, named: &Named, problems: &mut Problems) -> Option<MediumId> {
        let table = self.look_up(named).and_then(|mut table| {
            if table.index.iter().any(|n| n.im > TRANSPARENT) {
                return Err(named.place.problem(format!(
                    "above = \"{}\": light must come through a medium that does not absorb; choose one with k = 0",
                    named.name
                )));
            }
            table.index.iter_mut().for_each(|n| n.im = 0.0);
            Ok(table)
        });
        self.enter(named, table, problems)
    }

    fn enter(
        &mut self,
        named: &Named,
        table: Result<MediumTable, Problem>,
        problems: &mut Problems,
    ) -> Option<MediumId> {
        let id = table.and_then(|table| self.add(table, named)).map_err(|p| problems.push(p)).ok();
        self.known.insert(named.name.to_string(), id);
        id
    }

    fn look_up(&self, named: &Named) -> Result<MediumTable, Problem> {
        let defined = self.description.media.iter().find(|m| *m.name == *named.name);
        let (dispersion, place) = match defined {
            Some(medium) => (medium.dispersion.clone(), &medium.place),
            None => (self.built_in(named)?, &named.place),
        };
        let index: Result<Vec<C64>, _> = self.wavelengths.um().map(|w| dispersion.index(w)).collect();
        let index = index.map_err(|e| {
            let remedy = match e {
                NoIndex::OutOfRange { .. } => {
                    "choose --wavelengths within, other data, or extrapolate = true under [media]"
                }
                NoIndex::Impossible { .. } => "correct its formula",
            };
            place.problem(format!("medium `{}`: {e}; {remedy}", named.name))
        })?;
        Ok(MediumTable { name: named.name.to_string(), index })
    }

    fn built_in(&self, named: &Named) -> Result<Dispersion, Problem> {
        builtin(&named.name).map(Builtin::dispersion).ok_or_else(|| {
            let own = self.description.media.iter().map(|m| m.name.as_str());
            let hint = suggestion(&named.name, own.chain(builtins().iter().flat_map(|b| b.names.iter().copied())));
            let message =
                format!("unknown medium `{0}`{hint}; define it under [media], for example {0} = 1.5", named.name);
            named.place.problem(message)
        })
    }

    fn add(&mut self, table: MediumTable, named: &Named) -> Result<MediumId, Problem> {
        let known = self.tables.iter().position(|t| t.index == table.index);
        let at = known.unwrap_or(self.tables.len());
        if at == MOST_MEDIA {
            let message = format!("medium `{}`: at most {at} different media are taken; use fewer", named.name);
            return Err(named.place.problem(message));
        }
        if known.is_none() {
            self.tables.push(table);
        }
        Ok(MediumId(at as u16))
    }
}
