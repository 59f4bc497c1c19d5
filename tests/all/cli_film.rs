//! `gonio-embree film` as people and scripts use it.

use std::fs;
use std::path::PathBuf;

use serde_json::{Value, json};

use crate::desk::{Desk, errors};

fn reference(name: &str) -> String {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/reference").join(name);
    fs::read_to_string(path).unwrap()
}

/// Header and rows.
fn csv(text: &str) -> (Vec<&str>, Vec<Vec<&str>>) {
    let mut lines = text.lines().map(|line| line.split(',').collect::<Vec<_>>());
    (lines.next().unwrap(), lines.collect())
}

/// The number in a decimal text or a JSON number.
fn part(v: &Value) -> f64 {
    v.as_str().map_or_else(|| v.as_f64().unwrap(), |s| s.parse().unwrap())
}

/// Every amplitude within 4 times the effect of rounding its input plus 2e-15, after the way through the file.
#[test]
fn all_cases_of_the_reference_through_the_program() {
    let desk = Desk::of("film", "cases");
    let text = reference("films.json");
    fs::write(desk.0.join("films.json"), &text).unwrap();
    let truth: Value = serde_json::from_str(&text).unwrap();
    let got: Value = serde_json::from_str(&desk.printed(&["films.json", "--json"])).unwrap();
    assert_eq!(got["schema"], "gonio-films-result-1");
    let (truth, got) = (truth["cases"].as_array().unwrap(), got["cases"].as_array().unwrap());
    assert!(truth.len() == 213 && got.len() == 213);
    for (case, answer) in truth.iter().zip(got) {
        assert_eq!(case["id"], answer["id"]);
        for name in ["r", "t", "r_back", "t_back"] {
            let (z, x) = (&case[name], &answer[name]);
            let error = (part(&x[0]) - part(&z[0])).hypot(part(&x[1]) - part(&z[1]));
            let noise = part(&case["noise_1ulp"][name]);
            let allowed = 4.0 * noise + 2e-15 * part(&z[0]).hypot(part(&z[1])).max(1.0);
            assert!(error <= allowed, "{} {name}: {x} for {z}: {error:e} > {allowed:e}", case["name"]);
        }
        // Shares add up what rounding does to all amplitudes, and that of one far above 1 is worth less digits.
        let amplitudes = ["r", "t", "r_back", "t_back"];
        let noise: f64 = amplitudes.iter().map(|name| part(&case["noise_1ulp"][name])).sum();
        let scale = amplitudes.iter().map(|name| part(&case[name][0]).hypot(part(&case[name][1]))).fold(1.0, f64::max);
        for name in ["R", "T", "R_back", "T_back", "A"] {
            if case[name].is_null() || answer[name].is_null() {
                assert_eq!(case[name], answer[name], "{} {name}", case["name"]);
                continue;
            }
            let (error, allowed) =
                ((part(&answer[name]) - part(&case[name])).abs(), scale * scale * (1e-13 + 10.0 * noise));
            assert!(error <= allowed, "{} {name}: {error:e} > {allowed:e}", case["name"]);
        }
    }
}

/// Numbers have 17 digits: nothing is lost on the way through the text.
#[test]
fn json_has_17_digits() {
    let desk = Desk::of("film", "digits");
    desk.write_cases(&[case()]);
    let text = desk.printed(&["a.json", "--json"]);
    let r = text.split("\"R\": ").nth(1).unwrap().split(',').next().unwrap();
    let digits = r.split('e').next().unwrap().chars().filter(char::is_ascii_digit).count();
    assert_eq!(digits, 17, "{r}");
    let table = desk.printed(&["a.json"]);
    assert!(table.starts_with("case") && table.contains("\nq1 "), "{table}");
}

/// The curves are printed with 16 digits and good to 1.3e-14, which leaves room within 1e-12.
const CURVES: f64 = 1e-12;

fn compare(what: &str, got: &str, truth: f64) {
    let got: f64 = got.parse().unwrap();
    assert!((got - truth).abs() <= CURVES, "{what}: {got} for {truth}");
}

