//! Results in the formats of others: fluxes and values are those of the result.
//!
//! The results are also left in `target/tmp/exports`, where `tests/consumers` opens them with the programs they are for.

use std::f64::consts::PI;
use std::fs;
use std::path::PathBuf;

use crate::common::synthetic::{ggx, measured, mueller_ggx, result};
use glam::DVec3;
use gonio_embree::bsdf::{Bsdf, Lookup};
use gonio_embree::colour::Illuminant;
use gonio_embree::light::Incidence;
use gonio_embree::output::export::{Exits, Format, Grid, Source, Warped, export, tensor};
use gonio_embree::output::netcdf;

const NM: [f64; 9] = [400.0, 440.0, 480.0, 520.0, 560.0, 600.0, 640.0, 680.0, 700.0];

fn source<'a>(lookup: &'a Lookup<'a>) -> Source<'a> {
    Source {
        front: lookup,
        back: None,
        title: "a <test> & more".into(),
        wavelength: None,
        illuminant: Illuminant::D65,
        below: false,
        specular_width_deg: Some(2.0),
    }
}

fn folder() -> PathBuf {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("exports");
    fs::create_dir_all(&folder).unwrap();
    folder
}

fn theta(step: usize) -> Vec<(f64, f64)> {
    (0..=85).step_by(step).map(|t| (f64::from(t), 0.0)).collect()
}

/// Reflects and transmits, with a specular part and a spectrum.
fn coloured() -> Bsdf {
    result(3, &theta(17), &NM, 0.1, |i, o, nm| {
        let lobe = if o.z > 0.0 { 0.3 * ggx(i, o, [0.5, 0.5]) } else { 0.05 };
        lobe * (0.3 + 0.7 * ((nm - 400.0) / 300.0))
    })
}

fn text(format: Format, source: &Source<'_>) -> String {
    String::from_utf8(export(format, source).unwrap().bytes).unwrap()
}

/// Numbers of each block of data, with its wavelength and its direction.
fn blocks(xml: &str) -> Vec<(String, Vec<f64>)> {
    let between = |s: &str, from: &str, to: &str| s.split_once(from).unwrap().1.split_once(to).unwrap().0.to_string();
    xml.split("<WavelengthData>")
        .skip(1)
        .map(|block| {
            let name = between(block, "\"Integral\">", "<") + " " + &between(block, "Direction>", "<");
            let data = between(block, "<ScatteringData>", "</ScatteringData>");
            let numbers = data.split([',', '\n', ' ', '{', '}']).filter_map(|x| x.parse().ok());
            (name, numbers.collect())
        })
        .collect()
}

/// Projected solid angles of the patches of Klems' full basis.
fn klems_angles() -> Vec<f64> {
    let rings = [
        (0.0, 1),
        (5.0, 8),
        (15.0, 16),
        (25.0, 20),
        (35.0, 24),
        (45.0, 24),
        (55.0, 24),
        (65.0, 16),
        (75.0, 12),
        (90.0, 0),
    ];
    let square = |deg: f64| deg.to_radians().cos().powi(2);
    let ring = |w: &[(f64, i32)]| vec![PI * (square(w[0].0) - square(w[1].0)) / f64::from(w[0].1); w[0].1 as usize];
    rings.windows(2).flat_map(ring).collect()
}

/// What leaves is what is in the patches, to the digits that are written; at normal incidence to that of the ledger.
#[test]
fn klems_matrices_keep_the_flux() {
    let bsdf = coloured();
    let lookup = Lookup::new(&bsdf);
    let xml = text(Format::KlemsFull, &Source { wavelength: Some(3), ..source(&lookup) });
    assert!(xml.contains("a &lt;test&gt; &amp; more"));
    let angles = klems_angles();
    let blocks = blocks(&xml);
    let names: Vec<&str> = blocks.iter().map(|b| &b.0[..]).collect();
    assert_eq!(names, ["Visible Reflection Back", "Visible Transmission Back"]);
    for (name, values) in &blocks {
        assert_eq!(values.len(), 145 * 145);
        let flux = |column: usize| (0..145).map(|row| values[row * 145 + column] * angles[row]).sum::<f64>();
        let ledger = &bsdf.incidences[0].ledger;
        let expected = if name.contains("Reflection") { &ledger.reflected } else { &ledger.transmitted };
        assert!(
            (flux(0) - expected[3].value).abs() < 1e-5 * expected[3].value,
            "{name}: {} {:?}",
            flux(0),
            expected[3]
        );
        // All around a ring the sample is the same.
        assert!((flux(30) / flux(33) - 1.0).abs() < 1e-5);
    }
    // The specular part leaves in the azimuth in which the light goes.
    let (_, values) = &blocks[0];
    let brightest = (0..145).max_by(|&a, &b| values[a * 145 + 30].total_cmp(&values[b * 145 + 30])).unwrap();
    assert_eq!(brightest, 30);
}

