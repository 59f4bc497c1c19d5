//! Who decides which effects are simulated.

use std::fmt;
use std::str::FromStr;

use super::effects::Name;
use crate::text::one_of;

/// What the user wants: a base, and effects that are switched by hand.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Wanted {
    all: bool,
    /// By number of the effect.
    forced: [Option<bool>; Name::COUNT],
}

impl Wanted {
    /// Those that can matter.
    pub const AUTO: Self = Self { all: false, forced: [None; Name::COUNT] };
    /// Every one.
    pub const ALL: Self = Self { all: true, forced: [None; Name::COUNT] };

    /// Whether every effect is simulated that is not switched off by hand.
    pub fn all(&self) -> bool {
        self.all
    }

    /// Whether an effect is switched by hand, and how.
    pub fn by_hand(&self, name: Name) -> Option<bool> {
        self.forced[name as usize]
    }

    /// The same with an effect switched by hand.
    #[must_use]
    pub fn with(mut self, name: Name, on: bool) -> Self {
        self.forced[name as usize] = Some(on);
        self
    }

    /// The edits, in the order of the effects.
    fn edits(&self) -> impl Iterator<Item = (Name, bool)> + '_ {
        Name::ALL.into_iter().filter_map(|name| Some((name, self.forced[name as usize]?)))
    }
}

impl fmt::Display for Wanted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.all { "all" } else { "auto" })?;
        self.edits().try_for_each(|(name, on)| write!(f, ",{}{name}", if on { '+' } else { '-' }))
    }
}

impl FromStr for Wanted {
    type Err = String;

    fn from_str(s: &str) -> Result<Self, String> {
        let mut wanted = Self::AUTO;
        for (i, part) in s.split(',').map(str::trim).enumerate() {
            wanted = match (part, i) {
                ("auto", 0) => Self::AUTO,
                ("all", 0) => Self::ALL,
                _ => wanted.edited(part)?,
            };
        }
        Ok(wanted)
    }
}

impl Wanted {
    fn edited(self, part: &str) -> Result<Self, String> {
        let (on, name) = match (part.strip_prefix('+'), part.strip_prefix('-')) {
            (Some(name), _) => (true, name),
            (_, Some(name)) => (false, name),
            _ => return Err(format!("`{part}`: expected auto, all, +effect or -effect, such as auto,-dispersion")),
        };
        let known = Name::ALL.into_iter().find(|n| n.to_string() == name && n.is_for_hands());
        let name = known.ok_or_else(|| {
            let names: Vec<String> = Name::ALL.iter().filter(|n| n.is_for_hands()).map(Name::to_string).collect();
            format!("`{part}`: expected one of {}", one_of(&names.iter().map(String::as_str).collect::<Vec<_>>()))
        })?;
        Ok(self.with(name, on))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wishes_are_read_and_written() {
        for text in ["auto", "all", "auto,-polarization", "all,-phase,+dispersion"] {
            assert_eq!(text.parse::<Wanted>().unwrap().to_string(), text);
        }
        assert_eq!("-absorption".parse::<Wanted>().unwrap().to_string(), "auto,-absorption");
        assert!("polarization".parse::<Wanted>().unwrap_err().contains("+effect"));
        assert!("auto,-colour".parse::<Wanted>().unwrap_err().contains("dispersion"));
        assert!("auto,-priorities".parse::<Wanted>().is_err(), "geometry decides");
    }
}
