//! Good sample files are taken, bad ones refused with all that is wrong, and no file whatever makes the reader panic
//! or hang.

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use gonio_embree::light::{Coherence, Wavelengths};
use gonio_embree::sample::description::Sides;
use gonio_embree::sample::obj::Options;
use gonio_embree::sample::problem::Problems;
use gonio_embree::sample::{Description, Matter, Sample};
use gonio_embree::units::LengthUnit;
use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};

/// Longest time to read any file of the corpora, with room for a busy machine.
const LONGEST: Duration = Duration::from_secs(10);

fn corpus(name: &str) -> Vec<PathBuf> {
    let dir = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/samples").join(name);
    let mut files: Vec<PathBuf> = fs::read_dir(dir).unwrap().map(|e| e.unwrap().path()).collect();
    files.retain(|f| matches!(f.extension().and_then(|e| e.to_str()), Some("toml" | "obj")) && !is_part(f));
    files.sort();
    files
}

/// Files that others refer to begin with an underscore.
fn is_part(file: &Path) -> bool {
    file.file_name().is_some_and(|n| n.to_string_lossy().starts_with('_'))
}

/// Reads and flattens a file for the default light.
fn load(file: &Path) -> Result<Sample, Problems> {
    let options = Options { unit: LengthUnit::Micrometre, sides: Sides::Periodic, patch: None, media: Vec::new() };
    let is_obj = file.extension().is_some_and(|e| e == "obj");
    let description = if is_obj { Description::from_obj(file, &options) } else { Description::from_toml(file) }?;
    let wavelengths = Wavelengths::from_nm((0..16).map(|i| 400.0 + 20.0 * f64::from(i)).collect()).unwrap();
    Sample::new(&description, &wavelengths, Coherence::Falling(8.0, 16.0))
}

/// The problems of a file as people see them, without its directory.
fn problems(file: &Path) -> Vec<String> {
    let dir = format!("{}/", file.parent().unwrap().display());
    let Err(problems) = load(file) else { return Vec::new() };
    problems.iter().map(|p| p.to_string().replace(&dir, "")).collect()
}

/// What the leading comments of a file, or those of a file beside it, say is wrong.
fn expectations(file: &Path) -> Vec<String> {
    let beside = PathBuf::from(format!("{}.expect", file.display()));
    let text = fs::read(if beside.exists() { &beside } else { file }).unwrap();
    String::from_utf8_lossy(&text).lines().map_while(|l| l.strip_prefix("# expect: ")).map(Into::into).collect()
}

#[test]
fn good_samples_are_taken() {
    let files = corpus("good");
    assert!(files.len() >= 15, "only {} files", files.len());
    for file in files {
        assert_eq!(problems(&file), Vec::<String>::new(), "{}", file.display());
        assert!(!load(&file).unwrap().solids.is_empty());
    }
}

