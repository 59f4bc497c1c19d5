//! Scenes that are moved, scaled or turned.

use glam::{DMat3, DVec3, Vec3};
use gonio_embree::intersect::choose::Backend;
use gonio_embree::light::{Incidence, Polarization};
use gonio_embree::optics::C64;
use gonio_embree::optics::field::{Mueller, State, Stokes};
use gonio_embree::plan::{Limits, Wanted};

use super::twin::single;
use super::{Case, worst};
use crate::common::Mesh;
use crate::common::build::{Build, ball, light, mesh};
use crate::common::listen::{Heard, entries, listen};
use crate::common::matrices::{self, diagonal, distance, product, turn};

pub fn all() -> Vec<Case> {
    vec![moved(), scaled(), turned()]
}

const NM: [f64; 2] = [500.0, 520.0];
const TREES: u32 = 1000;

/// Spheres of different sizes above a film. All coordinates are exact in binary, moved by 10 mm, too.
fn spheres(at: DVec3, scale: f64) -> Build {
    let mut build = Build::within(1.0).patch(8.0 * scale, 8.0 * scale);
    build.0.patch.as_mut().unwrap().center = at.truncate();
    let build = build.films(at.z - 3.0 * scale, &[(1.75, 0.109375 * scale)]);
    (0..32).fold(build, |build, i| {
        let (x, y, z) = (f64::from(i % 4), f64::from(i / 4 % 4), f64::from(i / 16));
        let center = DVec3::new(2.0 * x - 3.0 + 0.25 * z, 2.0 * y - 3.0 - 0.125 * z, 2.0 * z);
        build.put(ball(at + scale * center, scale * (0.625 + 0.03125 * f64::from(i % 8))), 1.5)
    })
}

fn scattered(build: &Build, nm: &[f64]) -> Heard<Stokes> {
    let light = light(nm, &[(30.0, 0.0)], Polarization::P);
    let sample = build.sample(&light);
    listen(&sample, &light, Backend::Auto, Limits::default(), Wanted::AUTO, &entries(5, TREES))
}

/// Largest difference of direction or power of the rays of two runs.
fn difference(a: &Heard<Stokes>, b: &Heard<Stokes>) -> f64 {
    assert!(a.exits.len() > TREES as usize, "most trees must end in more than one exit");
    if a.exits.len() != b.exits.len() {
        return f64::INFINITY;
    }
    worst(a.exits.iter().zip(&b.exits).flat_map(|(a, b)| {
        let powers = a.fields.iter().zip(&b.fields).map(|(f, g)| (f.1.power() - g.1.power()).abs());
        powers.chain([a.dir.distance(b.dir), f64::from(a.tree.abs_diff(b.tree))])
    }))
}

/// Float32: one sphere of 1 µm, one ray through it.
fn moved() -> Case {
    let at = DVec3::new(10_000.0, -10_000.0, 10_000.0);
    let ours = difference(&scattered(&spheres(DVec3::ZERO, 1.0), &NM), &scattered(&spheres(at, 1.0), &NM));
    let single = through_a_ball(Vec3::ZERO).distance(through_a_ball(at.as_vec3()));
    Case::new("spheres and a film moved by 10 mm, all trees", "change of directions and powers", 0.0, ours, 1e-9)
        .single(single.into())
}

/// Where a ray goes that came down beside the centre of a ball of 1 µm, refracted on its way in and out.
fn through_a_ball(center: Vec3) -> Vec3 {
    let refracted = |d: Vec3, n: Vec3, ratio: f32| {
        let cos = -d.dot(n);
        ratio * d + (ratio * cos - (1.0 - ratio * ratio * (1.0 - cos * cos)).sqrt()) * n
    };
    let (o, d) = (center + Vec3::new(0.6, 0.3, 5.0), Vec3::NEG_Z);
    let Some([t, _]) = single::careful_sphere(o - center, d, 1.0) else { return Vec3::NAN };
    let p = o + t * d;
    let inside = refracted(d, p - center, 1.0 / 1.5);
    let q = p - 2.0 * (p - center).dot(inside) * inside;
    refracted(inside, center - q, 1.5)
}

fn scaled() -> Case {
    let small = scattered(&spheres(DVec3::ZERO, 1.0), &NM);
    let large = scattered(&spheres(DVec3::ZERO, 1024.0), &NM.map(|nm| 1024.0 * nm));
    let ours = difference(&small, &large);
    Case::new("the same 1024 times as large, wavelengths too", "change of directions and powers", 0.0, ours, 0.0)
}

const ALUMINIUM: C64 = C64::new(0.96, 6.69);
/// Direction of the light, and how the mirror's normal leans.
const THETA: f64 = 10.0;
const LEANING: [f64; 3] = [-0.375, -0.25, 1.0];

