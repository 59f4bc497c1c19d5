//! BSDF files of Radiance and LBNL WINDOW (XML): Klems matrices and tensor trees.
//!
//! Their words follow WINDOW, which sees the sample from the other side: light that comes from +z and stays there is
//! `Reflection Back`. They hold X, Y and Z at most, each normalised so that what reflects all light has 1 in each.

mod klems;
mod tree;

use std::fmt::Write as _;

use glam::DVec3;

use super::{Channels, Export, Exported, Source, refuse};
use crate::bsdf::{Blend, Lookup};
use crate::text::escaped;

pub use klems::klems;
pub use tree::tree;

/// A way through the sample.
#[derive(Clone, Copy, Debug)]
struct Way {
    /// Whether the light comes from below.
    from_below: bool,
    /// Whether it stays on its side.
    reflects: bool,
}

impl Way {
    const ALL: [Self; 4] = [
        Self { from_below: false, reflects: true },
        Self { from_below: false, reflects: false },
        Self { from_below: true, reflects: true },
        Self { from_below: true, reflects: false },
    ];

    fn name(self) -> &'static str {
        match (self.reflects, self.from_below) {
            (true, false) => "Reflection Back",
            (true, true) => "Reflection Front",
            (false, false) => "Transmission Back",
            (false, true) => "Transmission Front",
        }
    }
}

/// The result of a side, if there is one with this way through the sample.
fn measured<'a>(source: &Source<'a>, way: Way) -> Option<&'a Lookup<'a>> {
    let lookup = if way.from_below { source.back? } else { source.front };
    (way.reflects || Source::transmits(lookup)).then_some(lookup)
}

/// What the channels of the formats are made of: X, Y and Z, each 1 for what reflects all light.
struct Grey<'a> {
    channels: &'a Channels,
    white: [f64; 3],
}

impl<'a> Grey<'a> {
    fn new(source: &Source<'_>, channels: &'a Channels) -> Self {
        let white = match channels {
            Channels::Colour(_) => source.illuminant.white(),
            Channels::One(_) => [1.0; 3],
        };
        Self { channels, white }
    }

    fn xyz(&self, spectrum: &[f64]) -> [f64; 3] {
        let xyz = self.channels.xyz(spectrum);
        std::array::from_fn(|i| xyz[i] / self.white[i])
    }
}

/// One `WavelengthData` block.
struct Block {
    /// `Visible`, `CIE-X`, ...
    wavelength: &'static str,
    way: Way,
    data: String,
}

/// The file around its blocks.
fn document(source: &Source<'_>, structure: &str, basis: &str, angle_basis: &str, blocks: &[Block]) -> Vec<u8> {
    let mut out = String::from(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<WindowElement xmlns=\"http://windows.lbl.gov\" \
         xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" \
         xsi:schemaLocation=\"http://windows.lbl.gov/BSDF-v1.4.xsd\">\n\
         <WindowElementType>System</WindowElementType>\n<FileType>BSDF</FileType>\n<Optical>\n<Layer>\n",
    );
    let _ = writeln!(
        out,
        "<Material><Name>{}</Name><Manufacturer>gonio-embree {}</Manufacturer><DeviceType>Other</DeviceType></Material>",
        escaped(&source.title),
        env!("CARGO_PKG_VERSION")
    );
    let _ = writeln!(
        out,
        "<DataDefinition><IncidentDataStructure>{structure}</IncidentDataStructure>{angle_basis}</DataDefinition>"
    );
    let of_block = if angle_basis.is_empty() {
        format!("<AngleBasis>{basis}</AngleBasis>")
    } else {
        format!("<ColumnAngleBasis>{basis}</ColumnAngleBasis><RowAngleBasis>{basis}</RowAngleBasis>")
    };
    for b in blocks {
        let kind = if b.way.reflects { "BRDF" } else { "BTDF" };
        let _ = writeln!(
            out,
            "<WavelengthData><LayerNumber>System</LayerNumber><Wavelength unit=\"Integral\">{}</Wavelength>\
             <SourceSpectrum>CIE Illuminant {} 1nm.ssp</SourceSpectrum><DetectorSpectrum>ASTM E308 1931 Y.dsp</DetectorSpectrum>\n\
             <WavelengthDataBlock><WavelengthDataDirection>{}</WavelengthDataDirection>{of_block}\
             <ScatteringDataType>{kind}</ScatteringDataType><ScatteringData>\n{}</ScatteringData></WavelengthDataBlock>\
             </WavelengthData>",
            b.wavelength,
            source.illuminant,
            b.way.name(),
            b.data
        );
    }
    out += "</Layer>\n</Optical>\n</WindowElement>\n";
    out.into_bytes()
}

/// What these formats cannot hold.
fn notes(source: &Source<'_>) -> Vec<String> {
    let mut notes = Vec::new();
    if source.wavelength.is_none() {
        notes.push(
            "Radiance reads X, Y and Z only: rgl, astm, csv and npy hold spectra; --wavelength writes one wavelength"
                .into(),
        );
    }
    if source.back.is_none() {
        notes.push("light from below was not measured: --back RESULT.nc adds it".into());
    }
    let last = source.front.greatest_theta_deg();
    if last < 82.5 {
        notes.push(format!("more grazing light than at {last}° is taken to scatter as there: measure up to 85°"));
    }
    notes
}

/// A direction of the result in the frame of the sample: that of light from below was turned about x by half a turn.
fn in_sample(dir: DVec3, from_below: bool) -> DVec3 {
    if from_below { DVec3::new(dir.x, -dir.y, -dir.z) } else { dir }
}

/// The delta parts of a way through the sample: where they go in the frame of the sample, and their shares in X, Y, Z.
fn deltas(blend: &Blend<'_>, way: Way, grey: &Grey<'_>, wavelengths: usize) -> Vec<(DVec3, [f64; 3])> {
    let part = |w: usize| {
        let (share, exit) = if way.reflects {
            (blend.share(|l| &l.specular, w).value, Some(blend.mirror()))
        } else {
            (blend.share(|l| &l.undeflected, w).value, blend.straight(w))
        };
        let mut spectrum = vec![0.0; wavelengths];
        spectrum[w] = share;
        let exit = exit.filter(|_| share > 0.0)?;
        Some((in_sample(exit, way.from_below), grey.xyz(&spectrum)))
    };
    (0..wavelengths).filter_map(part).collect()
}
