//! Figures 4 and 5: a filter of glass spheres in a liquid.

use gonio_embree::bsdf::Ledger;
use gonio_embree::colour::{self, Srgb};
use gonio_embree::dome::Estimate;
use gonio_embree::experiment::Settings;
use gonio_embree::light::{Polarization, SourceMode};
use gonio_embree::plot::{self, Curve, Panel};
use gonio_embree::sample::{Description, Sample};

use super::figure::{Claim, Effort, Figure, Result, Table, light, measure_file, steps};

const FILE: &str = "christiansen.toml";
/// Where both media have one index, nm.
const CROSSING: f64 = 520.0;

/// Twenty wavelengths, as in the paper.
fn grid() -> Vec<f64> {
    steps(400.0, 685.0, 15.0)
}

pub fn indices(_: Effort) -> Result<Figure> {
    let nm = steps(400.0, 700.0, 5.0);
    let light = light(&nm, &[(0.0, 0.0)], Polarization::Unpolarized, SourceMode::Band)?;
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/samples").join(FILE);
    let sample = Sample::new(&Description::from_toml(&path)?, &light.wavelengths, light.coherence())?;
    let index = |name: &str| -> Result<Vec<f64>> {
        let medium = sample.media.iter().find(|m| m.name == name).ok_or("the filter has another medium")?;
        Ok(medium.index.iter().map(|n| n.re).collect())
    };
    let (glass, liquid) = (index("glass")?, index("liquid")?);
    let mut csv = Table::new(&["wavelength_nm", "n_glass", "n_liquid"]);
    (0..nm.len()).for_each(|i| csv.row(&[&nm[i], &glass[i], &liquid[i]]));
    let difference = |i: usize| liquid[i] - glass[i];
    let panel = Panel {
        title: "Indices of the Christiansen filter".into(),
        x_name: "vacuum wavelength / nm".into(),
        y_name: "refractive index".into(),
        curves: vec![
            Curve::exact("glass spheres", nm.clone(), glass.clone()),
            Curve::exact("liquid", nm.clone(), liquid.clone()),
        ],
        y_range: Some((1.56, 1.66)),
        ..Panel::default()
    };
    Ok(Figure {
        title: "indices of the glass and of the liquid".into(),
        made_of: format!("The media of `{FILE}`."),
        says: "\"Indices of refraction for glass particles and surrounding substrate for a Christiansen filter\": two curves that \
               cross near 500 nm, in the green, and differ most in the red and in the blue."
            .into(),
        finds: vec![
            "n = 1.585 + 4480 nm²/λ² (like a dense crown glass) and n = 1.535 + 18000 nm²/λ² (as dispersive as carbon \
             disulfide): they cross at 520 nm, exactly."
                .into(),
            format!("The liquid's index is {:+.4} off that of the glass at 400 nm, {:+.4} at 700 nm.", difference(0), difference(nm.len() - 1)),
        ],
        claims: vec![Claim::new(
            "the curves cross at 520 nm and nowhere else",
            (0..nm.len()).all(|i| nm[i] == CROSSING || (difference(i) > 0.0) == (nm[i] < CROSSING)),
        )],
        verdict: "The text has no numbers, so these curves are our choice; they have the shape it describes.".into(),
        svg: plot::panels("", &[panel]),
        csv,
    })
}

/// Where light goes, apart from the crossing of the curves.
struct Parts {
    direct: Vec<Estimate>,
    diffuse: Vec<Estimate>,
    back: Vec<Estimate>,
}

impl Parts {
    fn new(ledger: &Ledger, cone: Vec<Estimate>) -> Self {
        let rest = |(all, direct): (&Estimate, &Estimate)| Estimate {
            value: all.value - direct.value,
            se: all.se.hypot(direct.se),
        };
        let diffuse = ledger.transmitted.iter().zip(&cone).map(rest).collect();
        Self { direct: cone, diffuse, back: ledger.reflected.clone() }
    }
}

/// Full width of the cone that counts as direct light, degrees.
const CONE: f64 = 2.0;

