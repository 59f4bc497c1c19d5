//! What varies with what is varied.

use std::collections::BTreeMap;

use super::panel::{Curve, Panel};
use super::panels;
use crate::dome::Estimate;
use crate::output::sweep::{Row, Sweep};

/// Reflectance and transmittance of all measurements over what is varied (of several numbers that with the most values), mean
/// of all wavelengths, and their spectra; as SVG.
pub fn sweep(title: &str, sweep: &Sweep) -> String {
    let mut all = Vec::new();
    for (share, name) in [(0, "Reflectance"), (1, "Transmittance")] {
        if sweep.rows.iter().any(|r| r.shares[share].value > 0.0) {
            all.push(over_key(sweep, share, name));
            all.extend(spectra(sweep, share, name));
        }
    }
    panels(title, &all)
}

/// Which key is drawn along x, and its value in each row; without one the number of the measurement.
fn abscissa(sweep: &Sweep) -> (Option<usize>, String, Vec<f64>) {
    let distinct = |x: &[f64]| {
        let mut sorted = x.to_vec();
        sorted.sort_by(f64::total_cmp);
        sorted.dedup();
        sorted.len()
    };
    let numbers = (0..sweep.keys.len()).filter_map(|key| Some((key, sweep.numbers(key)?)));
    // Of equally many values the first counts.
    let best = numbers.filter(|(_, x)| distinct(x) > 1).max_by_key(|(key, x)| (distinct(x), usize::MAX - key));
    if let Some((key, x)) = best {
        return (Some(key), sweep.keys[key].clone(), x);
    }
    let mut number = 0.0;
    let mut last = None;
    let numbered = sweep.rows.iter().map(|row| {
        if last != Some(&row.name) {
            (number, last) = (number + 1.0, Some(&row.name));
        }
        number
    });
    (None, "number of the measurement".into(), numbered.collect())
}

fn over_key(sweep: &Sweep, share: usize, name: &str) -> Panel {
    let (key, x_name, x) = abscissa(sweep);
    // Rows of one curve, and of those the ones of one measurement and incidence.
    let mut curves: BTreeMap<String, Vec<(f64, Estimate, f64)>> = BTreeMap::new();
    for (row, x) in sweep.rows.iter().zip(x) {
        let points = curves.entry(label(sweep, row, key)).or_default();
        let e = row.shares[share];
        match points.iter_mut().find(|p| p.0 == x) {
            // Errors of wavelengths that share their rays do not average out.
            Some((_, mean, n)) => {
                let add = |mean: &mut f64, x: f64| *mean += (x - *mean) / (*n + 1.0);
                add(&mut mean.value, e.value);
                add(&mut mean.se, e.se);
                *n += 1.0;
            }
            None => points.push((x, e, 1.0)),
        }
    }
    let curve = |(name, mut points): (String, Vec<(f64, Estimate, f64)>)| {
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        Curve {
            name,
            x: points.iter().map(|p| p.0).collect(),
            y: points.iter().map(|p| p.1).collect(),
            ..Curve::default()
        }
    };
    Panel {
        title: format!("{name}, mean of all wavelengths"),
        x_name,
        y_name: "share of the incident light".into(),
        curves: curves.into_iter().map(curve).collect(),
        ..Panel::default()
    }
}

/// What tells a curve from the others: all that is varied but what is drawn along x, and the incidence.
fn label(sweep: &Sweep, row: &Row, without: Option<usize>) -> String {
    let mut parts: Vec<String> = Vec::new();
    for (i, key) in sweep.keys.iter().enumerate().filter(|(i, _)| without.is_some_and(|w| w != *i)) {
        let last = key.rsplit('.').next().unwrap_or_default();
        parts.extend(sweep.value(row, i).map(|value| format!("{last} {value}")));
    }
    let other = |r: &Row| r.name == row.name && (r.theta_deg, r.phi_deg) != (row.theta_deg, row.phi_deg);
    if sweep.rows.iter().any(other) {
        parts.push(format!("{}°, {}°", row.theta_deg, row.phi_deg));
    }
    parts.join(", ")
}

/// Spectra of all measurements at their first incidence, if there is more than one wavelength.
fn spectra(sweep: &Sweep, share: usize, name: &str) -> Option<Panel> {
    let mut curves: Vec<Curve> = Vec::new();
    for measurement in sweep.rows.chunk_by(|a, b| a.name == b.name) {
        let first = (measurement[0].theta_deg, measurement[0].phi_deg);
        let rows = || measurement.iter().filter(|r| (r.theta_deg, r.phi_deg) == first);
        curves.push(Curve {
            name: measurement[0].name.clone(),
            x: rows().map(|r| r.wavelength_nm).collect(),
            y: rows().map(|r| r.shares[share]).collect(),
            ..Curve::default()
        });
    }
    curves.iter().any(|c| c.x.len() > 1).then(|| Panel {
        title: format!("{name} at the first incidence of each"),
        x_name: "wavelength / nm".into(),
        y_name: "share of the incident light".into(),
        curves,
        ..Panel::default()
    })
}
