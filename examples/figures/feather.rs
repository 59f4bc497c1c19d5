//! Figures 6 and 7: films, plates and bricks of a hummingbird's feather.

use gonio_embree::dome::Estimate;
use gonio_embree::experiment::Settings;
use gonio_embree::light::{Polarization, SourceMode};
use gonio_embree::plot::{self, Curve, Panel};

use super::figure::{Claim, Effort, Figure, Result, Table, light, measure_file, reference, steps};

/// Reflectance at normal incidence of a sample in `hummingbird/`.
fn reflectance(sample: &str, nm: &[f64], trees: u64) -> Result<Vec<Estimate>> {
    let light = light(nm, &[(0.0, 0.0)], Polarization::Unpolarized, SourceMode::Line)?;
    let settings = Settings { trees, ..Settings::default() };
    let outcome = measure_file(&format!("hummingbird/{sample}.toml"), &light, &settings)?;
    Ok(outcome.bsdf.incidences[0].ledger.reflected.clone())
}

fn panel(title: &str, curves: Vec<Curve>) -> Panel {
    Panel {
        title: title.into(),
        x_name: "vacuum wavelength / nm".into(),
        y_name: "reflectance at normal incidence".into(),
        curves,
        y_range: Some((0.0, 1.05)),
        ..Panel::default()
    }
}

fn curve(name: &str, nm: &[f64], y: &[Estimate]) -> Curve {
    Curve { name: name.into(), x: nm.to_vec(), y: y.to_vec(), ..Curve::default() }
}

fn dashed(name: &str, points: &[(f64, f64)]) -> Curve {
    let (x, y): (Vec<f64>, Vec<f64>) = points.iter().copied().unzip();
    Curve { dashed: true, color: Some((0, 0, 0)), ..Curve::exact(name, x, y) }
}

fn peak(nm: &[f64], y: &[Estimate]) -> (f64, f64) {
    let at = (0..nm.len()).max_by(|&a, &b| y[a].value.total_cmp(&y[b].value)).unwrap_or(0);
    (nm[at], y[at].value)
}

pub fn films_and_plates(effort: Effort) -> Result<Figure> {
    let nm = steps(400.0, 750.0, effort.pick(10.0, 1.0));
    let mut csv = Table::new(&["sample", "wavelength_nm", "R"]);
    let (mut panels, mut finds, mut worst) = (Vec::new(), Vec::new(), 0.0f64);
    let mut green = true;
    for around in ["keratin", "air"] {
        let mut curves = Vec::new();
        for reading in ["optical", "literal"] {
            let [films, plates] = ["films", "plates"].map(|kind| format!("{kind}-{reading}-{around}"));
            let (a, b) = (reflectance(&films, &nm, 32)?, reflectance(&plates, &nm, 32)?);
            worst = a.iter().zip(&b).map(|(a, b)| (a.value - b.value).abs()).fold(worst, f64::max);
            let (at, most) = peak(&nm, &a);
            green &= (reading == "optical") == (500.0..600.0).contains(&at);
            finds.push(format!("In {around}, numbers read as {reading} thicknesses: a peak of {most:.3} at {at} nm."));
            curves.push(curve(&format!("films = plates, {reading}"), &nm, &a));
            for (name, y) in [(&films, &a), (&plates, &b)] {
                (0..nm.len()).for_each(|i| csv.row(&[name, &nm[i], &y[i].value]));
            }
        }
        let graded = reference("hummingbird_normal.csv", &format!("R_graded_sin2_nmin1.0_{around}"))?;
        let graded: Vec<(f64, f64)> = graded.into_iter().filter(|p| (400.0..=750.0).contains(&p.0)).collect();
        curves.push(dashed("smooth platelets (stand-in)", &graded));
        panels.push(panel(&format!("in {around}"), curves));
    }
    finds.insert(0, format!("Films and plates with cores reflect the same, to {worst:.0e}, in both readings."));
    finds.push(
        "The smooth platelet is n(z) = 2 − sin²(πz/98 nm): a stand-in, for the equations of Greenewalt, Brandt and Friel \
         could not be had. Its peak is not narrower than that of the films."
            .into(),
    );
    Ok(Figure {
        title: "films and plates of a hummingbird's feather".into(),
        made_of: "`hummingbird/films-*.toml` and `hummingbird/plates-*.toml`.".into(),
        says: "Films of 148, 98, 148 nm (74 nm at the ends), indices 2.0 and 1.5, have a broad peak with secondary peaks; plates of \
               172 nm with cores of 98 nm \"produced matching reflectance functions\". The feather is green."
            .into(),
        finds,
        claims: vec![
            Claim::new("films and plates reflect the same, to 1e-9", worst < 1e-9),
            Claim::new("read as optical thicknesses the numbers give green, as lengths they do not", green),
        ],
        verdict: "Yes for films and plates, with one correction: films of 148 nm are blue. Plates of 172 nm with cores of 98 nm leave 74 nm \
                  between cores, and 74 nm · 2.0 = 148 nm: the paper's 148 and 74 nm are optical thicknesses. Read so, films and plates \
                  match, and the feather is green."
            .into(),
        svg: plot::panels("Films and plates of a hummingbird's feather, seven layers", &panels),
        csv,
    })
}

/// Below this wavelength bricks guide light sideways, which rays know nothing of.
const VALID_FROM: f64 = 530.0;

