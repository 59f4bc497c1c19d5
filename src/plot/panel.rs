//! Curves with their error bands in one frame.

use plotters::prelude::*;

use super::{Area, Drawn, FONT, shade};
use crate::dome::Estimate;
use crate::units::significant;

/// Curves over one axis.
#[derive(Clone, Debug, Default)]
pub struct Panel {
    /// Above the frame.
    pub title: String,
    /// What x is.
    pub x_name: String,
    /// What y is.
    pub y_name: String,
    /// The curves.
    pub curves: Vec<Curve>,
    /// Lowest and highest y, where not those of the curves.
    pub y_range: Option<(f64, f64)>,
    /// Whether y is drawn in decades, three of them unless there is a range; what is less lies on the axis.
    pub is_log: bool,
}

/// One curve.
#[derive(Clone, Debug, Default)]
pub struct Curve {
    /// In the legend.
    pub name: String,
    /// Abscissae, ascending or descending.
    pub x: Vec<f64>,
    /// Ordinates; a band of two standard errors is drawn around them.
    pub y: Vec<Estimate>,
    /// Its colour, where not that of its rank.
    pub color: Option<(u8, u8, u8)>,
    /// Dashes in place of a line: for what others say.
    pub dashed: bool,
}

/// Curves in the legend.
const MOST_NAMED: usize = 8;
/// Values that are too few for a curve: the points are shown.
const FEW: usize = 20;

impl Curve {
    /// A curve without errors.
    pub fn exact(name: impl Into<String>, x: Vec<f64>, y: impl IntoIterator<Item = f64>) -> Self {
        let y = y.into_iter().map(|value| Estimate { value, se: 0.0 }).collect();
        Self { name: name.into(), x, y, ..Self::default() }
    }

    fn points(&self, errors: f64) -> impl DoubleEndedIterator<Item = (f64, f64)> + Clone + '_ {
        let points = self.x.iter().zip(&self.y).map(move |(&x, e)| (x, e.value + errors * known(e.se)));
        points.filter(|p| p.1.is_finite())
    }
}

/// A standard error, 0 where none is known.
fn known(se: f64) -> f64 {
    if se.is_finite() { se } else { 0.0 }
}

impl Panel {
    fn x_range(&self) -> (f64, f64) {
        let (low, high) = range(self.curves.iter().flat_map(|c| c.x.iter().copied()));
        // A single value still needs an axis.
        if low < high { (low, high) } else { (low - 10.0, high + 10.0) }
    }

    fn y_range(&self) -> (f64, f64) {
        let (_, high) = range(self.curves.iter().flat_map(|c| c.points(2.0)).map(|p| p.1));
        let top = if high > 1e-9 { 1.08 * high } else { 1.0 };
        self.y_range.unwrap_or(if self.is_log { (1e-3 * top, 1.5 * top) } else { (0.0, top) })
    }

    /// The corner in which a legend hides least.
    fn corner(&self, (left, right): (f64, f64), (bottom, top): (f64, f64)) -> SeriesLabelPosition {
        let hidden = |p: &(f64, f64)| p.1 > bottom + 0.6 * (top - bottom);
        let high =
            self.curves.iter().flat_map(|c| c.points(0.0)).map(|p| (p.0, self.height(p.1, bottom))).filter(hidden);
        let (mut on_left, mut on_right) = (0, 0);
        for (x, _) in high {
            let part = (x - left) / (right - left);
            on_left += usize::from(part < 0.45);
            on_right += usize::from(part > 0.55);
        }
        if on_left < on_right { SeriesLabelPosition::UpperLeft } else { SeriesLabelPosition::UpperRight }
    }

    /// Where a value is drawn, not below `bottom`.
    fn height(&self, y: f64, bottom: f64) -> f64 {
        if self.is_log { y.max(f64::MIN_POSITIVE).log10().max(bottom) } else { y }
    }
}

fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
    if low <= high { (low, high) } else { (0.0, 0.0) }
}

/// At most `most` numbers below `count`, evenly from the first to the last.
pub(super) fn evenly(count: usize, most: usize) -> impl Iterator<Item = usize> {
    let n = count.min(most);
    (0..n).map(move |i| if n < 2 { 0 } else { i * (count - 1) / (n - 1) })
}

/// Draws a panel.
pub(super) fn draw(area: &Area<'_>, panel: &Panel) -> Drawn {
    let ((left, right), (low, high)) = (panel.x_range(), panel.y_range());
    let (bottom, top) = if panel.is_log { (low.log10(), high.log10()) } else { (low, high) };
    let drawn = |p: (f64, f64)| (p.0, panel.height(p.1, bottom));
    let mut chart = ChartBuilder::on(area)
        .caption(&panel.title, (FONT, 18))
        .margin(10)
        .margin_right(24)
        .x_label_area_size(40)
        .y_label_area_size(60)
        .build_cartesian_2d(left..right, bottom..top)?;
    let whole = |x: &f64| format!("{x:.0}");
    let mut mesh = chart.configure_mesh();
    mesh.x_desc(&panel.x_name).y_desc(&panel.y_name).x_labels(7).light_line_style(WHITE).label_style((FONT, 13));
    let power = |y: &f64| significant(10f64.powf(*y), 2);
    let mesh = if panel.is_log { mesh.y_label_formatter(&power) } else { &mut mesh };
    if right - left >= 10.0 { mesh.x_label_formatter(&whole) } else { mesh }.draw()?;
    let named: Vec<usize> = evenly(panel.curves.len(), MOST_NAMED).collect();
    for (i, curve) in panel.curves.iter().enumerate() {
        let by_rank = shade(0.85 * i as f64 / (panel.curves.len() - 1).max(1) as f64);
        let color = curve.color.map_or(by_rank, |(r, g, b)| RGBColor(r, g, b));
        if curve.y.iter().any(|e| known(e.se) > 0.0) {
            let band: Vec<(f64, f64)> = curve.points(2.0).chain(curve.points(-2.0).rev()).map(drawn).collect();
            chart.draw_series(std::iter::once(Polygon::new(band, color.mix(0.25).filled())))?;
        }
        let (line, points) = (color.stroke_width(2), curve.points(0.0).map(drawn));
        let size = if curve.x.len() <= FEW { 3 } else { 0 };
        let series = if curve.dashed {
            chart.draw_series(DashedLineSeries::new(points, 6, 5, line))?
        } else {
            chart.draw_series(LineSeries::new(points, line).point_size(size))?
        };
        if named.contains(&i) && !curve.name.is_empty() {
            let to = if curve.dashed { 9 } else { 18 };
            series.label(&curve.name[..]).legend(move |(x, y)| PathElement::new([(x, y), (x + to, y)], line));
        }
    }
    if panel.curves.iter().all(|c| c.name.is_empty()) {
        return Ok(());
    }
    chart
        .configure_series_labels()
        .position(panel.corner((left, right), (bottom, top)))
        .background_style(WHITE.mix(0.8))
        .border_style(BLACK.mix(0.2))
        .label_font((FONT, 13))
        .draw()
}
