//! The language of stacks: `air | 12 x (chitin 50nm, air 150nm) | air`.
//!
//! ```text
//! stack  = medium "|" [ items "|" ] medium
//! items  = item { "," item }
//! item   = [ count ( "x" | "×" | "*" ) ] ( "(" items ")" | item | medium thickness )
//! medium = name | index            such as  fused silica, 1.5, 2.0+0.01i
//! thickness = number [ unit ]      unit: nm (if none is given), um, mm
//! ```

use super::tokens::{Kind, Token, number, starts_number, tokens};
use super::{FilmStack, MOST_LAYERS, Medium, Span, StackError, Written};
use crate::media::parse_index;

/// Deepest nesting of repetitions.
const DEEPEST: usize = 100;
/// Thickest layer, nm.
const THICKEST_NM: f64 = 1e9;

/// Reads a stack.
///
/// # Errors
/// The first thing that is wrong.
pub fn parse(text: &str) -> Result<FilmStack, StackError> {
    let tokens = tokens(text);
    let bars: Vec<&Token<'_>> = tokens.iter().filter(|t| t.kind == Kind::Bar).collect();
    if let Some(bar) = bars.get(2) {
        return Err(wrong(
            bar.span,
            "found a third `|`; expected first medium | layers | last medium: separate layers by commas",
        ));
    }
    let inner = bars.len() == 2;
    let mut parser = Parser { tokens: &tokens, depth: 0 };
    let first = parser.outer("first")?;
    parser.expect(Kind::Bar, "expected `|` and the layers, as in `air | chitin 50nm | air`")?;
    let layers = if inner { parser.items()? } else { Vec::new() };
    if inner {
        parser.expect(Kind::Bar, "expected `,` and a layer, or `|` and the last medium")?;
    }
    let last = parser.outer("last")?;
    parser.expect(Kind::End, "expected the end after the last medium")?;
    Ok(FilmStack { first, layers, last })
}

fn wrong(span: Span, message: impl Into<String>) -> StackError {
    StackError { span, message: message.into() }
}

/// From the beginning of one token to the end of another.
fn spanning(words: &[Token<'_>]) -> Span {
    let (first, last) = (words[0].span, words[words.len() - 1].span);
    Span { start: first.start, len: last.start + last.len - first.start }
}

fn found(token: &Token<'_>) -> String {
    if token.kind == Kind::End { "found the end".into() } else { format!("found `{}`", token.text) }
}

type Layers = Vec<(Written, f64)>;

struct Parser<'a> {
    /// What is still to be read; the last one is the end.
    tokens: &'a [Token<'a>],
    depth: usize,
}

impl<'a> Parser<'a> {
    fn next(&self) -> &'a Token<'a> {
        &self.tokens[0]
    }

