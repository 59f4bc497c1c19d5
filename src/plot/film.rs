//! Film stacks: shares over wavelength and over angle, and the colours they give.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::panel::{self, Curve, Panel, evenly};
use super::{Area, Drawn, FONT, WIDTH};
use crate::colour::Srgb;
use crate::films::{Shares, Spectrum, Sweep};

/// Heights of a row of charts and of the colours, pixels.
const ROW: u32 = 360;
const COLOURS: u32 = 130;
/// Colours beside each other.
const MOST_COLOURS: usize = 17;
/// Wavelengths drawn over the angle.
const MOST_WAVELENGTHS: usize = 6;
/// Characters of the title.
const LONGEST_TITLE: usize = 130;
/// Less is not worth a chart.
const NOTHING: f64 = 1e-9;

/// Reflectance, transmittance and absorptance over wavelength and over angle, where there is more than one, with the
/// colours of reflected daylight.
pub fn film(title: &str, sweep: &Sweep) -> String {
    let rows = rows(sweep);
    let mut text = String::new();
    {
        let height = rows.len() as u32 * ROW + COLOURS;
        let root = SVGBackend::with_string(&mut text, (WIDTH, height)).into_drawing_area();
        // Writing to a string cannot fail.
        let _ = draw(&root, title, sweep, &rows).and_then(|()| root.present());
    }
    text
}

/// What a chart shows.
type Share = fn(&Shares) -> f64;

/// Charts that share their axis along x.
struct Row {
    x_name: &'static str,
    x: Vec<f64>,
    lines: Vec<Line>,
}

struct Line {
    name: String,
    shares: Vec<Shares>,
}

fn rows(sweep: &Sweep) -> Vec<Row> {
    let (nm, spectra) = (&sweep.wavelength_nm, &sweep.spectra);
    let over_wavelength = Row {
        x_name: "vacuum wavelength / nm",
        x: nm.clone(),
        lines: spectra.iter().map(|s| Line { name: format!("{}°", s.angle_deg), shares: s.shares.clone() }).collect(),
    };
    let over_angle = Row {
        x_name: "angle of incidence / °",
        x: spectra.iter().map(|s| s.angle_deg).collect(),
        lines: evenly(nm.len(), MOST_WAVELENGTHS)
            .map(|w| Line { name: format!("{} nm", nm[w]), shares: spectra.iter().map(|s| s.shares[w]).collect() })
            .collect(),
    };
    match (nm.len() > 1, spectra.len() > 1) {
        (false, true) => vec![over_angle],
        (true, true) => vec![over_wavelength, over_angle],
        _ => vec![over_wavelength],
    }
}

fn draw(root: &Area<'_>, title: &str, sweep: &Sweep, rows: &[Row]) -> Drawn {
    root.fill(&WHITE)?;
    let (colours, charts) = root.split_vertically(COLOURS);
    draw_colours(&colours, title, sweep)?;
    for (area, row) in charts.split_evenly((rows.len(), 1)).iter().zip(rows) {
        draw_row(area, row)?;
    }
    Ok(())
}

fn draw_row(area: &Area<'_>, row: &Row) -> Drawn {
    let shares: [(&str, Share); 3] =
        [("Reflectance", |s| s.reflected), ("Transmittance", |s| s.transmitted), ("Absorptance", Shares::absorbed)];
    let some = |share: &Share| row.lines.iter().flat_map(|l| &l.shares).any(|s| share(s) > NOTHING);
    let shown: Vec<_> = shares.into_iter().filter(|(name, share)| *name == "Reflectance" || some(share)).collect();
    for (part, (name, share)) in area.split_evenly((1, shown.len())).iter().zip(shown) {
        panel::draw(part, &chart(name, row, share))?;
    }
    Ok(())
}

fn chart(title: &str, row: &Row, share: Share) -> Panel {
    let curve = |line: &Line| Curve::exact(&line.name[..], row.x.clone(), line.shares.iter().map(share));
    Panel {
        title: title.into(),
        x_name: row.x_name.into(),
        curves: row.lines.iter().map(curve).collect(),
        ..Panel::default()
    }
}

/// A rectangle per angle in the colour of what it reflects of daylight.
fn draw_colours(area: &Area<'_>, title: &str, sweep: &Sweep) -> Drawn {
    let text = |at: (i32, i32), text: &str, size: u32, anchor: HPos| {
        area.draw_text(text, &(FONT, size).into_text_style(area).pos(Pos::new(anchor, VPos::Top)), at)
    };
    let title: String = title.chars().take(LONGEST_TITLE).collect();
    text((12, 10), &title, 16, HPos::Left)?;
    let note = format!("{} light; colour of reflected daylight (D65, 2° observer) per angle:", sweep.polarization);
    text((12, 36), &note, 14, HPos::Left)?;
    let shown: Vec<&Spectrum> = evenly(sweep.spectra.len(), MOST_COLOURS).map(|i| &sweep.spectra[i]).collect();
    let width = ((WIDTH as i32 - 24) / shown.len().max(1) as i32).min(120);
    for (i, spectrum) in (0..).zip(&shown) {
        let left = 12 + i * width;
        let corners = [(left, 58), (left + width - 6, 104)];
        match spectrum.colour {
            Some(Srgb([r, g, b])) => area.draw(&Rectangle::new(corners, RGBColor(r, g, b).filled()))?,
            None => text((left + width / 2 - 3, 72), "unknown", 13, HPos::Center)?,
        }
        area.draw(&Rectangle::new(corners, BLACK.mix(0.3)))?;
        text((left + width / 2 - 3, 108), &format!("{}°", spectrum.angle_deg), 13, HPos::Center)?;
    }
    Ok(())
}