#[test]
fn grey_is_grey_and_colours_are_those_of_the_spectrum() {
    let grey = result(2, &[(0.0, 0.0), (60.0, 0.0)], &NM, 0.0, |_, o, _| if o.z > 0.0 { 0.5 / PI } else { 0.0 });
    let lookup = Lookup::new(&grey);
    let of_grey = blocks(&text(Format::KlemsQuarter, &source(&lookup)));
    assert_eq!(of_grey.len(), 3);
    for (name, v) in &of_grey {
        let worst = v.iter().map(|x| (x - 0.5 / PI).abs()).fold(0.0, f64::max);
        assert!(v.len() == 41 * 41 && worst < 1e-6, "{name}: {} {worst}", v.len());
    }
    assert!(of_grey.iter().all(|(_, v)| v.len() == 41 * 41 && v.iter().all(|x| (x - 0.5 / PI).abs() < 1e-6)));
    for format in [Format::TensorTree3, Format::TensorTree4] {
        let tree = blocks(&text(format, &source(&lookup)));
        let [y, u, v] = [0, 1, 2].map(|i: usize| &tree[i].1);
        assert!(u.iter().all(|x| (x - 4.0 / 19.0).abs() < 1e-4) && v.iter().all(|x| (x - 9.0 / 19.0).abs() < 1e-4));
        assert!(y.iter().all(|&x| x == 0.0 || (x - 0.5 / PI).abs() < 1e-4), "{format:?}");
    }
    let single = result(1, &[(0.0, 0.0)], &[550.0], 0.0, |_, _, _| 0.1);
    let lookup = Lookup::new(&single);
    for format in [Format::Merl, Format::RglRgb, Format::KlemsFull, Format::Zemax, Format::TensorTree3] {
        let error = export(format, &source(&lookup)).unwrap_err().to_string();
        assert!(error.contains("420 to 680 nm"), "{error}");
    }
}

/// Merged or not, a tree keeps the flux of each incidence.
#[test]
fn trees_keep_the_flux() {
    let bsdf = coloured();
    let lookup = Lookup::new(&bsdf);
    let xml = text(Format::TensorTree3, &Source { wavelength: Some(3), ..source(&lookup) });
    let data = xml.split_once("<ScatteringData>").unwrap().1.split_once("</ScatteringData>").unwrap().0;
    let mut cells = vec![0.0; 1 << 18];
    fill(&mut data.trim().chars().peekable(), [0; 3], 6, &mut cells);
    let slice = |at: usize| cells[at << 12..(at + 1) << 12].iter().sum::<f64>() * PI / 4096.0;
    // The last slice is nearly normal incidence.
    let expected = lookup.at(&Incidence { theta_deg: (1.0f64 / 64.0).asin().to_degrees(), phi_deg: 0.0 });
    let expected = expected.share(|l| &l.reflected, 3).value;
    assert!((slice(31) / expected - 1.0).abs() < 1e-3, "{} {expected}", slice(31));
    assert_eq!(slice(40), 0.0);
}