fn compare_normal(desk: &Desk, name: &str, stacks: &[(String, String)]) {
    let text = reference(name);
    let (header, rows) = csv(&text);
    let range = format!("{}:{}:1", rows[0][0], rows[rows.len() - 1][0]);
    assert_eq!(header.len(), stacks.len() + 1, "a stack for every column");
    for (column, stack) in stacks {
        let at = header.iter().position(|h| h == column).unwrap();
        let printed = desk.printed(&[stack, "--wavelengths", &range, "--csv"]);
        let (names, got) = csv(&printed);
        assert_eq!(names, ["angle_deg", "wavelength_nm", "R", "T", "A"]);
        assert_eq!(got.len(), rows.len());
        for (row, truth) in got.iter().zip(&rows) {
            assert_eq!(row[1].parse::<f64>(), truth[0].parse::<f64>());
            compare(&format!("{column} at {} nm", truth[0]), row[2], truth[at].parse().unwrap());
            assert!(row[4].parse::<f64>().unwrap().abs() < CURVES, "nothing absorbs");
        }
    }
}

fn morpho(films: usize) -> String {
    match films {
        1 => "air | 1.53 50nm | air".into(),
        n => format!("air | {} x (1.53 50nm, air 150nm), 1.53 50nm | air", n - 1),
    }
}

const HUMMINGBIRD: [(&str, &str); 7] = [
    ("humm15_air_air", "air | 2.0 74nm, 6 x (1.5 98nm, 2.0 148nm), 1.5 98nm, 2.0 74nm | air"),
    ("humm15_keratin_keratin", "1.5 | 2.0 74nm, 6 x (1.5 98nm, 2.0 148nm), 1.5 98nm, 2.0 74nm | 1.5"),
    ("humm14_air_air", "air | 2.0 74nm, 6 x (1.5 98nm, 2.0 148nm), 1.5 98nm | air"),
    ("plates_abut_air_air", "air | 2.0 37nm, 6 x (1.5 98nm, 2.0 74nm), 1.5 98nm, 2.0 37nm | air"),
    ("plates_abut_keratin", "1.5 | 7 x (2.0 37nm, 1.5 98nm, 2.0 37nm) | 1.5"),
    ("plates_gap74_keratin", "1.5 | 6 x (2.0 37nm, 1.5 98nm, 2.0 37nm, 1.5 74nm), 2.0 37nm, 1.5 98nm, 2.0 37nm | 1.5"),
    ("plates_246_abut_air", "air | 7 x (2.0 74nm, 1.5 98nm, 2.0 74nm) | air"),
];

/// Seven platelets whose core goes smoothly from index 2 down to `least` and back, in 60 steps.
fn graded(least: f64, around: f64) -> String {
    let step = |i: i32| {
        let sin = (std::f64::consts::PI * (f64::from(i) + 0.5) / 60.0).sin();
        format!("{} {}nm", 2.0 - (2.0 - least) * sin * sin, 98.0 / 60.0)
    };
    let core: Vec<String> = (0..60).map(step).collect();
    format!("{around} | 7 x (2.0 37nm, {}, 2.0 37nm) | {around}", core.join(", "))
}

#[test]
fn morpho_and_hummingbird_at_normal_incidence() {
    let desk = Desk::of("film", "normal");
    let films: Vec<_> = (1..=12).map(|n| (format!("R_{n}films"), morpho(n))).collect();
    compare_normal(&desk, "morpho_normal.csv", &films);
    let mut readings: Vec<_> = HUMMINGBIRD.iter().map(|(name, stack)| (format!("R_{name}"), (*stack).into())).collect();
    for (name, least, around) in [("1.0_keratin", 1.0, 1.5), ("1.0_air", 1.0, 1.0), ("1.5_air", 1.5, 1.0)] {
        readings.push((format!("R_graded_sin2_nmin{name}"), graded(least, around)));
    }
    compare_normal(&desk, "hummingbird_normal.csv", &readings);
}

