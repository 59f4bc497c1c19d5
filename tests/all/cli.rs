//! The program as people use it at the terminal.

use std::fs;
use std::path::Path;
use std::process::Output;

use crate::desk::{Desk, code, errors};
use gonio_embree::dome::klems::QUARTER;
use gonio_embree::output::netcdf;
use gonio_embree::sample::Description;
use gonio_embree::sample::description::Sides;
use gonio_embree::sample::generate::export::{self, Fineness};
use gonio_embree::sample::obj::Options;
use gonio_embree::units::LengthUnit;
use serde_json::Value;

const FEATHER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/feather.obj");

#[test]
fn the_asset_is_what_the_generator_writes() {
    let desk = Desk::new("asset");
    assert_eq!(code(&desk.run(&["generate", "bricks", "-o", "feather.obj"])), Some(0));
    for name in ["feather.obj", "feather.mtl"] {
        let asset = Path::new(FEATHER).with_file_name(name);
        assert_eq!(fs::read(asset).unwrap(), desk.read(name), "assets/{name}: write it again with generate bricks");
    }
}

/// The bodies of a sample file, as text without places.
fn bodies(desk: &Desk, file: &str) -> String {
    let description = Description::from_toml(&desk.0.join(file)).unwrap();
    export::to_toml(&description.objects).unwrap()
}

#[test]
fn generated_samples_are_the_same_in_every_form() {
    let desk = Desk::new("generate");
    let few = ["--count", "20", "--size", "9,9,9"];
    for (kind, options) in [
        ("bricks", &[][..]),
        ("web", &["--deviation", "15", "--size", "300,300", "--length", "0.2mm", "--fibres", "3", "--flatten", "0.5"]),
        ("packing", &[&["--radius", "0.8", "--spread", "0.2", "--open"], &few[..]].concat()),
        ("mosaic", &["--layers", "2", "--shell", "30nm", "--core", "air"]),
    ] {
        let write = |file: &str, more: &[&str]| {
            let output = desk.run(&[&["generate", kind, "-o", file], options, more].concat());
            assert_eq!(code(&output), Some(0), "{kind}: {}", errors(&output));
        };
        write("table.toml", &[]);
        write("all.toml", &["--explode"]);
        // A core has no nesting in the file, but a higher priority.
        let without_priority = |text: String| text.replace("priority = 1\n", "");
        assert_eq!(
            without_priority(bodies(&desk, "table.toml")),
            without_priority(bodies(&desk, "all.toml")),
            "{kind}"
        );
        write("mesh.obj", &["--fineness", "8"]);
        let options = Options { unit: LengthUnit::Micrometre, sides: Sides::Periodic, patch: None, media: Vec::new() };
        let mesh = Description::from_obj(&desk.0.join("mesh.obj"), &options).unwrap();
        assert!(mesh.objects.len() >= Description::from_toml(&desk.0.join("all.toml")).unwrap().objects.len());
    }
}

#[test]
fn the_command_line_has_the_defaults_of_the_sample_file() {
    let desk = Desk::new("defaults");
    for (kind, options, table) in [
        ("web", &[][..], "medium = \"fibre\""),
        ("bricks", &[], ""),
        (
            "packing",
            &["--radius", "1", "--count", "9", "--size", "9,9,9"],
            "medium = \"pigment\"\nradius = 1\ncount = 9\nsize = [9, 9, 9]",
        ),
        ("mosaic", &["--spread", "0", "--gap", "0", "--spacing", "0"], "medium = \"keratin\"\nsize = [1.5, 1, 0.1]"),
    ] {
        let output = desk.run(&[&["generate", kind, "-o", "typed.toml"], options].concat());
        assert_eq!(code(&output), Some(0), "{kind}: {}", errors(&output));
        let media = "[media]\nfibre = 1.53\npigment = 1.59\nplatelet = 2\ncore = 1.5\n";
        desk.write("short.toml", &format!("{media}[[generate]]\nkind = \"{kind}\"\n{table}\n"));
        assert_eq!(bodies(&desk, "typed.toml"), bodies(&desk, "short.toml"), "{kind}");
    }
}

