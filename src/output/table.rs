//! The result as people read it at the terminal.

use std::fmt::Write as _;

use super::measured::{Measured, StackHits};
use crate::bsdf::{Ledger, Scattering};
use crate::colour::{self, Illuminant, Srgb};
use crate::dome::Estimate;
use crate::plan::features::SMALL;
use crate::units::{show_length, significant};

/// One table per incidence, then what is to be said about all of them; `chips` draws colours where a terminal can.
pub fn text(measured: &Measured, chips: bool) -> String {
    let mut out = String::new();
    let shown = columns(&measured.bsdf.incidences);
    let weights = colour::weights(Illuminant::D65, &measured.bsdf.wavelength_nm);
    for s in &measured.bsdf.incidences {
        incidence(&mut out, s, &measured.bsdf.wavelength_nm, &shown);
        glance(&mut out, s, weights.as_deref(), chips);
        errors(&mut out, s);
    }
    notes(&mut out, measured);
    out
}

/// Columns of the ledger that are shown: reflection and transmission always, the rest where there is any.
fn columns(incidences: &[Scattering]) -> Vec<&'static str> {
    let names = Ledger::default().entries().map(|(name, _)| name);
    let any = |i: usize| incidences.iter().any(|s| s.ledger.entries()[i].1.iter().any(|e| e.value != 0.0));
    names
        .into_iter()
        .enumerate()
        .filter(|&(i, name)| match name {
            "reflected" | "transmitted" => true,
            // Told of in the notes.
            "small_feature_flux" | "edge_flux" => false,
            _ => any(i),
        })
        .map(|(_, name)| name)
        .collect()
}

/// Width of a column.
const WIDTH: usize = 21;

fn incidence(out: &mut String, s: &Scattering, wavelengths: &[f64], shown: &[&str]) {
    let facets = s.facets.iter().filter(|f| f.trees > 0).count();
    let _ = writeln!(
        out,
        "incidence θ {}°, φ {}°: {} trees, {} segments, {} facets hit",
        s.incidence.theta_deg, s.incidence.phi_deg, s.trees, s.segments, facets
    );
    let _ = write!(out, "{:>8}", "λ/nm");
    shown.iter().for_each(|name| {
        let _ = write!(out, "{name:>WIDTH$}");
    });
    out.push('\n');
    let entries: Vec<&Vec<Estimate>> =
        s.ledger.entries().into_iter().filter(|(name, _)| shown.contains(name)).map(|(_, e)| e).collect();
    for (w, wavelength) in wavelengths.iter().enumerate() {
        let _ = write!(out, "{wavelength:>8}");
        for entry in &entries {
            let _ = write!(out, "{:>WIDTH$}", value(entry[w]));
        }
        out.push('\n');
    }
}

/// Spectra at a glance: a line of blocks, highest where most is reflected, and the colour.
fn glance(out: &mut String, s: &Scattering, weights: Option<&[[f64; 3]]>, chips: bool) {
    let reflected: Vec<f64> = s.ledger.reflected.iter().map(|e| e.value).collect();
    let (least, most) = reflected.iter().fold((f64::INFINITY, 0.0), |(l, m): (f64, f64), &x| (l.min(x), m.max(x)));
    if reflected.len() > 1 && most > 0.0 {
        let _ = write!(out, "R(λ) {}  {least:.4} to {most:.4}", blocks(&reflected, most));
    }
    if let Some(lab) = s.derived.reflected_lab {
        let of = |name: &str, e: Estimate| format!("{name} {:.1} ±{:.2}", e.value, e.se);
        let _ = write!(out, "   {} {} {}", of("L*", lab[0]), of("a*", lab[1]), of("b*", lab[2]));
    }
    if let Some(weights) = weights {
        let Srgb([r, g, b]) = colour::srgb(colour::summed(weights, reflected.iter().copied()));
        let chip = if chips { format!("\x1b[48;2;{r};{g};{b}m    \x1b[0m ") } else { String::new() };
        let _ = write!(out, "   colour in daylight {chip}#{r:02x}{g:02x}{b:02x}");
    }
    out.push_str(if reflected.len() > 1 && most > 0.0 || weights.is_some() { "\n\n" } else { "\n" });
}

/// How far all of it may be from the truth.
fn errors(out: &mut String, s: &Scattering) {
    let p = &s.derived.precision;
    let percent = |share: f64| format!("{} %", significant(100.0 * share, 2));
    let percent = |share: f64| if share < 1.0 { percent(share) } else { "over 100 %".into() };
    let parts = [("BRDF", p.above), ("BTDF", p.below), ("reflected", p.reflected), ("transmitted", p.transmitted)];
    let told: Vec<String> =
        parts.iter().filter(|(_, e)| *e > 0.0).map(|(name, e)| format!("{name} {}", percent(*e))).collect();
    if told.is_empty() {
        return;
    }
    let worst = match p.facet {
        0.0 => String::new(),
        e if e.is_finite() => format!("; worst facet of 8° {}", percent(e)),
        _ => "; some facets of 8° unresolved".into(),
    };
    let _ = writeln!(out, "errors (95 %): {}{worst}\n", told.join(", "));
}