fn compare_angles(desk: &Desk, name: &str, key: &str, stack: &str, angles: &str, columns: &[(&str, &str)]) {
    let text = reference(name);
    let (header, mut rows) = csv(&text);
    rows.retain(|row| row[0] == key);
    for (column, polarization) in columns {
        let at = header.iter().position(|h| h == column).unwrap();
        let (first, last) = (rows[0][2], rows[rows.len() - 1][2]);
        let range = format!("{first}:{last}:5");
        let args = [stack, "--angle", angles, "--wavelengths", &range, "--polarization", polarization, "--csv"];
        let printed = desk.printed(&args);
        let (_, got) = csv(&printed);
        assert_eq!(got.len(), rows.len());
        for (row, truth) in got.iter().zip(&rows) {
            for i in 0..2 {
                assert_eq!(row[i].parse::<f64>(), truth[i + 1].parse::<f64>());
            }
            compare(&format!("{key} {column} at {}°", truth[1]), row[2], truth[at].parse().unwrap());
        }
    }
}

#[test]
fn morpho_and_hummingbird_over_the_angle() {
    let desk = Desk::of("film", "angles");
    let all = [("R_s", "s"), ("R_p", "p"), ("R_unpol", "unpolarized")];
    compare_angles(&desk, "morpho_angles.csv", "12", &morpho(12), "0:80:5", &all);
    for films in [1, 2, 3, 6, 9] {
        compare_angles(&desk, "morpho_angles.csv", &films.to_string(), &morpho(films), "0:80:20", &all);
    }
    for name in ["humm15_air_air", "plates_abut_air_air"] {
        let stack = HUMMINGBIRD.iter().find(|(n, _)| *n == name).unwrap().1;
        compare_angles(&desk, "hummingbird_angles.csv", name, stack, "0:80:10", &all[..2]);
    }
}

/// Stack, column from 1, what the message must say.
const MALFORMED: [(&str, usize, &str); 40] = [
    ("", 1, "found the end; expected the first medium"),
    ("   ", 4, "found the end; expected the first medium"),
    ("air", 4, "found the end; expected `|`"),
    ("| chitin 50nm | air", 1, "found `|`; expected the first medium"),
    ("air |", 6, "found the end; expected the last medium"),
    ("air | chitin 50nm |", 20, "found the end; expected the last medium"),
    ("air | | air", 7, "found `|`; expected a layer such as `chitin 50nm`"),
    ("air | a 5 | b 5 | air", 17, "found a third `|`"),
    ("air | chitin | air", 7, "found no thickness behind `chitin`; write for example `chitin 50nm`"),
    ("air | 50nm | air", 7, "found only `50nm`; expected a medium and a thickness"),
    ("air | 50 nm | air", 7, "found only `50 nm`; expected a medium and a thickness"),
    ("air | 1.5 | air", 7, "found only `1.5`"),
    ("air | chitin 50 kg | air", 17, "found the unit `kg`; expected nm, um or mm"),
    ("air | chitin 50m | air", 14, "found the unit `m`; expected nm, um or mm"),
    ("air | chitin -50nm | air", 14, "found a thickness of `-50nm`; expected 0 to 1000 mm"),
    ("air | chitin 1e999nm | air", 14, "found a thickness of `1e999nm`"),
    ("air | chitin 2000 mm | air", 14, "found a thickness of `2000 mm`"),
    ("air | chitin nan | air", 7, "found no thickness behind `chitin nan`"),
    ("air | chitin 50nm air 150nm | air", 19, "found `air` behind `chitin 50nm`; expected `,`"),
    ("air | chitin 50nm, | air", 20, "found `|`; expected a layer"),
    ("air | chitin 50nm,, air 5 | air", 19, "found `,`; expected a layer"),
    ("air | , chitin 50nm | air", 7, "found `,`; expected a layer"),
    (
        "air | 12 x (chitin 50nm, air 150nm | air",
        36,
        "found `|`; expected `,` and a layer, or the `)` for the `(` of column 12",
    ),
    ("air | 12 x chitin 50nm, air 150nm) | air", 34, "found `)`; expected `,` and a layer, or `|`"),
    ("air | 12 (chitin 50nm) | air", 7, "found only `12`"),
    ("air | 12 x () | air", 13, "found `)`; expected a layer"),
    ("air | 0 x (chitin 50nm) | air", 7, "found `0` repetitions; expected a whole number from 1"),
    ("air | 2.5 x (chitin 50nm) | air", 7, "found `2.5` repetitions"),
    ("air | -2 x (chitin 50nm) | air", 7, "found `-2` repetitions"),
    ("air | n x (chitin 50nm) | air", 7, "found no thickness behind `n x`"),
    ("air | × (chitin 50nm) | air", 7, "found `×` without a count"),
    ("air | 1000 x 1001 x chitin 50 | air", 7, "found 1001000 layers; expected at most 1000000"),
    ("air | 99999999999999999999 x a 5 | air", 7, "expected a whole number from 1"),
    ("air | chtin 50nm | air", 7, "found no medium `chtin` (did you mean `chitin`?)"),
    ("air | chitin 50nm | unobtainium", 21, "found no medium `unobtainium`"),
    ("air 50nm | chitin 50nm | air", 5, "the first medium is endless"),
    ("air | chitin 50nm | glass 2 mm", 27, "the last medium is endless"),
    ("air | 2.0-0.1i 50nm | air", 7, "k must not be negative"),
    ("0 | 1.5 50nm | air", 1, "expected 0 < n <= 20"),
    ("1.5+0.1i | 1.5 50nm | air", 1, "expected a transparent first medium"),
];

