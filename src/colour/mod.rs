//! The colour of a spectrum to the eye: CIE 1931 2° observer, daylight D65 or lamplight A, sRGB, CIELAB.

mod lab;

use std::fmt;

use crate::text::words;

pub use lab::{delta_e_76, delta_e_2000, lab};

/// Wavelength in nm, x̄, ȳ, z̄ and the power of D65, every 5 nm, as of ISO/CIE 11664-1 and 11664-2.
const TABLE: &str = include_str!("cie_5nm.csv");

/// A colour of sRGB (IEC 61966-2-1), one byte per channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Srgb(pub [u8; 3]);

impl fmt::Display for Srgb {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [r, g, b] = self.0;
        write!(f, "#{r:02x}{g:02x}{b:02x}")
    }
}

/// What shines.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Illuminant {
    /// Daylight.
    #[default]
    D65,
    /// Lamplight: a black body of 2856 K.
    A,
}

impl Illuminant {
    /// X, Y, Z of a perfect reflector; Y is 1.
    pub fn white(self) -> [f64; 3] {
        xyz_under(self, |_| 1.0)
    }

    /// Power at a wavelength in nm, of which `daylight` is that of D65; relative.
    fn power(self, nm: f64, daylight: f64) -> f64 {
        match self {
            Self::D65 => daylight,
            // ISO/CIE 11664-2, eq. 1.
            Self::A => {
                let planck = |nm: f64| nm.powi(-5) / (1.435e7 / (2848.0 * nm)).exp_m1();
                100.0 * planck(nm) / planck(560.0)
            }
        }
    }
}

words!(Illuminant { D65 = "D65", A = "A" });

/// A wavelength at which the eye sees.
struct Sample {
    nm: f64,
    /// x̄, ȳ, z̄.
    bars: [f64; 3],
    /// D65.
    daylight: f64,
}

fn samples() -> impl Iterator<Item = Sample> {
    TABLE.lines().filter(|line| !line.starts_with('#')).map(|line| {
        let mut fields = line.split(',').filter_map(|field| field.parse::<f64>().ok());
        let mut next = || fields.next().unwrap_or_default();
        Sample { nm: next(), bars: [next(), next(), next()], daylight: next() }
    })
}

/// X, Y, Z of what reflects the share `spectrum`(λ in nm) of daylight; Y is 1 for a perfect reflector.
///
/// # Errors
/// The first error of `spectrum`.
pub fn xyz<E>(spectrum: impl FnMut(f64) -> Result<f64, E>) -> Result<[f64; 3], E> {
    weighted(Illuminant::D65, spectrum)
}

/// X, Y, Z of what reflects the share `spectrum`(λ in nm) of an illuminant; Y is 1 for a perfect reflector.
pub fn xyz_under(illuminant: Illuminant, mut spectrum: impl FnMut(f64) -> f64) -> [f64; 3] {
    match weighted(illuminant, |nm| Ok::<_, std::convert::Infallible>(spectrum(nm))) {
        Ok(xyz) => xyz,
    }
}

fn weighted<E>(illuminant: Illuminant, mut spectrum: impl FnMut(f64) -> Result<f64, E>) -> Result<[f64; 3], E> {
    let (mut sum, mut white) = ([0.0; 3], 0.0);
    for sample in samples() {
        let power = illuminant.power(sample.nm, sample.daylight);
        let share = spectrum(sample.nm)?;
        sum = std::array::from_fn(|i| sum[i] + share * power * sample.bars[i]);
        white += power * sample.bars[1];
    }
    Ok(sum.map(|x| x / white))
}

/// Wavelengths that must be known for a colour, nm: what lies beyond adds less than 1 % to Y.
pub const VISIBLE_NM: (f64, f64) = (420.0, 680.0);
/// Widest gap between wavelengths of which a colour is told, nm.
pub const WIDEST_GAP_NM: f64 = 40.0;

/// What each of some wavelengths (nm, ascending) adds to X, Y and Z, so that these are sums over a measured spectrum: it is
/// taken to go straight between wavelengths and to stay constant beyond them. None where they do not tell a colour.
pub fn weights(illuminant: Illuminant, wavelength_nm: &[f64]) -> Option<Vec<[f64; 3]>> {
    let (first, last) = (*wavelength_nm.first()?, *wavelength_nm.last()?);
    let gaps = wavelength_nm.windows(2).map(|w| w[1] - w[0]);
    if first > VISIBLE_NM.0 || last < VISIBLE_NM.1 || gaps.fold(0.0, f64::max) > WIDEST_GAP_NM {
        return None;
    }
    let mut weights = vec![[0.0; 3]; wavelength_nm.len()];
    let white: f64 = samples().map(|s| illuminant.power(s.nm, s.daylight) * s.bars[1]).sum();
    for sample in samples() {
        let power = illuminant.power(sample.nm, sample.daylight) / white;
        let after = wavelength_nm.partition_point(|&nm| nm < sample.nm);
        let (high, low) = (after.min(wavelength_nm.len() - 1), after.saturating_sub(1));
        let span = wavelength_nm[high] - wavelength_nm[low];
        let share = if span > 0.0 { ((sample.nm - wavelength_nm[low]) / span).clamp(0.0, 1.0) } else { 0.0 };
        for (at, share) in [(low, 1.0 - share), (high, share)] {
            weights[at] = std::array::from_fn(|i| weights[at][i] + share * power * sample.bars[i]);
        }
    }
    Some(weights)
}

