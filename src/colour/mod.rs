//! The colour of a spectrum to the eye: CIE 1931 2° observer, daylight D65, sRGB.

use std::fmt;

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

/// A wavelength at which the eye sees daylight.
struct Sample {
    nm: f64,
    /// x̄, ȳ, z̄ times D65.
    weight: [f64; 3],
}

fn samples() -> impl Iterator<Item = Sample> {
    TABLE.lines().filter(|line| !line.starts_with('#')).map(|line| {
        let mut fields = line.split(',').filter_map(|field| field.parse::<f64>().ok());
        let mut next = || fields.next().unwrap_or_default();
        let (nm, bars, daylight) = (next(), [next(), next(), next()], next());
        Sample { nm, weight: bars.map(|bar| bar * daylight) }
    })
}

/// X, Y, Z of what reflects the share `spectrum`(λ in nm) of daylight; Y is 1 for a perfect reflector.
///
/// # Errors
/// The first error of `spectrum`.
pub fn xyz<E>(mut spectrum: impl FnMut(f64) -> Result<f64, E>) -> Result<[f64; 3], E> {
    let (mut sum, mut white) = ([0.0; 3], 0.0);
    for sample in samples() {
        let share = spectrum(sample.nm)?;
        sum = std::array::from_fn(|i| sum[i] + share * sample.weight[i]);
        white += sample.weight[1];
    }
    Ok(sum.map(|x| x / white))
}

/// The nearest colour a screen can show: channels beyond its gamut are cut off.
pub fn srgb(xyz: [f64; 3]) -> Srgb {
    const FROM_XYZ: [[f64; 3]; 3] = [
        [3.240_454_2, -1.537_138_5, -0.498_531_4],
        [-0.969_266_0, 1.876_010_8, 0.041_556_0],
        [0.055_643_4, -0.204_025_9, 1.057_225_2],
    ];
    Srgb(FROM_XYZ.map(|row| {
        let linear: f64 = row.iter().zip(xyz).map(|(m, x)| m * x).sum();
        (255.0 * encoded(linear.clamp(0.0, 1.0))).round() as u8
    }))
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
        let y: f64 = samples().map(|s| s.weight[1]).sum();
        assert!((y * 5.0 - 10_567.0).abs() < 20.0, "{y}");
    }
}
