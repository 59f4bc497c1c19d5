//! Media from files: published values come out, and what is no such file is refused with file and line.

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use gonio_embree::media::{Dispersion, read_file};
use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};

/// Longest time to read any file here, with room for a busy machine.
const LONGEST: Duration = Duration::from_secs(10);

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// A file of the database, built in or of these tests.
fn reference(name: &str) -> PathBuf {
    let dirs = ["src/media/data", "tests/reference/refractiveindex"].map(|dir| root().join(dir).join(name));
    dirs.into_iter().find(|path| path.exists()).unwrap_or_else(|| panic!("{name} is not there"))
}

/// All of them.
fn references() -> Vec<PathBuf> {
    let dirs = ["src/media/data", "tests/reference/refractiveindex"];
    let files = dirs.into_iter().flat_map(|dir| fs::read_dir(root().join(dir)).unwrap());
    let mut all: Vec<PathBuf> = files.map(|e| e.unwrap().path()).collect();
    all.retain(|path| path.extension().is_some_and(|e| e == "yml"));
    all.sort();
    all
}

/// A file of this test run.
fn scratch(name: &str, text: impl AsRef<[u8]>) -> PathBuf {
    let dir = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("media");
    fs::create_dir_all(&dir).unwrap();
    let path = dir.join(name);
    fs::write(&path, text).unwrap();
    path
}

fn dispersion(path: &Path) -> Dispersion {
    read_file(path).unwrap_or_else(|e| panic!("{e}")).dispersion
}

/// A file with one formula.
fn page(name: &str, number: u8, range: &str, coefficients: &str) -> PathBuf {
    let entry = format!("type: formula {number}\n    wavelength_range: {range}\n    coefficients: {coefficients}");
    scratch(name, format!("DATA:\n  - {entry}\n"))
}

/// n at wavelengths in nm to six decimals: of formulas 1, 2 and 4 as the database shows them, of the others by the
/// equations of its documentation with 30 digits.
#[test]
fn formulas_give_published_indices() {
    // Of the catalogue of HOYA; of Rheims, Köser and Wriedt, Meas. Sci. Technol. 8, 601 (1997); of Peck and Khanna,
    // J. Opt. Soc. Am. 56, 1059 (1966).
    let bsc7 = "2.2702566 -0.0091988101 2 0.011609706 -2 -7.6123911e-05 -4 2.8558727e-05 -6 -1.2566486e-06 -8";
    let bsc7 = page("bsc7.yml", 3, "0.36501 1.01398", bsc7);
    let ethanol = page("ethanol.yml", 5, "0.4765 0.83", "1.35265 0.00306 -2 0.00002 -4");
    let nitrogen = page("nitrogen.yml", 6, "0.4679 2.0587", "6.8552E-5 3.243157E-2 144");
    let visible = [450.0, 550.0, 589.0, 650.0];
    let cases = [
        (reference("SiO2-Malitson.yml"), visible, [1.465566, 1.459911, 1.458413, 1.456535]),
        (reference("N-BK7.yml"), visible, [1.525320, 1.518522, 1.516740, 1.514520]),
        (reference("cellulose-Sultanova.yml"), visible, [1.479562, 1.471993, 1.470070, 1.467750]),
        (reference("H2O-Daimon.yml"), visible, [1.339608, 1.334683, 1.333358, 1.331667]),
        (reference("CaCO3-Ghosh-o.yml"), visible, [1.672584, 1.661275, 1.658364, 1.654774]),
        (reference("CaCO3-Ghosh-e.yml"), visible, [1.492808, 1.487496, 1.486139, 1.484493]),
        (bsc7.clone(), visible, [1.525307, 1.518520, 1.516738, 1.514517]),
        (reference("TiO2-Devore-o.yml"), visible, [2.812569, 2.647935, 2.613146, 2.574165]),
        (reference("TiO2-Devore-e.yml"), visible, [3.163462, 2.952873, 2.908942, 2.859940]),
        (ethanol, [476.5, 550.0, 589.0, 650.0], [1.366515, 1.362984, 1.361637, 1.360005]),
        (nitrogen.clone(), [500.0, 550.0, 589.0, 650.0], [1.000300, 1.000299, 1.000298, 1.000298]),
        (reference("Si-Edwards.yml"), [2437.3, 4000.0, 10_000.0, 20_000.0], [3.443361, 3.429379, 3.421525, 3.420424]),
        (reference("AgBr-Schroter.yml"), [500.0, 550.0, 589.0, 650.0], [2.309452, 2.275584, 2.257365, 2.237244]),
        (reference("urea-Rosker-e.yml"), visible, [1.625982, 1.610178, 1.606338, 1.601801]),
    ];
    for (path, wavelengths, indices) in cases {
        let medium = dispersion(&path);
        for (nm, n) in wavelengths.into_iter().zip(indices) {
            let found = medium.index(nm / 1e3).unwrap();
            assert!((found.re - n).abs() < 5.1e-7, "{} at {nm} nm: {found}", path.display());
        }
    }
    let refractivity = dispersion(&nitrogen).index(0.589).unwrap().re - 1.0;
    assert!((refractivity - 2.983716e-4).abs() < 1e-10, "{refractivity}");
    // Lines d, F and C of the catalogue: nd = 1.51680, Vd = 64.20.
    let [d, f, c] = [0.587_561_8, 0.486_132_7, 0.656_272_5].map(|um| dispersion(&bsc7).index(um).unwrap().re);
    assert!((d - 1.51680).abs() < 5e-6 && ((d - 1.0) / (f - c) - 64.20).abs() < 5e-3, "{d} {f} {c}");
}