/// X, Y, Z from the [`weights`] and the values at their wavelengths.
pub fn summed(weights: &[[f64; 3]], values: impl IntoIterator<Item = f64>) -> [f64; 3] {
    let add = |sum: [f64; 3], (w, v): (&[f64; 3], f64)| std::array::from_fn(|i| sum[i] + w[i] * v);
    weights.iter().zip(values).fold([0.0; 3], add)
}

/// The nearest colour a screen can show: channels beyond its gamut are cut off.
pub fn srgb(xyz: [f64; 3]) -> Srgb {
    Srgb(linear_srgb(xyz).map(|linear| (255.0 * encoded(linear.clamp(0.0, 1.0))).round() as u8))
}

/// Linear channels of sRGB, beyond 0 to 1 where the colour is out of its gamut.
pub fn linear_srgb(xyz: [f64; 3]) -> [f64; 3] {
    const FROM_XYZ: [[f64; 3]; 3] = [
        [3.240_454_2, -1.537_138_5, -0.498_531_4],
        [-0.969_266_0, 1.876_010_8, 0.041_556_0],
        [0.055_643_4, -0.204_025_9, 1.057_225_2],
    ];
    FROM_XYZ.map(|row| row.iter().zip(xyz).map(|(m, x)| m * x).sum())
}

/// Gamma of sRGB.
fn encoded(linear: f64) -> f64 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seen(spectrum: impl Fn(f64) -> f64) -> [f64; 3] {
        xyz(|nm| Ok::<_, ()>(spectrum(nm))).unwrap()
    }

    #[test]
    fn daylight_is_white() {
        let [x, y, z] = seen(|_| 1.0);
        let sum = x + y + z;
        assert!((x / sum - 0.3127).abs() < 1e-4 && (y / sum - 0.3290).abs() < 1e-4, "{x} {y} {z}");
        assert!((y - 1.0).abs() < 1e-12);
        assert!(srgb([x, y, z]).0.iter().all(|&c| c >= 254));
        assert_eq!(srgb(seen(|_| 0.0)).to_string(), "#000000");
        assert!(srgb(seen(|_| 0.5)).0.iter().all(|&c| c.abs_diff(188) <= 1));
    }

    #[test]
    fn bands_have_their_colour() {
        let band = |low: f64, high: f64| srgb(seen(|nm| f64::from(u8::from(nm >= low && nm < high)))).0;
        let ([r, g, b], [r2, g2, b2], [r3, g3, b3]) = (band(420.0, 490.0), band(510.0, 570.0), band(610.0, 700.0));
        assert!(b > r && b > g && g2 > r2 && g2 > b2 && r3 > g3 && r3 > b3);
    }

    #[test]
    fn the_table_is_whole() {
        let nm: Vec<f64> = samples().map(|s| s.nm).collect();
        assert!(nm.len() == 95 && nm[0] == 360.0 && nm.windows(2).all(|w| w[1] - w[0] == 5.0));
        let y: f64 = samples().map(|s| s.bars[1]).sum();
        assert!((y * 5.0 - 106.857).abs() < 1e-3, "{y}");
        let y: f64 = samples().map(|s| s.daylight * s.bars[1]).sum();
        assert!((y * 5.0 - 10_567.0).abs() < 20.0, "{y}");
    }

    #[test]
    fn illuminants_have_their_white() {
        let close = |a: [f64; 3], b: [f64; 3]| (0..3).all(|i| (a[i] - b[i]).abs() < 1e-4);
        assert!(close(Illuminant::D65.white(), [0.950_47, 1.0, 1.088_97]), "{:?}", Illuminant::D65.white());
        assert!(close(Illuminant::A.white(), [1.098_50, 1.0, 0.355_85]), "{:?}", Illuminant::A.white());
        assert!((Illuminant::A.power(400.0, 0.0) - 14.708).abs() < 1e-3);
        assert!((Illuminant::A.power(700.0, 0.0) - 198.26).abs() < 1e-2);
    }

    #[test]
    fn weights_are_those_of_the_straight_spectrum() {
        let nm: Vec<f64> = (0..16).map(|i| 400.0 + 20.0 * f64::from(i)).collect();
        let f = |nm: f64| 0.2 + 1e-3 * (nm.clamp(400.0, 700.0) - 400.0);
        for illuminant in [Illuminant::D65, Illuminant::A] {
            let of_weights = summed(&weights(illuminant, &nm).unwrap(), nm.iter().map(|&nm| f(nm)));
            let direct = xyz_under(illuminant, f);
            assert!((0..3).all(|i| (of_weights[i] - direct[i]).abs() < 1e-12));
        }
        assert!(weights(Illuminant::D65, &[550.0]).is_none());
        assert!(weights(Illuminant::D65, &[430.0, 460.0, 500.0, 540.0, 580.0, 620.0, 660.0, 700.0]).is_none());
        assert!(weights(Illuminant::D65, &[400.0, 550.0, 700.0]).is_none() && weights(Illuminant::A, &[]).is_none());
    }
}
