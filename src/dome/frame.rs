//! Frames for the polarization of light that leaves.
//!
//! The frame of s and p turns by 360° around a pole, so that light of a facet near to it would be added up in all
//! directions. Until a facet is whole its light is told in a frame that has no such place on its hemisphere: x̂ carried
//! from the pole without a turn. At the end the whole facet is turned, by one angle, to where x̂ at its centre is θ̂,
//! the direction of growing polar angle: p.

use glam::DVec3;

use super::geodesic::Facet;

impl Facet {
    /// Cosine and sine of the angle about `dir`, a direction in this facet, from the frame its light is told in to θ̂ there.
    pub fn turn_to_theta(self, dir: DVec3) -> [f64; 2] {
        let to_theta = |dir: DVec3| turn(dir, carried(dir), theta(dir));
        let ([c, s], [cos, sin]) = (to_theta(self.center()), to_theta(dir));
        [cos * c + sin * s, sin * c - cos * s]
    }
}

/// x̂ carried to `dir` from the pole of its hemisphere, along the great circle through both.
pub fn carried(dir: DVec3) -> DVec3 {
    let pole = DVec3::new(0.0, 0.0, 1.0f64.copysign(dir.z));
    DVec3::X - dir.x / (1.0 + dir.z.abs()) * (pole + dir)
}

/// Direction of growing polar angle: p of light that leaves along `dir`. At a pole, as if it were reached along φ = 0.
pub fn theta(dir: DVec3) -> DVec3 {
    let across = dir.x.hypot(dir.y);
    let [cos, sin] = if across > 0.0 { [dir.x / across, dir.y / across] } else { [1.0, 0.0] };
    DVec3::new(dir.z * cos, dir.z * sin, -across)
}

/// Cosine and sine of the angle about `dir` from one frame's x̂ to that of another.
pub fn turn(dir: DVec3, from: DVec3, to: DVec3) -> [f64; 2] {
    [from.dot(to), dir.cross(from).dot(to)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_across_their_direction() {
        for dir in [DVec3::Z, DVec3::NEG_Z, DVec3::new(0.6, 0.0, -0.8), DVec3::new(0.48, 0.64, 0.6), DVec3::Y] {
            for x in [carried(dir), theta(dir)] {
                assert!(x.dot(dir).abs() < 1e-15 && (x.length() - 1.0).abs() < 1e-15, "{dir} {x}");
            }
            let [cos, sin] = turn(dir, carried(dir), theta(dir));
            assert!((cos.hypot(sin) - 1.0).abs() < 1e-15);
        }
        assert_eq!((carried(DVec3::Z), theta(DVec3::Z), theta(DVec3::NEG_Z)), (DVec3::X, DVec3::X, DVec3::NEG_X));
        // The polar angle grows towards the horizon above, away from it below.
        assert!(theta(DVec3::new(0.6, 0.0, 0.8)).z < 0.0 && theta(DVec3::new(0.6, 0.0, -0.8)).z < 0.0);
    }

    /// Neighbouring frames differ by little everywhere on a hemisphere, also at its pole.
    #[test]
    fn carried_frames_are_smooth() {
        for tilt in [0.0, 1e-3, 0.3, 1.0, 1.5] {
            for turn in 0..12 {
                let (s, c) = f64::from(turn).sin_cos();
                let at = |t: f64, d: f64| DVec3::new(t.sin() * c - d * s, t.sin() * s + d * c, t.cos()).normalize();
                assert!(carried(at(tilt, 0.01)).distance(carried(at(tilt, 0.0))) < 0.02);
            }
        }
    }
}