pub fn filter(effort: Effort) -> Result<Figure> {
    let nm = grid();
    let light = light(&nm, &[(0.0, 0.0)], Polarization::Unpolarized, SourceMode::Band)?;
    let arm = gonio_embree::bsdf::Arm { angles_deg: vec![0.0], aperture_deg: CONE, below: true, turn_deg: 0.0 };
    let trees = effort.pick(20_000, 200_000);
    let outcome = measure_file(FILE, &light, &Settings { trees, arm: Some(arm.clone()), ..Settings::default() })?;
    let scattering = &outcome.bsdf.incidences[0];
    let apertures = arm.apertures(&scattering.incidence);
    let angle = apertures.projected_solid_angle(apertures.axes()[0]);
    let share = |e: &Estimate| Estimate { value: e.value * angle, se: e.se * angle };
    let cone = outcome.scans[0].readings[0].value.iter().map(share).collect();
    let parts = Parts::new(&scattering.ledger, cone);
    let mut csv = Table::new(&[
        "wavelength_nm",
        "direct",
        "direct_se",
        "diffuse_transmitted",
        "diffuse_transmitted_se",
        "diffuse_reflected",
        "diffuse_reflected_se",
        "undeflected",
    ]);
    for (i, nm) in nm.iter().enumerate() {
        let [a, b, c] = [parts.direct[i], parts.diffuse[i], parts.back[i]];
        csv.row(&[nm, &a.value, &a.se, &b.value, &b.se, &c.value, &c.se, &scattering.ledger.undeflected[i].value]);
    }
    let panel = |title: &str, y: &[Estimate]| -> Result<(Panel, Srgb, [f64; 2])> {
        let (colour, xy) = seen(&nm, y)?;
        let curve = Curve { x: nm.clone(), y: y.to_vec(), color: Some(colour.0.into()), ..Curve::default() };
        let title = format!("{title}: {colour} if bright");
        Ok((
            Panel {
                title,
                x_name: "vacuum wavelength / nm".into(),
                y_name: "share of the light".into(),
                curves: vec![curve],
                ..Panel::default()
            },
            colour,
            xy,
        ))
    };
    let (direct, green, xy_direct) = panel(&format!("direct, within {CONE}°"), &parts.direct)?;
    let (diffuse, _, _) = panel("transmitted beside it", &parts.diffuse)?;
    let (back, magenta, xy_back) = panel("reflected", &parts.back)?;
    let at = nm.iter().position(|&x| x == CROSSING).ok_or("the grid has no crossing")?;
    let top = (0..nm.len()).max_by(|&a, &b| parts.direct[a].value.total_cmp(&parts.direct[b].value)).unwrap_or(0);
    let undeflected = scattering.ledger.undeflected[at].value;
    let [first, last] = [0, nm.len() - 1];
    let is_green = green.0[1] > green.0[0] && green.0[1] > green.0[2];
    let is_magenta = magenta.0[1] < magenta.0[0] && magenta.0[1] < magenta.0[2];
    let far = |i: usize| parts.direct[i].value < 0.5 * parts.direct[at].value;
    let falls = far(at - 4) && far(at + 4) && parts.direct[first].value < 0.1 && parts.direct[last].value < 0.1;
    Ok(Figure {
        title: "light that a Christiansen filter transmits and reflects".into(),
        made_of: format!("`{FILE}`, 20 wavelengths, normal incidence, {trees} ray trees."),
        says: "Direct transmission is green, of the wavelength at which the curves of figure 4 cross; diffuse transmission is a \
               mixture of the wavelengths around it; the diffuse reflectance is a \"vivid magenta\", for red and blue are scattered \
               most, so much that much of this light is not transmitted."
            .into(),
        finds: vec![
            format!("At {CROSSING} nm {undeflected:.4} of the light goes straight on; no other wavelength has as much within {CONE}°."),
            format!(
                "The direct light is green ({green}; x = {:.3}, y = {:.3}), the reflected light magenta ({magenta}; x = {:.3}, y = {:.3}).",
                xy_direct[0], xy_direct[1], xy_back[0], xy_back[1]
            ),
            format!(
                "Of the blue end {:.2} % is reflected, of the red end {:.2} %, at the crossing {:.4} %.",
                100.0 * parts.back[first].value,
                100.0 * parts.back[last].value,
                100.0 * parts.back[at].value
            ),
        ],
        claims: vec![
            Claim::new("the direct light is most where the curves cross, and there more than 0.99 of all", top == at && undeflected > 0.99),
            Claim::new("it falls on both sides", falls),
            Claim::new("the direct light is green, the reflected light magenta", is_green && is_magenta),
        ],
        verdict: "Yes, in all colours. How much is reflected depends on the indices of figure 4, which the text does not tell: with those \
                  of a real glass and a real liquid it is about a percent, not much of the light."
            .into(),
        svg: plot::panels("A Christiansen filter of 14,000 microspheres", &[direct, diffuse, back]),
        csv,
    })
}

/// The colour of light with this spectrum, made as bright as white, and its chromaticity x, y.
fn seen(nm: &[f64], y: &[Estimate]) -> Result<(Srgb, [f64; 2])> {
    let xyz = colour::xyz(|at| Ok::<_, String>(between(nm, y, at)))?;
    let sum: f64 = xyz.iter().sum();
    let bright = xyz.map(|x| 0.7 * x / xyz[1].max(xyz[0]).max(xyz[2]).max(1e-12));
    Ok((colour::srgb(bright), [xyz[0] / sum, xyz[1] / sum]))
}

/// Linear between wavelengths, constant beyond.
fn between(nm: &[f64], y: &[Estimate], at: f64) -> f64 {
    let next = nm.partition_point(|&x| x <= at);
    if next == 0 {
        return y[0].value;
    }
    if next == nm.len() {
        return y[next - 1].value;
    }
    let part = (at - nm[next - 1]) / (nm[next] - nm[next - 1]);
    (1.0 - part) * y[next - 1].value + part * y[next].value
}
