//! Pure functions on numbers in a local frame: Snell, Fresnel, film stacks, Jones matrices, absorption.
//!
//! Conventions: fields ~ exp(i(k·r − ωt)); index n + ik, k > 0 absorbs; s along ŝ = k̂ × n̂, p along p̂ = ŝ × k̂ for
//! each of the incident, reflected and transmitted wave, so that r_p = −r_s at normal incidence (Byrnes,
//! arXiv:1603.02720). Angles enter as direction cosines, never as angles: 1 − sin² loses half the digits near
//! grazing incidence.

pub mod batch;
pub mod elementary;
pub mod field;
pub mod film;
pub mod fresnel;
pub mod lanes;
pub mod table;

/// A complex number in double precision.
pub type C64 = num_complex::Complex<f64>;

/// A coefficient for each of the two linear polarizations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair<T> {
    /// Electric field perpendicular to the plane of incidence.
    pub s: T,
    /// Electric field in the plane of incidence.
    pub p: T,
}

impl<T> Pair<T> {
    /// Applies `f` to both.
    pub fn map<U>(self, mut f: impl FnMut(T) -> U) -> Pair<U> {
        Pair { s: f(self.s), p: f(self.p) }
    }
}

/// What an interface or a stack does to a power-normalised field: |coefficient|² is the share of the power.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coefficients {
    /// Reflection.
    pub r: Pair<C64>,
    /// Transmission.
    pub t: Pair<C64>,
}

/// Square root in the branch of outgoing waves: Im ≥ 0, and Re ≥ 0 where Im = 0.
///
/// The wave then decays, or travels, away from the interface. For passive media n² − kx² never lies in the
/// lower half-plane up to rounding, so the principal root with its sign turned to Im ≥ 0 is the one.
pub fn outgoing_root(z: C64) -> C64 {
    if z.im == 0.0 {
        return if z.re >= 0.0 { C64::new(z.re.sqrt(), 0.0) } else { C64::new(0.0, (-z.re).sqrt()) };
    }
    let root = z.sqrt();
    if root.im < 0.0 { -root } else { root }
}
