//! Measured scans as people store them: `angle,value` or `angle,value,se`, in degrees and 1/sr.

use std::path::Path;

use crate::bsdf::{Overlay, Point};
use crate::dome::Estimate;
use crate::text;

/// Largest file taken.
const MOST_BYTES: u64 = 1 << 24;

/// Reads a measured scan. Lines that begin with `#` and a first line of names are passed over.
///
/// # Errors
/// The line and what is wrong with it.
pub fn read(path: &Path) -> Result<Vec<Point>, String> {
    let text = text::read(path, MOST_BYTES).map_err(|e| format!("{}: {e}", path.display()))?;
    let mut points: Vec<Point> = Vec::new();
    for (i, line) in text.lines().enumerate() {
        let line = line.trim();
        let is_name = points.is_empty() && line.starts_with(|c: char| c.is_alphabetic());
        if line.is_empty() || line.starts_with('#') || is_name {
            continue;
        }
        let point = point(line).map_err(|e| format!("{}:{}: {e}", path.display(), i + 1))?;
        if points.iter().any(|p| p.angle_deg == point.angle_deg) {
            return Err(format!("{}:{}: there is a second value at {}°", path.display(), i + 1, point.angle_deg));
        }
        points.push(point);
    }
    if points.is_empty() {
        return Err(format!("{}: has no values; expected lines of angle,value or angle,value,se", path.display()));
    }
    points.sort_by(|a, b| a.angle_deg.total_cmp(&b.angle_deg));
    Ok(points)
}

fn point(line: &str) -> Result<Point, String> {
    let fields: Vec<&str> = line.split([',', ';', '\t']).map(str::trim).collect();
    let number = |s: &str| s.parse().ok().filter(|x: &f64| x.is_finite()).ok_or_else(|| format!("`{s}` is no number"));
    let (angle_deg, value, se) = match fields[..] {
        [angle, value] => (number(angle)?, number(value)?, 0.0),
        [angle, value, se] => (number(angle)?, number(value)?, number(se)?),
        _ => return Err(format!("`{line}`: expected angle,value or angle,value,se (degrees, 1/sr)")),
    };
    if !(-90.0..=90.0).contains(&angle_deg) {
        return Err(format!(
            "exit angle {angle_deg}°: expected −90 to 90, positive on the side of the mirror direction"
        ));
    }
    if se < 0.0 {
        return Err(format!("standard error {se}: expected 0 or more"));
    }
    Ok(Point { angle_deg, value: Estimate { value, se } })
}

/// How simulation and measurement differ, in a line.
pub fn verdict(overlay: &Overlay) -> String {
    let rms = format!("residuals: {:.1} % rms of {} points", 100.0 * overlay.rms, overlay.points.len());
    match overlay.counted {
        0 => rms + "; no standard errors, so no χ²",
        n => format!("{rms}; χ² {:.1} of {n} points ({:.2} per point)", overlay.chi2, overlay.chi2 / n as f64),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_points_or_told_apart() {
        assert_eq!(point("10, 0.5").unwrap(), Point { angle_deg: 10.0, value: Estimate { value: 0.5, se: 0.0 } });
        assert_eq!(point("-10;0.5;0.01").unwrap().value.se, 0.01);
        for (line, why) in [
            ("10", "expected angle,value"),
            ("a,1", "`a` is no number"),
            ("95,1", "95°"),
            ("5,1,-1", "standard error -1"),
            ("5,nan", "`nan` is no number"),
        ] {
            assert!(point(line).unwrap_err().contains(why), "{line}: {}", point(line).unwrap_err());
        }
    }
}
