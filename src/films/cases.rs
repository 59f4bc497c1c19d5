//! Stacks in a file, each with one wavelength, direction and polarization (schema `gonio-films-1`).

use std::path::Path;

use serde_json::Value;

use super::{Films, MOST_LAYERS};
use crate::optics::C64;
use crate::optics::film::{Amplitudes, Incidence, Layer};
use crate::sample::problem::{Place, Problem, Problems};
use crate::text;

/// Largest file taken, bytes.
const MOST_BYTES: u64 = 256 << 20;

/// A direction of incidence.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Direction {
    /// Angle of incidence, degrees, 0..=90.
    Angle(f64),
    /// Its cosine, 0..=1.
    Cos(f64),
    /// n sin θ, 0..=n.
    Kx(f64),
}

/// One question.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// Its name.
    pub id: String,
    /// The stack, its layers taken once.
    pub once: Films,
    /// How many times the layers are taken.
    pub repeat: usize,
    /// Direction of the light.
    pub direction: Direction,
    /// Whether the electric field lies in the plane of incidence (p), or perpendicular to it (s).
    pub p: bool,
}

impl Case {
    /// The answer.
    pub fn solve(&self) -> Amplitudes {
        let films = Films { layers: self.once.layers.repeat(self.repeat), ..self.once.clone() };
        let n = films.first;
        let both = films.solve(&match self.direction {
            Direction::Angle(deg) => Incidence::from_angle(n, deg.to_radians()),
            Direction::Cos(cos) => Incidence::from_cos(n, cos),
            Direction::Kx(kx) => Incidence::from_kx(n, kx),
        });
        if self.p { both.p } else { both.s }
    }

    /// Shares reflected and transmitted for light from behind; none if no light travels there, or not without loss.
    pub fn back(&self, solved: &Amplitudes) -> Option<(f64, f64)> {
        let (n, last) = (self.once.first, self.once.last);
        let grazing = matches!(self.direction, Direction::Cos(0.0)) || self.direction == Direction::Kx(n);
        let r = solved.r_back.norm_sqr();
        if last.im != 0.0 {
            None
        } else if grazing {
            // Along the first medium nothing is carried away.
            (last.re > n).then_some((r, 0.0))
        } else {
            (solved.flux_ratio > 0.0).then(|| (r, solved.t_back.norm_sqr() / solved.flux_ratio))
        }
    }
}

/// Reads all cases of a file.
///
/// # Errors
/// What is wrong with each case.
pub fn read(path: &Path) -> Result<Vec<Case>, Problems> {
    let place = Place::file(path);
    let text = text::read(path, MOST_BYTES).map_err(|e| place.problem(e))?;
    from_json(&text, &place)
}

fn from_json(text: &str, place: &Place) -> Result<Vec<Case>, Problems> {
    let file: Value =
        serde_json::from_str(&quote_non_numbers(text)).map_err(|e| place.problem(format!("no JSON: {e}")))?;
    let Some(values) = file["cases"].as_array() else {
        return Err(place.problem("expected {\"cases\": [...]} of schema gonio-films-1").into());
    };
    let read: Vec<Result<Case, Problem>> =
        values.iter().enumerate().map(|(i, v)| case(v, i).map_err(|e| place.problem(e))).collect();
    let problems: Problems = read.iter().filter_map(|r| r.as_ref().err().cloned()).collect();
    problems.or(read.into_iter().flatten().collect())
}

/// NaN and Infinity are no JSON, but some programs write them: as texts they are refused where a number is needed,
/// with the name of the field.
fn quote_non_numbers(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    // Pieces between quotes are outside and inside of strings by turns; an escaped quote does not count.
    let (mut inside, mut rest) = (false, text);
    while !rest.is_empty() {
        let end = if inside { closing_quote(rest) } else { rest.find('"') };
        let (piece, behind) = rest.split_at(end.map_or(rest.len(), |i| i + 1));
        if inside {
            out += piece;
        } else {
            out +=
                &piece.replace("NaN", "\"NaN\"").replace("-Infinity", "Infinity").replace("Infinity", "\"Infinity\"");
        }
        (inside, rest) = (!inside, behind);
    }
    out
}

fn closing_quote(text: &str) -> Option<usize> {
    let mut escaped = false;
    text.bytes().position(|b| {
        let closes = b == b'"' && !escaped;
        escaped = b == b'\\' && !escaped;
        closes
    })
}

