//! Error against time.

use std::collections::BTreeMap;

use plotters::prelude::*;

use super::{Area, Drawn, FONT, WIDTH};
use crate::experiment::accuracy::{BASE, Ladder, Point, TREES};
use crate::units::significant;

const HEIGHT: u32 = 720;
/// Width of the column of names beside the frame.
const NAMES: u32 = 270;
/// What is not seen in the plot: errors below this are as good as none.
const LEAST: f64 = 1e-9;

/// Errors of the settings of a ladder over the time each takes, both in decades, as SVG: a line for each knob, the settings
/// that nothing beats, how errors fall with the number of trees, and what stays however many there are.
pub fn accuracy(ladder: &Ladder, title: &str) -> String {
    let mut text = String::new();
    {
        let root = SVGBackend::with_string(&mut text, (WIDTH, HEIGHT)).into_drawing_area();
        // Writing to a string cannot fail.
        let _ = draw(&root, ladder, title).and_then(|()| root.present());
    }
    text
}

/// Where a point is drawn.
fn at(p: &Point) -> (f64, f64) {
    (p.cost.seconds.max(1e-6), 100.0 * p.error.whole.max(LEAST))
}

/// Least and greatest of some values, with room around them.
fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = values.fold((f64::INFINITY, 0.0f64), |(l, h), x| (l.min(x), h.max(x)));
    if low < high { (low / 1.6, high * 1.6) } else { (0.1 * low.min(1.0), 10.0 * low.clamp(1.0, 1e3)) }
}

fn draw(root: &Area<'_>, ladder: &Ladder, title: &str) -> Drawn {
    root.fill(&WHITE)?;
    let (frame, names) = root.split_horizontally(WIDTH - NAMES);
    let seen = || ladder.points.iter().filter(|p| p.error.whole > LEAST);
    let (left, right) = range(seen().map(|p| at(p).0));
    let (bottom, top) = range(seen().map(|p| at(p).1));
    let mut chart = ChartBuilder::on(&frame)
        .caption(title, (FONT, 18))
        .margin(10)
        .x_label_area_size(44)
        .y_label_area_size(64)
        .build_cartesian_2d((left..right).log_scale(), (bottom..top).log_scale())?;
    chart
        .configure_mesh()
        .x_desc("time of one measurement / s")
        .y_desc("error / %")
        .label_style((FONT, 13))
        .light_line_style(BLACK.mix(0.04))
        .x_label_formatter(&|x| significant(*x, 2))
        .y_label_formatter(&|y| significant(*y, 2))
        .draw()?;
    let grey = RGBColor(120, 120, 120);
    // From the measurement as given: four times the time for half the error.
    if let Some(base) = ladder.points.first().filter(|p| p.error.whole > LEAST) {
        let (x, y) = at(base);
        let guide = [left, right].map(|t| (t, y * (x / t).sqrt()));
        let inside = guide_inside(guide, (bottom, top));
        chart.draw_series(DashedLineSeries::new(inside, 4, 5, grey.stroke_width(1)))?;
    }
    let mut front: Vec<(f64, f64)> = seen().filter(|p| ladder.is_on_front(p)).map(at).collect();
    front.sort_by(|a, b| a.0.total_cmp(&b.0));
    chart.draw_series(LineSeries::new(front, RGBColor(255, 190, 120).stroke_width(7)))?;
    let mut legend = vec![("as errors of chance fall, 1/√time".to_string(), grey.to_rgba(), false)];
    legend.push(("nothing is better and faster".into(), RGBColor(255, 190, 120).to_rgba(), false));
    for (i, (knob, points)) in knobs(ladder).into_iter().enumerate() {
        let color = if knob == TREES { BLACK.to_rgba() } else { color(i).to_rgba() };
        if knob == TREES {
            let mut line: Vec<(f64, f64)> = points.iter().map(|p| at(p)).collect();
            line.extend(ladder.points.first().map(at));
            line.sort_by(|a, b| a.0.total_cmp(&b.0));
            chart.draw_series(LineSeries::new(line, color.stroke_width(2)))?;
        }
        chart.draw_series(points.iter().map(|p| Circle::new(at(p), 4, color.filled())))?;
        legend.push((knob.into(), color, true));
        // Names of what stands out, not of what is as good as the rest.
        for p in points.iter().filter(|p| p.floor > 0.0) {
            let line = [(left, 100.0 * p.floor), (right, 100.0 * p.floor)];
            if (bottom..top).contains(&(100.0 * p.floor)) {
                chart.draw_series(DashedLineSeries::new(line, 2, 4, color.mix(0.6).stroke_width(1)))?;
            }
            let text = format!("{} (floor {} %)", p.setting, significant(100.0 * p.floor, 2));
            let style = (FONT, 12).into_font().color(&color);
            let place = at(p);
            let shift = if place.0 > (left * right).sqrt() { -7 * text.chars().count() as i32 } else { 8 };
            chart.draw_series(std::iter::once(EmptyElement::at(place) + Text::new(text, (shift, -14), style)))?;
        }
    }
    if let Some(base) = ladder.points.first() {
        chart.draw_series(std::iter::once(TriangleMarker::new(at(base), 8, RED.filled())))?;
        legend.push((format!("{BASE} ({})", base.setting), RED.to_rgba(), true));
    }
    for (i, (name, color, is_point)) in legend.into_iter().enumerate() {
        let y = 50 + 22 * i as i32;
        if is_point {
            names.draw(&Circle::new((18, y + 7), 4, color.filled()))?;
        } else {
            names.draw(&PathElement::new([(8, y + 7), (28, y + 7)], color.stroke_width(3)))?;
        }
        names.draw_text(&name, &(FONT, 13).into_text_style(&names), (36, y))?;
    }
    Ok(())
}

/// The part of a line of slope −1/2 between two heights.
fn guide_inside([(x0, y0), (x1, y1)]: [(f64, f64); 2], (bottom, top): (f64, f64)) -> [(f64, f64); 2] {
    let at = |y: f64| (x0 * (y0 / y).powi(2), y);
    [if y0 > top { at(top) } else { (x0, y0) }, if y1 < bottom { at(bottom) } else { (x1, y1) }]
}

/// The points of each knob but those as given.
fn knobs(ladder: &Ladder) -> BTreeMap<&'static str, Vec<&Point>> {
    let mut all: BTreeMap<&'static str, Vec<&Point>> = BTreeMap::new();
    let seen = ladder.points.iter().filter(|p| p.error.whole > LEAST && p.knob != BASE);
    seen.for_each(|p| all.entry(p.knob).or_default().push(p));
    all
}

/// A colour of its own for each of a dozen knobs: hues far apart, by turns dark and bright.
fn color(i: usize) -> HSLColor {
    const GOLDEN: f64 = 0.618_034;
    HSLColor((0.55 + GOLDEN * i as f64).fract(), 0.75, if i.is_multiple_of(2) { 0.35 } else { 0.5 })
}