pub fn bricks(effort: Effort) -> Result<Figure> {
    let nm: Vec<f64> = reference("rcwa_bricks2d_keratin.csv", "R_plane_film")?.into_iter().map(|p| p.0).collect();
    let trees = effort.pick(4000, 400_000);
    let mut csv = Table::new(&["around", "wavelength_nm", "R_films", "R_bricks", "R_bricks_se", "R_columns", "R_rcwa"]);
    let (mut panels, mut finds, mut claims) = (Vec::new(), Vec::new(), Vec::new());
    for around in ["keratin", "air"] {
        let file = format!("rcwa_bricks2d_{around}.csv");
        let films = reflectance(&format!("films-optical-{around}"), &nm, 32)?;
        let bricks = reflectance(&format!("bricks-optical-{around}"), &nm, trees)?;
        let columns = reference(&file, "R_columns_incoherent")?;
        let [x, y] = ["x", "y"].map(|pol| reference(&file, &format!("R_rcwa_{pol}pol_total")));
        let rigorous: Vec<(f64, f64)> = x?.iter().zip(y?).map(|(x, y)| (x.0, 0.5 * (x.1 + y.1))).collect();
        for (i, nm) in nm.iter().enumerate() {
            csv.row(&[&around, nm, &films[i].value, &bricks[i].value, &bricks[i].se, &columns[i].1, &rigorous[i].1]);
        }
        let z = bricks.iter().zip(&columns).map(|(b, c)| (b.value - c.1).abs() / b.se.max(1e-7));
        let z = z.fold(0.0, f64::max);
        let rms = |a: &dyn Fn(usize) -> f64, b: &dyn Fn(usize) -> f64, from: f64| {
            let all: Vec<f64> = (0..nm.len()).filter(|&i| nm[i] >= from).map(|i| (a(i) - b(i)).powi(2)).collect();
            (all.iter().sum::<f64>() / all.len() as f64).sqrt()
        };
        let (of_bricks, of_films, of_rcwa) =
            (|i: usize| bricks[i].value, |i: usize| films[i].value, |i: usize| rigorous[i].1);
        let width = |of: &dyn Fn(usize) -> f64| {
            let top = (0..nm.len()).map(of).fold(0.0, f64::max);
            (0..nm.len()).filter(|&i| nm[i] > 480.0 && of(i) > 0.5 * top).count() as f64 * (nm[1] - nm[0])
        };
        // On the blue side of the band, which ends where it has fallen to less than half.
        let lobe = |of: &dyn Fn(usize) -> f64| {
            let peak = (0..nm.len()).max_by(|&a, &b| of(a).total_cmp(&of(b))).unwrap_or(0);
            let edge = (0..peak).rev().find(|&i| of(i) < 0.5 * of(peak)).unwrap_or(0);
            let valley = (1..=edge).rev().find(|&i| of(i - 1) > of(i)).unwrap_or(0);
            (0..valley).map(of).fold(0.0, f64::max)
        };
        finds.push(format!(
            "In {around}: the bricks reflect what their columns of films do on average by area, to {z:.1} standard errors. The band is \
             {:.0} nm wide at half its height (films {:.0} nm, RCWA {:.0} nm); the highest secondary peak below it {:.3} (films {:.3}, RCWA {:.3}).",
            width(&of_bricks), width(&of_films), width(&of_rcwa), lobe(&of_bricks), lobe(&of_films), lobe(&of_rcwa)
        ));
        finds.push(format!(
            "In {around}: root mean square distance to rigorous coupled waves {:.3} (films {:.3}); from {VALID_FROM} nm on {:.3} (films {:.3}).",
            rms(&of_bricks, &of_rcwa, 0.0), rms(&of_films, &of_rcwa, 0.0), rms(&of_bricks, &of_rcwa, VALID_FROM), rms(&of_films, &of_rcwa, VALID_FROM)
        ));
        claims.push(Claim::new(
            format!("in {around}: bricks are the columns of films, within 5 standard errors"),
            z < 5.0,
        ));
        claims.push(Claim::new(
            format!("in {around}: the highest secondary peak is lower than that of films"),
            lobe(&of_bricks) < lobe(&of_films),
        ));
        let columns: Vec<(f64, f64)> = rigorous;
        panels.push(panel(
            &format!("in {around}"),
            vec![
                curve("plane films", &nm, &films),
                curve("bricks", &nm, &bricks),
                dashed("bricks, coupled waves (RCWA)", &columns),
            ],
        ));
    }
    Ok(Figure {
        title: "interlocking bricks".into(),
        made_of: format!("`hummingbird/films-optical-*.toml`, `hummingbird/bricks-optical-*.toml`, {trees} ray trees."),
        says: "For bricks of 1500 × 2000 nm \"the bandwidth of the primary peak has narrowed and the secondary peaks, while still \
               visible, have been attenuated\"."
            .into(),
        finds,
        claims,
        verdict: "In part. The highest secondary peak is lower than that of films, as the paper says (in keratin the next one is not). The band of the bricks does not become narrower in \
                  rays; rigorous waves make it lower and move it to the red. Bricks are three wavelengths wide, so light in them is no ray: below \
                  530 nm waves guided along the layers change the reflectance by more than the bricks do, and nothing is claimed \
                  there."
            .into(),
        svg: plot::panels("Bricks of a hummingbird's feather, seven layers", &panels),
        csv,
    })
}
