//! Films that rays find in a scene of 2 mm, and all paths through one.

use std::f64::consts::TAU;

use gonio_embree::intersect::choose::Backend;
use gonio_embree::light::{Light, Polarization, SourceMode};
use gonio_embree::optics::C64;
use gonio_embree::optics::field::Jones;
use gonio_embree::plan::stacks::Marks;
use gonio_embree::plan::{Limits, Name, Options, Plan, Wanted};
use gonio_embree::trace::TreeKey;
use num_complex::Complex;

use super::Case;
use super::twin::{Stack32, offset32, seen};
use crate::common::build::{Build, ball, cuboid, light};
use crate::common::collapse::{Stack, interface_by_interface, kz_by_differences};
use crate::common::listen::{coherent_sum, listen_to};

pub fn all() -> Vec<Case> {
    let thicknesses = [("no thickness", 0.0), ("1e-3 nm", 1e-6), ("1 nm", 1e-3), ("50 nm", 0.05)];
    let films = thicknesses.map(|(name, d)| {
        let (film, name) = (Plates::new(&[(2.0, d)]), format!("film of {name}"));
        if d == 1e-6 { film.transmission(&name) } else { film.reflection(&name) }
    });
    let gap = Plates::new(&[(1.5, 0.1), (1.0, 1e-3), (1.5, 0.1)]).reflection("bricks of 100 nm with a gap of 1 nm");
    let touching = Plates::new(&[(1.5, 0.1), (1.5, 0.1)]).reflection("bricks of 100 nm that touch");
    let tree = [0.3, 2.1].map(all_paths);
    [films.to_vec(), vec![gap, touching], tree.to_vec()].concat()
}

/// Height of the uppermost face, µm: beyond 2048 units in the last place double.
const TOP: f64 = 2050.0;
const UM: f64 = 0.5;

/// Index and thickness, µm, from the top; in air.
struct Plates(Vec<(f64, f64)>);

impl Plates {
    fn new(layers: &[(f64, f64)]) -> Self {
        Self(layers.to_vec())
    }

    /// Heights of the faces.
    fn faces(&self) -> Vec<f64> {
        let mut z = TOP;
        let below = self.0.iter().map(|(_, d)| {
            z -= d;
            z
        });
        [TOP].into_iter().chain(below).collect()
    }

    /// Boxes as wide as the patch, far above a sphere. What has no thickness is no box, but may be a film.
    fn build(&self) -> Build {
        let empty = Build::within(1.0).patch(2000.0, 2000.0).put(ball([-900.0, -900.0, 60.0], 50.0), 1.5);
        let faces = self.faces();
        let plates = self.0.iter().zip(faces.windows(2));
        plates.fold(empty, |build, (&(n, d), z)| {
            if d == 0.0 {
                return build.films(TOP, &[(n, d)]);
            }
            build.put(cuboid([-1000.0, -1000.0, z[1]], [1000.0, 1000.0, z[0]]), n)
        })
    }

    /// r and t at normal incidence if rays meet only these faces, and take what is behind each for granted.
    fn answer(&self, faces: &[f64], met: &[usize]) -> [C64; 2] {
        let behind = |i: usize| C64::from(self.0.get(i).map_or(1.0, |l| l.0));
        let layers: Vec<_> = met.windows(2).map(|w| (behind(w[0]), faces[w[0]] - faces[w[1]])).collect();
        film(&layers, met.last().map_or(C64::ONE, |&i| behind(i)), 1.0, 0.0)
    }

    /// How far r is from that of the film, of which thicknesses are exact.
    fn reflection(&self, name: &str) -> Case {
        let [ours, single, naive] = self.errors()[0];
        let r = match self.truth()[0].norm() {
            0.0 => "0".into(),
            r => format!("{r:.2e}"),
        };
        Case::new(name, format!("error of r ({r})"), 0.0, ours, 1e-10).single(single).naive(STEPS, naive)
    }

    /// A film of 1e-3 nm reflects so little (4e-10 of the power) that one tree in 3·10⁹ follows it. The others carry its
    /// power, too: their field is too large by 2e-10, which is all the error.
    fn transmission(&self, name: &str) -> Case {
        let [ours, single, naive] = self.errors()[1];
        let t = self.truth()[1] - 1.0;
        Case::new(name, format!("error of t (1 + {:.2e}i)", t.im), 0.0, ours, 2e-10).single(single).naive(STEPS, naive)
    }

