//! Reading tables of a TOML file with places, units and several errors at once.

use std::cell::{Cell, RefCell};
use std::ops::Range;
use std::path::{Path, PathBuf};

use glam::DVec3;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::problem::{Place, Problem, Problems, suggestion};
use crate::text;
use crate::units::{self, LengthUnit};

/// Largest length taken, µm (10 m): beyond it double precision no longer holds a film.
pub const LARGEST: f64 = 1e7;

/// Largest sample file taken, bytes.
const MOST_BYTES: u64 = 64 << 20;

/// A text file, with what is wrong with it so far.
pub struct Source {
    path: PathBuf,
    text: String,
    /// Where lines end.
    ends: Vec<usize>,
    problems: RefCell<Problems>,
    /// Other files it names.
    named: RefCell<Vec<PathBuf>>,
}

impl Source {
    /// Reads a file.
    ///
    /// # Errors
    /// When it cannot be read or is no text.
    pub fn read(path: &Path) -> Result<Self, Problem> {
        let text = text::read(path, MOST_BYTES).map_err(|e| Place::file(path).problem(e))?;
        Ok(Self::new(path, text))
    }

    /// A text that stands in no file.
    pub fn text(text: &str) -> Self {
        Self::new(Path::new(""), text.into())
    }

    /// All of it.
    pub fn as_text(&self) -> &str {
        &self.text
    }

    /// The same file with another text.
    pub fn with_text(self, text: String) -> Self {
        Self::new(&self.path, text)
    }

    fn new(path: &Path, text: String) -> Self {
        let ends = text.bytes().enumerate().filter(|(_, b)| *b == b'\n').map(|(i, _)| i).collect();
        Self { path: path.into(), text, ends, problems: RefCell::default(), named: RefCell::default() }
    }

    /// Parses the file as TOML; what cannot be parsed is left out and noted.
    pub fn parse(&self) -> Spanned<DeTable<'_>> {
        let (table, errors) = DeTable::parse_recoverable(&self.text);
        for e in errors {
            let place = self.place(&e.span().unwrap_or_default());
            self.note(place.problem(e.message().to_string()));
        }
        table
    }

    /// Another file, named in this one: it is looked up from the same directory.
    pub fn beside(&self, name: &str) -> PathBuf {
        let path = self.path.parent().unwrap_or(Path::new("")).join(name);
        self.named.borrow_mut().push(path.clone());
        path
    }

    /// This file and those it names.
    pub fn files(&self) -> Vec<PathBuf> {
        let mut files = vec![self.path.clone()];
        files.extend(self.named.borrow().iter().cloned());
        files
    }

    /// The text of a byte range.
    pub fn slice(&self, span: &Range<usize>) -> &str {
        &self.text[span.clone()]
    }

    /// The line of a byte range.
    pub fn place(&self, span: &Range<usize>) -> Place {
        Place::line(&self.path, 1 + self.ends.partition_point(|&end| end < span.start))
    }

    /// Adds a problem.
    pub fn note(&self, problem: Problem) {
        self.problems.borrow_mut().push(problem);
    }

    /// Whether no problem has been noted.
    pub fn is_clean(&self) -> bool {
        self.problems.borrow().is_empty()
    }

    /// All problems noted.
    pub fn into_problems(self) -> Problems {
        self.problems.into_inner()
    }
}

/// A table being read. Every getter notes what is wrong and returns `None` then.
pub struct Table<'a> {
    source: &'a Source,
    entries: &'a DeTable<'a>,
    place: Place,
    unit: LengthUnit,
    asked: RefCell<Vec<&'static str>>,
    accepts_all: Cell<bool>,
}

impl<'a> Table<'a> {
    /// The entries of `table`, which begins at `span`; bare lengths are in `unit`.
    pub fn new(source: &'a Source, table: &'a DeTable<'a>, span: &Range<usize>, unit: LengthUnit) -> Self {
        let place = source.place(span);
        Self { source, entries: table, place, unit, asked: RefCell::default(), accepts_all: Cell::default() }
    }

    /// Where the table begins.
    pub fn place(&self) -> &Place {
        &self.place
    }