/// Reads a tree of three dimensions into its cells.
fn fill(text: &mut std::iter::Peekable<std::str::Chars<'_>>, corner: [usize; 3], level: u32, cells: &mut [f64]) {
    let skip = |text: &mut std::iter::Peekable<std::str::Chars<'_>>| {
        while text.next_if(|c| c.is_whitespace()).is_some() {}
    };
    skip(text);
    assert_eq!(text.next(), Some('{'));
    skip(text);
    let half = 1usize << level.saturating_sub(1);
    let child = |n: usize| [0, 1, 2].map(|d| corner[d] + (n >> d & 1) * half);
    if text.peek() == Some(&'{') {
        for n in 0..8 {
            fill(text, child(n), level - 1, cells);
            skip(text);
        }
    } else {
        let mut numbers = Vec::new();
        while text.peek() != Some(&'}') {
            let mut number = String::new();
            while let Some(c) = text.next_if(|c| !c.is_whitespace() && *c != '}') {
                number.push(c);
            }
            numbers.push(number.parse::<f64>().unwrap());
            skip(text);
        }
        let mut put = |[x, y, z]: [usize; 3], value: f64| cells[x << 12 | y << 6 | z] = value;
        if let [value] = numbers[..] {
            let n = 1usize << level;
            for at in 0..n * n * n {
                put([corner[0] + at / (n * n), corner[1] + at / n % n, corner[2] + at % n], value);
            }
        } else {
            assert_eq!((numbers.len(), level), (8, 1));
            // A grid counts its first dimension slowest, unlike the children of a branch.
            (0..8).for_each(|n| put([corner[0] + (n >> 2), corner[1] + (n >> 1 & 1), corner[2] + (n & 1)], numbers[n]));
        }
    }
    skip(text);
    assert_eq!(text.next(), Some('}'));
}

#[test]
fn tables_hold_all_facets_and_deltas() {
    let bsdf = coloured();
    let lookup = Lookup::new(&bsdf);
    let csv = text(Format::Csv, &source(&lookup));
    let mut lines = csv.lines().filter(|l| !l.starts_with('#'));
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    let column = |name: &str| header.iter().position(|h| *h == name).unwrap();
    let (mut reflected, mut rows) = (0.0, 0);
    for line in lines {
        let fields: Vec<&str> = line.split(',').collect();
        let number = |name: &str| fields[column(name)].parse::<f64>().unwrap();
        rows += 1;
        if number("theta_i_deg") == 34.0 && number("wavelength_nm") == 560.0 && number("theta_o_deg") < 90.0 {
            let weight = if fields[column("part")] == "facet" { number("projected_solid_angle") } else { 1.0 };
            reflected += weight * number("bsdf");
        }
    }
    assert_eq!(rows, 6 * 9 * (1280 + 1));
    assert!((reflected - bsdf.incidences[2].ledger.reflected[4].value).abs() < 1e-12);
    let npy = export(Format::Npy, &source(&lookup)).unwrap().bytes;
    let header = 10 + usize::from(u16::from_le_bytes([npy[8], npy[9]]));
    assert!(header % 64 == 0 && npy.len() == header + rows * 81);
}

#[test]
fn zemax_and_astm_tables_have_the_shape_they_announce() {
    let bsdf = coloured();
    let lookup = Lookup::new(&bsdf);
    for below in [false, true] {
        let one = Source { wavelength: Some(4), below, ..source(&lookup) };
        let zemax = text(Format::Zemax, &one);
        let data = zemax.split_once("DataBegin\n").unwrap().1;
        let blocks: Vec<&str> = data.split("TIS ").skip(1).collect();
        assert_eq!(blocks.len(), 6);
        let lines: Vec<&str> = blocks[2].lines().collect();
        let ledger = &bsdf.incidences[2].ledger;
        let all = if below { &ledger.transmitted } else { &ledger.reflected }[4].value;
        assert!((lines[0].parse::<f64>().unwrap() - all).abs() < 1e-6);
        let row = |i: usize| lines[i].split(' ').map(|x| x.parse().unwrap()).collect::<Vec<f64>>();
        assert!((1..=19).all(|i| row(i).len() == 30 && row(i)[0] == row(1)[0]));
        assert!(zemax.contains(if below { "ScatterType  BTDF" } else { "ScatterType  BRDF" }));
        let astm = text(Format::Astm, &one);
        let points: usize = astm.lines().find_map(|l| l.strip_prefix("NUM_POINTS ")).unwrap().parse().unwrap();
        let after = astm.split_once("560nm\n").unwrap().1;
        assert_eq!(after.lines().count(), points);
    }
    let colours = text(Format::Zemax, &source(&lookup));
    assert_eq!(colours.matches("DataBegin").count(), 3);
}