#[test]
fn tables_are_linear_between_their_lines() {
    let silver = dispersion(&reference("Ag-Johnson.yml"));
    let at = |um: f64| silver.index(um).unwrap();
    assert_eq!((at(0.4509).re, at(0.4509).im), (0.04, 2.657));
    assert!((at((0.4509 + 0.4714) / 2.0).im - (2.657 + 2.869) / 2.0).abs() < 1e-12);
    assert_eq!((at(0.1879).im, at(1.937).im), (1.212, 14.08));
    // k of a formula's second entry.
    let glass = dispersion(&reference("N-BK7.yml"));
    let k = glass.index(0.45).unwrap().im;
    assert!((k - 1.064475e-8).abs() < 1e-14, "{k}");
    let water = read_file(&reference("H2O-Hale.yml")).unwrap();
    assert_eq!(water.dispersion.range(), (0.2, 200.0));
    assert_eq!(water.dispersion.index(0.55).unwrap().im, 1.96e-9);
    assert!(water.source.starts_with("G. M. Hale and M. R. Querry.") && water.source.contains("<i>Appl. Opt.</i>"));
}

#[test]
fn nothing_is_known_beyond_the_range() {
    let error = |name: &str, um: f64| dispersion(&reference(name)).index(um).unwrap_err().to_string();
    assert_eq!(error("cellulose-Sultanova.yml", 0.4), "no index at 400 nm: known from 436.8 to 1052 nm");
    assert_eq!(error("Ag-Johnson.yml", 2.0), "no index at 2000 nm: known from 187.9 to 1937 nm");
    // The narrower one of n and k.
    let text = "DATA:\n- type: tabulated n\n  data: |\n    0.3 1.5\n    0.9 1.4\n- type: tabulated k\n  data: |\n    \
                0.4 0.1\n    1.0 0.2\n";
    let both = dispersion(&scratch("both.yml", text));
    assert!(both.index(0.95).unwrap_err().to_string().ends_with("known from 400 to 900 nm"));
    let held = Dispersion::Extrapolated(Box::new(both.clone()));
    assert_eq!(held.index(0.1), both.index(0.4));
    assert_eq!(held.index(5.0), both.index(0.9));
    let point = dispersion(&scratch("point.yml", "DATA:\n- type: tabulated n\n  data: 0.589 1.473\n"));
    assert_eq!(point.index(0.589).unwrap().re, 1.473);
    assert!(point.index(0.59).is_err());
}

/// The same data in other words.
#[test]
fn order_quotes_and_line_ends_do_not_matter() {
    let plain = "REFERENCES: |\n    Nobody\nDATA:\n  - type: formula 2\n    wavelength_range: 0.3 2.5\n    \
                 coefficients: 0 1.1 0.01\n  - type: tabulated k\n    data: |\n        0.3 1e-3\n        0.9 2e-3\n";
    let truth = read_file(&scratch("plain.yml", plain)).unwrap();
    assert_eq!(truth.source, "Nobody");
    let windows = plain.replace('\n', "\r\n");
    let marked = format!("\u{feff}{plain}");
    let turned = "PROPERTIES:\n    nd: 1.5\n    deep: [{a: [1, 2]}, *x, \"]\"]\n".replace("*x, ", "")
        + "CONDITIONS:\nDATA:\n- data: |2-\n    0.3 1e-3\n\n    0.9 2e-3\n  type: 'tabulated  k'\n  note: {x: [1]}\n- \
           {type: formula 2, coefficients: \"0 1.1\\\n  \\ 0.01\", wavelength_range: 0.3 2.5}\n- type: tabulated \
           n2\n  data: |\n    1.064 3e-20\nREFERENCES: \"Nobody\"\nNAMES: [a, b]\n";
    let table = "400,1.5,0.1\n500,1.6,0.2\n";
    let tables = [("a.csv", table.into()), ("b.csv", format!("\u{feff}{table}")), ("c.CSV", table.replace(',', " ; "))];
    let tables = tables.map(|(name, text)| read_file(&scratch(name, text)).unwrap());
    assert!(tables.iter().all(|t| *t == tables[0]));
    for (name, text) in [("windows.yml", windows), ("marked.yaml", marked), ("turned.YML", turned)] {
        assert_eq!(read_file(&scratch(name, text)), Ok(truth.clone()), "{name}");
    }
}

