//! n and k of a medium over wavelength.

use plotters::prelude::*;

use super::{Area, Drawn, FONT, WIDTH};
use crate::optics::C64;

const HEIGHT: u32 = 440;
const TITLE: u32 = 40;
/// More measured points than this are not told apart.
const MOST_POINTS: usize = 80;
/// k that differs by more than this factor is drawn in decades.
const WIDE: f64 = 100.0;

/// What is drawn.
#[derive(Clone, Copy, Debug)]
pub struct IndexCurve<'a> {
    /// What stands above it.
    pub title: &'a str,
    /// Vacuum wavelengths, nm, ascending.
    pub nm: &'a [f64],
    /// The index at each.
    pub index: &'a [C64],
    /// Measured (λ in µm, n).
    pub measured_n: &'a [(f64, f64)],
    /// Measured (λ in µm, k).
    pub measured_k: &'a [(f64, f64)],
}

/// Its picture, as SVG.
pub fn material(curve: &IndexCurve<'_>) -> String {
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, (WIDTH, HEIGHT)).into_drawing_area();
        // Writing to a string cannot fail.
        let _ = draw(&root, curve).and_then(|()| root.present());
    }
    text
}

fn draw(root: &Area<'_>, curve: &IndexCurve<'_>) -> Drawn {
    root.fill(&WHITE)?;
    let (title, charts) = root.split_vertically(TITLE);
    title.draw_text(curve.title, &(FONT, 18).into_text_style(&title), (12, 12))?;
    let n = Chart::new("refractive index n", curve.nm, curve.index.iter().map(|n| n.re), curve.measured_n);
    let k = Chart::new("extinction coefficient k", curve.nm, curve.index.iter().map(|n| n.im), curve.measured_k);
    if k.line.iter().all(|(_, k)| *k == 0.0) {
        return n.draw(&charts);
    }
    let (left, right) = charts.split_horizontally(WIDTH / 2);
    n.draw(&left)?;
    k.in_decades_if_wide().draw(&right)
}

/// A curve and measured points over the wavelength in nm.
struct Chart {
    name: &'static str,
    line: Vec<(f64, f64)>,
    points: Vec<(f64, f64)>,
    is_log: bool,
}

impl Chart {
    fn new(name: &'static str, nm: &[f64], values: impl Iterator<Item = f64>, measured: &[(f64, f64)]) -> Self {
        let (first, last) = (nm.first().copied().unwrap_or(0.0), nm.last().copied().unwrap_or(0.0));
        let points = measured.iter().map(|(um, y)| (um * 1e3, *y));
        let points: Vec<_> = points.filter(|(nm, _)| (first..=last).contains(nm)).collect();
        let points = if points.len() > MOST_POINTS { Vec::new() } else { points };
        Self { name, line: nm.iter().copied().zip(values).collect(), points, is_log: false }
    }

    /// The logarithm of its values, where they are of different size.
    fn in_decades_if_wide(self) -> Self {
        let positive = self.line.iter().map(|(_, y)| *y).filter(|y| *y > 0.0);
        let (low, high) = positive.fold((f64::INFINITY, 0.0_f64), |(low, high), y| (low.min(y), high.max(y)));
        if high <= WIDE * low {
            return self;
        }
        // What is 0 has no place among decades.
        let log = |all: Vec<(f64, f64)>| all.into_iter().filter(|p| p.1 > 0.0).map(|(x, y)| (x, y.log10())).collect();
        Self { line: log(self.line), points: log(self.points), is_log: true, ..self }
    }

    fn draw(&self, area: &Area<'_>) -> Drawn {
        let (x, y) = (ends(self.line.iter().map(|p| p.0)), ends(self.line.iter().map(|p| p.1)));
        // A single value still needs an axis.
        let x = if x.0 < x.1 { x } else { (x.0 - 10.0, x.1 + 10.0) };
        let pad = if y.0 < y.1 { 0.06 * (y.1 - y.0) } else { 0.05 };
        let mut chart = ChartBuilder::on(area)
            .margin(10)
            .margin_right(24)
            .x_label_area_size(44)
            .y_label_area_size(70)
            .build_cartesian_2d(x.0..x.1, y.0 - pad..y.1 + pad)?;
        let decimals = (1.0 - (y.1 - y.0 + 2.0 * pad).log10().floor()).clamp(1.0, 6.0) as usize;
        let y_label = |y: &f64| match self.is_log {
            true if y.fract() == 0.0 => format!("1e{y}"),
            true => format!("{:.1e}", 10_f64.powf(*y)),
            false => format!("{y:.decimals$}"),
        };
        let x_label = |x: &f64| if x.fract() == 0.0 { format!("{x:.0}") } else { format!("{x:.1}") };
        chart
            .configure_mesh()
            .x_desc("vacuum wavelength / nm")
            .y_desc(self.name)
            .x_labels(8)
            .y_labels(8)
            .x_label_formatter(&x_label)
            .y_label_formatter(&y_label)
            .light_line_style(WHITE)
            .label_style((FONT, 13))
            .axis_desc_style((FONT, 15))
            .draw()?;
        chart.draw_series(LineSeries::new(self.line.iter().copied(), BLUE.stroke_width(2)))?;
        chart.draw_series(self.points.iter().map(|&at| Circle::new(at, 3, BLUE.filled())))?;
        Ok(())
    }
}

/// The least and the greatest.
fn ends(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
}