#[test]
fn malformed_stacks_say_where_and_how_to_mend_them() {
    let desk = Desk::of("film", "malformed");
    for (stack, column, expected) in MALFORMED {
        let complaint = desk.complaint(&[stack]);
        assert!(complaint.contains(&format!("stack, column {column}: ")), "{stack}: column {column}\n{complaint}");
        assert!(complaint.contains(expected), "{stack}: {expected}\n{complaint}");
        let carets = complaint.lines().last().unwrap();
        assert_eq!(carets.find('^'), Some(column + 1), "{complaint}");
    }
    let deep = format!("air | {}a 5{} | air", "(".repeat(200), ")".repeat(200));
    assert!(desk.complaint(&[&deep]).contains("more than 100 repetitions within each other"));
    let long = format!("air | 9{} | air", "0".repeat(50_000));
    assert!(desk.complaint(&[&long]).len() < 100_000 + 1000);
}

#[test]
fn wrong_options_say_what_is_expected() {
    let desk = Desk::of("film", "options");
    let stack = "air | chitin 50nm | air";
    for (args, expected) in [
        (&[stack, "--angle", "95"][..], "--angle: 95°: expected 0 to 90°"),
        (&[stack, "--angle", "0:80:7"], "choose a step that divides"),
        (&[stack, "--wavelengths", "700,400"], "wavelengths must ascend"),
        (&[stack, "--wavelengths", "0"], "expected 10 to 1000000 nm"),
        (&["air | N-BK7 50nm | air", "--wavelengths", "200"], "no index at 200 nm: known from 300 to 2500 nm"),
        (&[stack, "--polarization", "x"], "expected unpolarized, s, p, mueller, or a Stokes vector"),
        (&[stack, "--polarization", "mueller"], "choose unpolarized, s, p or a Stokes vector"),
        (&[stack, "--medium", "a"], "expected NAME=INDEX such as melanin=2.0+0.01i, or NAME=FILE"),
        (&[stack, "--medium", "a=none.yml"], "--medium a: none.yml: cannot be read: No such file"),
        (&[stack, "--medium", "a=-1"], "expected 0 < n <= 20"),
        (&[stack, "--medium", "2a=1.5"], "expected a name whose words do not begin like a number"),
        (&[stack, "--medium", "a=1.5", "--medium", "a=2"], "--medium a: given twice"),
        (&[stack, "-o", "a.nc"], "name it FILE.svg"),
        (&[stack, "-o", "none/a.svg"], "none/a.svg: cannot be written"),
        (&[stack, "--json"], "write --csv for a stack"),
        (&["none.json"], "none.json: cannot be read"),
        (&["none.json", "--angle", "5"], "--angle belongs to a stack"),
        (&[], "STACK|FILE.json"),
    ] {
        let complaint = desk.complaint(args);
        assert!(complaint.contains(expected), "{args:?}: {complaint}");
    }
    assert_eq!(fs::read_dir(&desk.0).unwrap().count(), 0, "nothing is half-written");
}

