//! Samples and lights for tests, built without files.

use glam::{DVec2, DVec3};
use gonio_embree::light::{Incidence, Light, Polarization, SourceMode, Wavelengths};
use gonio_embree::media::Dispersion;
use gonio_embree::optics::C64;
use gonio_embree::sample::description::{Body, Description, Fibre, Fill, Medium, Named, Object, Patch, Shape, Sides};
use gonio_embree::sample::generate::bricks::Bricks;
use gonio_embree::sample::generate::packing::Packing;
use gonio_embree::sample::problem::Place;
use gonio_embree::sample::relief::{HeightField, Relief};
use gonio_embree::sample::{Sample, mesh};

use super::Mesh;

/// A sample in the making. Media are named after their index.
#[derive(Clone)]
pub struct Build(pub Description);

fn named(name: impl AsRef<str>) -> Named {
    Named { name: name.as_ref().into(), place: Place::default() }
}

impl Build {
    /// Nothing yet, in a medium of index `n`.
    pub fn within(n: f64) -> Self {
        let mut build = Self(Description::default());
        let around = build.medium(n);
        (build.0.above, build.0.below) = (around.clone(), around);
        build
    }

    /// The name of a medium of this index.
    pub fn medium(&mut self, n: impl Into<C64>) -> Named {
        let n = n.into();
        self.define(format!("{:?}+{:?}i", n.re, n.im), Dispersion::Constant(n))
    }

    /// The name of a medium with Cauchy's index a + b/λ², λ in nm.
    pub fn cauchy(&mut self, a: f64, b: f64) -> Named {
        self.define(format!("cauchy {a:?} {b:?}"), Dispersion::Cauchy { a, b })
    }

    fn define(&mut self, name: String, dispersion: Dispersion) -> Named {
        if self.0.media.iter().all(|m| m.name != name) {
            self.0.media.push(Medium { name: name.clone(), dispersion, place: Place::default() });
        }
        named(name)
    }

    /// The medium below.
    pub fn below(mut self, n: impl Into<C64>) -> Self {
        self.0.below = self.medium(n);
        self
    }

    /// Nothing beside the patch.
    pub fn open(mut self) -> Self {
        self.0.sides = Sides::Open;
        self
    }

    /// The footprint, around the origin.
    pub fn patch(mut self, x: f64, y: f64) -> Self {
        self.0.patch = Some(Patch { size: DVec2::new(x, y), center: DVec2::ZERO });
        self
    }

    /// A body of index `n`.
    pub fn put(mut self, shape: Shape, n: impl Into<C64>) -> Self {
        let medium = self.medium(n);
        self.fill(shape, Fill::Medium(medium))
    }

    /// A body of a built-in medium.
    pub fn made_of(self, shape: Shape, name: &str) -> Self {
        self.fill(shape, Fill::Medium(named(name)))
    }

    /// A body; endless ones give way to others.
    pub fn fill(mut self, shape: Shape, fill: Fill) -> Self {
        let priority = if matches!(shape, Shape::Slab { .. }) { -1 } else { 0 };
        self.add(Body::Solid(shape, fill), priority);
        self
    }

    /// A fibre of index `n` with a lumen of index `inner` and radius `radius`.
    pub fn hollow(mut self, fibre: Fibre, n: impl Into<C64>, radius: f64, inner: impl Into<C64>) -> Self {
        let lumen = Some((radius, self.medium(inner)));
        self.put(Fibre { lumen, ..fibre }.into(), n)
    }

    /// Films from `top` down, (index, thickness).
    pub fn films<N: Into<C64> + Copy>(mut self, top: f64, layers: &[(N, f64)]) -> Self {
        let layers = layers.iter().map(|&(n, d)| (self.medium(n), d)).collect();
        self.add(Body::Films { top, layers }, -1);
        self
    }

    /// Spheres of index `n`.
    pub fn packing(self, packing: &Packing, n: impl Into<C64> + Copy) -> Self {
        let size = packing.size;
        let empty = self.patch(size.x, size.y);
        packing.centers().unwrap().into_iter().fold(empty, |b, center| b.put(ball(center, packing.radius), n))
    }

    /// Bricks of index `n` with cores of index `core`, on their patch.
    pub fn bricks(mut self, bricks: &Bricks, n: f64, core: f64) -> Self {
        let (medium, core) = (self.medium(n), self.medium(core));
        let [x, y] = bricks.patch();
        self.0.objects.extend(Bricks { medium, core, ..bricks.clone() }.objects(&Place::default()));
        self.patch(x, y)
    }

    /// Gives the last object a priority.
    pub fn priority(mut self, priority: i32) -> Self {
        self.0.objects.last_mut().unwrap().priority = priority;
        self
    }

    fn add(&mut self, body: Body, priority: i32) {
        let name = format!("object {}", self.0.objects.len() + 1).into();
        self.0.objects.push(Object { name, body, priority, nesting: 0, place: Place::default() });
    }

    /// The finished sample.
    pub fn sample(&self, light: &Light) -> Sample {
        Sample::new(&self.0, &light.wavelengths, light.coherence()).unwrap_or_else(|e| panic!("{e}"))
    }
}

/// A sphere.
pub fn ball(center: impl Into<DVec3>, radius: f64) -> Shape {
    Shape::Sphere { center: center.into(), radius }
}

/// A box.
pub fn cuboid(min: impl Into<DVec3>, max: impl Into<DVec3>) -> Shape {
    Shape::Cuboid { min: min.into(), max: max.into() }
}

/// A solid round fibre with ends.
pub fn fibre(from: impl Into<DVec3>, to: impl Into<DVec3>, radius: f64) -> Fibre {
    Fibre { from: from.into(), to: to.into(), radius, lumen: None, flatten: None, caps: true }
}

/// A closed surface of triangles.
pub fn mesh(mesh: Mesh) -> Shape {
    Shape::Mesh(mesh::Mesh { vertices: mesh.vertices, triangles: mesh.triangles })
}

/// A box as a mesh.
pub fn mesh_box(min: impl Into<DVec3>, max: impl Into<DVec3>) -> Shape {
    Shape::Mesh(mesh::Mesh::cuboid(min.into(), max.into()))
}

/// A body under heights (of column and row) around the origin.
pub fn relief(size: [usize; 2], pixel: [f64; 2], floor: f64, height: impl Fn(usize, usize) -> f64) -> Shape {
    let [columns, rows] = size;
    let heights = (0..rows * columns).map(|i| height(i % columns, i / columns)).collect();
    let field = HeightField { columns, rows, pixel: pixel.into(), heights };
    Shape::Relief(Box::new(Relief { field, center: DVec2::ZERO, floor }))
}

/// Heights without order, from 0 to `most`.
pub fn rough(most: f64) -> impl Fn(usize, usize) -> f64 {
    move |column, row| most * ((column * 7919 + row * 104_729 + column * row * 31) % 97) as f64 / 96.0
}

/// Light of these wavelengths (nm) from these directions (degrees).
pub fn light(nm: &[f64], from: &[(f64, f64)], polarization: Polarization) -> Light {
    Light {
        wavelengths: Wavelengths::from_nm(nm.to_vec()).unwrap(),
        incidences: from.iter().map(|&(theta_deg, phi_deg)| Incidence { theta_deg, phi_deg }).collect(),
        polarization,
        source: SourceMode::Band,
    }
}