const TABLE: &str = "DATA:\n  - type: tabulated nk\n    data: |\n";
const FORMULA: &str = "DATA:\n  - type: formula 2\n    wavelength_range: 0.3 2.5\n    coefficients: ";

/// What stands in the file, in which line it is wrong, and what is said of it.
fn malformed() -> Vec<(String, usize, &'static str)> {
    let table = |rows: &str| format!("# a comment\n{TABLE}{rows}");
    vec![
        (String::new(), 1, "expected a file of refractiveindex.info, with keys such as DATA"),
        ("just words".into(), 1, "expected a file of refractiveindex.info"),
        ("- a\n- b\n".into(), 1, "expected a file of refractiveindex.info"),
        ("REFERENCES: nobody\n".into(), 1, "expected a list under DATA, of entries such as `- type: tabulated nk`"),
        ("\nDATA:\n".into(), 2, "expected a list under DATA"),
        ("\nDATA: []\n".into(), 1, "expected a list under DATA"),
        ("\nDATA: 5\n".into(), 2, "expected a list under DATA"),
        ("\nDATA:\n  - 5\n".into(), 3, "expected a list under DATA"),
        ("DATA:\n  - *a\n".into(), 2, "no YAML: "),
        ("a: \"\n\n".into(), 1, "no YAML: "),
        ("a: 1\n  b: 2\n".into(), 2, "no YAML: "),
        ("\u{0}\u{1}\u{2}".into(), 1, "no YAML: "),
        ("{{{{: []}}]".into(), 1, "expected a key and a colon"),
        ("? [a, b]\n: c\n".into(), 1, "expected a key and a colon"),
        (table("        0.4 1.5 0.1\n") + "DATA:\n  - type: tabulated k\n", 6, "DATA comes twice; leave one out"),
        ("DATA:\n  - data: |\n      1 2 3\n".into(), 2, "`type` is missing; write for example type: tabulated nk"),
        ("DATA:\n  - type: tabulated nk\n".into(), 2, "`data` is missing; write for example data: |"),
        ("DATA:\n  - type: tabulated nk\n    data:\n".into(), 3, "data: expected lines of λ n k, λ in µm"),
        ("DATA:\n  - type: tabulated nk\n    data: [1, 2]\n".into(), 3, "data: expected a text or numbers"),
        ("DATA:\n  - type: [a]\n".into(), 2, "type: expected a text or numbers"),
        ("DATA:\n  - type: a\n    type: b\n".into(), 3, "type comes twice; leave one out"),
        (
            "DATA:\n  - type: tabulated\n".into(),
            2,
            "type `tabulated`: expected formula 1 to formula 9, tabulated n, tabulated k or tabulated nk",
        ),
        ("DATA:\n  - type: model 5\n".into(), 2, "type `model 5`: expected formula 1"),
        ("DATA:\n  - type: formula x\n".into(), 2, "type `formula x`: expected formula 1"),
        ("DATA:\n  - type: formula -1\n".into(), 2, "type `formula -1`: expected formula 1"),
        (format!("{FORMULA}1\n").replace('2', "10"), 2, "formula 10: expected one from 1 to 9"),
        (format!("{FORMULA}0 1\n"), 2, "found 2 coefficients; formula 2 has 1, 3, 5, 7, 9, 11, 13, 15, 17"),
        (format!("{FORMULA}\n"), 2, "found 0 coefficients"),
        (format!("{FORMULA}0 one 2\n"), 4, "coefficients: `one` is no number"),
        (format!("{FORMULA}0 1 inf\n"), 4, "coefficients: `inf` is no number"),
        (format!("{FORMULA}0 1,5 2\n"), 4, "coefficients: `1,5` is no number"),
        ("DATA:\n  - type: formula 2\n    wavelength_range: 0.3 2.5\n".into(), 2, "`coefficients` is missing"),
        ("DATA:\n  - type: formula 2\n    coefficients: 0 1 2\n".into(), 2, "`wavelength_range` is missing"),
        (format!("{FORMULA}1\n").replace("0.3 2.5", "0.3"), 3, "wavelength_range: expected two wavelengths in µm"),
        (format!("{FORMULA}1\n").replace("0.3 2.5", "2.5 0.3"), 2, "found a range of 2.5 to 0.3 µm; expected"),
        (table("        0.4 1.5 0.1\n        0.5 1.5\n"), 6, "`0.5 1.5`: expected λ n k, λ in µm"),
        (table("        0.4 1.5 0.1\n\n        0.5 1.5 x\n"), 7, "`0.5 1.5 x`: `x` is no number"),
        (table("\n\n        0.4 1.5 0.1\n        0.5 1.5 x\n"), 8, "`0.5 1.5 x`: `x` is no number"),
        (
            "DATA:\n  - type: tabulated n\n    data: \"0.4 1.5\n\n\n      0.5 x\"\n".into(),
            3,
            "`0.5 x`: `x` is no number",
        ),
        (table("        0.4 1.5 nan\n"), 5, "`0.4 1.5 nan`: `nan` is no number"),
        (table("        0.4 1.5 0.1\n        0.3 1.5 0.1\n"), 6, "wavelength 300 nm behind 400 nm: sort them"),
        (table("        0.4 1.5 0.1\n        0.4 1.6 0.1\n"), 6, "wavelength 400 nm comes twice; leave one out"),
        (table("        -0.4 1.5 0.1\n"), 5, "wavelength -400 nm: expected one greater than 0"),
        (table("        0.4 1.5 0.1\n        0.5 1.5 -0.1\n"), 6, "k = -0.1 at 500 nm: expected k from 0"),
        (table("        0.4 0 0.1\n"), 5, "n = 0 at 400 nm: expected n greater than 0"),
        (table("        0.4 -1.5 0.1\n"), 5, "n = -1.5 at 400 nm: expected n greater than 0"),
        (TABLE.replace("nk", "k") + "        0.4 0.1\n", 2, "there is no n; expected a formula"),
        (TABLE.replace("nk", "n2") + "        0.4 1e-20\n", 2, "there is no n; expected a formula"),
        (format!("{FORMULA}1\n{}        0.4 1.5 0.1\n", &TABLE[6..]), 5, "n is given twice; leave one"),
        (
            format!("{FORMULA}1\n{}        3 0.1\n", TABLE[6..].replace("nk", "k")),
            2,
            "n and k are known at no wavelength in common; take data that overlap",
        ),
        ("DATA:\n".to_string() + &"- ".repeat(100_000), 2, "expected a list under DATA"),
        ("DATA: ".to_string() + &"[".repeat(100_000), 1, "no YAML: "),
    ]
}