fn case(value: &Value, number: usize) -> Result<Case, String> {
    let Some(id) = value["id"].as_str() else {
        return Err(format!("cases[{number}]: id: {}", found(&value["id"], "a text")));
    };
    fields(value, id).map_err(|e| format!("case `{id}`: {e}"))
}

fn fields(value: &Value, id: &str) -> Result<Case, String> {
    let first = index(&value["n_first"], "n_first")?;
    if first.im != 0.0 || first.re <= 0.0 {
        return Err(format!("n_first: {first}: expected a transparent medium: n > 0 and k = 0"));
    }
    let layers = value["layers"].as_array().ok_or_else(|| wrong("layers", &value["layers"], "a list of [n, k, nm]"))?;
    let layers: Vec<Layer> = layers.iter().enumerate().map(|(i, l)| layer(l, i)).collect::<Result<_, _>>()?;
    let expected = "a whole number from 1";
    let repeat =
        value["repeat"].as_u64().filter(|&n| n > 0).ok_or_else(|| wrong("repeat", &value["repeat"], expected))?;
    let repeat = usize::try_from(repeat).unwrap_or(usize::MAX);
    if layers.len().saturating_mul(repeat) > MOST_LAYERS {
        return Err(format!("repeat: more than {MOST_LAYERS} layers; repeat less often"));
    }
    let last = index(&value["n_last"], "n_last")?;
    let wavelength_nm = real(&value["wavelength_nm"], "wavelength_nm", |w| w > 0.0, "a length greater than 0, nm")?;
    let p = match value["pol"].as_str() {
        Some("s") => false,
        Some("p") => true,
        _ => return Err(wrong("pol", &value["pol"], "\"s\" or \"p\"")),
    };
    let direction = direction(&value["angle"], first.re)?;
    Ok(Case { id: id.into(), once: Films { first: first.re, layers, last, wavelength_nm }, repeat, direction, p })
}

fn direction(angle: &Value, n: f64) -> Result<Direction, String> {
    let value = &angle["value"];
    let within = |most: f64, what: &str| {
        let expected = format!("{what} from 0 to {most}");
        real(value, "angle.value", |x| (0.0..=most).contains(&x), &expected)
    };
    match angle["kind"].as_str() {
        Some("angle_deg") => Ok(Direction::Angle(within(90.0, "an angle in degrees")?)),
        Some("cos0") => Ok(Direction::Cos(within(1.0, "a cosine")?)),
        Some("kx") => Ok(Direction::Kx(within(n, "n sin of the angle")?)),
        _ => Err(wrong("angle.kind", &angle["kind"], "\"angle_deg\", \"cos0\" or \"kx\"")),
    }
}

fn layer(value: &Value, i: usize) -> Result<Layer, String> {
    let name = format!("layers[{i}]");
    if value.as_array().is_none_or(|a| a.len() != 3) {
        return Err(wrong(&name, value, "[n, k, thickness in nm]"));
    }
    let thickness = real(&value[2], &format!("{name} thickness"), |d| d >= 0.0, "a length from 0, nm")?;
    Ok(Layer { index: parts(value, &name)?, thickness })
}

fn index(value: &Value, name: &str) -> Result<C64, String> {
    if value.as_array().is_none_or(|a| a.len() != 2) {
        return Err(wrong(name, value, "[n, k]"));
    }
    parts(value, name)
}

/// n and k; metals and plasmas with n = 0 are media too, nothing at all is not.
fn parts(value: &Value, name: &str) -> Result<C64, String> {
    let k = real(&value[1], &format!("{name} k"), |k| k >= 0.0, "a number from 0 (k > 0 absorbs)")?;
    let n = real(&value[0], &format!("{name} n"), |n| n > 0.0 || n == 0.0 && k > 0.0, "a number greater than 0")?;
    Ok(C64::new(n, k))
}

fn real(value: &Value, name: &str, holds: impl Fn(f64) -> bool, expected: &str) -> Result<f64, String> {
    value.as_f64().filter(|&x| x.is_finite() && holds(x)).ok_or_else(|| wrong(name, value, expected))
}

fn wrong(name: &str, value: &Value, expected: &str) -> String {
    format!("{name}: {}", found(value, expected))
}

fn found(value: &Value, expected: &str) -> String {
    /// Characters of a value that are shown.
    const SHOWN: usize = 60;
    if value.is_null() {
        return format!("missing; expected {expected}");
    }
    let text: String = value.to_string().chars().take(SHOWN).collect();
    format!("found {text}; expected {expected}")
}