#[test]
fn a_measurement_leaves_a_result_a_picture_and_a_table() {
    let desk = Desk::new("measure");
    let output = desk.run(&["--mesh", FEATHER, "--incident", "0:60:30", "--trees", "2k"]);
    assert_eq!(code(&output), Some(0), "{}", errors(&output));
    assert_eq!(desk.names(), ["feather.nc", "feather.svg"]);
    let table = String::from_utf8(output.stdout).unwrap();
    assert_eq!(table.matches("incidence θ").count(), 3);
    assert!(table.contains("interference") && table.contains("films: 6000 stacks solved"), "{table}");
    assert!(desk.read("feather.svg").starts_with(b"<svg"));
    let measured = netcdf::from_bytes(&desk.read("feather.nc")).unwrap();
    assert_eq!(measured.bsdf.incidences.len(), 3);
    assert_eq!(measured.provenance.sample_files.len(), 2);
    let nm = measured.provenance.validity.smallest_feature_um.unwrap() * 1e3;
    assert!((nm - 37.0).abs() < 1e-9, "the shell is the thinnest film: {nm}");
}

#[test]
fn json_is_as_scripts_expect_it() {
    let desk = Desk::new("json");
    let output = desk.run(&["--mesh", FEATHER, "--incident", "0,75", "--trees", "1000", "--json"]);
    assert_eq!(code(&output), Some(0), "{}", errors(&output));
    let json: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(json["schema"], "gonio-summary-1");
    assert_eq!(json["wavelength_nm"].as_array().unwrap().len(), 16);
    assert!(json["backend"]["name"].is_string() && json["backend"]["version"].is_string());
    assert!(json["seconds"].as_f64().unwrap() > 0.0 && json["threads"].as_u64().unwrap() > 0);
    assert_eq!(json["seed"], 1);
    let effect = &json["effects"]["interference"];
    assert!(effect["on"] == true && effect["reason"].is_string() && effect["bound"].is_number());
    assert!(json["validity"]["smallest_feature_um"].is_number());
    assert!(json["validity"]["small_feature_flux"].is_number());
    assert!(json["stacks"][0]["layers"].is_u64() && json["stacks"][0]["hits"].is_u64());
    let incidence = &json["incidences"][1];
    assert_eq!(incidence["theta_deg"], 75.0);
    assert_eq!(incidence["phi_deg"], 0.0);
    assert_eq!(incidence["trees"], 1000);
    assert!(incidence["segments"].is_u64());
    let term = |name: &str, w: usize| incidence[name][w].as_f64().unwrap_or_else(|| panic!("{name}[{w}]"));
    for w in 0..16 {
        let sum: f64 = ["reflected", "transmitted", "absorbed", "side", "lost"].iter().map(|n| term(n, w)).sum();
        assert!((sum - 1.0).abs() < 1e-9, "{sum}");
        for name in ["reflected_se", "transmitted_se", "specular", "undeflected"] {
            assert!(term(name, w) >= 0.0);
        }
    }
}

#[test]
fn the_command_in_the_result_gives_the_result() {
    let desk = Desk::new("again");
    let first = desk.run(&["--mesh", FEATHER, "--trees", "2e3", "--threads", "2", "-o", "a.nc", "--seed", "7"]);
    assert_eq!(code(&first), Some(0), "{}", errors(&first));
    let command = netcdf::from_bytes(&desk.read("a.nc")).unwrap().provenance.command;
    let mut words: Vec<&str> = command.split_whitespace().skip(1).collect();
    words.extend(["-o", "b.nc", "--threads", "1", "--quiet"]);
    let second = desk.run(&words);
    assert_eq!(code(&second), Some(0), "{}", errors(&second));
    assert_eq!(desk.read("a.nc"), desk.read("b.nc"));
    assert!(second.stderr.is_empty());
}

