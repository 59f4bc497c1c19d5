//! A half of the dome seen from above, in Lambert's equal-area projection: the facets as they were measured.

use glam::DVec3;
use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::{Area, Drawn, FONT, MOST_MAPS, shade};
use crate::bsdf::{FacetValue, Scattering};
use crate::dome::{Estimate, Facet};

/// Decades of the colour scale.
const DECADES: f64 = 4.0;
/// Radius of a map, pixels.
const RADIUS: f64 = 125.0;
/// Width of the column with the scale, pixels.
const SCALE: u32 = 100;

/// Draws the upper or the lower half of the dome for each incidence, on one scale.
pub fn draw_row(area: &Area<'_>, incidences: &[&Scattering], up: bool) -> Drawn {
    let (width, height) = area.dim_in_pixel();
    let (maps, scale) = area.split_horizontally(width - SCALE);
    let seen = |f: &&FacetValue| (f.facet.center().z > 0.0) == up;
    let values = || incidences.iter().flat_map(|s| s.facets.iter().filter(seen).map(mean));
    let top = values().fold(0.0, f64::max);
    for (i, (part, s)) in maps.split_evenly((1, MOST_MAPS)).iter().zip(incidences).enumerate() {
        let center = (i32::try_from((width - SCALE) / 8).unwrap_or(0), (height / 2 + 12) as i32);
        draw_map(part, center, s, up, top)?;
        if i == 0 {
            let what = if up {
                "BRDF, upper half, seen from above. Cross: the source; disc: the specular part"
            } else {
                "BTDF, lower half, seen from above. Disc: the undeflected part"
            };
            label(&maps, what, (12, 10), 14, HPos::Left)?;
        }
    }
    if top > 0.0 { draw_scale(&scale, top, if up { "BRDF" } else { "BTDF" }) } else { Ok(()) }
}

/// Mean over the wavelengths, 1/sr.
fn mean(f: &FacetValue) -> f64 {
    f.value.iter().map(|e| e.value).sum::<f64>() / f.value.len() as f64
}

fn draw_map(area: &Area<'_>, center: (i32, i32), s: &Scattering, up: bool, top: f64) -> Drawn {
    let place = |d: DVec3| {
        let flat = DVec3::new(d.x, d.y, 0.0).normalize_or_zero() * (RADIUS * (1.0 - d.z.abs()).max(0.0).sqrt());
        (center.0 + flat.x.round() as i32, center.1 - flat.y.round() as i32)
    };
    area.draw(&Circle::new(center, RADIUS as i32, RGBColor(235, 235, 235).filled()))?;
    for f in s.facets.iter().filter(|f| (f.facet.center().z > 0.0) == up) {
        let value = mean(f);
        if value > 0.0 {
            let color = shade(1.0 + (value / top).log10() / DECADES);
            area.draw(&Polygon::new(outline(f.facet).map(place).collect::<Vec<_>>(), color.filled()))?;
        }
    }
    area.draw(&Circle::new(center, RADIUS as i32, BLACK.mix(0.6)))?;
    let source = -s.incidence.propagation();
    let straight = if up { source.with_z(source.z) * DVec3::new(-1.0, -1.0, 1.0) } else { -source };
    // The part that goes exactly this way has no place among facets: its disc grows with its share.
    let share = part(if up { &s.ledger.specular } else { &s.ledger.undeflected });
    area.draw(&Circle::new(place(straight), (16.0 * share.sqrt()).round() as i32, RED.mix(0.5).filled()))?;
    area.draw(&Circle::new(place(straight), 4, RED.stroke_width(1)))?;
    if up {
        area.draw(&Cross::new(place(source), 4, RED.stroke_width(1)))?;
    }
    let (total, delta, name) = if up {
        (&s.ledger.reflected, &s.ledger.specular, "specular")
    } else {
        (&s.ledger.transmitted, &s.ledger.undeflected, "undeflected")
    };
    let text = format!("θ {}°: {:.3}, of it {name} {:.3}", s.incidence.theta_deg, part(total), part(delta));
    label(area, &text, (center.0, center.1 + RADIUS as i32 + 8), 14, HPos::Center)
}

/// Mean over the wavelengths.
fn part(all: &[Estimate]) -> f64 {
    all.iter().map(|e| e.value).sum::<f64>() / all.len() as f64
}

/// Points along the edges of a facet; those of coarse ones are visibly bent.
fn outline(facet: Facet) -> impl Iterator<Item = DVec3> {
    let steps = 32 >> facet.level.min(5);
    let [a, b, c] = facet.corners();
    [(a, b), (b, c), (c, a)]
        .into_iter()
        .flat_map(move |(p, q)| (0..steps).map(move |i| p.lerp(q, f64::from(i) / f64::from(steps)).normalize()))
}

fn label(area: &Area<'_>, text: &str, at: (i32, i32), size: u32, anchor: HPos) -> Drawn {
    let style = (FONT, size).into_text_style(area).pos(Pos::new(anchor, VPos::Top));
    area.draw_text(text, &style, at)
}

fn draw_scale(area: &Area<'_>, top: f64, name: &str) -> Drawn {
    const STEPS: i32 = 64;
    let (x, y, height) = (12, 60, 220);
    label(area, name, (x, y - 42), 14, HPos::Left)?;
    label(area, "1/sr", (x, y - 24), 14, HPos::Left)?;
    for i in 0..STEPS {
        let (from, to) = (y + height * i / STEPS, y + height * (i + 1) / STEPS);
        let color = shade(1.0 - f64::from(i) / f64::from(STEPS - 1));
        area.draw(&Rectangle::new([(x, from), (x + 16, to)], color.filled()))?;
    }
    for decade in 0..=DECADES as i32 {
        let at = y + height * decade / DECADES as i32;
        label(area, &format!("{:.1e}", top / 10f64.powi(decade)), (x + 22, at - 7), 13, HPos::Left)?;
    }
    Ok(())
}
