//! Pictures of results, as SVG.

mod accuracy;
mod colours;
mod film;
mod hemisphere;
mod material;
mod panel;
mod png;
mod scan;
mod spectra;
mod sweep;

pub use accuracy::accuracy;
pub use colours::colours;
pub use film::film;
pub use material::{IndexCurve, material};
pub use panel::{Curve, Panel};
pub use png::png;
pub use scan::{overlaid, scans};
pub use sweep::sweep;

use plotters::coord::Shift;
use plotters::prelude::*;

use crate::bsdf::Scattering;
use crate::output::Measured;

type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Drawn = Result<(), DrawingAreaErrorKind<std::io::Error>>;

const FONT: &str = "sans-serif";
const WIDTH: u32 = 1200;
/// Heights of the spectra and of a row of hemispheres.
const SPECTRA: u32 = 400;
const ROW: u32 = 340;
/// Height of a title.
const TITLE: u32 = 36;
/// Hemispheres beside each other.
const MOST_MAPS: usize = 4;

/// The lobes of some incidences, and reflectance and transmittance over wavelength of all of them.
pub fn measurement(measured: &Measured) -> String {
    let incidences = &measured.bsdf.incidences;
    let transmits = incidences.iter().any(|s| s.ledger.transmitted.iter().any(|e| e.value > 0.0));
    let rows = if transmits { 2 } else { 1 };
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, (WIDTH, SPECTRA + rows * ROW)).into_drawing_area();
        // Writing to a string cannot fail; a plot without data is an empty one.
        let _ = draw(&root, measured, transmits).and_then(|()| root.present());
    }
    text
}

fn draw(root: &Area<'_>, measured: &Measured, transmits: bool) -> Drawn {
    root.fill(&WHITE)?;
    let (top, below) = root.split_vertically(SPECTRA);
    let bsdf = &measured.bsdf;
    let reflected = |s: &Scattering| s.ledger.reflected.clone();
    let transmitted = |s: &Scattering| s.ledger.transmitted.clone();
    if transmits {
        let (left, right) = top.split_horizontally(WIDTH / 2);
        spectra::draw(&left, "Reflectance", bsdf, reflected)?;
        spectra::draw(&right, "Transmittance", bsdf, transmitted)?;
        let (up, down) = below.split_vertically(ROW);
        hemisphere::draw_row(&up, &chosen(&bsdf.incidences), true)?;
        hemisphere::draw_row(&down, &chosen(&bsdf.incidences), false)
    } else {
        spectra::draw(&top, "Reflectance", bsdf, reflected)?;
        hemisphere::draw_row(&below, &chosen(&bsdf.incidences), true)
    }
}

/// Some incidences, evenly from the first to the last.
fn chosen(all: &[Scattering]) -> Vec<&Scattering> {
    panel::evenly(all.len(), MOST_MAPS).map(|i| &all[i]).collect()
}

/// Panels beside each other, at most two in a row, as SVG; no title if it is empty.
pub fn panels(title: &str, panels: &[Panel]) -> String {
    let columns = panels.len().clamp(1, 2);
    let rows = panels.len().div_ceil(columns);
    let head = if title.is_empty() { 0 } else { TITLE };
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, (WIDTH, head + rows as u32 * SPECTRA)).into_drawing_area();
        // Writing to a string cannot fail.
        let _ = draw_panels(&root, title, head, panels, (rows, columns)).and_then(|()| root.present());
    }
    text
}

fn draw_panels(root: &Area<'_>, title: &str, head: u32, panels: &[Panel], grid: (usize, usize)) -> Drawn {
    root.fill(&WHITE)?;
    let (top, charts) = root.split_vertically(head);
    if head > 0 {
        top.draw_text(title, &(FONT, 20).into_text_style(&top), (16, 10))?;
    }
    charts.split_evenly(grid).iter().zip(panels).try_for_each(|(area, panel)| panel::draw(area, panel))
}

/// A colour for a part (0 to 1) of a scale.
fn shade(part: f64) -> RGBColor {
    ViridisRGB.get_color(part.clamp(0.0, 1.0))
}