#[test]
fn malformed_files_are_refused_with_their_line() {
    for (text, line, expected) in malformed() {
        let path = scratch("malformed.yml", &text);
        let error = read_file(&path).expect_err(&text);
        let start = format!("{}:{line}: ", path.display());
        assert!(
            error.starts_with(&start) && error.contains(expected),
            "{error}\n for {text:.300}\n expected {expected}"
        );
        assert!(error.len() < path.as_os_str().len() + 300, "{error:.500}");
    }
    for (text, line, expected) in [
        ("", 1, "expected at least two lines of wavelength in nm, n and k"),
        ("nm,n,k\n400,1.5\n", 2, "expected at least two lines"),
        ("nm,n,k\n400,1.5\n500,x", 3, "`500,x`: expected wavelength in nm, n and, where it absorbs, k"),
        ("400 1.5\n300 1.5", 2, "wavelength 300 nm behind 400 nm: sort them"),
        ("400;1.5;0\n500;1.5;-1", 2, "k = -1 at 500 nm: expected k from 0"),
    ] {
        let path = scratch("malformed.csv", text);
        let error = read_file(&path).expect_err(text);
        assert!(error.starts_with(&format!("{}:{line}: ", path.display())) && error.contains(expected), "{error}");
    }
}

#[test]
fn what_is_no_text_or_too_large_is_refused() {
    let binary = read_file(&scratch("binary.yml", [0xff, 0xfe, 0x00, 0x80])).unwrap_err();
    assert!(binary.ends_with("binary.yml: cannot be read: it is no text in UTF-8"), "{binary}");
    let other = read_file(Path::new("glass.txt")).unwrap_err();
    assert_eq!(other, "glass.txt: expected a file of refractiveindex.info (.yml or .yaml) or a table (.csv)");
    let missing = read_file(Path::new("nowhere.yml")).unwrap_err();
    assert!(missing.starts_with("nowhere.yml: cannot be read: "), "{missing}");
    for name in ["large.yml", "large.csv"] {
        let path = scratch(name, "");
        File::options().write(true).open(&path).unwrap().set_len((100 << 20) + 1).unwrap();
        let large = read_file(&path).unwrap_err();
        fs::remove_file(&path).unwrap();
        assert!(large.ends_with("is larger than 100 MB: more is not taken"), "{large}");
    }
}

