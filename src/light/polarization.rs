//! The state of polarization of the incident light.

use std::fmt;
use std::str::FromStr;

/// State of the incident light, and whether one state is asked for or all.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Polarization {
    /// Equal, incoherent parts of s and p.
    Unpolarized,
    /// Electric field perpendicular to the plane of incidence.
    S,
    /// Electric field in the plane of incidence.
    P,
    /// The Stokes vector (1, Q, U, V), Q = I_p − I_s, U + iV = 2 E_p E_s*.
    Stokes([f64; 4]),
    /// Every state: the result has Mueller matrices besides what unpolarized light becomes.
    Mueller,
}

impl Polarization {
    /// Stokes vector of the incident light in the frame (p̂, ŝ), of unit power.
    pub fn stokes(&self) -> [f64; 4] {
        match *self {
            Self::Unpolarized | Self::Mueller => [1.0, 0.0, 0.0, 0.0],
            Self::S => [1.0, -1.0, 0.0, 0.0],
            Self::P => [1.0, 1.0, 0.0, 0.0],
            Self::Stokes(stokes) => stokes,
        }
    }

    /// Shares of the power that are s and p.
    pub fn shares(&self) -> [f64; 2] {
        let [i, q, ..] = self.stokes();
        [0.5 * (i - q), 0.5 * (i + q)]
    }
}

impl fmt::Display for Polarization {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Unpolarized => f.write_str("unpolarized"),
            Self::S => f.write_str("s"),
            Self::P => f.write_str("p"),
            Self::Stokes([i, q, u, v]) => write!(f, "{i},{q},{u},{v}"),
            Self::Mueller => f.write_str("mueller"),
        }
    }
}

/// A polarization that is more than the light.
const OVER: f64 = 1e-9;

impl FromStr for Polarization {
    type Err = String;

    fn from_str(s: &str) -> Result<Self, String> {
        match s {
            "unpolarized" => Ok(Self::Unpolarized),
            "s" => Ok(Self::S),
            "p" => Ok(Self::P),
            "mueller" => Ok(Self::Mueller),
            _ => stokes(s).map(Self::Stokes),
        }
    }
}

/// Four numbers, scaled to unit power.
fn stokes(s: &str) -> Result<[f64; 4], String> {
    let wrong = || format!("`{s}`: expected unpolarized, s, p, mueller, or a Stokes vector I,Q,U,V such as 1,0,0.5,0");
    let numbers: Result<Vec<f64>, _> = s.split(',').map(|x| x.trim().parse::<f64>()).collect();
    let [i, q, u, v] = numbers.map_err(|_| wrong())?[..] else { return Err(wrong()) };
    if ![i, q, u, v].iter().all(|x| x.is_finite()) || i <= 0.0 {
        return Err(format!("`{s}`: expected finite numbers, the first (the power) greater than 0"));
    }
    let polarized = (q * q + u * u + v * v).sqrt() / i;
    if polarized > 1.0 + OVER {
        return Err(format!(
            "`{s}`: expected Q² + U² + V² ≤ I²; here the polarized part is {polarized:.3} of the light"
        ));
    }
    Ok([1.0, q / i, u / i, v / i])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn states_are_read_and_written() {
        for text in ["unpolarized", "s", "p", "mueller", "1,0,0.5,-0.25"] {
            assert_eq!(text.parse::<Polarization>().unwrap().to_string(), text);
        }
        assert_eq!("2,0,1,0".parse::<Polarization>().unwrap(), Polarization::Stokes([1.0, 0.0, 0.5, 0.0]));
        for (text, why) in [
            ("1,1,1,0", "Q² + U² + V²"),
            ("0,0,0,0", "greater than 0"),
            ("1,0,0", "expected unpolarized"),
            ("1,NaN,0,0", "finite"),
        ] {
            assert!(text.parse::<Polarization>().unwrap_err().contains(why), "{text}");
        }
    }

    #[test]
    fn shares_are_those_of_s_and_p() {
        assert_eq!(Polarization::S.shares(), [1.0, 0.0]);
        assert_eq!(Polarization::P.shares(), [0.0, 1.0]);
        assert_eq!(Polarization::Stokes([1.0, 0.5, 0.5, 0.0]).shares(), [0.25, 0.75]);
    }
}
