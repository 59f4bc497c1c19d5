use std::fs;
use std::path::{Path, PathBuf};

use glam::{DVec2, DVec3};
use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};

use super::*;

fn files() -> Vec<PathBuf> {
    let dir = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/samples/good");
    let mut files: Vec<PathBuf> = fs::read_dir(dir).unwrap().map(|e| e.unwrap().path()).collect();
    files.retain(|f| f.file_name().is_some_and(|n| n.to_string_lossy().starts_with("_hills")));
    files.sort();
    assert_eq!(files.len(), 9);
    files
}

/// However short a file is cut: it is refused, or holds all its heights.
#[test]
fn files_cut_off_anywhere_are_refused() {
    for file in files() {
        let bytes = fs::read(&file).unwrap();
        let whole = parse(&bytes, LengthUnit::Micrometre).unwrap();
        for length in 0..bytes.len() {
            match parse(&bytes[..length], LengthUnit::Micrometre) {
                Ok(raw) => {
                    // The last number of a text may have lost digits, the rest of it is what comes after the heights.
                    assert_eq!(raw.values[..11], whole.values[..11], "{} {length}", file.display());
                    assert_eq!(raw.values.len(), 12, "{} {length}", file.display());
                }
                Err(flaw) => assert!(!flaw.message.is_empty()),
            }
        }
    }
}

#[test]
fn damaged_files_never_panic() {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(3);
    for file in files() {
        let bytes = fs::read(&file).unwrap();
        for _ in 0..2000 {
            let mut damaged = bytes.clone();
            for _ in 0..rng.random_range(1..6) {
                let at = rng.random_range(0..damaged.len());
                damaged[at] = rng.random();
            }
            if let Ok(raw) = parse(&damaged, LengthUnit::Micrometre) {
                assert_eq!(raw.values.len(), raw.columns * raw.rows);
            }
        }
    }
}

/// Deviations of surface data files that are about: two numbers more in the header, marks of gaps, comments.
#[test]
fn surface_data_files_of_other_makers_are_read() {
    let dir = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/samples/good");
    let plain = fs::read(dir.join("_hills_binary.sdf")).unwrap();
    let heights = parse(&plain, LengthUnit::Micrometre).unwrap();
    let longer = [&plain[..81], &[5, 0, 0, 0, 1, 0, 0, 0], &plain[81..]].concat();
    assert_eq!(parse(&longer, LengthUnit::Micrometre).unwrap(), heights);
    let mut unsigned = [b"bBCR-1.0", &plain[8..]].concat();
    unsigned[79] = 1;
    unsigned[81..83].fill(0xff);
    let gap = parse(&unsigned, LengthUnit::Micrometre).unwrap();
    assert!(gap.values[0].is_nan());
    assert_eq!(gap.values[1..], heights.values[1..]);
    let text = fs::read_to_string(dir.join("_hills.sdf")).unwrap();
    let latin = text.replacen("\r\n", "\r\n; 1 \u{fffd}m\r\n", 1).into_bytes();
    assert_eq!(parse(&latin, LengthUnit::Micrometre).unwrap(), parse(text.as_bytes(), LengthUnit::Micrometre).unwrap());
}

#[test]
fn what_is_written_can_be_read() {
    let field = hills().field;
    let read = parse(&field.to_gsf(), LengthUnit::Millimetre).unwrap().into_field(None, None, None).unwrap();
    assert!(read.pixel.distance(field.pixel) < 1e-12);
    assert!(read.heights.iter().zip(&field.heights).all(|(a, b)| (a - b).abs() < 1e-6 * b.max(1.0)));
}

fn hills() -> Relief {
    let heights = (0..12).map(|i| f64::from(i * 7 % 12)).collect();
    let field = HeightField { columns: 4, rows: 3, pixel: DVec2::new(0.5, 0.25), heights };
    Relief { field, center: DVec2::new(3.0, -1.0), floor: -2.0 }
}

#[test]
fn bodies_are_closed_and_the_first_row_is_that_of_largest_y() {
    let relief = hills();
    let block = relief.block();
    assert_eq!(block.closed().unwrap(), block);
    assert_eq!(block.vertices[0], DVec3::new(2.25, -0.75, 0.0));
    assert_eq!(block.vertices[11], DVec3::new(3.75, -1.25, 5.0));
    let period = relief.field.period();
    let (mesh, wrap) = relief.periodic(period);
    assert_eq!(mesh.closed().unwrap(), mesh);
    // The mean height over a period is that of the heights: each is the corner of six triangles.
    assert!((mesh.volume() - period.element_product() * (5.5 + 2.0)).abs() < 1e-12);
    assert_eq!(wrap.faces(&mesh).count(), 2 * 12 + 2);
    // Whatever repeats is moved by periods: the corners are where the mesh has them.
    for (i, p) in mesh.vertices.iter().enumerate() {
        let (twin, by) = wrap.origin(i as u32, [0, 0]);
        let moved =
            mesh.vertices[twin as usize] + DVec3::new(f64::from(by[0]) * period.x, f64::from(by[1]) * period.y, 0.0);
        assert!(moved.distance(*p) < 1e-15, "{i}: {moved} {p}");
    }
    // Without sides: in a torus of one period every edge is passed once in each direction.
    let mut edges = std::collections::HashMap::new();
    for t in wrap.faces(&mesh) {
        for k in 0..3 {
            let [(p, by_p), (q, by_q)] = [t[k], t[(k + 1) % 3]].map(|corner| wrap.origin(corner, [0, 0]));
            let by = [by_q[0] - by_p[0], by_q[1] - by_p[1]];
            *edges.entry((p, q, by)).or_insert(0) += 1;
            *edges.entry((q, p, by.map(|x| -x))).or_insert(0) -= 1;
        }
    }
    assert!(edges.values().all(|&n| n == 0));
}
