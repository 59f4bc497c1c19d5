//! A measured scan beside a simulated one.

use super::Scan;
use crate::dome::Estimate;

/// A point of a measured scan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Signed exit angle, degrees.
    pub angle_deg: f64,
    /// What was measured, 1/sr; its standard error is 0 where it was not told.
    pub value: Estimate,
}

/// How a scan and a measured one differ.
#[derive(Clone, Debug, PartialEq)]
pub struct Overlay {
    /// What was measured.
    pub points: Vec<Point>,
    /// Simulated less measured, with the standard error of the difference, 1/sr.
    pub residuals: Vec<Estimate>,
    /// Sum of the squares of the residuals over their standard errors, of those that have one.
    pub chi2: f64,
    /// How many these are.
    pub counted: usize,
    /// Root of the mean square of the residuals over that of what was measured.
    pub rms: f64,
}

impl Scan {
    /// Compares a scan of one wavelength with points at its exit angles.
    pub fn overlaid(&self, points: Vec<Point>) -> Overlay {
        let reading = |p: &Point| self.readings.iter().find(|r| r.angle_deg == p.angle_deg);
        let residual = |p: &Point| {
            let ours = reading(p).map_or(Estimate { value: f64::NAN, se: f64::NAN }, |r| r.value[0]);
            Estimate { value: ours.value - p.value.value, se: ours.se.hypot(p.value.se) }
        };
        let residuals: Vec<Estimate> = points.iter().map(residual).collect();
        let counted: Vec<f64> = residuals.iter().filter(|e| e.se > 0.0).map(|e| (e.value / e.se).powi(2)).collect();
        let square = |all: &mut dyn Iterator<Item = f64>| all.map(|x| x * x).sum::<f64>();
        let (off, size) =
            (square(&mut residuals.iter().map(|e| e.value)), square(&mut points.iter().map(|p| p.value.value)));
        let rms = if size > 0.0 { (off / size).sqrt() } else { f64::NAN };
        Overlay { points, residuals, chi2: counted.iter().sum(), counted: counted.len(), rms }
    }
}
