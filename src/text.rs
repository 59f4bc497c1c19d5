//! Text: files, read whole but not without bounds, and choices written as words.

use std::fs::File;
use std::io::{ErrorKind, Read as _};
use std::path::Path;

/// The text of a file of at most `most` bytes.
///
/// # Errors
/// Why there is none.
pub fn read(path: &Path, most: u64) -> Result<String, String> {
    let mut text = String::new();
    let file = File::open(path).map_err(|e| format!("cannot be read: {e}"))?;
    file.take(most + 1).read_to_string(&mut text).map_err(|e| match e.kind() {
        ErrorKind::InvalidData => "cannot be read: it is no text in UTF-8".to_string(),
        _ => format!("cannot be read: {e}"),
    })?;
    if text.len() as u64 > most {
        return Err(format!("is larger than {} MB: more is not taken", most >> 20));
    }
    Ok(text)
}

/// The words one may choose from, as in `a, b or c`.
pub fn one_of(words: &[&str]) -> String {
    match words {
        [first @ .., before, last] => [first, &[&format!("{before} or {last}")]].concat().join(", "),
        _ => words.join(""),
    }
}

/// Text as XML and HTML show it, in an element or an attribute.
pub fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            '\'' => out.push_str("&#39;"),
            // Invisible ones, which could turn what follows around or end the document.
            c if c.is_control() || matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}') => {
                out.push('\u{fffd}')
            }
            c => out.push(c),
        }
    }
    out
}

/// Makes an enumeration one that is written, and read, as one of some words.
macro_rules! words {
    ($type:ty { $($variant:ident = $word:literal),+ $(,)? }) => {
        impl std::fmt::Display for $type {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str(match self { $(Self::$variant => $word),+ })
            }
        }

        impl std::str::FromStr for $type {
            type Err = String;

            fn from_str(s: &str) -> Result<Self, String> {
                match s {
                    $($word => Ok(Self::$variant),)+
                    _ => Err(format!("`{s}`: expected {}", $crate::text::one_of(&[$($word),+]))),
                }
            }
        }
    };
}
pub(crate) use words;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn choices_read_like_a_sentence() {
        assert_eq!(one_of(&["a", "b", "c"]), "a, b or c");
        assert_eq!(one_of(&["a", "b"]), "a or b");
        assert_eq!(one_of(&["a"]), "a");
    }

    #[test]
    fn marks_of_xml_are_written_as_names() {
        assert_eq!(escaped("<a b=\"c\">&amp;"), "&lt;a b=&quot;c&quot;&gt;&amp;amp;");
    }
}