#[test]
fn a_medium_comes_from_a_file() {
    let desk = Desk::new("medium");
    let glass = concat!(env!("CARGO_MANIFEST_DIR"), "/src/media/data/N-BK7.yml");
    fs::copy(glass, desk.0.join("glass.yml")).unwrap();
    let measure = |medium: &str, out: &str| {
        let light = ["--wavelengths", "550", "--trees", "1k", "--json", "-o", out];
        desk.run(&[&["--mesh", FEATHER, "--medium", medium][..], &light].concat())
    };
    let output = measure("platelet=glass.yml", "a.nc");
    assert_eq!(code(&output), Some(0), "{}", errors(&output));
    let origin = netcdf::from_bytes(&desk.read("a.nc")).unwrap().provenance;
    assert!(origin.command.contains("--medium platelet=glass.yml"), "{}", origin.command);
    assert!(origin.sample_files.iter().any(|file| file.ends_with("glass.yml")), "{:?}", origin.sample_files);
    let reflected = |output: &Output| {
        let json: Value = serde_json::from_slice(&output.stdout).unwrap();
        json["incidences"][0]["reflected"][0].as_f64().unwrap()
    };
    let by_index = reflected(&measure("platelet=1.518522+7.24e-9i", "b.nc"));
    assert!((reflected(&output) - by_index).abs() < 1e-6 && by_index < 0.3, "{by_index}");
}

