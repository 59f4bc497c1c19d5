//! The media of a stack: names become indices.

use super::tokens::{sign, starts_number};
use super::{FilmStack, Films, Medium, Span, StackError, Written};
use crate::media::{Builtin, Dispersion, TRANSPARENT, builtin, builtins};
use crate::optics::C64;
use crate::optics::film::Layer;
use crate::sample::problem::suggestion;

/// A stack whose media are known.
#[derive(Clone, Debug)]
pub struct Stack {
    /// Media that differ; the others are numbers of these.
    media: Vec<Known>,
    first: usize,
    /// Medium and thickness in nm.
    layers: Vec<(usize, f64)>,
    last: usize,
}

#[derive(Clone, Debug)]
struct Known {
    medium: Medium,
    span: Span,
    dispersion: Dispersion,
}

impl FilmStack {
    /// Looks its media up: first among `named`, then among the built-in ones.
    ///
    /// # Errors
    /// The first name that is not known.
    pub fn resolve(&self, named: &[(String, Dispersion)]) -> Result<Stack, StackError> {
        let mut media = Vec::new();
        let first = number_of(&self.first, &mut media, named)?;
        let layers = self.layers.iter().map(|(m, nm)| Ok((number_of(m, &mut media, named)?, *nm)));
        let layers = layers.collect::<Result<_, StackError>>()?;
        let last = number_of(&self.last, &mut media, named)?;
        Ok(Stack { media, first, layers, last })
    }
}

fn number_of(written: &Written, media: &mut Vec<Known>, named: &[(String, Dispersion)]) -> Result<usize, StackError> {
    if let Some(i) = media.iter().position(|m| m.medium == written.medium) {
        return Ok(i);
    }
    let dispersion = match &written.medium {
        Medium::Index(n) => Dispersion::Constant(*n),
        Medium::Named(name) => dispersion(name, named).map_err(|message| StackError { span: written.span, message })?,
    };
    media.push(Known { medium: written.medium.clone(), span: written.span, dispersion });
    Ok(media.len() - 1)
}

fn dispersion(name: &str, named: &[(String, Dispersion)]) -> Result<Dispersion, String> {
    if let Some((_, dispersion)) = named.iter().find(|(n, _)| n == name) {
        return Ok(dispersion.clone());
    }
    builtin(name).map(Builtin::dispersion).ok_or_else(|| {
        let known = named.iter().map(|(n, _)| &n[..]).chain(builtins().iter().flat_map(|b| b.names.iter().copied()));
        let hint = suggestion(name, known);
        format!("found no medium `{name}`{hint}; expected an index, a built-in medium or one of --medium {name}=1.5")
    })
}

impl Stack {
    /// The stack at a vacuum wavelength in nm.
    ///
    /// # Errors
    /// Where a medium is not known at this wavelength, or the first one absorbs.
    pub fn at(&self, wavelength_nm: f64) -> Result<Films, StackError> {
        let index = |m: &Known| {
            m.dispersion.index(wavelength_nm / 1e3).map_err(|e| {
                let message = format!("{e}; choose other --wavelengths, or write an index such as 1.5 instead");
                StackError { span: m.span, message }
            })
        };
        let n: Vec<C64> = self.media.iter().map(index).collect::<Result<_, _>>()?;
        let first = n[self.first];
        if first.im > TRANSPARENT {
            let span = self.media[self.first].span;
            let message =
                format!("index {first} absorbs: expected a transparent first medium, such as air; turn the stack");
            return Err(StackError { span, message });
        }
        let layers = self.layers.iter().map(|&(m, thickness)| Layer { index: n[m], thickness }).collect();
        Ok(Films { first: first.re, layers, last: n[self.last], wavelength_nm })
    }

    /// Number of layers.
    pub fn len(&self) -> usize {
        self.layers.len()
    }

    /// Whether it is a mere interface.
    pub fn is_empty(&self) -> bool {
        self.layers.is_empty()
    }
}

/// Whether a medium of this name can be written in a stack.
///
/// # Errors
/// Why not.
pub fn check_name(name: &str) -> Result<(), String> {
    let written = |word: &str| !starts_number(word) && !word.contains(|c| sign(c).is_some());
    if name.split_whitespace().all(written) && !name.trim().is_empty() {
        return Ok(());
    }
    Err(format!("`{name}`: expected a name whose words do not begin like a number, without | , ( ) * and ×"))
}