#[test]
fn media_come_by_name_or_index() {
    let desk = Desk::of("film", "media");
    let by_name =
        desk.printed(&["air | my ink 80nm | glass", "--medium", "my ink=2.0+0.01i", "--medium", "glass=1.5", "--csv"]);
    assert_eq!(by_name, desk.printed(&["1 | 2.0 + 0.01i .08um | 1.5", "--csv"]));
    let (_, rows) = csv(&by_name);
    for row in rows {
        let share = |i: usize| row[i].parse::<f64>().unwrap();
        assert!(share(4) > 1e-3 && (share(2) + share(3) + share(4) - 1.0).abs() < 1e-15);
    }
    let over = desk.printed(&["air | chitin 1um | air", "--medium", "chitin=1", "--csv"]);
    assert!(
        csv(&over).1.iter().all(|row| row[2].parse::<f64>().unwrap() < 1e-30),
        "a name given goes before a built-in one"
    );
}

#[test]
fn media_come_from_files() {
    let desk = Desk::of("film", "files");
    let glass = concat!(env!("CARGO_MANIFEST_DIR"), "/src/media/data/N-BK7.yml");
    fs::copy(glass, desk.0.join("glass.yml")).unwrap();
    let medium = ["--medium", "lens=glass.yml", "--wavelengths", "300:2500:100", "--csv"];
    let of = |stack: &str| desk.printed(&[&[stack][..], &medium].concat());
    assert_eq!(of("air | lens 1um | lens"), of("air | N-BK7 1um | N-BK7"));
    // Light comes through it, though 1e-8 of k is published.
    assert!(csv(&of("lens | air 50nm | lens")).1.iter().all(|row| row[4].parse::<f64>().unwrap().abs() < 1e-6));
    let beyond = desk.complaint(&["air | lens 1um | air", "--medium", "lens=glass.yml", "--wavelengths", "299"]);
    assert!(beyond.contains("no index at 299 nm: known from 300 to 2500 nm"), "{beyond}");
    fs::write(desk.0.join("ink.csv"), "nm,n,k\n400,1.5,0.1\n700,1.8,0.1\n").unwrap();
    let line = ["--wavelengths", "500", "--csv"];
    let table = desk.printed(&[&["air | ink 80 | air", "--medium", "ink=ink.csv"][..], &line].concat());
    assert_eq!(table, desk.printed(&[&["air | 1.6+0.1i 80 | air"][..], &line].concat()));
    fs::write(desk.0.join("ink.csv"), "400,1.5,0.1\n700,1.8,x\n").unwrap();
    let wrong = desk.complaint(&["air | ink 80 | air", "--medium", "ink=ink.csv"]);
    assert!(wrong.contains("--medium ink: ink.csv:2: `700,1.8,x`: expected wavelength in nm"), "{wrong}");
}

