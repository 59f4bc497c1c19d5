//! How flakes are turned.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::{DMat3, DVec3};
use rand::{Rng, RngExt};

use super::super::super::reader::Table;
use crate::units::{self, significant};

/// How far flakes are tilted out of the plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tilt {
    /// By this angle in the mean, radians: both components of the tilt are normal, so that it has the distribution of
    /// Rayleigh.
    Mean(f64),
    /// At random: all directions of the normal alike.
    Random,
}

/// Largest mean tilt, of which the distribution of Rayleigh has nothing beyond a right angle.
const LARGEST_TILT: f64 = 20.0;

impl Tilt {
    /// A turn: about the normal by any angle, then tilted to any side.
    pub(super) fn draw(self, rng: &mut impl Rng) -> DMat3 {
        let [spin, side]: [f64; 2] = [TAU * rng.random::<f64>(), TAU * rng.random::<f64>()];
        let u: f64 = rng.random();
        let tilt = match self {
            Self::Mean(mean) => (mean / FRAC_PI_2.sqrt() * (-2.0 * (1.0 - u).ln()).sqrt()).min(FRAC_PI_2),
            // A flake has no upper side.
            Self::Random => u.acos(),
        };
        let axis = DVec3::new(-side.sin(), side.cos(), 0.0);
        DMat3::from_axis_angle(axis, tilt) * DMat3::from_rotation_z(spin)
    }
}

pub(super) fn read_tilt(t: &Table<'_>) -> Option<Tilt> {
    let Some(value) = t.get("tilt") else { return Some(Tilt::Mean(0.0)) };
    let text = value.get_ref().as_str();
    if text == Some("random") {
        return Some(Tilt::Random);
    }
    let mean = match text {
        Some(text) => units::angle(text).ok(),
        None => Some(t.angle("tilt")?),
    };
    if let Some(mean) = mean.filter(|m| (0.0..=LARGEST_TILT.to_radians()).contains(m)) {
        return Some(Tilt::Mean(mean));
    }
    let found = mean.map_or_else(
        || format!("{:?}", text.unwrap_or_default()),
        |m| format!("{} deg", significant(m.to_degrees(), 4)),
    );
    let message = format!(
        "tilt = {found}: expected the mean angle out of the plane, from 0 to {LARGEST_TILT} such as \"5 deg\", or \"random\""
    );
    t.source().note(t.place_of("tilt").problem(message));
    None
}
