//! Cones of directions: from one into another light goes as it goes back (Helmholtz).
//!
//! With the direction of incidence drawn uniformly from cone I, the mean of cos θᵢ times the power that leaves into
//! cone O is ∬ f cos θᵢ cos θₒ dωᵢ dωₒ / |I|: symmetric in I and O, for cones of any width. Each incidence is its own
//! batch.

use glam::DVec3;
use gonio_embree::light::{Incidence, Light, Polarization};
use gonio_embree::optics::C64;
use gonio_embree::sample::description::{Body, Fill, Shape};
use gonio_embree::sample::generate::packing::Packing;
use gonio_embree::trace::Batch;
use rand::rngs::Xoshiro256PlusPlus;
use rand::{RngExt, SeedableRng};

use super::build::{Build, ball, cuboid, fibre, light};

/// Half-angle of the cones, degrees.
const HALF: f64 = 25.0;
/// Trees of a direction.
pub const TREES: u32 = 128;
/// Directions of a cone: 10⁵ and 2·10⁶ trees each way.
pub const FEW: u32 = 768;
pub const MANY: u32 = 16_384;

/// The unit vector with this polar angle and azimuth, degrees.
pub fn towards((theta, phi): (f64, f64)) -> DVec3 {
    let ((s, c), (sin, cos)) = (theta.to_radians().sin_cos(), phi.to_radians().sin_cos());
    DVec3::new(s * cos, s * sin, c)
}

/// The incidence from this direction.
pub fn incidence(d: DVec3) -> Incidence {
    Incidence { theta_deg: d.z.acos().to_degrees(), phi_deg: d.y.atan2(d.x).to_degrees() }
}

/// Whether a direction is in the cone around `axis`.
pub fn holds(axis: DVec3, dir: DVec3) -> bool {
    dir.dot(axis) > HALF.to_radians().cos()
}

/// A direction of the cone around `axis`.
fn draw(axis: DVec3, rng: &mut Xoshiro256PlusPlus) -> DVec3 {
    let c = 1.0 - rng.random::<f64>() * (1.0 - HALF.to_radians().cos());
    let (sin, cos) = (std::f64::consts::TAU * rng.random::<f64>()).sin_cos();
    let (u, v) = axis.any_orthonormal_pair();
    c * axis + (1.0 - c * c).sqrt() * (cos * u + sin * v)
}

/// Light from many directions of the cone around `from`, which points away from the sample.
pub fn light_from(from: DVec3, directions: u32, seed: u64, polarization: Polarization) -> Light {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    let incidences = (0..directions).map(|_| incidence(draw(from, &mut rng))).collect();
    Light { incidences, ..light(&[550.0], &[], polarization) }
}

/// One batch for each direction.
pub fn batches(seed: u64, directions: u32) -> Vec<Batch> {
    (0..directions).map(|incidence| Batch { seed, incidence, scramble: 0 }).collect()
}

/// Half a turn about x.
pub fn over(p: DVec3) -> DVec3 {
    DVec3::new(p.x, -p.y, -p.z)
}

/// The sample turned upside down, by half a turn about x. Frames of light from below and to below are turned by 180° at
/// that, which no Mueller matrix sees.
pub fn turned_over(build: &Build) -> Build {
    let mut d = build.0.clone();
    for object in &mut d.objects {
        let Body::Solid(shape, _) = &mut object.body else { panic!("no films here") };
        match shape {
            Shape::Sphere { center, .. } => *center = over(*center),
            Shape::Cylinder(f) => (f.from, f.to) = (over(f.from), over(f.to)),
            Shape::Cuboid { min, max } => {
                let (a, b) = (over(*min), over(*max));
                (*min, *max) = (a.min(b), a.max(b));
            }
            Shape::Slab { top, bottom } => (*top, *bottom) = (-*bottom, -*top),
            Shape::Relief(_) => panic!("no reliefs here"),
            Shape::Mesh(mesh) => mesh.vertices.iter_mut().for_each(|v| *v = over(*v)),
        }
    }
    Build(d)
}

pub fn spheres() -> Build {
    let size = DVec3::new(20.0, 20.0, 12.0);
    Build::within(1.0).packing(&Packing { count: 350, radius: 1.0, size, periodic: true, seed: 3 }, 1.5)
}

/// Nothing about it is symmetric; there is total reflection, metal, absorption and a matt ball.
pub fn lopsided() -> Build {
    Build::within(1.0)
        .patch(12.0, 9.0)
        .put(cuboid([-5.0, -4.0, 0.0], [-1.0, 1.0, 2.0]), 1.5)
        .put(ball([3.0, 1.0, 5.0], 2.5), C64::new(1.4, 5e-3))
        .put(ball([-3.5, -3.0, 4.5], 1.0), C64::new(0.96, 6.69))
        .put(Shape::from(fibre([-5.0, 3.0, 2.0], [1.0, -3.0, 6.0], 1.0)), 1.7)
        .fill(ball([3.0, -3.0, 1.5], 1.2), Fill::Diffuse(0.7))
}
