//! Media as people type them: a name, and an index or a file.

use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use gonio_embree::media::{self, Dispersion, parse_index};
use gonio_embree::optics::C64;

use super::Failure;

/// A medium given as `melanin=2.0+0.01i` or `glass=N-BK7.yml`.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedMedium {
    /// Its name.
    pub name: String,
    given: Given,
}

#[derive(Clone, Debug, PartialEq)]
enum Given {
    Index(C64),
    File(PathBuf),
}

impl FromStr for NamedMedium {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, value) = text
            .split_once('=')
            .ok_or("expected NAME=INDEX such as melanin=2.0+0.01i, or NAME=FILE such as glass=N-BK7.yml")?;
        let value = value.trim();
        let given = if media::is_file(value) { Given::File(value.into()) } else { Given::Index(parse_index(value)?) };
        Ok(Self { name: name.trim().into(), given })
    }
}

impl fmt::Display for NamedMedium {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.given {
            Given::Index(n) => write!(f, "{}={}+{}i", self.name, n.re, n.im),
            Given::File(path) => write!(f, "{}={}", self.name, path.display()),
        }
    }
}

impl NamedMedium {
    /// Its index over wavelength; a file is read.
    pub fn dispersion(&self) -> Result<Dispersion, Failure> {
        match &self.given {
            Given::Index(n) => Ok(Dispersion::Constant(*n)),
            Given::File(path) => media::read_file(path)
                .map(|read| read.dispersion)
                .map_err(|e| Failure::Input(format!("--medium {}: {e}", self.name))),
        }
    }

    /// The file it comes from.
    pub fn file(&self) -> Option<&Path> {
        match &self.given {
            Given::Index(_) => None,
            Given::File(path) => Some(path),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn media_are_indices_or_files() {
        for (text, shown) in [
            ("ink=2.0+0.01i", "ink=2+0.01i"),
            (" my ink = 1.5 ", "my ink=1.5+0i"),
            ("glass=dir/N-BK7.YML", "glass=dir/N-BK7.YML"),
            ("ink= a=b.csv", "ink=a=b.csv"),
        ] {
            assert_eq!(text.parse::<NamedMedium>().unwrap().to_string(), shown);
        }
        for bad in ["ink", "ink=", "ink=x.txt", "ink=-1"] {
            assert!(bad.parse::<NamedMedium>().is_err(), "{bad}");
        }
    }
}