#[test]
fn what_a_format_cannot_hold_is_told() {
    let bsdf = coloured();
    let lookup = Lookup::new(&bsdf);
    let notes = |format| export(format, &source(&lookup)).unwrap().notes.join("\n");
    assert!(notes(Format::Rgl).contains("klems-full") && notes(Format::Rgl).contains("2° wide"));
    assert!(notes(Format::KlemsFull).contains("spectra") && notes(Format::KlemsFull).contains("--back"));
    assert!(notes(Format::Merl).contains("spectra") && notes(Format::Csv).is_empty());
    let error = export(Format::Pbsdf, &source(&lookup)).unwrap_err().to_string();
    assert!(error.contains("--polarization mueller"), "{error}");
    let turned = result(1, &[(10.0, 0.0), (10.0, 90.0)], &NM, 0.0, |_, _, _| 0.1);
    let lookup = Lookup::new(&turned);
    for (format, other) in
        [(Format::TensorTree3, "tensor-tree-4"), (Format::Merl, "rgl-rgb"), (Format::Pbsdf, "the result")]
    {
        let error = export(format, &source(&lookup)).unwrap_err().to_string();
        assert!(error.contains("several azimuths") && error.contains(other), "{error}");
    }
}

/// Results and formulas, for the programs that read them.
#[test]
fn files_for_consumers_are_written() {
    let folder = folder();
    let store = |name: &str, bsdf: Bsdf| {
        fs::write(folder.join(name), netcdf::to_bytes(&measured(bsdf)).unwrap()).unwrap();
    };
    let lambert = |o: DVec3, nm: f64| if o.z > 0.0 { (0.2 + 0.1 * (nm - 400.0) / 300.0) / PI } else { 0.0 };
    store("lambert.nc", result(3, &theta(5), &NM, 0.0, |_, o, nm| lambert(o, nm)));
    store("coloured.nc", coloured());
    // Facets tilted by 15° towards +x, seen from 20°, and transmission that goes to +y alone.
    let axis = DVec3::new(30f64.to_radians().sin(), 0.0, 30f64.to_radians().cos());
    let tilted = |_: &Incidence, o: DVec3, _: f64| match o.z > 0.0 {
        true => 3.0 * f64::from(u8::from(o.dot(axis) > 0.95)),
        false => 0.5 * f64::from(u8::from(o.y > 0.3)),
    };
    let azimuths: Vec<(f64, f64)> =
        (0..4).flat_map(|p| [(0.0, 90.0 * f64::from(p)), (80.0, 90.0 * f64::from(p))]).collect();
    store("tilted.nc", result(5, &azimuths, &NM, 0.0, tilted));
    store("mueller.nc", mueller_ggx(5, &theta(5), &[450.0, 500.0, 550.0, 600.0, 650.0], 0.3));
    let nine: Vec<f64> = (0..16).map(|i| (5.85 * f64::from(i)).to_radians()).collect();
    for (name, alpha) in [("ggx", [0.2, 0.2]), ("anisotropic", [0.4, 0.15])] {
        let steps = if alpha[0] == alpha[1] { 0 } else { 32 };
        let phi = if steps == 0 { vec![0.0] } else { (0..=steps).map(|i| PI * (f64::from(i) / 16.0 - 1.0)).collect() };
        let exits = move |light: DVec3| -> Exits<'static> {
            let incidence =
                Incidence { theta_deg: light.z.acos().to_degrees(), phi_deg: light.y.atan2(light.x).to_degrees() };
            Box::new(move |exit, weight, out| out.iter_mut().for_each(|x| *x += weight * ggx(&incidence, exit, alpha)))
        };
        let table = Warped::new(&Grid { theta: nine.clone(), phi, points: 1 }, 2, exits);
        let mut fields = table.fields(name, "spectra");
        fields.push(tensor::Field::floats("wavelengths", &[2], vec![400.0, 700.0]));
        fs::write(folder.join(format!("{name}.bsdf")), tensor::to_bytes(&fields)).unwrap();
    }
}
