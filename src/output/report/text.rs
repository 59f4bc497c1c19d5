//! The parts of a page that no slider changes.

use std::fmt::Write as _;
use std::path::Path;

use super::data::{APERTURE_DEG, Data, LEAST_ERROR};
use crate::output::measured::{EffectUsed, Measured, Provenance, StackHits};
use crate::output::table;
use crate::text::escaped;
use crate::units::{show_length, significant};

/// What was measured: the name of the sample's file.
pub fn title(p: &Provenance) -> String {
    let name = |file: &String| Path::new(file).file_name().map(|n| n.to_string_lossy().into_owned());
    p.sample_files.first().and_then(name).unwrap_or_else(|| "Sample".into())
}

/// One sentence on the measurement.
pub fn summary(measured: &Measured) -> String {
    let (bsdf, p) = (&measured.bsdf, &measured.provenance);
    let wavelengths = match &bsdf.wavelength_nm[..] {
        [one] => format!("{one} nm"),
        [first, .., last] => format!("{} wavelengths from {first} to {last} nm", bsdf.wavelength_nm.len()),
        [] => "no wavelength".into(),
    };
    let directions = match bsdf.incidences.len() {
        1 => "one direction".into(),
        n => format!("{n} directions"),
    };
    let trees = bsdf.incidences.iter().map(|s| s.trees).max().unwrap_or(0);
    let state = match &p.polarization[..] {
        "mueller" => {
            "all polarizations. The file has Mueller matrices; this page shows what they do to unpolarized light"
                .to_owned()
        }
        state => format!("polarization: {}", escaped(state)),
    };
    format!("Light of {wavelengths} from {directions}, {} ray trees each; {state}.", thousands(trees))
}

fn thousands(n: u64) -> String {
    let digits = n.to_string();
    let mut out = String::new();
    for (i, c) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            out.push('\u{202f}');
        }
        out.push(c);
    }
    out
}

/// What is to be said against the result.
pub fn doubts(measured: &Measured) -> String {
    let doubts = table::doubts(measured);
    if doubts.is_empty() {
        return "<p class=\"fine\">No energy was lost, and nothing puts ray optics in doubt.</p>".into();
    }
    let items: String = doubts.iter().map(|d| format!("<li>{}</li>", escaped(d))).collect();
    format!("<div class=\"doubts\" role=\"note\"><h2>Validity</h2><ul>{items}</ul></div>")
}

/// What swatches show, or why there are none.
pub fn colour_note(known: bool) -> String {
    if known {
        format!(
            "Colours of daylight (D65) to the CIE 1931 2° observer, in sRGB. Spectra go straight from each wavelength to the \
             next and stay as they are beyond the ends. Each strip shows what a detector with an aperture of {APERTURE_DEG}° sees \
             in the plane of incidence, scaled so that its brightest place just fits a screen: brightness compares within a \
             strip, not between strips. What leaves exactly in one direction does not set that scale unless it is all there \
             is; it is shown as bright as fits. At the right: all that is reflected or transmitted, not scaled."
        )
    } else {
        "The colour is not known: the wavelengths do not reach from 400 to 700 nm.".into()
    }
}

fn row(cells: &[(&str, String)]) -> String {
    let cells: String = cells.iter().map(|(class, text)| format!("<td class=\"{class}\">{text}</td>")).collect();
    format!("<tr>{cells}</tr>")
}

/// The plan, with its reasons.
pub fn effects(effects: &[EffectUsed]) -> String {
    let bound = |b: f64| match b {
        b if b >= 1.0 => "any".into(),
        0.0 => "0".into(),
        b => format!("{} %", significant(100.0 * b, 2)),
    };
    let of = |e: &EffectUsed| {
        let state = if e.on { "<b>simulated</b>" } else { "left out" };
        row(&[
            ("name", escaped(&e.name)),
            ("", state.into()),
            ("number bound", bound(e.bound)),
            ("text", escaped(&e.reason)),
        ])
    };
    effects.iter().map(of).collect()
}

/// The stacks of films that were found.
pub fn stacks(stacks: &[StackHits]) -> String {
    if stacks.is_empty() {
        return "<p>No films were found.</p>".into();
    }
    let hits: u64 = stacks.iter().map(|s| s.hits).sum();
    let plural = if stacks.len() == 1 { "kind" } else { "kinds" };
    let rows: String = stacks.iter().map(stack).collect();
    format!(
        "<p>{} stacks solved, of {} {plural}. Share: power that met them over incident power, mean of all incidences and \
         wavelengths; light that meets several counts for each.</p><div class=\"wide\" tabindex=\"0\" role=\"region\" \
         aria-label=\"Stacks of films\"><table><thead><tr><th>share</th><th>met</th><th>layers</th>\
         <th class=\"text\">media, from the side of the light</th></tr></thead><tbody>{rows}</tbody></table></div>",
        thousands(hits),
        stacks.len()
    )
}

fn stack(s: &StackHits) -> String {
    let layer = |(medium, [least, most]): (&String, &[f64; 2])| {
        // To what a film could feel.
        let thickness = if most - least < 1e-6 {
            show_length(*least)
        } else {
            format!("{} to {}", show_length(*least), show_length(*most))
        };
        format!("{} {thickness}", escaped(medium))
    };
    let mut layers: Vec<String> = s.media.iter().zip(&s.thickness_um).map(layer).collect();
    if s.layers > layers.len() {
        layers.push(format!("and {} more", s.layers - layers.len()));
    }
    row(&[
        ("number", format!("{:.2} %", 100.0 * s.flux_share)),
        ("number", thousands(s.hits)),
        ("number", s.layers.to_string()),
        ("text", layers.join(", ")),
    ])
}

/// Where the result comes from.
pub fn provenance(p: &Provenance) -> String {
    let entries = [
        ("command", format!("<code>{}</code>", escaped(&p.command))),
        ("version", format!("gonio-embree {}", escaped(&p.version))),
        ("seed", p.seed.to_string()),
        ("intersection", format!("{} {}", escaped(&p.backend.name), escaped(&p.backend.version))),
        ("polarization", escaped(&p.polarization)),
        ("source", escaped(&p.source_mode)),
        ("files", p.sample_files.iter().map(|f| format!("<code>{}</code>", escaped(f))).collect::<Vec<_>>().join(", ")),
        ("SHA-256 of these", format!("<code class=\"hash\">{}</code>", escaped(&p.sample_sha256))),
    ];
    let mut out = String::new();
    for (name, text) in entries {
        let _ = write!(out, "<dt>{name}</dt><dd>{text}</dd>");
    }
    out
}

/// What packing does to the numbers of this page.
pub fn rounding(data: &Data<'_>) -> String {
    let (value, error) = data.rounding();
    format!(
        "Values of facets and scans are rounded here to {} %, their standard errors to {} % (below {LEAST_ERROR:e} of the value \
         they are told as that); the ledger to seven digits. The result itself has all digits.",
        significant(100.0 * value, 2),
        significant(100.0 * error, 2)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_gets_out_of_its_element() {
        let nasty = "</script><b a='1' b=\"2\">&amp;\0\u{202e}";
        let safe = escaped(nasty);
        assert_eq!(safe, "&lt;/script&gt;&lt;b a=&#39;1&#39; b=&quot;2&quot;&gt;&amp;amp;\u{fffd}\u{fffd}");
    }

    #[test]
    fn thousands_are_set_apart() {
        let shown = [0, 999, 1000, 1_234_567].map(|n| thousands(n).replace('\u{202f}', "'"));
        assert_eq!(shown, ["0", "999", "1'000", "1'234'567"]);
    }
}