#[test]
fn table_and_picture() {
    let desk = Desk::of("film", "picture");
    let stack = "air | 12 x (chitin 50nm, air 150nm) | air";
    let output = desk.run(&[stack, "--angle", "0:80:20", "--wavelengths", "350:800:5", "-o", "a.svg"]);
    assert_eq!(output.status.code(), Some(0), "{}", errors(&output));
    assert!(errors(&output).contains("wrote a.svg"));
    let table = String::from_utf8(output.stdout).unwrap();
    assert_eq!(table.matches("incidence ").count(), 5);
    assert_eq!(table.lines().filter(|l| l.trim_start().starts_with("450 ")).count(), 5);
    assert!(table.starts_with("incidence 0°, unpolarized; colour of reflected daylight #00"), "a blue: {table:.80}");
    assert!(!table.contains("-0.000000"));
    let svg = fs::read_to_string(desk.0.join("a.svg")).unwrap();
    let colour = &table[table.find('#').unwrap()..][..7];
    assert!(svg.contains(&colour.to_uppercase()), "the swatch {colour} is in the picture");
    assert!(svg.contains("Reflectance") && svg.contains("Transmittance") && !svg.contains("Absorptance"));
    assert!(svg.contains("angle of incidence") && svg.contains("80°"));
}

#[test]
fn pictures_of_little() {
    let desk = Desk::of("film", "little");
    for (name, args) in [
        ("one.svg", &["air | 2+0.1i 50nm | air", "--wavelengths", "500"][..]),
        ("angle.svg", &["air | 2+0.1i 50nm | air", "--wavelengths", "500", "--angle", "0:90:1"]),
        ("bare.svg", &["1.5 | air", "--angle", "60"]),
        (
            "unknown.svg",
            &["air | cellulose 100nm | <air> & air", "--medium", "<air> & air=1", "--wavelengths", "450:1000:50"],
        ),
    ] {
        let mut args = args.to_vec();
        args.extend(["-o", name]);
        let table = desk.printed(&args);
        let svg = fs::read_to_string(desk.0.join(name)).unwrap();
        assert!(svg.starts_with("<svg") && svg.contains("Reflectance") && !svg.contains("NaN"), "{name}");
        assert_eq!(svg.contains("Absorptance"), table.contains("incidence") && args[0].contains('+'), "{name}");
        assert_eq!(svg.contains("unknown"), name == "unknown.svg");
        assert!(!svg.contains("<air>"), "text is escaped");
    }
}

/// A case that is right.
fn case() -> Value {
    json!({
        "id": "q1", "pol": "s", "wavelength_nm": 550.0, "angle": {"kind": "angle_deg", "value": 30.0},
        "n_first": [1.0, 0.0], "n_last": [1.5, 0.0], "layers": [[2.0, 0.1, 74.0], [1.5, 0.0, 98.0]], "repeat": 3,
    })
}

impl Desk {
    fn write_cases(&self, cases: &[Value]) {
        fs::write(self.0.join("a.json"), json!({ "cases": cases }).to_string()).unwrap();
    }
}