#[test]
fn wrong_usage_says_what_is_wrong_and_how_to_mend_it() {
    let desk = Desk::new("usage");
    desk.write("thin.toml", "[[object]]\nshape = \"sphere\"\nradius = 0\ncenter = [0, 0, 0]\nmedum = \"glas\"\n");
    for (args, expected) in [
        (&["--mesh", "none.obj"][..], "none.obj: cannot be read"),
        (&["--mesh", FEATHER, "--incident", "0:80:7"], "choose a step that divides"),
        (&["--mesh", FEATHER, "--incident", "95"], "--incident: 95°: expected 0 to 89.99°"),
        (&["--mesh", FEATHER, "--wavelengths", "700,400"], "wavelengths must ascend"),
        (&["--mesh", FEATHER, "--trees", "0.5"], "expected a whole number"),
        (&["--mesh", FEATHER, "--medium", "cor=1.5"], "did you mean `core`?"),
        (&["--mesh", FEATHER, "--medium", "core=-1"], "core=-1"),
        (&["--mesh", FEATHER, "--medium", "core=none.csv"], "--medium core: none.csv: cannot be read"),
        (&["--mesh", FEATHER, "--patch", "3"], "expected two lengths"),
        (&["--mesh", FEATHER, "--backend", "optix"], "expected auto, embree, obvhs, grid or brute"),
        (&["--mesh", FEATHER, "-o", "none/x.nc"], "none/x.nc: cannot be written"),
        (&["--mesh", FEATHER, "-o", "x.svg"], "name the result FILE.nc"),
        (&["--mesh", FEATHER, "--sample", "thin.toml"], "cannot be used with"),
        (&["--sample", "thin.toml"], "thin.toml:3: radius = 0: expected a length greater than 0"),
        (&["--sample", "thin.toml"], "thin.toml:5: unknown key `medum` (did you mean `medium`?)"),
        (&["--sample", "thin.toml", "--unit", "nm"], "cannot be used with"),
        (&["--mesh", FEATHER, "--polarization", "1,1,1,0"], "expected Q² + U² + V² ≤ I²"),
        (&["--mesh", FEATHER, "--polarization", "0,0,0,0"], "the first (the power) greater than 0"),
        (&["--mesh", FEATHER, "--polarization", "1,0,0"], "a Stokes vector I,Q,U,V such as 1,0,0.5,0"),
        (&["--mesh", FEATHER, "--polarization", "x"], "expected unpolarized, s, p, mueller, or a Stokes vector"),
        (&["--mesh", FEATHER, "--coherence-length", "0"], "expected a length greater than 0, such as 30um"),
        (&["--mesh", FEATHER, "--coherence-length", "inf"], "for a laser --source-mode line"),
        (&["--mesh", FEATHER, "--coherence-length", "30um", "--source-mode", "line"], "cannot be used with"),
        (&["--mesh", FEATHER, "--spread", "100"], "--spread 100: expected 0 to 90 degrees"),
        (&["--mesh", FEATHER, "--spread", "nan"], "expected 0 to 90 degrees"),
        (
            &["--mesh", FEATHER, "--effects", "colour"],
            "expected auto, all, +effect or -effect, such as auto,-dispersion",
        ),
        (
            &["--mesh", FEATHER, "--effects", "auto,-priorities"],
            "`-priorities`: expected one of interference, polarization, phase, dispersion or absorption",
        ),
        (
            &["--mesh", FEATHER, "--polarization", "mueller", "--effects", "auto,-polarization"],
            "--polarization mueller needs what --effects -polarization leaves out",
        ),
        (&["explain", "--mesh", FEATHER, "--spread", "100"], "--spread 100: expected 0 to 90 degrees"),
        (&["--json"], "give --mesh FILE.obj or --sample FILE.toml"),
        (&["scan"], "give --mesh FILE.obj or --sample FILE.toml"),
        (&["scan", "none.nc"], "none.nc: cannot be read"),
        (&["scan", FEATHER], "this is no result of gonio-embree, or it is damaged"),
        (&["scan", "x.nc", "--mesh", FEATHER], "cannot be used with"),
        (&["scan", "x.nc", "--polarization", "s"], "cannot be used with"),
        (&["scan", "--mesh", FEATHER, "--exit", "-95:90:5"], "exit angle -95°: expected −90 to 90"),
        (&["scan", "--mesh", FEATHER, "--aperture", "0"], "aperture 0°: expected more than 0"),
        (&["generate", "bricks", "-o", "x.mtl"], "name the mesh FILE.obj"),
        (&["generate", "bricks", "-o", "x.gsf"], "name the mesh FILE.obj, or the sample FILE.toml"),
        (&["generate", "rough", "-o", "x.gsf", "--size", "4,4"], "expected at least eight times the length"),
        (&["generate", "bricks", "-o", "x.obj", "--shell", "1,1,1"], "less than half"),
        (&["generate", "web", "-o", "x.txt"], "name the mesh FILE.obj, or the sample FILE.toml"),
        (&["generate", "web", "-o", "x.toml", "--radius=-1"], "radius = -1: expected a length greater than 0"),
        (&["generate", "web", "-o", "x.toml", "--deviation", "15"], "`size` is missing"),
        (&["generate", "web", "-o", "x.toml", "--medium", "wol"], "unknown medium `wol`"),
        (&["generate", "packing", "-o", "x.toml", "--radius", "1", "--size", "9,9,9"], "expected either `count`"),
        (
            &["generate", "flakes", "-o", "x.toml", "--explode", "--count", "3", "--size", "90,90,9"],
            "leave out --explode, or write FILE.obj",
        ),
        (&["generate", "mosaic", "-o", "x.obj", "--gap=-1nm"], "gap = -1 nm: expected 0 or more"),
    ] {
        let output = desk.run(args);
        assert_eq!(code(&output), Some(2), "{args:?}: {}", errors(&output));
        assert!(errors(&output).contains(expected), "{args:?}: {}", errors(&output));
        assert!(output.stdout.is_empty());
    }
    assert_eq!(desk.names(), ["thin.toml"], "nothing is half-written");
}

/// All effects, in the order in which they are told.
const EFFECTS: [&str; 7] =
    ["interference", "polarization", "phase", "dispersion", "absorption", "priorities", "finder"];

#[test]
fn all_polarizations_at_once_are_a_result_like_others() {
    let desk = Desk::new("mueller");
    let args = ["--mesh", FEATHER, "--wavelengths", "500,600", "--incident", "30", "--trees", "500", "--json"];
    let summary = |polarization: &str| -> Value {
        let output = desk.run(&[&args[..], &["--polarization", polarization]].concat());
        assert_eq!(code(&output), Some(0), "{}", errors(&output));
        serde_json::from_slice(&output.stdout).unwrap()
    };
    let mueller = summary("mueller");
    assert_eq!(mueller["schema"], "gonio-summary-1");
    assert_eq!(mueller["effects"]["polarization"]["on"], true);
    let measured = netcdf::from_bytes(&desk.read("feather.nc")).unwrap();
    assert_eq!(measured.provenance.polarization, "mueller");
    let deltas = measured.bsdf.incidences[0].deltas.as_ref().expect("matrices");
    let unpolarized = summary("unpolarized");
    for w in 0..2 {
        let specular = |json: &Value| json["incidences"][0]["specular"][w].as_f64().unwrap();
        assert!((specular(&mueller) - specular(&unpolarized)).abs() < 1e-9, "{w}");
        assert!((deltas.specular[w][0].value - specular(&mueller)).abs() < 1e-9, "{w}");
    }
}

