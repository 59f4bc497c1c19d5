//! Grey pictures as heights: PNG of 8 or 16 bit, TIFF of 8 or 16 bit or of floating-point heights.

use std::io::Cursor;

use tiff::ColorType;
use tiff::decoder::{Decoder, DecodingResult};

use super::{Flaw, Raw, check_count, check_size, flaw};
use crate::units::LengthUnit;

pub(super) const PNG: &[u8] = b"\x89PNG\r\n\x1a\n";

/// Little-endian and big-endian.
pub(super) const TIFF: [&[u8]; 2] = [b"II*\0", b"MM\0*"];

const ADVICE: &str = "export the heights as grey of 16 bit";

pub(super) fn parse_png(bytes: &[u8]) -> Result<Raw, Flaw> {
    let damaged = |e: &dyn std::fmt::Display| Flaw { line: None, message: format!("is damaged as a PNG picture: {e}") };
    let mut reader = png::Decoder::new(Cursor::new(bytes)).read_info().map_err(|e| damaged(&e))?;
    let info = reader.info();
    let (columns, rows) = check_size(info.width.into(), info.height.into())?;
    let (wide, white) = match (info.color_type, info.bit_depth) {
        (png::ColorType::Grayscale, png::BitDepth::Sixteen) => (true, 65535.0),
        (png::ColorType::Grayscale, png::BitDepth::Eight) => (false, 255.0),
        (colour, depth) => {
            let bits = depth as u8;
            return flaw(format!(
                "is a picture of type {colour:?} with {bits} bit: expected grey of 8 or 16 bit; {ADVICE}"
            ));
        }
    };
    // No larger than the size that was checked.
    let mut data = vec![0; columns * rows * if wide { 2 } else { 1 }];
    reader.next_frame(&mut data).map_err(|e| damaged(&e))?;
    let values = if wide {
        data.chunks_exact(2).map(|b| f64::from(u16::from_be_bytes([b[0], b[1]]))).collect()
    } else {
        data.iter().copied().map(f64::from).collect()
    };
    Ok(Raw { columns, rows, pixel: None, values, white: Some(white) })
}

pub(super) fn parse_tiff(bytes: &[u8], unit: LengthUnit) -> Result<Raw, Flaw> {
    let damaged = |e: tiff::TiffError| Flaw { line: None, message: format!("is damaged as a TIFF picture: {e}") };
    let mut decoder = Decoder::new(Cursor::new(bytes)).map_err(damaged)?;
    let (width, height) = decoder.dimensions().map_err(damaged)?;
    let (columns, rows) = check_size(width.into(), height.into())?;
    let colour = decoder.colortype().map_err(damaged)?;
    if !matches!(colour, ColorType::Gray(_)) {
        return flaw(format!("is a picture of type {colour:?}: expected grey; {ADVICE}"));
    }
    let lengths = |z: f64| unit.to_micrometres(z);
    let (values, white): (Vec<f64>, _) = match decoder.read_image().map_err(damaged)? {
        DecodingResult::U8(v) => (v.into_iter().map(f64::from).collect(), Some(255.0)),
        DecodingResult::U16(v) => (v.into_iter().map(f64::from).collect(), Some(65535.0)),
        DecodingResult::F32(v) => (v.into_iter().map(f64::from).map(lengths).collect(), None),
        DecodingResult::F64(v) => (v.into_iter().map(lengths).collect(), None),
        _ => {
            return flaw(format!("is a picture of type {colour:?}: expected 8 or 16 bit, or floating point; {ADVICE}"));
        }
    };
    check_count(values.len(), columns, rows)?;
    Ok(Raw { columns, rows, pixel: None, values, white })
}