#[test]
fn wrong_cases_are_named_with_their_field() {
    let desk = Desk::of("film", "wrong");
    for (pointer, value, expected) in [
        ("/id", json!(5), "cases[1]: id: found 5; expected a text"),
        ("/id", Value::Null, "cases[1]: id: missing"),
        ("/pol", json!("x"), "case `q1`: pol: found \"x\"; expected \"s\" or \"p\""),
        ("/pol", Value::Null, "case `q1`: pol: missing"),
        ("/wavelength_nm", Value::Null, "case `q1`: wavelength_nm: missing; expected a length greater than 0"),
        ("/wavelength_nm", json!("550"), "case `q1`: wavelength_nm: found \"550\""),
        ("/wavelength_nm", json!(0), "case `q1`: wavelength_nm: found 0"),
        ("/wavelength_nm", json!(-550.0), "case `q1`: wavelength_nm: found -550.0"),
        ("/angle", json!(30.0), "case `q1`: angle.kind: missing"),
        ("/angle/kind", json!("deg"), "case `q1`: angle.kind: found \"deg\""),
        ("/angle/value", json!(91), "case `q1`: angle.value: found 91; expected an angle in degrees from 0 to 90"),
        ("/angle/value", Value::Null, "case `q1`: angle.value: missing"),
        ("/angle", json!({"kind": "cos0", "value": 1.5}), "case `q1`: angle.value: found 1.5; expected a cosine"),
        (
            "/angle",
            json!({"kind": "kx", "value": 1.1}),
            "angle.value: found 1.1; expected n sin of the angle from 0 to 1",
        ),
        ("/n_first", json!([1.0, 0.1]), "case `q1`: n_first: 1+0.1i: expected a transparent medium"),
        ("/n_first", json!([0.0, 0.0]), "case `q1`: n_first n: found 0.0; expected a number greater than 0"),
        ("/n_first", json!(1.0), "case `q1`: n_first: found 1.0; expected [n, k]"),
        ("/n_last", json!([1.5]), "case `q1`: n_last: found [1.5]; expected [n, k]"),
        ("/n_last", json!([1.5, -0.1]), "case `q1`: n_last k: found -0.1; expected a number from 0 (k > 0 absorbs)"),
        ("/layers", json!({}), "case `q1`: layers: found {}; expected a list of [n, k, nm]"),
        ("/layers", Value::Null, "case `q1`: layers: missing"),
        ("/layers/1", json!([1.5, 98.0]), "case `q1`: layers[1]: found [1.5,98.0]; expected [n, k, thickness in nm]"),
        ("/layers/1/2", json!(-98.0), "case `q1`: layers[1] thickness: found -98.0; expected a length from 0, nm"),
        ("/layers/1/0", json!(0), "case `q1`: layers[1] n: found 0; expected a number greater than 0"),
        ("/layers/0/0", json!(-2.0), "case `q1`: layers[0] n: found -2.0"),
        ("/layers/0/1", json!(true), "case `q1`: layers[0] k: found true"),
        ("/repeat", json!(0), "case `q1`: repeat: found 0; expected a whole number from 1"),
        ("/repeat", json!(1.5), "case `q1`: repeat: found 1.5"),
        ("/repeat", json!(1e9 as u64), "case `q1`: repeat: more than 1000000 layers"),
        ("/repeat", json!(u64::MAX), "case `q1`: repeat: more than 1000000 layers"),
    ] {
        let mut bad = case();
        *bad.pointer_mut(pointer).unwrap() = value;
        desk.write_cases(&[case(), bad]);
        let complaint = desk.complaint(&["a.json", "--json"]);
        assert!(complaint.contains(expected), "{pointer}: {expected}\n{complaint}");
    }
}

#[test]
fn wrong_files_are_refused_and_all_wrong_cases_told() {
    let desk = Desk::of("film", "columns");
    for (text, expected) in [
        ("", "a.json: no JSON: EOF"),
        ("{", "a.json: no JSON"),
        ("[]", "expected {\"cases\": [...]}"),
        ("{\"cases\": 5}", "expected {\"cases\": [...]}"),
        ("{\"cases\": [5]}", "cases[0]: id: missing"),
    ] {
        fs::write(desk.0.join("a.json"), text).unwrap();
        assert!(desk.complaint(&["a.json"]).contains(expected), "{text}");
    }
    for bare in ["NaN", "Infinity", "-Infinity", "1e999"] {
        let text = json!({ "cases": [case()] }).to_string().replace("550.0", bare);
        fs::write(desk.0.join("a.json"), text).unwrap();
        let expected = if bare == "1e999" { "number out of range" } else { "case `q1`: wavelength_nm: found \"" };
        assert!(desk.complaint(&["a.json"]).contains(expected), "{bare}");
    }
    let (mut one, mut two) = (case(), case());
    (one["pol"], two["repeat"], two["id"]) = (json!(1), json!(-1), json!("q\" NaN"));
    desk.write_cases(&[one, case(), two]);
    let complaint = desk.complaint(&["a.json"]);
    assert!(complaint.contains("case `q1`: pol") && complaint.contains("case `q\" NaN`: repeat"), "{complaint}");
    fs::write(desk.0.join("a.json"), "{\"cases\": []}").unwrap();
    assert!(desk.printed(&["a.json", "--json"]).contains("\"cases\": ["));
}
