//! A result as one page of HTML that needs nothing else: no network, no other file.
//!
//! The page is a template with its style and scripts in `assets/report`, the texts that do not change made here, and a
//! payload (`data`) from which the scripts draw what the sliders choose.

mod data;
mod pack;
mod text;

use super::measured::Measured;
use data::Data;

const PAGE: &str = include_str!("../../../assets/report/page.html");
const STYLE: [&str; 2] =
    [include_str!("../../../assets/report/vendor/uPlot.min.css"), include_str!("../../../assets/report/style.css")];
const LIBRARY: &str = include_str!("../../../assets/report/vendor/uPlot.min.js");
const LIBRARY_VERSION: &str = include_str!("../../../assets/report/vendor/uPlot.version");
const LIBRARY_LICENCE: &str = include_str!("../../../assets/report/vendor/uPlot.LICENSE");
/// Scripts, each of which uses those before it.
const SCRIPTS: [&str; 11] = [
    include_str!("../../../assets/report/payload.js"),
    include_str!("../../../assets/report/dome.js"),
    include_str!("../../../assets/report/colour.js"),
    include_str!("../../../assets/report/canvas.js"),
    include_str!("../../../assets/report/arrows.js"),
    include_str!("../../../assets/report/lobe.js"),
    include_str!("../../../assets/report/map.js"),
    include_str!("../../../assets/report/plots.js"),
    include_str!("../../../assets/report/swatches.js"),
    include_str!("../../../assets/report/tables.js"),
    include_str!("../../../assets/report/app.js"),
];

/// The page. The same result gives the same bytes.
pub fn html(measured: &Measured) -> String {
    let data = Data::new(&measured.bsdf);
    let parts = [
        ("title", crate::text::escaped(&text::title(&measured.provenance))),
        ("style", STYLE.concat()),
        ("summary", text::summary(measured)),
        ("doubts", text::doubts(measured)),
        ("colour-note", text::colour_note(data.colour())),
        ("effects", text::effects(&measured.provenance.effects)),
        ("stacks", text::stacks(&measured.provenance.stacks)),
        ("provenance", text::provenance(&measured.provenance)),
        ("rounding", text::rounding(&data)),
        ("library", library()),
        ("data", data.json()),
        ("scripts", SCRIPTS.map(|s| format!("<script>\n{s}</script>\n")).concat()),
    ];
    fill(PAGE, &parts)
}

fn library() -> String {
    let (version, licence) = (LIBRARY_VERSION.trim(), LIBRARY_LICENCE.trim());
    format!("<script>\n/* uPlot {version}\n\n{licence} */\n{LIBRARY}</script>")
}

/// Puts each part in the place that `{{name}}` marks. What is put in is not searched for marks.
fn fill(template: &str, parts: &[(&str, String)]) -> String {
    let mut pieces = template.split("{{");
    let mut page = pieces.next().unwrap_or_default().to_owned();
    for piece in pieces {
        let (name, rest) = piece.split_once("}}").unwrap_or((piece, ""));
        let part = parts.iter().find(|(known, _)| *known == name);
        page += &part.unwrap_or_else(|| panic!("page.html asks for {name}")).1;
        page += rest;
    }
    page
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_put_in_stays_as_it_is() {
        let parts = [("a", "{{b}}".to_owned()), ("b", "<x>".to_owned())];
        assert_eq!(fill("1{{a}}2{{b}}3{{a}}", &parts), "1{{b}}2<x>3{{b}}");
    }

    #[test]
    fn the_library_is_the_one_asked_for() {
        let wanted = include_str!("../../../assets/report/package.json");
        assert!(wanted.contains(&format!("\"uplot\": \"{}\"", LIBRARY_VERSION.trim())), "run assets/report/vendor.sh");
    }
}
