//! The facets as a structured array of numpy (NEP 1): `np.load(path)`, `pd.DataFrame(np.load(path))`.

use super::rows::{Row, rows};
use super::{Exported, Source};

/// Fields in the order of the bytes, with their types.
const FIELDS: [(&str, &str); 11] = [
    ("theta_i", "<f8"),
    ("phi_i", "<f8"),
    ("theta_o", "<f8"),
    ("phi_o", "<f8"),
    ("wavelength", "<f8"),
    ("bsdf", "<f8"),
    ("se", "<f8"),
    ("solid_angle", "<f8"),
    ("projected_solid_angle", "<f8"),
    ("trees", "<u8"),
    ("part", "|u1"),
];
/// The magic, version 1.0.
const MAGIC: &[u8] = b"\x93NUMPY\x01\x00";
/// What comes before the data is a multiple of this.
const ALIGNMENT: usize = 64;

pub fn write(source: &Source<'_>) -> Exported {
    let rows: Vec<Row> = rows(source).collect();
    let mut bytes = header(rows.len());
    for r in &rows {
        let numbers = [
            r.theta_i,
            r.phi_i,
            r.theta_o,
            r.phi_o,
            r.wavelength,
            r.bsdf,
            r.se,
            r.solid_angle,
            r.projected_solid_angle,
        ];
        numbers.iter().for_each(|x| bytes.extend(x.to_le_bytes()));
        bytes.extend(r.trees.to_le_bytes());
        bytes.push(r.part);
    }
    Exported { bytes, notes: Vec::new() }
}

fn header(rows: usize) -> Vec<u8> {
    let fields: Vec<String> = FIELDS.iter().map(|(name, dtype)| format!("('{name}', '{dtype}')")).collect();
    let mut text = format!("{{'descr': [{}], 'fortran_order': False, 'shape': ({rows},), }}", fields.join(", "));
    let before = MAGIC.len() + size_of::<u16>();
    while !(before + text.len() + 1).is_multiple_of(ALIGNMENT) {
        text.push(' ');
    }
    text.push('\n');
    [MAGIC, &(text.len() as u16).to_le_bytes(), text.as_bytes()].concat()
}