/// Published traces of absorption of a glass do not keep light from coming through it.
#[test]
fn the_medium_above_is_clear() {
    let sample = load(&Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/samples/good/index_files.toml")).unwrap();
    let above = &sample.media[usize::from(sample.above.0)];
    assert!(above.name == "lens" && !above.absorbs());
    let slab = sample.solids.iter().find(|s| s.name.contains("slab")).map(|s| s.matter);
    assert!(matches!(slab, Some(Matter::Medium(id)) if id == sample.above), "one medium, not two: {slab:?}");
}

#[test]
fn bad_samples_are_refused_with_all_that_is_wrong() {
    let files = corpus("bad");
    assert!(files.len() >= 40, "only {} files", files.len());
    let mut failed = 0;
    for file in files {
        let expected = expectations(&file);
        let start = Instant::now();
        let found = problems(&file);
        assert!(start.elapsed() < LONGEST, "{} took {:?}", file.display(), start.elapsed());
        if expected.is_empty() || found != expected {
            failed += 1;
            println!("{}\n  expected {expected:#?}\n  found {found:#?}", file.display());
        }
    }
    assert_eq!(failed, 0, "files with other problems than expected");
}

#[test]
fn missing_files_and_directories_are_problems() {
    let dir = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests");
    for name in ["nowhere.toml", "nowhere.obj"] {
        let found = problems(&dir.join(name));
        assert_eq!(found, [format!("{name}: cannot be read: No such file or directory (os error 2)")]);
    }
    assert!(problems(&dir.join("samples"))[0].starts_with("samples: cannot be read: "));
}

#[test]
fn nesting_without_end_is_a_problem() {
    let deep = [
        format!("a = {}", "[".repeat(100_000)),
        format!("a = {}", "{a=".repeat(100_000)),
        format!("{}a = 1", "a.".repeat(100_000)),
        format!("[{}a]", "a.".repeat(100_000)),
        format!("[[object]]\nshape = {}{}", "[".repeat(3000), "]".repeat(3000)),
        "[[object]]\n".repeat(20_000),
    ];
    let file = scratch("deep.toml");
    for text in deep {
        fs::write(&file, &text).unwrap();
        let start = Instant::now();
        assert!(!problems(&file).is_empty(), "{:.40}", text);
        assert!(start.elapsed() < LONGEST, "{:.40}: {:?}", text, start.elapsed());
    }
}

#[test]
fn many_media_and_many_objects_are_read_in_no_time() {
    let media: String = (0..10_050).map(|i| format!("m{i} = 1.{i:05}\n")).collect();
    let layers: String = (0..10_050).map(|i| format!("{{ medium = \"m{i}\", thickness = 1 }},")).collect();
    let object = "[[object]]\nshape = \"sphere\"\nradius = 0.5\nmedium = \"water\"\n";
    let spheres: String = (0..50_000).map(|i| format!("{object}center = [{i}, 0, 0]\n")).collect();
    let file = scratch("many.toml");
    let start = Instant::now();
    fs::write(&file, format!("[media]\n{media}[[object]]\nshape = \"films\"\nlayers = [{layers}]\n")).unwrap();
    let found = problems(&file);
    assert_eq!(found.len(), 50);
    assert_eq!(found[0], "many.toml:10054: medium `m10000`: at most 10000 different media are taken; use fewer");
    fs::write(&file, spheres).unwrap();
    assert_eq!(problems(&file), Vec::<String>::new());
    assert!(start.elapsed() < LONGEST, "{:?}", start.elapsed());
}

/// A file name of this test run.
fn scratch(name: &str) -> PathBuf {
    let dir = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("samples");
    fs::create_dir_all(&dir).unwrap();
    dir.join(name)
}

/// Words that mean something, or are hard to take, in these files.
const WORDS: [&str; 28] = [
    "0",
    "-1",
    "1e-300",
    "1e300",
    "nan",
    "inf",
    "1e18",
    "9223372036854775807",
    "\"1 m\"",
    "\"nm\"",
    "[]",
    "{}",
    "\"\"",
    "true",
    "[[object]]",
    "[media]",
    "shape",
    "\"box\"",
    "\"mesh\"",
    "\"open\"",
    "1e-9",
    "1e6",
    "-0.0",
    "f 1 2 3",
    "f 1 -1 2",
    "usemtl",
    "\n",
    "1_0",
];

/// `text` with a few bytes or words left out, doubled, replaced or exchanged.
fn mutated(text: &[u8], rng: &mut Xoshiro256PlusPlus) -> Vec<u8> {
    let mut out = text.to_vec();
    for _ in 0..rng.random_range(1..4) {
        if out.is_empty() {
            break;
        }
        let at = rng.random_range(0..out.len());
        let (from, to) = if rng.random_range(0..4) == 0 { (at, at + 1) } else { word_around(&out, at) };
        let piece = out[from..to].to_vec();
        match rng.random_range(0..4) {
            0 => drop(out.drain(from..to)),
            1 => drop(out.splice(to..to, piece)),
            2 => drop(out.splice(from..to, WORDS[rng.random_range(0..WORDS.len())].bytes())),
            _ => out[at] = rng.random(),
        }
    }
    out
}

fn word_around(text: &[u8], at: usize) -> (usize, usize) {
    let ends = |b: &u8| b" \n,=[]{}".contains(b);
    let from = text[..at].iter().rposition(ends).map_or(0, |i| i + 1);
    let to = text[at..].iter().position(ends).map_or(text.len(), |i| at + i);
    (from, to.max(from + 1).min(text.len()))
}

#[test]
fn damaged_files_never_panic_or_hang() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(20);
    let files = corpus("good");
    let dir = scratch("damaged");
    fs::create_dir_all(&dir).unwrap();
    for part in fs::read_dir(files[0].parent().unwrap()).unwrap().map(|e| e.unwrap().path()) {
        fs::copy(&part, dir.join(part.file_name().unwrap())).unwrap();
    }
    for case in 0..2000 {
        let original = &files[case % files.len()];
        let text = mutated(&fs::read(original).unwrap(), &mut rng);
        let file = dir.join(format!("damaged.{}", original.extension().unwrap().to_string_lossy()));
        fs::write(&file, &text).unwrap();
        let start = Instant::now();
        let found = std::panic::catch_unwind(|| problems(&file));
        let text = String::from_utf8_lossy(&text);
        assert!(found.is_ok(), "case {case} panics:\n{text}");
        assert!(start.elapsed() < LONGEST, "case {case} takes {:?}:\n{text}", start.elapsed());
    }
}
