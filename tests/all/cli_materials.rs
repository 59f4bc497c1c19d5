//! `gonio-embree materials` as people and scripts use it.

use std::fs;
use std::path::PathBuf;

use gonio_embree::media::{Certainty, builtin, builtins};
use serde_json::Value;

use crate::desk::{Desk, errors};

fn json(desk: &Desk, args: &[&str]) -> Value {
    let document: Value = serde_json::from_str(&desk.printed(&[args, &["--json"]].concat())).unwrap();
    assert_eq!(document["schema"], "gonio-materials-1");
    document["materials"].clone()
}

fn copy(desk: &Desk, name: &str, to: &str) {
    let root = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    fs::copy(root.join("tests/reference/refractiveindex").join(name), desk.0.join(to)).unwrap();
}

#[test]
fn the_table_has_all_of_them() {
    let table = Desk::of("materials", "table").printed(&[]);
    for medium in builtins() {
        let line = table.lines().find(|l| l.starts_with(medium.names[0])).unwrap();
        assert!(medium.names.iter().all(|name| line.contains(name)) && line.ends_with(medium.source), "{line}");
        let mark = line.contains(" * ");
        assert_eq!(mark, medium.certainty != Certainty::Published, "{line}");
        let n = format!("{:.6}", medium.dispersion().index(0.55).unwrap().re);
        assert!(line.contains(&n), "{line}");
    }
    assert!(table.lines().all(|line| line.chars().count() < 160), "{table}");
}

#[test]
fn a_name_gives_all_there_is_to_say() {
    let desk = Desk::of("materials", "name");
    let glass = desk.printed(&["bk7"]);
    for part in
        ["N-BK7, BK7", "SCHOTT", "300 to 2500 nm", "formula 2 (Sellmeier)", "103.560653", "table of 25 wavelengths"]
    {
        assert!(glass.contains(part), "{part}: {glass}");
    }
    assert!(glass.lines().any(|l| l.split_whitespace().eq(["400", "1.530849", "1.02e-8"])), "{glass}");
    let melanin = desk.printed(&["melanin", "--wavelengths", "400:700:100"]);
    assert!(melanin.contains("Not all numbers are certain.") && melanin.contains("0.56 exp(−λ/270 nm)"), "{melanin}");
    assert!(melanin.lines().rev().take(4).all(|l| l.split_whitespace().count() == 3), "{melanin}");
    assert_eq!(desk.printed(&["fused", "silica"]), desk.printed(&["Fused Silica"]));
    assert!(desk.printed(&["air"]).contains("all wavelengths"));
}

#[test]
fn a_file_is_shown_like_a_name() {
    let desk = Desk::of("materials", "file");
    copy(&desk, "H2O-Hale.yml", "water.yml");
    let water = desk.printed(&["water.yml"]);
    assert!(water.contains("Appl. Opt. 12, 555-563 (1973)") && !water.contains("<i>"), "{water}");
    assert!(water.contains("200 to 200000 nm") && !water.contains("certainty"), "{water}");
    fs::write(desk.0.join("ink.csv"), "# Somebody\n400 1.5 0.1\n420 1.5 0.2\n").unwrap();
    let ink = desk.printed(&["ink.csv"]);
    assert!(ink.contains("source     Somebody"), "{ink}");
    assert_eq!(ink.lines().skip_while(|l| !l.contains("λ/nm")).count(), 3, "{ink}");
    // Nothing of it is visible.
    copy(&desk, "Si-Edwards.yml", "si.yaml");
    let silicon = desk.printed(&["si.yaml"]);
    assert!(silicon.contains("2437.3") && silicon.contains("25000"), "{silicon}");
}

#[test]
fn scripts_get_the_same() {
    let desk = Desk::of("materials", "json");
    let all = json(&desk, &[]);
    assert_eq!(all.as_array().unwrap().len(), builtins().len());
    let silver = &json(&desk, &["silver", "--wavelengths", "450.9,548.6"])[0];
    assert_eq!(silver["names"][0], "Ag");
    assert_eq!(silver["certainty"], "uncertain");
    assert!(silver["uncertain"].as_str().unwrap().contains("two decimals"));
    assert_eq!(silver["range_nm"], serde_json::json!([187.9, 1937.0]));
    let truth = builtin("Ag").unwrap().dispersion();
    for (i, nm) in [450.9, 548.6].into_iter().enumerate() {
        let n = truth.index(nm / 1e3).unwrap();
        assert_eq!(silver["wavelength_nm"][i], nm);
        assert_eq!((silver["n"][i].as_f64(), silver["k"][i].as_f64()), (Some(n.re), Some(n.im)));
    }
    let air = &json(&desk, &["air"])[0];
    assert!(air["range_nm"].is_null() && air["uncertain"].is_null() && air["certainty"] == "published");
}

#[test]
fn pictures_have_axes_and_a_title() {
    let desk = Desk::of("materials", "plot");
    copy(&desk, "Si-Edwards.yml", "si.yml");
    for (args, k) in [
        (&["water"][..], false),
        (&["Al"], true),
        (&["N-BK7", "--wavelengths", "300:2500:10"], true),
        (&["air"], false),
        (&["melanin", "--wavelengths", "550"], true),
        (&["si.yml"], false),
    ] {
        let output = desk.run(&[args, &["--plot", "a.svg"]].concat());
        assert_eq!(output.status.code(), Some(0), "{args:?}: {}", errors(&output));
        assert!(errors(&output).contains("wrote a.svg") && !output.stdout.is_empty());
        let svg = fs::read_to_string(desk.0.join("a.svg")).unwrap();
        assert!(svg.starts_with("<svg") && !svg.contains("NaN") && !svg.contains("inf"), "{args:?}");
        assert!(svg.contains("vacuum wavelength / nm") && svg.contains("refractive index n"), "{args:?}");
        assert_eq!(svg.contains("extinction coefficient k"), k, "{args:?}");
        assert_eq!(svg.contains("(not all certain)"), args[0] == "melanin", "{args:?}");
    }
}

#[test]
fn what_is_wrong_is_said() {
    let desk = Desk::of("materials", "wrong");
    fs::write(desk.0.join("bad.yml"), "DATA:\n  - type: formula 12\n").unwrap();
    for (args, expected) in [
        (&["silca"][..], "found no built-in medium `silca` (did you mean `silica`?)"),
        (&["calcite"], "(did you mean `calcite-o`?)"),
        (&["glass.txt"], "a file ends in .yml, .yaml or .csv"),
        (&["none.yml"], "none.yml: cannot be read: No such file"),
        (&["bad.yml"], "bad.yml:2: `wavelength_range` is missing"),
        (&["cellulose", "--wavelengths", "400"], "cellulose: no index at 400 nm: known from 436.8 to 1052 nm"),
        (&["water", "--wavelengths", "700,400"], "--wavelengths: wavelengths must ascend"),
        (&["water", "--plot", "a.png"], "name it FILE.svg"),
        (&["water", "--plot", "none/a.svg"], "none/a.svg: cannot be written"),
        (&["--plot", "a.svg"], "NAME|FILE"),
    ] {
        let complaint = desk.complaint(args);
        assert!(complaint.contains(expected), "{args:?}: {complaint}");
    }
    assert_eq!(fs::read_dir(&desk.0).unwrap().count(), 1, "nothing is half-written");
}
