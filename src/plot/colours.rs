//! Colours of what a sample reflects of daylight, against the exit angle.

use plotters::prelude::*;
use plotters::style::text_anchor::{HPos, Pos, VPos};

use super::{Area, Drawn, FONT, WIDTH};
use crate::bsdf::{Bsdf, Scan};
use crate::colour::{self, Illuminant};

const ROW: i32 = 44;
const HEAD: i32 = 70;
const LEFT: i32 = 170;
const RIGHT: i32 = 30;

/// A strip per incidence: the colours of its scan, the brightest one as bright as the screen can show it; before it the colour
/// of all reflected light.
pub fn colours(bsdf: &Bsdf, scans: &[Scan]) -> String {
    let mut text = String::new();
    {
        let height = HEAD + ROW * scans.len() as i32 + 60;
        let root = SVGBackend::with_string(&mut text, (WIDTH, height as u32)).into_drawing_area();
        // Writing to a string cannot fail.
        let _ = draw(&root, bsdf, scans).and_then(|()| root.present());
    }
    text
}

fn draw(area: &Area<'_>, bsdf: &Bsdf, scans: &[Scan]) -> Drawn {
    area.fill(&WHITE)?;
    let text = |at: (i32, i32), text: &str, size: u32, anchor: HPos| {
        area.draw_text(text, &(FONT, size).into_text_style(area).pos(Pos::new(anchor, VPos::Top)), at)
    };
    text((16, 12), "Colour of reflected daylight (D65, 2° observer) in the plane of incidence", 18, HPos::Left)?;
    let Some(weights) = colour::weights(Illuminant::D65, &bsdf.wavelength_nm) else {
        return text((16, 44), "The wavelengths of this result do not tell a colour.", 15, HPos::Left);
    };
    text((16, 40), "first all reflected light, then the exits; each strip is scaled to its brightest", 14, HPos::Left)?;
    let fill = |corners: [(i32, i32); 2], xyz: [f64; 3]| {
        let [r, g, b] = colour::srgb(xyz).0;
        area.draw(&Rectangle::new(corners, RGBColor(r, g, b).filled()))
    };
    for (row, (scan, scattering)) in (0..).zip(scans.iter().zip(&bsdf.incidences)) {
        let top = HEAD + row * ROW;
        let at = scan.incidence;
        text((16, top + 10), &format!("θ {}°, φ {}°", at.theta_deg, at.phi_deg), 14, HPos::Left)?;
        let all = colour::summed(&weights, scattering.ledger.reflected.iter().map(|e| e.value));
        fill([(LEFT - 50, top), (LEFT - 14, top + ROW - 8)], all)?;
        let xyz: Vec<[f64; 3]> =
            scan.readings.iter().map(|r| colour::summed(&weights, r.value.iter().map(|e| e.value))).collect();
        let brightest = xyz.iter().map(|c| c[1]).fold(f64::MIN_POSITIVE, f64::max);
        let width = f64::from(WIDTH as i32 - LEFT - RIGHT) / xyz.len() as f64;
        let x = |i: usize| LEFT + (i as f64 * width).round() as i32;
        for (i, c) in xyz.iter().enumerate() {
            fill([(x(i), top), (x(i + 1), top + ROW - 8)], c.map(|v| v / brightest))?;
        }
    }
    let bottom = HEAD + ROW * scans.len() as i32;
    let span = f64::from(WIDTH as i32 - LEFT - RIGHT);
    for deg in (-90..=90).step_by(30) {
        text((LEFT + (span * f64::from(deg + 90) / 180.0) as i32, bottom), &format!("{deg}°"), 13, HPos::Center)?;
    }
    text((LEFT + span as i32 / 2, bottom + 24), "exit angle (negative: the side of the source)", 14, HPos::Center)
}
