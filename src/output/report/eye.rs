//! Colours of spectra that are known at some wavelengths only.

use std::convert::Infallible;

use crate::colour;

/// Light beyond these, nm, adds little to a colour.
const SEEN_NM: (f64, f64) = (400.0, 700.0);

/// What each wavelength adds to X, Y and Z in daylight, if the spectrum goes straight from each to the next and stays as it
/// is beyond the ends: X, Y, Z = Σ share · weight. None if the ends leave out some of what is visible.
pub fn weights(wavelength_nm: &[f64]) -> Option<Vec<[f64; 3]>> {
    let (first, last) = (*wavelength_nm.first()?, *wavelength_nm.last()?);
    if first > SEEN_NM.0 || last < SEEN_NM.1 {
        return None;
    }
    let weight = |w: usize| {
        let xyz: Result<_, Infallible> = colour::xyz(|nm| Ok(part(wavelength_nm, w, nm)));
        xyz.unwrap_or_default()
    };
    Some((0..wavelength_nm.len()).map(weight).collect())
}

/// What of the spectrum at `nm` is that at wavelength `w`.
fn part(all: &[f64], w: usize, nm: f64) -> f64 {
    let i = all.partition_point(|&x| x <= nm);
    match i {
        0 => f64::from(u8::from(w == 0)),
        i if i == all.len() => f64::from(u8::from(w + 1 == i)),
        i => {
            let along = (nm - all[i - 1]) / (all[i] - all[i - 1]);
            if w == i {
                along
            } else if w + 1 == i {
                1.0 - along
            } else {
                0.0
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_give_what_the_eye_sees() {
        let all = [380.0, 420.0, 500.0, 530.0, 640.0, 700.0, 800.0];
        let spectrum = |nm: f64| 0.1 + 1e-3 * (nm - 350.0).abs();
        // Straight between the wavelengths and within them: the same as of the spectrum itself.
        let direct = colour::xyz(|nm| Ok::<_, Infallible>(spectrum(nm.clamp(380.0, 800.0)))).unwrap();
        let weights = weights(&all).unwrap();
        for i in 0..3 {
            let sum: f64 = all.iter().zip(&weights).map(|(&nm, weight)| spectrum(nm) * weight[i]).sum();
            assert!((sum - direct[i]).abs() < 1e-12, "{sum} {}", direct[i]);
        }
    }

    #[test]
    fn what_is_not_measured_has_no_colour() {
        assert!(weights(&[]).is_none() && weights(&[550.0]).is_none());
        assert!(weights(&[410.0, 700.0]).is_none() && weights(&[400.0, 690.0]).is_none());
        assert!(weights(&[400.0, 700.0]).is_some());
    }
}
