//! Over which paths waves of the light interfere.

use std::fmt;
use std::str::FromStr;

use super::Light;
use crate::units::show_length;

/// What each wavelength of the grid stands for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SourceMode {
    /// Its band: the coherence length is finite.
    Band,
    /// A laser line: everything plane-parallel is coherent.
    Line,
    /// A Gaussian line of this coherence length λ²/Δλ, µm; Δλ is its full width at half maximum.
    Gaussian(f64),
}

impl fmt::Display for SourceMode {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Band => f.write_str("band"),
            Self::Line => f.write_str("line"),
            Self::Gaussian(length) => write!(f, "coherence length {}", show_length(*length)),
        }
    }
}

/// The words; a coherence length is a number of its own.
impl FromStr for SourceMode {
    type Err = String;

    fn from_str(s: &str) -> Result<Self, String> {
        match s {
            "band" => Ok(Self::Band),
            "line" => Ok(Self::Line),
            _ => Err(format!("`{s}`: expected band or line")),
        }
    }
}

/// Band of a single wavelength, nm: that of the default grid.
const LONELY_BAND_NM: f64 = 20.0;

/// Over which differences of optical paths waves interfere: a tree interferes up to a path drawn for it, so that of many
/// trees the share γ(path) does, and nothing jumps when a film grows into a slab.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Coherence {
    /// Over all.
    Endless,
    /// Surely up to the first path (µm), not at all beyond the second, and in between with a γ that falls linearly.
    Falling(f64, f64),
    /// With γ = exp(−(π path/l)²/(4 ln 2)) for a length l, µm.
    Gaussian(f64),
}

impl Coherence {
    /// The path over which waves of a tree interfere, µm, for a number of the tree in [0, 1).
    #[inline]
    pub fn length(&self, number: f64) -> f64 {
        match *self {
            Self::Endless => f64::INFINITY,
            Self::Falling(full, none) => full + number * (none - full),
            Self::Gaussian(l) => {
                let exponent = -(1.0 - number).ln();
                (l / std::f64::consts::PI * (4.0 * std::f64::consts::LN_2 * exponent).sqrt()).min(self.longest())
            }
        }
    }

    /// Share of the trees whose waves interfere over a path, µm.
    pub fn degree(&self, path: f64) -> f64 {
        match *self {
            _ if path > self.longest() => 0.0,
            Self::Endless => 1.0,
            Self::Falling(full, none) => ((none - path) / (none - full)).clamp(0.0, 1.0),
            Self::Gaussian(l) => {
                let u = std::f64::consts::PI * path / l;
                (-u * u / (4.0 * std::f64::consts::LN_2)).exp()
            }
        }
    }

    /// The longest path over which anything interferes, µm; of a Gaussian line it does to less than 10⁻⁶ beyond.
    pub fn longest(&self) -> f64 {
        match *self {
            Self::Endless => f64::INFINITY,
            Self::Falling(_, none) => none,
            Self::Gaussian(l) => 2.0 * l,
        }
    }

    /// How deep stacks are searched, µm: deeper than that, light that goes straight through air is not coherent.
    pub fn depth(&self) -> f64 {
        0.5 * self.longest()
    }

    /// The path that counts of a stack with an optical path there and back, and of a depth (µm). Light that runs along a gap
    /// has a short path in a deep one: from half of the depth that is searched it counts as longer, and as the longest at the
    /// end of it, so that nothing jumps there.
    pub fn counted(&self, path: f64, depth: f64) -> f64 {
        path.max(4.0 * depth - self.longest())
    }
}

impl Light {
    /// Over which paths waves interfere. The band of a wavelength is as wide as the step of the grid; up to λ²/Δλ, the
    /// first zero of its degree of coherence at the shortest wavelength, the grid shows the fringes of films, and the
    /// value at a wavelength is that of the wavelength itself. Beyond twice that path there is none but the mean.
    pub fn coherence(&self) -> Coherence {
        match self.source {
            SourceMode::Line => Coherence::Endless,
            SourceMode::Gaussian(length) => Coherence::Gaussian(length),
            SourceMode::Band => {
                let nm = self.wavelengths.nm();
                let count = nm.len();
                let band = if count > 1 { (nm[count - 1] - nm[0]) / (count - 1) as f64 } else { LONELY_BAND_NM };
                let full = nm[0] * nm[0] / band / 1e3;
                Coherence::Falling(full, 2.0 * full)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Polarization, Wavelengths};
    use super::*;

    #[test]
    fn coherence_follows_the_band() {
        let mut light = Light {
            wavelengths: Wavelengths::from_nm((0..16).map(|i| 400.0 + 20.0 * f64::from(i)).collect()).unwrap(),
            incidences: Vec::new(),
            polarization: Polarization::Unpolarized,
            source: SourceMode::Band,
        };
        let coherence = light.coherence();
        assert_eq!(coherence, Coherence::Falling(8.0, 16.0));
        assert_eq!([4.0, 8.0, 10.0, 20.0].map(|path| coherence.degree(path)), [1.0, 1.0, 0.75, 0.0]);
        light.source = SourceMode::Line;
        assert_eq!(light.coherence().length(0.5), f64::INFINITY);
        light.source = SourceMode::Gaussian(30.0);
        assert_eq!(light.coherence().longest(), 60.0);
    }

    /// Light that goes straight through air, or steeper through denser media, has the path that it has.
    #[test]
    fn only_short_paths_in_deep_stacks_count_as_longer() {
        for coherence in [Coherence::Falling(8.0, 16.0), Coherence::Gaussian(8.0), Coherence::Endless] {
            for depth in [0.1, 2.0, 4.0, 6.0, 8.0] {
                assert_eq!(coherence.counted(2.0 * depth, depth), 2.0 * depth);
            }
            assert_eq!(coherence.counted(1.0, 4.0), 1.0);
        }
        assert_eq!(Coherence::Gaussian(8.0).counted(1.0, 8.0), 16.0);
        assert_eq!(Coherence::Endless.counted(1.0, 1e6), 1.0);
    }

    /// Of evenly spread numbers as many give a longer path as the degree of coherence says.
    #[test]
    fn lengths_have_the_degree_as_their_share() {
        for coherence in [Coherence::Falling(8.0, 16.0), Coherence::Gaussian(30.0), Coherence::Endless] {
            for path in [1.0, 7.0, 10.0, 15.0, 20.0, 40.0, 70.0] {
                let numbers = (0..100_000).map(|i| (f64::from(i) + 0.5) / 1e5);
                let share = numbers.filter(|&x| coherence.length(x) > path).count() as f64 / 1e5;
                assert!((share - coherence.degree(path)).abs() < 2e-5, "{coherence:?} {path}: {share}");
            }
        }
    }
}
