//! Detectors that look at the sample through round apertures, as the arm of a goniometer does. They may overlap.

use glam::DVec3;

/// Apertures of one width on one side of the sample, whose axes lie in one plane.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Apertures {
    axes: Vec<DVec3>,
    /// Normal of their plane.
    normal: DVec3,
    /// Half of the width.
    sin: f64,
    cos: f64,
    below: bool,
}

/// Steps of the integral over an aperture.
const STEPS: u32 = 4096;

impl Apertures {
    /// Apertures around `axes` (unit vectors at right angles to `normal`) that are `width` wide, in radians, and see what
    /// goes to their side of the horizon.
    pub fn new(axes: Vec<DVec3>, normal: DVec3, width: f64, below: bool) -> Self {
        let (sin, cos) = (0.5 * width).sin_cos();
        Self { axes, normal, sin, cos, below }
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.axes.is_empty()
    }

    /// How many.
    pub fn len(&self) -> usize {
        self.axes.len()
    }

    /// Directions of their centres.
    pub fn axes(&self) -> &[DVec3] {
        &self.axes
    }

    /// Whether the aperture around `axis` sees what goes into `dir`.
    pub fn sees(&self, axis: DVec3, dir: DVec3) -> bool {
        (dir.z < 0.0) == self.below && axis.dot(dir) >= self.cos
    }

    /// Numbers of those that see what goes into `dir`.
    pub fn catching(&self, dir: DVec3) -> impl Iterator<Item = u32> + '_ {
        // Most light goes past the plane.
        let near = if self.normal.dot(dir).abs() <= self.sin { &self.axes[..] } else { &[] };
        (0u32..).zip(near).filter(move |(_, axis)| self.sees(**axis, dir)).map(|(i, _)| i)
    }

    /// Projected solid angle ∫ |cos θ| dω of an aperture, as far as it is on its side of the horizon, sr.
    pub fn projected_solid_angle(&self, axis: DVec3) -> f64 {
        let half = self.sin.atan2(self.cos);
        let height = if self.below { -axis.z } else { axis.z };
        let slope = axis.truncate().length();
        // Around the axis, at the angle r from it, cos θ = a + b cos φ; where that is negative lies the other side.
        let ring = |r: f64| {
            let (a, b) = (r.cos() * height, r.sin() * slope);
            let seen = if a >= b { std::f64::consts::PI } else { (-a / b).clamp(-1.0, 1.0).acos() };
            2.0 * (a * seen + b * seen.sin()) * r.sin()
        };
        let step = half / f64::from(STEPS);
        (0..STEPS).map(|i| step * ring((f64::from(i) + 0.5) * step)).sum()
    }

    /// Directions spread evenly over an aperture, each standing for as much of its solid angle.
    pub fn spread(&self, axis: DVec3, count: u32) -> impl Iterator<Item = DVec3> {
        let (u, v) = axis.any_orthonormal_pair();
        let golden = std::f64::consts::PI * (3.0 - 5f64.sqrt());
        let depth = 1.0 - self.cos;
        (0..count).map(move |i| {
            let cos = 1.0 - depth * (f64::from(i) + 0.5) / f64::from(count);
            let (sin_phi, cos_phi) = (f64::from(i) * golden).sin_cos();
            cos * axis + (1.0 - cos * cos).sqrt() * (cos_phi * u + sin_phi * v)
        })
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    fn at(degrees: f64) -> DVec3 {
        let (sin, cos) = f64::to_radians(degrees).sin_cos();
        DVec3::new(sin, 0.0, cos)
    }

    #[test]
    fn apertures_have_the_solid_angles_of_caps() {
        let some = Apertures::new(vec![at(0.0)], DVec3::Y, 0.1, false);
        let cap = PI * f64::sin(0.05).powi(2);
        for degrees in [0.0, 40.0, 80.0] {
            let angle = some.projected_solid_angle(at(degrees));
            assert!((angle - cap * degrees.to_radians().cos()).abs() < 1e-9, "{degrees}°: {angle}");
        }
        // Half of it lies above the horizon: ∫ sin r · 2 sin r dr.
        let half: f64 = 0.05 - 0.5 * f64::sin(0.1);
        assert!((some.projected_solid_angle(at(90.0)) - half).abs() < 1e-9);
        let whole = Apertures::new(vec![at(0.0)], DVec3::Y, PI, false);
        assert!((whole.projected_solid_angle(DVec3::Z) - PI).abs() < 1e-6);
    }

    #[test]
    fn apertures_catch_what_they_see() {
        let axes: Vec<DVec3> = (-2..=2).map(|i| at(f64::from(i))).collect();
        let some = Apertures::new(axes, DVec3::Y, f64::to_radians(2.5), false);
        let caught = |dir: DVec3| some.catching(dir).collect::<Vec<_>>();
        assert_eq!(caught(at(0.1)), [1, 2, 3]);
        assert_eq!(caught(at(3.0)), [4]);
        assert!(caught(at(3.5)).is_empty() && caught(-at(0.0)).is_empty());
        assert!(caught(DVec3::new(0.0, 0.03, 1.0).normalize()).is_empty());
        assert!(some.spread(at(1.0), 100).all(|d| some.sees(at(1.0), d) && (d.length() - 1.0).abs() < 1e-12));
    }
}
