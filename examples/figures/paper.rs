//! Figures 10 and 11: webs of fibres, bare and coated, under a laser at 75°.

use gonio_embree::bsdf::{Arm, Scan};
use gonio_embree::dome::Estimate;
use gonio_embree::experiment::Settings;
use gonio_embree::light::{Polarization, SourceMode};
use gonio_embree::plot::{self, Curve, Panel};
use gonio_embree::sample::Description;

use super::figure::{Claim, Effort, Figure, Result, Table, light, measure_description, steps};

/// The instrument of section 5.1: a laser of 670 nm, s-polarized; machine direction and across.
const NM: f64 = 670.0;
const DIRECTIONS: [(&str, f64); 2] = [("along the machine direction", 0.0), ("across", 90.0)];
const APERTURE: f64 = 4.0;

/// Readings of several seeds of a random sample: means over them, with the standard error that tells how much such samples
/// differ.
struct Series {
    angles: Vec<f64>,
    /// Per seed.
    rows: Vec<Vec<f64>>,
}

impl Series {
    fn estimates(&self) -> Vec<Estimate> {
        (0..self.angles.len()).map(|i| mean(&self.rows.iter().map(|r| r[i]).collect::<Vec<f64>>())).collect()
    }

    /// Mean over the angles from `low` to `high`, per seed.
    fn over(&self, low: f64, high: f64) -> Vec<f64> {
        let inside: Vec<usize> = (0..self.angles.len()).filter(|&i| (low..=high).contains(&self.angles[i])).collect();
        self.rows.iter().map(|r| inside.iter().map(|&i| r[i]).sum::<f64>() / inside.len() as f64).collect()
    }

    fn curve(&self, name: &str) -> Curve {
        Curve { name: name.into(), x: self.angles.clone(), y: self.estimates(), ..Curve::default() }
    }
}

fn mean(values: &[f64]) -> Estimate {
    let n = values.len() as f64;
    let value = values.iter().sum::<f64>() / n;
    let variance = values.iter().map(|v| (v - value).powi(2)).sum::<f64>() / (n - 1.0) / n;
    Estimate { value, se: variance.sqrt() }
}

/// The mean of differences of the same seeds.
fn difference(a: &[f64], b: &[f64]) -> Estimate {
    mean(&a.iter().zip(b).map(|(a, b)| a - b).collect::<Vec<f64>>())
}

fn z(e: Estimate) -> f64 {
    e.value / e.se
}

/// Scans of a sample of `assets/samples` along both directions, per seed.
fn scans(file: &str, theta: f64, seeds: u64, trees: u64) -> Result<[Series; 2]> {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/samples").join(file);
    let text = std::fs::read_to_string(path)?;
    let light = light(&[NM], &DIRECTIONS.map(|(_, phi)| (theta, phi)), Polarization::S, SourceMode::Band)?;
    let arm = Arm { angles_deg: steps(-90.0, 80.0, 2.0), aperture_deg: APERTURE, below: false, turn_deg: 0.0 };
    let mut series = [(); 2].map(|()| Series { angles: arm.angles_deg.clone(), rows: Vec::new() });
    for seed in 1..=seeds {
        let (description, _) = Description::from_text(&text.replace("seed = 1\n", &format!("seed = {seed}\n")))?;
        let settings = Settings { trees, seed, arm: Some(arm.clone()), ..Settings::default() };
        let outcome = measure_description(&description, &light, &settings)?;
        let row = |scan: &Scan| scan.readings.iter().map(|r| r.value[0].value).collect();
        series.iter_mut().zip(&outcome.scans).for_each(|(s, scan)| s.rows.push(row(scan)));
    }
    Ok(series)
}

fn note(csv: &mut Table, sample: &str, series: &[Series; 2]) {
    for (s, (direction, _)) in series.iter().zip(DIRECTIONS) {
        for (angle, e) in s.angles.iter().zip(s.estimates()) {
            csv.row(&[&sample, &direction, angle, &e.value, &e.se]);
        }
    }
}

fn panel(title: &str, curves: Vec<Curve>) -> Panel {
    Panel {
        title: title.into(),
        x_name: "exit angle / ° (negative: the side of the source)".into(),
        y_name: "BRDF / (1/sr)".into(),
        curves,
        is_log: true,
        ..Panel::default()
    }
}

/// Where the peak on the mirror side is looked for, degrees.
const MIRROR: (f64, f64) = (74.0, 76.0);