    fn take(&mut self, count: usize) -> &'a [Token<'a>] {
        let (taken, rest) = self.tokens.split_at(count);
        self.tokens = rest;
        taken
    }

    fn words(&mut self) -> &'a [Token<'a>] {
        self.take(self.tokens.iter().take_while(|t| t.kind == Kind::Word).count())
    }

    fn expect(&mut self, kind: Kind, expected: &str) -> Result<(), StackError> {
        let token = self.next();
        if token.kind != kind {
            return Err(wrong(token.span, format!("{}; {expected}", found(token))));
        }
        if kind != Kind::End {
            self.take(1);
        }
        Ok(())
    }

    /// The first or the last medium.
    fn outer(&mut self, which: &str) -> Result<Written, StackError> {
        let words = self.words();
        if words.is_empty() {
            let token = self.next();
            return Err(wrong(
                token.span,
                format!("{}; expected the {which} medium, such as air or 1.5", found(token)),
            ));
        }
        let (name, thickness) = split(words);
        let thick = number(thickness[0].text).is_some_and(|(_, behind)| !behind.starts_with(['+', '-', 'i']));
        if !name.is_empty() && thick {
            let found = text(thickness);
            let message = format!("found a thickness `{found}`; the {which} medium is endless: write its name only");
            return Err(wrong(spanning(thickness), message));
        }
        medium(words)
    }

    fn items(&mut self) -> Result<Layers, StackError> {
        let mut all = self.item()?;
        while self.next().kind == Kind::Comma {
            let comma = self.take(1)[0].span;
            all.extend(self.item()?);
            check_count(all.len(), comma)?;
        }
        Ok(all)
    }

    fn item(&mut self) -> Result<Layers, StackError> {
        let start = self.next();
        self.depth += 1;
        if self.depth > DEEPEST {
            return Err(wrong(
                start.span,
                format!("found more than {DEEPEST} repetitions within each other; write fewer"),
            ));
        }
        let layers = match (start.kind, self.tokens.get(1).map(|t| t.kind)) {
            (Kind::Word, Some(Kind::Times)) => {
                let count = count(start)?;
                self.take(2);
                let once = self.item()?;
                check_count(once.len().saturating_mul(count), start.span)?;
                (0..count).flat_map(|_| once.iter().cloned()).collect()
            }
            (Kind::Open, _) => self.group()?,
            (Kind::Word, _) => vec![layer(self.words())?],
            (Kind::Times, _) => {
                return Err(wrong(
                    start.span,
                    format!("{} without a count; write for example `12 x (...)`", found(start)),
                ));
            }
            _ => return Err(wrong(start.span, format!("{}; expected a layer such as `chitin 50nm`", found(start)))),
        };
        self.depth -= 1;
        Ok(layers)
    }

    fn group(&mut self) -> Result<Layers, StackError> {
        let open = self.take(1)[0].span.start + 1;
        let layers = self.items()?;
        self.expect(Kind::Close, &format!("expected `,` and a layer, or the `)` for the `(` of column {open}"))?;
        Ok(layers)
    }
}

fn check_count(layers: usize, span: Span) -> Result<(), StackError> {
    if layers <= MOST_LAYERS {
        return Ok(());
    }
    Err(wrong(span, format!("found {layers} layers; expected at most {MOST_LAYERS}: repeat less often")))
}

fn count(token: &Token<'_>) -> Result<usize, StackError> {
    token.text.parse().ok().filter(|&n| n > 0).ok_or_else(|| {
        wrong(
            token.span,
            format!("found `{}` repetitions; expected a whole number from 1, as in `12 x (...)`", token.text),
        )
    })
}

/// What is before a thickness, and the thickness: the last word, or a number and its unit.
fn split<'t, 'a>(words: &'t [Token<'a>]) -> (&'t [Token<'a>], &'t [Token<'a>]) {
    let count = words.len();
    let whole = |t: &Token<'_>| number(t.text).is_some_and(|(_, behind)| behind.is_empty());
    let apart = count > 1 && whole(&words[count - 2]) && !starts_number(words[count - 1].text);
    words.split_at(count - if apart { 2 } else { 1 })
}

