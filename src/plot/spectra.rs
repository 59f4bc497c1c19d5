//! Shares of the light over wavelength, one line per incidence.

use plotters::prelude::*;

use super::{Area, Drawn, FONT, shade};
use crate::bsdf::{Bsdf, Scattering};
use crate::dome::Estimate;

/// Lines in the legend.
const MOST_NAMED: usize = 6;

/// Draws the `share` of each incidence with a band of two standard errors.
pub fn draw(area: &Area<'_>, title: &str, bsdf: &Bsdf, share: impl Fn(&Scattering) -> Vec<Estimate>) -> Drawn {
    let nm = &bsdf.wavelength_nm;
    let lines: Vec<Vec<Estimate>> = bsdf.incidences.iter().map(share).collect();
    let top = lines.iter().flatten().map(|e| e.value + 2.0 * known(e.se)).fold(0.0, f64::max);
    let top = if top > 0.0 { 1.08 * top } else { 1.0 };
    // A single wavelength still needs an axis.
    let (first, last) = (nm[0], nm[nm.len() - 1]);
    let pad = if first == last { 10.0 } else { 0.0 };
    let mut chart = ChartBuilder::on(area)
        .caption(title, (FONT, 20))
        .margin(12)
        .margin_right(30)
        .x_label_area_size(40)
        .y_label_area_size(60)
        .build_cartesian_2d(first - pad..last + pad, 0.0..top)?;
    chart
        .configure_mesh()
        .x_desc("vacuum wavelength / nm")
        .y_desc("share of the incident power")
        .x_label_formatter(&|nm| format!("{nm:.0}"))
        .light_line_style(WHITE)
        .label_style((FONT, 14))
        .draw()?;
    let count = lines.len();
    let every = (count - 1).div_ceil(MOST_NAMED - 1).max(1);
    let named = |i: usize| i.is_multiple_of(every) || i == count - 1;
    for (i, line) in lines.iter().enumerate() {
        let color = shade(0.85 * i as f64 / (count - 1).max(1) as f64);
        let edge = |sign: f64| nm.iter().zip(line).map(move |(&x, e)| (x, e.value + sign * 2.0 * known(e.se)));
        let band: Vec<(f64, f64)> = edge(1.0).chain(edge(-1.0).rev()).collect();
        chart.draw_series(std::iter::once(Polygon::new(band, color.mix(0.25).filled())))?;
        let points = nm.iter().zip(line).map(|(&x, e)| (x, e.value));
        let series = chart.draw_series(LineSeries::new(points.clone(), color.stroke_width(2)).point_size(2))?;
        if named(i) {
            let at = bsdf.incidences[i].incidence;
            let azimuth = if at.phi_deg == 0.0 { String::new() } else { format!(", φ {}°", at.phi_deg) };
            series
                .label(format!("θ {}°{azimuth}", at.theta_deg))
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], color.stroke_width(2)));
        }
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperRight)
        .background_style(WHITE.mix(0.8))
        .border_style(BLACK.mix(0.2))
        .label_font((FONT, 14))
        .draw()
}

/// A standard error, 0 where none is known.
fn known(se: f64) -> f64 {
    if se.is_finite() { se } else { 0.0 }
}