/// The mirror is the roof of a prism; light and prism are turned about z together.
fn turned() -> Case {
    let (truth, single, naive) = (mirror(), mirror_in_single(), mirror_by_acos());
    let ours = worst([0.0, 37.0, 90.0, 200.0].map(|phi| distance(&measured_mirror(phi), &truth)));
    Case::new(
        "leaning mirror and light turned by 0°, 37°, 90°, 200°",
        "Mueller matrix, largest error",
        0.0,
        ours,
        1e-12,
    )
    .single(distance(&single, &truth))
    .naive("frames by acos", distance(&naive, &truth))
}

fn measured_mirror(phi: f64) -> matrices::Mueller {
    let [nx, ny, _] = LEANING;
    let about = DMat3::from_rotation_z(phi.to_radians());
    let roof = |x: f64, y: f64| -(nx * x + ny * y);
    let shape = Mesh::cube().map(|p| {
        let (x, y) = (8.0 * p.x - 4.0, 8.0 * p.y - 4.0);
        about * DVec3::new(x, y, if p.z > 0.5 { roof(x, y) } else { -20.0 })
    });
    let light = light(&[550.0], &[(THETA, phi)], Polarization::Mueller);
    let sample = Build::within(1.0).open().patch(0.5, 0.5).put(mesh(shape), ALUMINIUM).sample(&light);
    let entries = vec![entries(1, 1)[0]];
    let heard = listen::<Mueller>(&sample, &light, Backend::Auto, Limits::default(), Wanted::AUTO, &entries);
    let [exit] = &heard.exits[..] else { return [f64::NAN; 16] };
    let growing = growing_theta(exit.dir);
    let turned = turn(growing.dot(exit.frame), growing.dot(exit.dir.cross(exit.frame)));
    product(&turned, &exit.fields[0].1.rows())
}

/// θ̂ of a direction.
fn growing_theta(dir: DVec3) -> DVec3 {
    let across = dir.truncate().length();
    (dir.truncate() * dir.z / across).extend(-across)
}

/// Unit vectors of the mirror at φ = 0: of light that comes k and x̂ = p̂ of the instrument; the normal; of light that
/// leaves k and θ̂.
fn directions() -> [DVec3; 5] {
    let incidence = Incidence { theta_deg: THETA, phi_deg: 0.0 };
    let (k, n) = (incidence.propagation(), DVec3::from(LEANING).normalize());
    let out = k - 2.0 * k.dot(n) * n;
    [k, incidence.p_direction(), n, out, growing_theta(out)]
}

/// Fresnel between rotations of frames (Jones and Mueller as everywhere: p, s). `cos` and `sin` of the rotations from x̂ to p̂
/// before, and from p̂ to θ̂ behind.
fn between(cos_theta: f64, before: [f64; 2], behind: [f64; 2]) -> matrices::Mueller {
    let n = ALUMINIUM;
    let cos = (1.0 - (1.0 - cos_theta * cos_theta) / (n * n)).sqrt();
    let r_p = (n * cos_theta - cos) / (n * cos_theta + cos);
    let r_s = (cos_theta - n * cos) / (cos_theta + n * cos);
    let [before, behind] = [before, behind].map(|[cos, sin]| turn(cos, sin));
    product(&behind, &product(&diagonal(r_p, r_s), &before))
}

fn mirror() -> matrices::Mueller {
    let [k, x, n, out, theta] = directions();
    let s = k.cross(n).normalize();
    let (p, p_out) = (s.cross(k), s.cross(out));
    between(-k.dot(n), [x.dot(p), p.dot(k.cross(x))], [theta.dot(p_out), theta.dot(s)])
}

/// All directions in float32.
fn mirror_in_single() -> matrices::Mueller {
    let [k, x, n, _, _] = directions().map(|v| v.as_vec3());
    let (s, out) = (k.cross(n).normalize(), k - 2.0 * k.dot(n) * n);
    let across = out.truncate().length();
    let theta = (out.truncate() * out.z / across).extend(-across);
    let (p, p_out) = (s.cross(k), s.cross(out));
    let pair = |a: f32, b: f32| [a.into(), b.into()];
    between((-k.dot(n)).into(), pair(x.dot(p), p.dot(k.cross(x))), pair(theta.dot(p_out), theta.dot(s)))
}

/// An angle from its cosine has no sign.
fn mirror_by_acos() -> matrices::Mueller {
    let [k, x, n, out, theta] = directions();
    let s = k.cross(n).normalize();
    let angle = |cos: f64| [cos.acos().cos(), cos.acos().sin()];
    between(-k.dot(n), angle(x.dot(s.cross(k))), angle(theta.dot(s.cross(out))))
}
