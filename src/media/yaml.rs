//! Reading YAML piece by piece: no tree is built, so a hostile file costs no more than its length.

use std::borrow::Cow;

use saphyr_parser::{Event, Parser, ScalarStyle, StrInput};

/// What is wrong with a text, and in which line (from 1).
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Wrong {
    pub(super) line: usize,
    pub(super) message: String,
}

impl Wrong {
    pub(super) fn at(line: usize, message: impl Into<String>) -> Self {
        Self { line, message: message.into() }
    }
}

/// A text of the file.
#[derive(Clone, Debug)]
pub(super) struct Text<'a> {
    pub(super) text: Cow<'a, str>,
    /// The line of its first character that is no blank.
    pub(super) line: usize,
    is_block: bool,
}

impl Text<'_> {
    /// Its lines that are not empty, with their numbers in the file.
    pub(super) fn lines(&self) -> impl Iterator<Item = (usize, &str)> {
        let empty = self.text.lines().take_while(|line| line.trim().is_empty()).count();
        let all = self.text.lines().map(str::trim).enumerate().skip(empty).filter(|(_, line)| !line.is_empty());
        all.map(move |(i, line)| (if self.is_block { self.line + i - empty } else { self.line }, line))
    }
}

/// What comes next.
enum Piece<'a> {
    Text(Text<'a>),
    List,
    Map,
    End,
    Reference,
}

/// The pieces of a file, in turn.
pub(super) struct Pieces<'a> {
    parser: Parser<'a, StrInput<'a>>,
    line: usize,
}

impl<'a> Pieces<'a> {
    pub(super) fn new(text: &'a str) -> Self {
        Self { parser: Parser::new_from_str(text), line: 1 }
    }

    fn next(&mut self) -> Result<Piece<'a>, Wrong> {
        loop {
            let Some(event) = self.parser.next_event() else { return Ok(Piece::End) };
            let (event, span) =
                event.map_err(|e| Wrong::at(e.marker().line().max(1), format!("no YAML: {}", e.info())))?;
            self.line = span.start.line();
            return Ok(match event {
                Event::Scalar(text, style, ..) => {
                    Piece::Text(Text { text, line: self.line, is_block: style == ScalarStyle::Literal })
                }
                Event::SequenceStart(..) => Piece::List,
                Event::MappingStart(..) => Piece::Map,
                Event::SequenceEnd | Event::MappingEnd | Event::DocumentEnd | Event::StreamEnd => Piece::End,
                Event::Alias(_) => Piece::Reference,
                Event::StreamStart | Event::DocumentStart(_) | Event::Nothing => continue,
            });
        }
    }

    /// Reads a map; `entry` reads the value behind a key.
    pub(super) fn map(
        &mut self,
        expected: &str,
        entry: impl FnMut(&mut Self, &Text<'a>) -> Result<(), Wrong>,
    ) -> Result<(), Wrong> {
        match self.next()? {
            Piece::Map => self.entries(entry),
            _ => Err(Wrong::at(self.line, format!("expected {expected}"))),
        }
    }

    /// Reads a list of maps, each with the line in which it begins; `entry` reads the value behind a key of the last.
    pub(super) fn maps<T: Default>(
        &mut self,
        expected: &str,
        mut entry: impl FnMut(&mut Self, &mut T, &Text<'a>) -> Result<(), Wrong>,
    ) -> Result<Vec<(usize, T)>, Wrong> {
        let Piece::List = self.next()? else { return Err(Wrong::at(self.line, format!("expected {expected}"))) };
        let mut all = Vec::new();
        loop {
            match self.next()? {
                Piece::Map => {
                    let (line, mut one) = (self.line, T::default());
                    self.entries(|pieces, key| entry(pieces, &mut one, key))?;
                    all.push((line, one));
                }
                Piece::End => return Ok(all),
                _ => return Err(Wrong::at(self.line, format!("expected {expected}"))),
            }
        }
    }

    /// The entries of a map that has begun.
    fn entries(&mut self, mut entry: impl FnMut(&mut Self, &Text<'a>) -> Result<(), Wrong>) -> Result<(), Wrong> {
        loop {
            match self.next()? {
                Piece::Text(key) => entry(self, &key)?,
                Piece::End => return Ok(()),
                _ => return Err(Wrong::at(self.line, "expected a key and a colon")),
            }
        }
    }

    /// Reads the text behind a key.
    pub(super) fn text(&mut self, key: &str) -> Result<Text<'a>, Wrong> {
        match self.next()? {
            Piece::Text(text) => Ok(text),
            _ => Err(Wrong::at(self.line, format!("{key}: expected a text or numbers"))),
        }
    }

    /// Passes over whatever stands behind a key.
    pub(super) fn skip(&mut self) -> Result<(), Wrong> {
        let mut depth = 0_usize;
        loop {
            match self.next()? {
                Piece::List | Piece::Map => depth += 1,
                // The end of the file cannot come within: the parser says what is wrong first.
                Piece::End => depth = depth.saturating_sub(1),
                Piece::Text(_) | Piece::Reference => {}
            }
            if depth == 0 {
                return Ok(());
            }
        }
    }
}
