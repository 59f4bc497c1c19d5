//! The words and signs of a stack.

use super::Span;

/// What a token is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// `|`
    Bar,
    /// `,`
    Comma,
    /// `(`
    Open,
    /// `)`
    Close,
    /// `x`, `×` or `*` after a count.
    Times,
    /// Anything else up to a blank or a sign.
    Word,
    /// Behind the last character.
    End,
}

/// A token and its place.
#[derive(Clone, Copy, Debug)]
pub(super) struct Token<'a> {
    pub(super) kind: Kind,
    pub(super) text: &'a str,
    pub(super) span: Span,
}

/// Cuts a text into tokens; the last one is [`Kind::End`].
pub(super) fn tokens(text: &str) -> Vec<Token<'_>> {
    let mut all: Vec<Token<'_>> = Vec::new();
    let (mut rest, mut start) = (text, 0);
    while let Some(c) = rest.chars().next() {
        let after_count = all.last().is_some_and(|t| t.kind == Kind::Word && is_count(t.text));
        let (kind, len) = match sign(c) {
            Some(kind) => (Some(kind), c.len_utf8()),
            None if c.is_whitespace() => (None, c.len_utf8()),
            None => word(rest, after_count),
        };
        let (token, behind) = rest.split_at(len);
        let count = token.chars().count();
        all.extend(kind.map(|kind| Token { kind, text: token, span: Span { start, len: count } }));
        (rest, start) = (behind, start + count);
    }
    all.push(Token { kind: Kind::End, text: "", span: Span { start, len: 1 } });
    all
}

/// The kind of a character that stands for itself.
pub(super) fn sign(c: char) -> Option<Kind> {
    match c {
        '|' => Some(Kind::Bar),
        ',' => Some(Kind::Comma),
        '(' => Some(Kind::Open),
        ')' => Some(Kind::Close),
        '×' | '*' => Some(Kind::Times),
        _ => None,
    }
}

/// A word, its length in bytes; `12x` is a count and a sign.
fn word(rest: &str, after_count: bool) -> (Option<Kind>, usize) {
    let len = rest.find(|c: char| c.is_whitespace() || sign(c).is_some()).unwrap_or(rest.len());
    let word = &rest[..len];
    let digits = word.find(|c: char| !c.is_ascii_digit()).unwrap_or(len);
    match &word[digits..] {
        "x" | "X" if digits > 0 => (Some(Kind::Word), digits),
        "x" | "X" if after_count => (Some(Kind::Times), len),
        _ => (Some(Kind::Word), len),
    }
}

/// Whether a word can only be a number: then an `x` behind it is no name.
fn is_count(word: &str) -> bool {
    number(word).is_some_and(|(_, behind)| behind.is_empty())
}

/// Most characters of a number.
const LONGEST_NUMBER: usize = 64;

/// A number at the beginning of a word, and what follows it.
pub(super) fn number(word: &str) -> Option<(f64, &str)> {
    if !starts_number(word) {
        return None;
    }
    let ends = word.char_indices().map(|(i, c)| i + c.len_utf8()).take(LONGEST_NUMBER);
    ends.filter_map(|end| Some((word[..end].parse().ok()?, &word[end..]))).last()
}

/// Whether a word begins like a number; names do not.
pub(super) fn starts_number(word: &str) -> bool {
    word.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '+' | '-' | '.'))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cut(text: &str) -> Vec<&str> {
        tokens(text).iter().map(|t| t.text).collect()
    }

    #[test]
    fn blanks_do_not_matter() {
        assert_eq!(cut("air|12x(a 5nm)|air"), ["air", "|", "12", "x", "(", "a", "5nm", ")", "|", "air", ""]);
        assert_eq!(cut(" 3 × ( x 2 ) "), ["3", "×", "(", "x", "2", ")", ""]);
        let kinds: Vec<Kind> = tokens("2 x x 5nm").iter().map(|t| t.kind).collect();
        assert_eq!(kinds, [Kind::Word, Kind::Times, Kind::Word, Kind::Word, Kind::End]);
        assert_eq!(tokens("µm ß|")[2].span, Span { start: 4, len: 1 });
    }

    #[test]
    fn numbers_lead_words() {
        assert_eq!(number("1.5e2nm"), Some((150.0, "nm")));
        assert_eq!(number("2.0+0.01i"), Some((2.0, "+0.01i")));
        assert_eq!((number("nan"), number("inf"), number("nm")), (None, None, None));
    }
}