#[test]
fn a_plan_is_explained_effect_by_effect() {
    let desk = Desk::new("explain");
    let args = ["explain", "--mesh", FEATHER, "--wavelengths", "500,600", "--trees", "500"];
    let output = desk.run(&args);
    assert_eq!(code(&output), Some(0), "{}", errors(&output));
    let text = String::from_utf8(output.stdout).unwrap();
    for name in EFFECTS {
        let line = text.lines().find(|l| l.starts_with(name)).unwrap_or_else(|| panic!("{name}: {text}"));
        let state = line.split_whitespace().nth(1);
        assert!(matches!(state, Some("on" | "off")), "{line}");
    }
    assert!(text.contains("estimated time:"), "{text}");
    let output = desk.run(&[&args[..], &["--json"]].concat());
    assert_eq!(code(&output), Some(0), "{}", errors(&output));
    let json: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(json["schema"], "gonio-plan-1");
    let effects = json["effects"].as_array().unwrap();
    assert_eq!(effects.iter().map(|e| e["name"].as_str().unwrap()).collect::<Vec<_>>(), EFFECTS);
    for effect in effects {
        assert!(effect["on"].is_boolean() && !effect["reason"].as_str().unwrap().is_empty(), "{effect}");
        assert!((0.0..=1.0).contains(&effect["bound"].as_f64().unwrap()), "{effect}");
    }
    assert!(json["state"].is_string() && json["estimated_seconds"].as_f64().unwrap() > 0.0);
    assert!(desk.names().is_empty(), "nothing is measured: {:?}", desk.names());
}

#[test]
fn measured_heights_become_a_sample_file_a_mesh_or_other_heights() {
    let desk = Desk::new("heights");
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/samples/good/_hills.png");
    let of = |out: &str| {
        let heights = ["--file", file, "--pixel", "500nm", "--height", "0,2um"];
        desk.run(&[&["generate", "height-field"][..], &heights, &["-o", out]].concat())
    };
    for out in ["h.toml", "h.obj", "h.gsf"] {
        let output = of(out);
        assert_eq!(code(&output), Some(0), "{out}: {}", errors(&output));
    }
    let heights = |file: &str| {
        let description = Description::from_toml(&desk.0.join(file)).unwrap();
        export::to_obj("", &description.objects, "h.mtl", Fineness { sides: 3, same_volume: false }).unwrap()
    };
    desk.write("again.toml", "[[object]]\nshape = \"height_field\"\nfile = \"h.gsf\"\nmedium = \"fused silica\"\n");
    let corners = |text: &str| -> Vec<f64> {
        let lines = text.lines().filter(|l| l.starts_with("v "));
        lines.flat_map(|l| l[2..].split(' ').map(|x| x.parse().unwrap()).collect::<Vec<f64>>()).collect()
    };
    let (a, b) = (corners(&heights("h.toml")), corners(&heights("again.toml")));
    // A Gwyddion file has single precision, and a middle of its own.
    assert!(a.len() == b.len() && a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-5), "{a:?}\n{b:?}");
    let measured = desk.run(&["--sample", "h.toml", "--wavelengths", "550", "--trees", "500", "--json"]);
    assert_eq!(code(&measured), Some(0), "{}", errors(&measured));
    let missing = desk.run(&["generate", "height-field", "--file", file, "-o", "x.toml"]);
    assert!(code(&missing) == Some(2) && errors(&missing).contains("pixel"), "{}", errors(&missing));
}