pub fn webs(effort: Effort) -> Result<Figure> {
    let (seeds, trees) = effort.pick((4, 5000), (20, 20_000));
    let mut csv = Table::new(&["web", "light", "angle_deg", "BRDF", "SE"]);
    let (mut panels, mut finds, mut signs) = (Vec::new(), Vec::new(), Vec::new());
    for (name, file) in [("fully oriented", "web-oriented.toml"), ("15°", "web-15.toml"), ("random", "web-random.toml")]
    {
        let series = scans(file, 75.0, seeds, trees)?;
        note(&mut csv, name, &series);
        let [along, across] = [0, 1].map(|i| series[i].over(MIRROR.0, MIRROR.1));
        let (a, b, d) = (mean(&along), mean(&across), difference(&along, &across));
        signs.push((d.value, z(d)));
        finds.push(format!(
            "{name}: BRDF from {}° to {}° along the machine direction {:.3} ± {:.3}, across {:.3} ± {:.3}; the difference is {:.1} standard \
             errors, over {seeds} webs.",
            MIRROR.0, MIRROR.1, a.value, a.se, b.value, b.se, z(d)
        ));
        let curves = series.iter().zip(DIRECTIONS).map(|(s, (direction, _))| s.curve(direction)).collect();
        panels.push(panel(&format!("{name} web"), curves));
    }
    let [oriented, slanted, random] = [signs[0], signs[1], signs[2]];
    let claims = vec![
        Claim::new(
            "the oriented web's peak is larger along the machine direction than across, by more than 5 standard errors",
            oriented.1 > 5.0,
        ),
        Claim::new(
            "that of the 15° web is in between",
            slanted.0 < oriented.0 && slanted.0 > random.0 && slanted.1 > 2.0,
        ),
        Claim::new("the random web's does not differ by more than 2 standard errors", random.1.abs() < 2.0),
    ];
    Ok(Figure {
        title: "webs of fibres: fully oriented, 15°, random".into(),
        made_of: format!(
            "`web-oriented.toml`, `web-15.toml`, `web-random.toml`, 75°, 670 nm, s-polarized; {seeds} webs each, {trees} ray trees \
             on each; aperture {APERTURE}°."
        ),
        says: "The specular peak is smaller across than along the machine direction; at 15° the anisotropy is still significant; it \
               disappears for a fully random web."
            .into(),
        finds,
        claims,
        verdict: "Yes, at 75°. Across an oriented web there is no peak: the light grows towards the horizon, and at grazing exits there is more of it than at 75°."
            .into(),
        svg: plot::panels("Simulated sheets under light from 75°", &panels),
        csv,
    })
}

/// Where light goes back to the source, and what it is compared with on either side, degrees.
const BACK: (f64, f64) = (-76.0, -74.0);
const BESIDE: [(f64, f64); 2] = [(-86.0, -84.0), (-66.0, -64.0)];

/// By how much the light that goes back exceeds that on both sides of it.
fn rise(series: &Series) -> Estimate {
    let [lower, upper] = BESIDE.map(|(low, high)| series.over(low, high));
    let beside: Vec<f64> = lower.iter().zip(&upper).map(|(a, b)| 0.5 * (a + b)).collect();
    difference(&series.over(BACK.0, BACK.1), &beside)
}

pub fn coating(effort: Effort) -> Result<Figure> {
    let (seeds, trees) = effort.pick((5, 20_000), (20, 30_000));
    let mut csv = Table::new(&["sheet", "light", "angle_deg", "BRDF", "SE"]);
    let (mut curves, mut finds, mut claims) = ([Vec::new(), Vec::new()], Vec::new(), Vec::new());
    for (name, file) in [("coated", "web-coated.toml"), ("bare", "web-oriented.toml")] {
        let all = scans(file, 75.0, seeds, trees)?;
        note(&mut csv, name, &all);
        for ((series, (direction, _)), curves) in all.iter().zip(DIRECTIONS).zip(&mut curves) {
            let (rise, mirror) = (rise(series), mean(&series.over(MIRROR.0, MIRROR.1)));
            let back = mean(&series.over(BACK.0, BACK.1));
            finds.push(format!(
                "{name}, light {direction}: BRDF at −75° {:.3} ± {:.3}, {:+.3} ± {:.3} against its surroundings at −65° and −85° ({}); mean \
                 from {}° to {}° {:.2} ± {:.2}.",
                back.value,
                back.se,
                rise.value,
                rise.se,
                if rise.value == 0.0 { "no light at all".into() } else { format!("{:.1} standard errors", z(rise)) },
                MIRROR.0,
                MIRROR.1,
                mirror.value,
                mirror.se
            ));
            claims.push(if name == "coated" {
                Claim::new(
                    format!("coated, light {direction}: light goes back in a peak, by more than 5 standard errors"),
                    z(rise) > 5.0,
                )
            } else {
                Claim::new(
                    format!("bare, light {direction}: no peak beyond 2 standard errors"),
                    rise.value == 0.0 || z(rise) < 2.0,
                )
            });
            let beside = mean(&series.over(30.0, 50.0));
            claims.push(Claim::new(
                format!(
                    "{name}, light {direction}: more light at 75° than from 30° to 50°, by more than 5 standard errors"
                ),
                mirror.value - beside.value > 5.0 * mirror.se.hypot(beside.se),
            ));
            curves.push(series.curve(name));
        }
    }
    let [along, across] = curves;
    let mut panels = [panel("light along the machine direction", along), panel("light across", across)];
    panels.iter_mut().for_each(|p| p.y_range = Some((0.05, 200.0)));
    Ok(Figure {
        title: "a web with and without calcium carbonate".into(),
        made_of: format!(
            "`web-coated.toml`, `web-oriented.toml`, 75°, 670 nm, s-polarized; {seeds} coatings, {trees} ray trees on each."
        ),
        says: "The coated web has both a specular peak and a retro-reflectance peak; a similar web without coating has no \
               retro-reflectance peak."
            .into(),
        finds,
        claims,
        verdict: "Yes, for geometry alone: light that is reflected once inside a sphere of index 1.6 goes back to within 15° (its rainbow is at \
                  165°). Waves would add coherent backscattering, which this program does not know. The web of figure 10b has a small peak at \
                  −75° without any coating: the flat ends of its fibres send light back as corners do; endless fibres have none."
            .into(),
        svg: plot::panels("Sheets with and without calcium carbonate under light from 75°", &panels),
        csv,
    })
}
