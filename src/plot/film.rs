//! Film stacks: shares over wavelength and over angle, and the colours they give.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::{Area, Drawn, FONT, WIDTH, shade};
use crate::colour::Srgb;
use crate::films::{Shares, Spectrum, Sweep};

/// Heights of a row of charts and of the colours, pixels.
const ROW: u32 = 360;
const COLOURS: u32 = 130;
/// Lines in a legend, colours beside each other.
const MOST_NAMED: usize = 6;
const MOST_COLOURS: usize = 17;
/// Wavelengths drawn over the angle.
const MOST_WAVELENGTHS: usize = 6;
/// Values that are too few for a curve: the points are shown.
const FEW: usize = 20;
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
        lines: chosen(nm.len(), MOST_WAVELENGTHS)
            .map(|w| Line { name: format!("{} nm", nm[w]), shares: spectra.iter().map(|s| s.shares[w]).collect() })
            .collect(),
    };
    match (nm.len() > 1, spectra.len() > 1) {
        (false, true) => vec![over_angle],
        (true, true) => vec![over_wavelength, over_angle],
        _ => vec![over_wavelength],
    }
}

/// At most `most` numbers below `count`, evenly from the first to the last.
fn chosen(count: usize, most: usize) -> impl Iterator<Item = usize> {
    let n = count.min(most);
    (0..n).map(move |i| if n < 2 { 0 } else { i * (count - 1) / (n - 1) })
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
        draw_chart(part, name, row, share)?;
    }
    Ok(())
}

fn draw_chart(area: &Area<'_>, title: &str, row: &Row, share: Share) -> Drawn {
    let low = row.x.iter().copied().fold(f64::INFINITY, f64::min);
    let high = row.x.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    // A single value still needs an axis.
    let pad = if low == high { 10.0 } else { 0.0 };
    let top = row.lines.iter().flat_map(|l| &l.shares).map(share).fold(0.0, f64::max);
    let top = if top > NOTHING { 1.08 * top } else { 1.0 };
    let mut chart = ChartBuilder::on(area)
        .caption(title, (FONT, 18))
        .margin(10)
        .margin_right(24)
        .x_label_area_size(40)
        .y_label_area_size(50)
        .build_cartesian_2d(low - pad..high + pad, 0.0..top)?;
    let format = |x: &f64| format!("{x:.0}");
    let mut mesh = chart.configure_mesh();
    mesh.x_desc(row.x_name).x_labels(6).light_line_style(WHITE).label_style((FONT, 13));
    if high - low >= 10.0 { mesh.x_label_formatter(&format) } else { &mut mesh }.draw()?;
    let count = row.lines.len();
    let named: Vec<usize> = chosen(count, MOST_NAMED).collect();
    for (i, line) in row.lines.iter().enumerate() {
        let color = shade(0.85 * i as f64 / (count - 1).max(1) as f64);
        let points = row.x.iter().zip(&line.shares).map(|(&x, s)| (x, share(s)));
        let size = if row.x.len() <= FEW { 3 } else { 0 };
        let series = chart.draw_series(LineSeries::new(points, color.stroke_width(2)).point_size(size))?;
        if named.contains(&i) {
            let mark = move |(x, y)| PathElement::new([(x, y), (x + 18, y)], color.stroke_width(2));
            series.label(&line.name[..]).legend(mark);
        }
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperRight)
        .background_style(WHITE.mix(0.8))
        .border_style(BLACK.mix(0.2))
        .label_font((FONT, 13))
        .draw()
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
    let shown: Vec<&Spectrum> = chosen(sweep.spectra.len(), MOST_COLOURS).map(|i| &sweep.spectra[i]).collect();
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