/// From the sample itself and from its result; in the mirror direction there is all that a pane reflects.
#[test]
fn a_scan_is_what_scripts_expect_it_to_be() {
    let desk = Desk::new("scan");
    let output = desk.run(&["generate", "rough", "--rms", "600nm", "--size", "16,16", "--points", "64", "-o", "r.gsf"]);
    assert_eq!(code(&output), Some(0), "{}", errors(&output));
    let relief = "[media]\nglass = 1.5\n[[object]]\nshape = \"height_field\"\nfile = \"r.gsf\"\nmedium = \"glass\"\n";
    desk.write("rough.toml", &format!("[sample]\nbelow = \"glass\"\n{relief}"));
    let sample = ["--sample", "rough.toml", "--incident", "30", "--wavelengths", "500,600", "--trees", "20k"];
    let output = desk.run(&[&sample[..], &["-o", "rough.nc"]].concat());
    assert_eq!(code(&output), Some(0), "{}", errors(&output));
    let arm = ["--exit", "-60:60:20", "--aperture", "16", "--csv"];
    let here = desk.run(
        &[&["scan"][..], &sample[..4], &["--wavelength", "500", "--trees", "20k"], &arm, &["-o", "s.svg"]].concat(),
    );
    let stored = desk.run(&[&["scan", "rough.nc", "--wavelength", "500"][..], &arm].concat());
    let values = |output: &Output| -> Vec<[f64; 3]> {
        assert_eq!(code(output), Some(0), "{}", errors(output));
        let text = String::from_utf8(output.stdout.clone()).unwrap();
        let mut lines = text.lines();
        assert_eq!(lines.next(), Some("angle_deg,value,se"));
        let row = |line: &str| line.split(',').map(|x| x.parse().unwrap()).collect::<Vec<f64>>().try_into().unwrap();
        lines.map(row).collect()
    };
    let (here, stored) = (values(&here), values(&stored));
    assert_eq!(here.iter().map(|v| v[0]).collect::<Vec<_>>(), [-60.0, -40.0, -20.0, 0.0, 20.0, 40.0, 60.0]);
    for ([angle, a, se], [_, b, other]) in here.iter().zip(&stored) {
        assert!((a - b).abs() <= 6.0 * se.hypot(*other) + 0.2 * a, "{angle}°: {a} ± {se}, {b} ± {other}");
    }
    let most = here.iter().max_by(|a, b| a[1].total_cmp(&b[1])).unwrap();
    assert!(most[0] > 0.0 && most[1] > 2.0 * here[0][1], "light goes to the mirror side: {here:?}");
    assert!(String::from_utf8(desk.read("s.svg")).unwrap().contains("exit angle"));
    // Of both wavelengths there are both.
    let both = desk.run(&[&["scan", "rough.nc"][..], &arm].concat());
    let text = String::from_utf8(both.stdout).unwrap();
    assert!(text.starts_with("theta_i_deg,phi_i_deg,wavelength_nm,angle_deg,value,se\n") && text.lines().count() == 15);
    let missing = desk.run(&["scan", "rough.nc", "--wavelength", "550"]);
    assert!(code(&missing) == Some(2) && errors(&missing).contains("550 was not measured; there are 500, 600"));
}

#[test]
fn lost_energy_is_an_exit_code_and_the_result_is_kept() {
    let desk = Desk::new("lost");
    desk.write(
        "ball.toml",
        "[media]\nglass = 1.5\n[[object]]\nshape = \"sphere\"\ncenter = [0, 0, 0]\nradius = 50\nmedium = \"glass\"\n",
    );
    let output = desk.run(&["--sample", "ball.toml", "--trees", "2k", "--depth", "1"]);
    assert_eq!(code(&output), Some(1));
    assert!(errors(&output).contains("of the light was lost"), "{}", errors(&output));
    assert!(desk.names().contains(&"ball.nc".into()));
    let allowed = desk.run(&["--sample", "ball.toml", "--trees", "2k", "--depth", "1", "--max-lost", "1"]);
    assert_eq!(code(&allowed), Some(0));
}

