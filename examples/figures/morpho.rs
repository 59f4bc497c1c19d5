//! Figure 3: the colours of one to twelve films.

use gonio_embree::colour::{self, Srgb};
use gonio_embree::experiment::Settings;
use gonio_embree::films::{self, Sweep};
use gonio_embree::light::{Polarization, SourceMode};

use super::figure::{Claim, Effort, Figure, Result, Table, light, measure_file, steps};

const FILMS: usize = 12;
/// Pixels: a sphere with its swatches.
const CELL: f64 = 190.0;
const RADIUS: f64 = 74.0;

pub fn colours(effort: Effort) -> Result<Figure> {
    let nm = steps(360.0, 830.0, 5.0);
    let angles = steps(0.0, 85.0, effort.pick(17.0, 5.0));
    let incidences: Vec<(f64, f64)> = angles.iter().map(|&a| (a, 0.0)).collect();
    let light = light(&nm, &incidences, Polarization::Unpolarized, SourceMode::Line)?;
    let mut csv = Table::new(&["films", "angle_deg", "X", "Y", "Z", "sRGB", "peak_nm", "peak_R"]);
    let (mut cells, mut worst, mut peaks) = (String::new(), 0.0f64, Vec::new());
    for count in 1..=FILMS {
        let file = if count == FILMS { "morpho.toml".into() } else { format!("morpho-{count}.toml") };
        let outcome = measure_file(&file, &light, &Settings { trees: 32, ..Settings::default() })?;
        let truth = solved(count, &nm, &angles)?;
        let mut seen = Vec::new();
        for (i, s) in outcome.bsdf.incidences.iter().enumerate() {
            let reflected: Vec<f64> = s.ledger.reflected.iter().map(|e| e.value).collect();
            let off = reflected.iter().zip(&truth.spectra[i].shares).map(|(a, b)| (a - b.reflected).abs());
            worst = off.fold(worst, f64::max);
            let xyz = colour::xyz(|at| Ok::<_, String>(reflected[((at - 360.0) / 5.0).round() as usize]))?;
            let colour = colour::srgb(xyz);
            let at = (0..nm.len()).max_by(|&a, &b| reflected[a].total_cmp(&reflected[b])).unwrap_or(0);
            csv.row(&[&count, &angles[i], &xyz[0], &xyz[1], &xyz[2], &colour, &nm[at], &reflected[at]]);
            seen.push(colour);
            if i == 0 {
                peaks.push((nm[at], reflected[at], xyz));
            }
        }
        cells += &cell(count, &angles, &seen);
    }
    let height = 60.0 + 3.0 * (CELL + 40.0);
    let svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"1200\" height=\"{height}\" viewBox=\"0 0 1200 {height}\" \
         font-family=\"sans-serif\"><rect width=\"1200\" height=\"{height}\" fill=\"#303030\"/>\
         <text x=\"16\" y=\"30\" font-size=\"18\" fill=\"white\">Spheres of Morpho stacks in daylight (D65), seen from where the \
         light comes; below each, its colour from {}° to {}°</text>{cells}</svg>",
        angles[0],
        angles[angles.len() - 1]
    );
    let (nm12, r12, [x, y, z]) = peaks[FILMS - 1];
    let sum = x + y + z;
    Ok(Figure {
        title: "colours of stacks of one to twelve films".into(),
        made_of: "`morpho-1.toml` to `morpho-11.toml` and `morpho.toml`, unpolarized laser lines every 5 nm.".into(),
        says:
            "\"Computer generated example of multilayer interference for stacks of one to twelve high index films\": \
               twelve films come closest to the butterfly, whose wing is an iridescent blue."
                .into(),
        finds: vec![
            format!(
                "The measured reflectances are those of the film formula to {worst:.0e}, at all angles and wavelengths."
            ),
            format!(
                "Twelve films reflect {r12:.4} at {nm12} nm and normal incidence, and are blue: chromaticity x = {:.3}, \
                 y = {:.3}. One film reflects {:.2} at most, and is white with a tinge.",
                x / sum,
                y / sum,
                peaks[0].1
            ),
            "Towards grazing light the band moves to the violet and out of sight, as the spheres show.".into(),
        ],
        claims: vec![
            Claim::new("the samples reflect what the film formula says, to 1e-9", worst < 1e-9),
            Claim::new(
                "twelve films are blue: they reflect most at 455 nm (of steps of 5 nm)",
                nm12 == 455.0 && r12 > 0.99,
            ),
        ],
        verdict: "Yes.".into(),
        svg,
        csv,
    })
}

/// The same by the film formula.
fn solved(count: usize, nm: &[f64], angles: &[f64]) -> Result<Sweep> {
    let stack = films::parse(&format!("air | {count} x (1.53 50nm, air 150nm) | air")).map_err(|e| e.message)?;
    let stack = stack.resolve(&[]).map_err(|e| e.message)?;
    Ok(films::sweep(&stack, nm, angles, Polarization::Unpolarized).map_err(|e| e.message)?)
}

/// A sphere seen along the light, whose local angle of incidence is asin(r/R), and the colours of the angles beside each other.
fn cell(count: usize, angles: &[f64], colours: &[Srgb]) -> String {
    let (column, row) = (((count - 1) % 4) as f64, ((count - 1) / 4) as f64);
    let (x, y) = (60.0 + column * 285.0 + CELL / 2.0, 60.0 + row * (CELL + 40.0) + RADIUS);
    let stops: String = angles
        .iter()
        .zip(colours)
        .map(|(a, c)| format!("<stop offset=\"{:.4}\" stop-color=\"{c}\"/>", a.to_radians().sin()))
        .collect();
    let width = CELL / angles.len() as f64;
    let swatches: String = colours
        .iter()
        .enumerate()
        .map(|(i, c)| {
            let left = x - CELL / 2.0 + i as f64 * width;
            format!(
                "<rect x=\"{left:.2}\" y=\"{}\" width=\"{:.2}\" height=\"22\" fill=\"{c}\"/>",
                y + RADIUS + 10.0,
                width + 0.5
            )
        })
        .collect();
    format!(
        "<defs><radialGradient id=\"f{count}\">{stops}</radialGradient></defs>\
         <circle cx=\"{x}\" cy=\"{y}\" r=\"{RADIUS}\" fill=\"url(#f{count})\"/>{swatches}\
         <text x=\"{}\" y=\"{}\" font-size=\"15\" fill=\"white\">{count}</text>",
        x - CELL / 2.0,
        y - RADIUS + 14.0
    )
}