/// Values as blocks of eight heights, `most` the highest.
fn blocks(values: &[f64], most: f64) -> String {
    const HEIGHTS: [char; 8] = ['▁', '▂', '▃', '▄', '▅', '▆', '▇', '█'];
    values.iter().map(|x| HEIGHTS[((x / most * 8.0) as usize).min(7)]).collect()
}

/// A share with its standard error, as many digits as the error allows.
fn value(e: Estimate) -> String {
    if e.se.is_nan() || e.se == 0.0 {
        return if e.value == 0.0 { "0".into() } else { tiny(e.value, 6) };
    }
    // Two digits of the error, but not beyond what fits.
    let decimals = (1 - e.se.log10().floor() as i32).clamp(2, 6) as usize;
    format!("{} ±{}", tiny(e.value, decimals), tiny(e.se, decimals))
}

fn tiny(x: f64, decimals: usize) -> String {
    if x != 0.0 && x.abs() < 0.5 * 0.1f64.powi(decimals as i32) {
        format!("{x:.1e}")
    } else {
        format!("{x:.decimals$}")
    }
}

fn notes(out: &mut String, measured: &Measured) {
    let p = &measured.provenance;
    let list = |on: bool| p.effects.iter().filter(|e| e.on == on).map(|e| &e.name[..]).collect::<Vec<_>>().join(", ");
    let _ = writeln!(out, "simulated: {}; not needed: {}", or_none(list(true)), or_none(list(false)));
    stacks(out, &p.stacks);
    doubts(measured).iter().for_each(|doubt| {
        let _ = writeln!(out, "{doubt}");
    });
}

/// Stacks, and layers of them, that are listed.
const STACKS_LISTED: usize = 5;
const LAYERS_LISTED: usize = 4;

fn stacks(out: &mut String, stacks: &[StackHits]) {
    if stacks.is_empty() {
        return;
    }
    let hits: u64 = stacks.iter().map(|s| s.hits).sum();
    let _ =
        writeln!(out, "films: {hits} stacks solved, of {}; by share of the light that met them:", kinds(stacks.len()));
    for s in stacks.iter().take(STACKS_LISTED) {
        let plural = if s.layers == 1 { "" } else { "s" };
        let _ = writeln!(out, "{:>8.2} %  {} layer{plural}: {}", 100.0 * s.flux_share, s.layers, layers(s));
    }
    if stacks.len() > STACKS_LISTED {
        let _ =
            writeln!(out, "{:>10}  and {} more, in --json and in the result", "", kinds(stacks.len() - STACKS_LISTED));
    }
}

fn kinds(n: usize) -> String {
    format!("{n} kind{}", if n == 1 { "" } else { "s" })
}

/// Media with their thicknesses, from the side of the light.
fn layers(stack: &StackHits) -> String {
    let one = |(medium, [least, most]): (&String, &[f64; 2])| {
        // To what a film could feel.
        if most - least < 1e-6 {
            format!("{medium} {}", show_length(*least))
        } else {
            format!("{medium} {} to {}", show_length(*least), show_length(*most))
        }
    };
    let listed: Vec<String> = stack.media.iter().zip(&stack.thickness_um).take(LAYERS_LISTED).map(one).collect();
    listed.join(", ") + if stack.layers > LAYERS_LISTED { ", ..." } else { "" }
}

fn or_none(list: String) -> String {
    if list.is_empty() { "nothing".into() } else { list }
}

/// Shares below this are not worth a line.
const NEGLIGIBLE: f64 = 0.005;

/// What is to be said against the result, a line each.
pub fn doubts(measured: &Measured) -> Vec<String> {
    let v = &measured.provenance.validity;
    let mut all = Vec::new();
    let loss = measured.bsdf.largest_loss();
    if loss > 0.0 {
        all.push(format!("energy lost: {loss:.1e} at most"));
    }
    if v.edge_flux >= NEGLIGIBLE {
        let done = if v.edges == "reject" {
            "none was taken (--edges reject)"
        } else {
            "they count as endless (--edges column)"
        };
        let share = 100.0 * v.edge_flux;
        all.push(format!("films end near where up to {share:.1} % of the light met them; there {done}"));
    }
    if v.small_feature_flux >= NEGLIGIBLE {
        let smallest = v.smallest_feature_um.map(|um| format!(" (smallest feature {})", show_length(um)));
        all.push(format!(
            "ray optics is in doubt for up to {:.1} % of the light: it met faces narrower than {SMALL} wavelengths{}",
            100.0 * v.small_feature_flux,
            smallest.unwrap_or_default()
        ));
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_rise_with_their_values() {
        assert_eq!(blocks(&[0.0, 0.5, 1.0, 0.99, 0.12], 1.0), "▁▅██▁");
    }

    #[test]
    fn values_show_as_many_digits_as_their_error() {
        let show = |value, se| super::value(Estimate { value, se });
        assert_eq!(show(0.123_456, 0.001_23), "0.1235 ±0.0012");
        assert_eq!(show(0.123_456, 0.0), "0.123456");
        assert_eq!(show(0.0, 0.0), "0");
        assert_eq!(show(3e-9, 0.0), "3.0e-9");
        assert_eq!(show(0.5, f64::NAN), "0.500000");
        assert_eq!(show(0.25, 1e-8), "0.250000 ±1.0e-8");
        assert!([show(0.502, 9e-6), show(-1e-9, 1e-9)].iter().all(|t| t.chars().count() < WIDTH));
    }
}