    fn truth(&self) -> [C64; 2] {
        let layers: Vec<_> = self.0.iter().map(|&(n, d)| (C64::from(n), d)).collect();
        film(&layers, C64::ONE, 1.0, 0.0)
    }

    /// Of r and of t: here, in float32, with small steps.
    fn errors(&self) -> [[f64; 3]; 2] {
        let faces = self.faces();
        let rounded: Vec<f64> = faces.iter().map(|&z| f64::from(z as f32)).collect();
        let single = self.answer(&rounded, &seen(&rounded, offset32));
        let naive = self.answer(&faces, &seen(&faces, |_| EPSILON));
        let (truth, ours) = (self.truth(), self.measured());
        [0, 1].map(|i| [ours, single, naive].map(|answer| (answer[i] - truth[i]).norm()))
    }

    fn measured(&self) -> [C64; 2] {
        let light = Light { source: SourceMode::Line, ..light(&[1e3 * UM], &[(0.0, 0.0)], Polarization::S) };
        let sample = self.build().sample(&light);
        let options = Options { wanted: Wanted::AUTO.with(Name::Phase, true), ..Options::default() };
        let plan = Plan::new(&sample, &light, &options);
        let heard = listen_to::<Jones>(&plan, &sample, &light, Backend::Auto, &entry());
        [true, false].map(|up| coherent_sum(&heard, &sample, &light, up, 1.0)[0])
    }
}

/// r and t of films in air, for s; t referred to the wave that met nothing.
fn film(layers: &[(C64, f64)], last: C64, cos: f64, sin: f64) -> [C64; 2] {
    let stack = Stack { first: C64::ONE, layers, last, wavelength: UM, p: false };
    let (r, t) = interface_by_interface(&stack, kz_by_differences(1.0, cos, sin, false));
    let depth: f64 = layers.iter().map(|l| l.1).sum();
    [r, t * C64::cis(-TAU * cos * depth / UM)]
}

const STEPS: &str = "rays start ε = 0.1 nm behind";
const EPSILON: f64 = 1e-4;

fn entry() -> Vec<([f64; 2], TreeKey)> {
    vec![([0.3, 0.6], TreeKey { key: 1, first: [0.5; 2] })]
}

/// Every path through a film, reflected as often as its amplitude stays above 1e-14, at 30°, against Airy's sum.
fn all_paths(thickness: f64) -> Case {
    let (n, theta) = (1.5, 30f64);
    let light = Light { source: SourceMode::Line, ..light(&[1e3 * UM], &[(theta, 30.0)], Polarization::S) };
    let sample = Build::within(1.0).films(TOP, &[(n, thickness)]).sample(&light);
    let options = Options {
        limits: Limits::whole_trees(1e-28),
        wanted: Wanted::AUTO.with(Name::Phase, true),
        ..Options::default()
    };
    let mut plan = Plan::new(&sample, &light, &options);
    plan.marks = Marks::default();
    let heard = listen_to::<Jones>(&plan, &sample, &light, Backend::Auto, &entry());
    let ours = coherent_sum(&heard, &sample, &light, true, 1.0)[0];
    let (sin, cos) = theta.to_radians().sin_cos();
    let [truth, _] = film(&[(C64::from(n), thickness)], C64::ONE, cos, sin);
    let single = paths_in_single(n as f32, theta as f32, TOP as f32 - (TOP - thickness) as f32);
    Case::new(
        format!("all paths through a film of {thickness} µm, summed"),
        "error of r",
        0.0,
        (ours - truth).norm(),
        1e-9,
    )
    .single((single - truth).norm())
}

/// r + t t′ r′ e^(2iδ) Σ (r′² e^(2iδ))^k in float32, the thickness a difference of heights, each path's phase by its length.
fn paths_in_single(n: f32, theta_deg: f32, thickness: f32) -> C64 {
    let (sin, cos) = theta_deg.to_radians().sin_cos();
    let stack =
        Stack32 { first: 1.0, cos, sin, layers: vec![], last: Complex::from(n), wavelength: UM as f32, p: false };
    let r = stack.solve().r;
    let kz = (n * n - sin * sin).sqrt();
    let mut sum = r;
    let mut amplitude = -(r * -r + 1.0) * r;
    let mut path = 0.0f32;
    for _ in 0..30 {
        path += 2.0 * kz * thickness;
        sum += amplitude * Complex::cis(TAU as f32 * path / UM as f32);
        amplitude *= r * r;
    }
    C64::new(sum.re.into(), sum.im.into())
}