#[test]
fn help_and_version_name_what_is_there() {
    let desk = Desk::new("help");
    let version = desk.run(&["--version"]);
    assert_eq!(code(&version), Some(0));
    let text = String::from_utf8(version.stdout).unwrap();
    assert!(text.contains(env!("CARGO_PKG_VERSION")) && (text.contains("embree ") || text.contains("obvhs")), "{text}");
    let help = String::from_utf8(desk.run(&["--help"]).stdout).unwrap();
    for option in [
        "--mesh",
        "--sample",
        "--unit",
        "--sides",
        "--patch",
        "--medium",
        "--incident",
        "--azimuth",
        "--wavelengths",
        "--polarization",
        "--source-mode",
        "--trees",
        "--effects",
        "--backend",
        "--threads",
        "--seed",
        "--max-lost",
        "--output",
        "--json",
        "--quiet",
        "generate",
        "materials",
    ] {
        assert!(help.contains(option), "{option}");
    }
    assert_eq!(code(&desk.run(&[])), Some(2));
}

#[test]
#[cfg(not(has_embree))]
fn a_missing_backend_is_said_before_any_work() {
    let desk = Desk::new("backend");
    let output = desk.run(&["--mesh", FEATHER, "--backend", "embree"]);
    assert_eq!(code(&output), Some(3));
    assert!(errors(&output).contains("apt-get install libembree-dev libclang-dev"), "{}", errors(&output));
}

/// Of a matrix's own directions no column is a blend of others: its flux is that of the ledger, whatever the azimuth.
#[test]
fn the_directions_of_a_matrix_are_measured_in_one_run() {
    let desk = Desk::new("klems");
    // Not as wide as deep, so that azimuths differ.
    desk.write(
        "beads.toml",
        "[sample]\npatch = { size = [3, 5] }\n[media]\nglass = 1.5\n[[object]]\nshape = \"sphere\"\nmedium = \"glass\"\n\
         center = [0, 0, 0]\nradius = 1.2\n",
    );
    let line = ["--sample", "beads.toml", "--incident", "klems-quarter", "--wavelengths", "550", "--trees", "2000"];
    desk.printed(&[&line[..], &["-o", "beads.nc"]].concat());
    desk.printed(&["export", "beads.nc", "--to", "klems-quarter", "--wavelength", "550", "-o", "beads.xml"]);
    let measured = netcdf::from_bytes(&desk.read("beads.nc")).unwrap();
    let xml = String::from_utf8(desk.read("beads.xml")).unwrap();
    let cells = QUARTER.cells();
    assert_eq!(measured.bsdf.incidences.len(), cells.len());
    for (kind, reflected) in [("Reflection Back", true), ("Transmission Back", false)] {
        let block = xml.split("<WavelengthDataDirection>").find(|b| b.starts_with(kind)).unwrap();
        let data = block.split("<ScatteringData>").nth(1).unwrap().split('<').next().unwrap();
        let values: Vec<f64> = data.split([',', '\n', ' ']).filter_map(|x| x.parse().ok()).collect();
        assert_eq!(values.len(), cells.len() * cells.len());
        for (column, s) in measured.bsdf.incidences.iter().enumerate() {
            let rows = cells.iter().enumerate();
            let flux = rows.map(|(row, c)| values[row * cells.len() + column] * c.patch.projected_solid_angle());
            let share = if reflected { &s.ledger.reflected } else { &s.ledger.transmitted };
            let flux: f64 = flux.sum();
            assert!((flux - share[0].value).abs() < 1e-5, "{kind} {:?}: {flux} {:?}", s.incidence, share[0]);
        }
    }
    let refused = desk.complaint(&["--sample", "beads.toml", "--incident", "klems-full", "--azimuth", "10"]);
    assert!(refused.contains("klems-full have their own azimuths"), "{refused}");
    let refused = desk.complaint(&["scan", "beads.nc", "--incident", "klems-quarter"]);
    assert!(refused.contains("is no angle"), "{refused}");
    let refused = desk.complaint(&["--sample", "beads.toml", "--incident", "klems-all"]);
    assert!(refused.contains("klems-half"), "{refused}");
}