/// A layer: a medium and its thickness.
fn layer(words: &[Token<'_>]) -> Result<(Written, f64), StackError> {
    let (name, thickness) = split(words);
    let Some((value, behind)) = number(thickness[0].text) else {
        let all = spanning(words);
        return Err(wrong(all, format!("found no thickness behind `{}`; write for example `{0} 50nm`", text(words))));
    };
    let nm = match thickness {
        [_, unit] => value * nanometres(unit.text, unit.span)?,
        _ => value * nanometres(behind, spanning(thickness))?,
    };
    if name.is_empty() {
        let message = format!("found only `{}`; expected a medium and a thickness, such as `chitin 50nm`", text(words));
        return Err(wrong(spanning(words), message));
    }
    if !(0.0..=THICKEST_NM).contains(&nm) {
        let message = format!("found a thickness of `{}`; expected 0 to 1000 mm", text(thickness));
        return Err(wrong(spanning(thickness), message));
    }
    Ok((medium(name)?, nm))
}

/// Nanometres per unit.
fn nanometres(unit: &str, span: Span) -> Result<f64, StackError> {
    match unit {
        "" | "nm" => Ok(1.0),
        "um" | "µm" | "μm" => Ok(1e3),
        "mm" => Ok(1e6),
        _ => Err(wrong(span, format!("found the unit `{unit}`; expected nm, um or mm, as in `50nm`"))),
    }
}

/// An index written with blanks: `2.0 + 0.01i`.
fn is_sum(words: &[Token<'_>]) -> bool {
    matches!(words, [a, plus, b] if number(a.text).is_some() && matches!(plus.text, "+" | "-") && b.text.ends_with('i'))
}

fn text(words: &[Token<'_>]) -> String {
    words.iter().map(|t| t.text).collect::<Vec<_>>().join(" ")
}

fn medium(words: &[Token<'_>]) -> Result<Written, StackError> {
    let span = spanning(words);
    let name = text(words);
    if starts_number(words[0].text) && (words.len() == 1 || is_sum(words)) {
        let index = parse_index(&name.replace(' ', "")).map_err(|e| wrong(span, e))?;
        return Ok(Written { medium: Medium::Index(index), span });
    }
    if let Some(i) = words.iter().skip(1).position(|t| starts_number(t.text)) {
        // Only a thickness begins so within a layer, and it would have been the last.
        let next = words.get(i + 2).unwrap_or(&words[i + 1]);
        return Err(wrong(
            next.span,
            format!("found `{}` behind `{}`; expected `,`", next.text, text(&words[..=i + 1])),
        ));
    }
    if starts_number(words[0].text) {
        return Err(wrong(span, format!("found `{name}`; expected an index such as 1.5, or a name, not both")));
    }
    Ok(Written { medium: Medium::Named(name), span })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::optics::C64;

    fn layers(text: &str) -> Vec<(Medium, f64)> {
        parse(text).unwrap().layers.into_iter().map(|(w, nm)| (w.medium, nm)).collect()
    }

    fn named(name: &str) -> Medium {
        Medium::Named(name.into())
    }

    #[test]
    fn blanks_units_and_indices() {
        let truth = [(named("fused silica"), 50.0), (Medium::Index(C64::new(2.0, 0.01)), 1500.0)];
        for text in [
            "air|fused silica 50nm,2.0+0.01i 1.5um|air",
            "  air |  fused   silica 50 nm , 2.0+0.01i 1.5 µm | air ",
            "air | fused silica 50, 2.0 + 0.01i 1.5e-3mm | 1.5",
            "air\t|\nfused silica .05 um,2.0 + 0.01i 1500 | 1.5 + 2i",
        ] {
            assert_eq!(layers(text), truth, "{text}");
        }
        assert!(layers("air | glass").is_empty());
    }

    #[test]
    fn repetitions_nest() {
        let nested = layers("a | 2 x (b 1, 3×(c 2, 2x d 3)), 2*e 4 | f");
        let names: String = nested.iter().map(|(m, _)| if let Medium::Named(n) = m { &n[..] } else { "?" }).collect();
        assert_eq!(names, "bcddcddcddbcddcddcddee");
        assert_eq!(layers("a | 2 x 3 x b 1 | a").len(), 6);
        assert_eq!(layers("a | 2 x x 5nm | x")[0], (named("x"), 5.0));
    }

    #[test]
    fn errors_have_a_place() {
        let error = parse("air | chitin 50 kg | air").unwrap_err();
        let shown = error.show("air | chitin 50 kg | air").to_string();
        let lines: Vec<&str> = shown.lines().collect();
        assert_eq!(lines[1..], ["  air | chitin 50 kg | air", "                  ^^"]);
        assert!(lines[0].starts_with("stack, column 17: found the unit `kg`"), "{shown}");
    }
}