/// Words that mean something, or are hard to take, in these files.
const WORDS: [&str; 24] = [
    "0",
    "-1",
    "1e-300",
    "1e300",
    "-0.0",
    "nan",
    "inf",
    "1e999",
    "|",
    "|9",
    ">",
    "-",
    ":",
    "{",
    "[",
    "]",
    "&a",
    "*a",
    "!!x",
    "DATA:",
    "type:",
    "formula 4",
    "tabulated n",
    "\n",
];

/// `text` with a few bytes or words left out, doubled, replaced or exchanged, or its end cut off.
fn mutated(text: &[u8], rng: &mut Xoshiro256PlusPlus) -> Vec<u8> {
    let mut out = text.to_vec();
    for _ in 0..rng.random_range(1..4) {
        if out.is_empty() {
            break;
        }
        let at = rng.random_range(0..out.len());
        let is_end = |b: &u8| b" \n,:".contains(b);
        let from = out[..at].iter().rposition(is_end).map_or(0, |i| i + 1);
        let to = out[at..].iter().position(is_end).map_or(out.len(), |i| at + i).max(from + 1).min(out.len());
        let piece = out[from..to].to_vec();
        match rng.random_range(0..8) {
            0 | 1 => drop(out.drain(from..to)),
            2 => drop(out.splice(to..to, piece)),
            3..=5 => drop(out.splice(from..to, WORDS[rng.random_range(0..WORDS.len())].bytes())),
            6 => out[at] = rng.random(),
            _ => out.truncate(at),
        }
    }
    out
}

/// Nothing panics, hangs, or yields an index that no passive medium has.
fn survives(path: &Path, what: &str) -> bool {
    let start = Instant::now();
    let read = std::panic::catch_unwind(|| {
        let medium = match read_file(path) {
            Ok(read) => read.dispersion,
            Err(e) => {
                assert!(e.starts_with(&path.display().to_string()), "{e}");
                return false;
            }
        };
        let (low, high) = medium.range();
        assert!(low <= high, "{low} {high}");
        for part in [0.0, 0.3, 0.7, 1.0] {
            if let Ok(n) = medium.index(low + part * (high - low)) {
                assert!(n.re > 0.0 && n.im >= 0.0 && n.is_finite(), "{n}");
            }
        }
        true
    });
    assert!(start.elapsed() < LONGEST, "{what} takes {:?}", start.elapsed());
    read.unwrap_or_else(|_| panic!("{what} panics:\n{}", String::from_utf8_lossy(&fs::read(path).unwrap())))
}

#[test]
fn damaged_files_never_panic_or_hang() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(23);
    let mut texts: Vec<(&str, Vec<u8>)> = references().iter().map(|p| ("damaged.yml", fs::read(p).unwrap())).collect();
    texts.push(("damaged.csv", b"# Somebody\nnm, n, k\n400, 1.5, 0\n500, 1.6, 0.1\n600, 1.7, 0\n".to_vec()));
    let (mut good, cases) = (0, 4000);
    for case in 0..cases {
        let (name, text) = &texts[case % texts.len()];
        let path = scratch(name, mutated(text, &mut rng));
        good += usize::from(survives(&path, &format!("case {case}")));
    }
    assert!((cases / 10..9 * cases / 10).contains(&good), "too mild or too harsh: {good} of {cases} are taken");
}

#[test]
fn files_cut_off_never_panic() {
    for path in references() {
        let text = fs::read(&path).unwrap();
        for end in (0..text.len()).step_by(1 + text.len() / 200) {
            survives(&scratch("cut.yml", &text[..end]), &format!("{} up to {end}", path.display()));
        }
    }
}