    /// The file.
    pub fn source(&self) -> &'a Source {
        self.source
    }

    /// Notes a problem with the table as a whole.
    pub fn complain(&self, message: impl Into<String>) {
        self.source.note(self.place.problem(message));
    }

    fn wrong(&self, key: &str, value: &Spanned<DeValue<'_>>, expected: &str) {
        let found = &self.source.text[value.span()];
        let found = found.lines().next().unwrap_or_default();
        self.source.note(self.source.place(&value.span()).problem(format!("{key} = {found}: expected {expected}")));
    }

    /// The raw value of `key`.
    pub fn get(&self, key: &'static str) -> Option<&'a Spanned<DeValue<'a>>> {
        let mut asked = self.asked.borrow_mut();
        if !asked.contains(&key) {
            asked.push(key);
        }
        self.entries.get(key)
    }

    /// The place of `key`, or that of the table.
    pub fn place_of(&self, key: &str) -> Place {
        self.entries.get(key).map_or_else(|| self.place.clone(), |v| self.source.place(&v.span()))
    }

    /// Notes that `key` is missing; `None`.
    pub fn missing<T>(&self, key: &str, example: &str) -> Option<T> {
        self.complain(format!("`{key}` is missing; give for example {key} = {example}"));
        None
    }

    /// The same unless `key` is there (then what is wrong with it has been noted).
    pub fn missing_if_absent<T>(&self, key: &str, example: &str) -> Option<T> {
        if self.entries.get(key).is_none() { self.missing(key, example) } else { None }
    }

    /// The table with another unit for bare lengths.
    pub fn with_unit(self, unit: LengthUnit) -> Self {
        Self { unit, ..self }
    }

    /// The unit of bare lengths.
    pub fn unit(&self) -> LengthUnit {
        self.unit
    }

    /// An angle, radians; bare numbers are degrees.
    pub fn angle(&self, key: &'static str) -> Option<f64> {
        let value = self.get(key)?;
        let angle = match value.get_ref() {
            DeValue::String(s) => units::angle(s).ok(),
            number => as_number(number).map(f64::to_radians),
        };
        if angle.is_none() {
            self.wrong(key, value, "an angle such as 15 or \"15 deg\"");
        }
        angle
    }

    /// `N` plain numbers.
    pub fn numbers<const N: usize>(&self, key: &'static str, expected: &str) -> Option<[f64; N]> {
        let value = self.get(key)?;
        let list = value.get_ref().as_array().map(|a| a.iter().filter_map(|v| as_number(v.get_ref())).collect());
        let numbers = list.and_then(|l: Vec<f64>| l.try_into().ok());
        if numbers.is_none() {
            self.wrong(key, value, expected);
        }
        numbers
    }

    /// A number.
    pub fn number(&self, key: &'static str) -> Option<f64> {
        let value = self.get(key)?;
        let number = as_number(value.get_ref());
        if number.is_none() {
            self.wrong(key, value, "a finite number");
        }
        number
    }

    /// An integer within `range`.
    pub fn integer(&self, key: &'static str, range: Range<i64>) -> Option<i64> {
        let value = self.get(key)?;
        let integer = value.get_ref().as_integer().and_then(|i| {
            let digits: String = i.as_str().chars().filter(|&c| c != '_').collect();
            i64::from_str_radix(&digits, i.radix()).ok()
        });
        let within = integer.filter(|i| range.contains(i));
        if within.is_none() {
            self.wrong(key, value, &format!("an integer from {} to {}", range.start, range.end - 1));
        }
        within
    }

    /// A truth value.
    pub fn boolean(&self, key: &'static str) -> Option<bool> {
        let value = self.get(key)?;
        let boolean = value.get_ref().as_bool();
        if boolean.is_none() {
            self.wrong(key, value, "true or false");
        }
        boolean
    }

    /// A text.
    pub fn text(&self, key: &'static str) -> Option<&'a str> {
        let value = self.get(key)?;
        let text = value.get_ref().as_str();
        if text.is_none() {
            self.wrong(key, value, "a text in quotes");
        }
        text
    }

    /// A length, µm.
    pub fn length(&self, key: &'static str) -> Option<f64> {
        let value = self.get(key)?;
        self.as_length(key, value)
    }

    /// A length greater than 0, µm.
    pub fn positive_length(&self, key: &'static str) -> Option<f64> {
        let x = self.length(key)?;
        if x > 0.0 {
            return Some(x);
        }
        self.wrong(key, self.entries.get(key)?, "a length greater than 0");
        None
    }

    /// Three lengths, µm.
    pub fn point(&self, key: &'static str) -> Option<DVec3> {
        self.lengths::<3>(key, "three lengths such as [0, 0, 5]").map(DVec3::from_array)
    }

    /// `N` lengths, µm.
    pub fn lengths<const N: usize>(&self, key: &'static str, expected: &str) -> Option<[f64; N]> {
        let value = self.get(key)?;
        let Some(list) = value.get_ref().as_array().filter(|a| a.len() == N) else {
            self.wrong(key, value, expected);
            return None;
        };
        let all: Vec<f64> = list.iter().filter_map(|v| self.as_length(key, v)).collect();
        all.try_into().ok()
    }

    /// Any number of lengths, µm.
    pub fn list_of_lengths(&self, key: &'static str) -> Option<Vec<f64>> {
        let value = self.get(key)?;
        let Some(list) = value.get_ref().as_array() else {
            self.wrong(key, value, "a list of lengths such as [0.3, 0.5]");
            return None;
        };
        list.iter().map(|v| self.as_length(key, v)).collect()
    }

    /// Any number of plain numbers.
    pub fn list_of_numbers(&self, key: &'static str) -> Option<Vec<f64>> {
        let value = self.get(key)?;
        let list = value.get_ref().as_array();
        let numbers = list.and_then(|l| l.iter().map(|v| as_number(v.get_ref())).collect());
        if numbers.is_none() {
            self.wrong(key, value, "a list of numbers such as [0.8, 0.2]");
        }
        numbers
    }

    /// Three plain numbers, not all 0.
    pub fn direction(&self, key: &'static str) -> Option<DVec3> {
        let expected = "a direction such as [0, 0, 1]";
        let v = DVec3::from_array(self.numbers(key, expected)?).try_normalize();
        if v.is_none() {
            self.wrong(key, self.entries.get(key)?, expected);
        }
        v
    }

    /// A sub-table.
    pub fn table(&self, key: &'static str) -> Option<Table<'a>> {
        let value = self.get(key)?;
        let table = value.get_ref().as_table();
        if table.is_none() {
            self.wrong(key, value, "a table { ... }");
        }
        Some(Table::new(self.source, table?, &value.span(), self.unit))
    }

    /// A list of tables.
    pub fn tables(&self, key: &'static str) -> Vec<Table<'a>> {
        let Some(value) = self.get(key) else { return Vec::new() };
        let Some(list) = value.get_ref().as_array() else {
            self.wrong(key, value, "a list of tables: [[object]], or [{ ... }, ...]");
            return Vec::new();
        };
        let table = |v: &'a Spanned<DeValue<'a>>| {
            let table = v.get_ref().as_table();
            if table.is_none() {
                self.wrong(key, v, "a table { ... }");
            }
            Some(Table::new(self.source, table?, &v.span(), self.unit))
        };
        list.iter().filter_map(table).collect()
    }

    /// All entries as (name, value): for tables whose keys are names the user gives.
    pub fn named(&self) -> impl Iterator<Item = (&'a str, &'a Spanned<DeValue<'a>>)> {
        self.entries.iter().map(|(k, v)| (k.get_ref().as_ref(), v))
    }

    /// A value that must be a table, under a name the user gave.
    pub fn named_table(&self, value: &'a Spanned<DeValue<'a>>) -> Option<Table<'a>> {
        value.get_ref().as_table().map(|t| Table::new(self.source, t, &value.span(), self.unit))
    }

    /// Takes all keys: what they should be is not known.
    pub fn accept_all_keys(&self) {
        self.accepts_all.set(true);
    }

    /// Notes every key that nobody asked for, with the nearest one that is known.
    pub fn refuse_unknown_keys(&self) {
        if self.accepts_all.get() {
            return;
        }
        let asked = self.asked.borrow();
        for (key, _) in self.entries.iter() {
            let name: &str = key.get_ref();
            if !asked.contains(&name) {
                let place = self.source.place(&key.span());
                let hint = suggestion(name, asked.iter().copied());
                let hint = if hint.is_empty() { format!("; known here: {}", asked.join(", ")) } else { hint };
                self.source.note(place.problem(format!("unknown key `{name}`{hint}")));
            }
        }
    }

    fn as_length(&self, key: &str, value: &Spanned<DeValue<'_>>) -> Option<f64> {
        let length = match value.get_ref() {
            DeValue::String(s) => units::length(s, self.unit).ok(),
            number => as_number(number).map(|x| self.unit.to_micrometres(x)),
        };
        let length = length.filter(|x| x.is_finite());
        match length {
            None => self.wrong(key, value, "a length such as 0.05 or \"50 nm\""),
            Some(x) if x.abs() > LARGEST => {
                self.wrong(key, value, "a length of at most 10 m");
                return None;
            }
            Some(_) => {}
        }
        length
    }
}

fn as_number(value: &DeValue<'_>) -> Option<f64> {
    let text = match value {
        DeValue::Integer(i) if i.radix() == 10 => i.as_str(),
        DeValue::Float(f) => f.as_str(),
        _ => return None,
    };
    let digits: String = text.chars().filter(|&c| c != '_').collect();
    digits.parse::<f64>().ok().filter(|x| x.is_finite())
}
