//! Whole trees against an independent tracer: polarization ray tracing in global coordinates, where no ray has a frame.

use crate::common::matrices;
use crate::common::oracle;
use std::cell::Cell;

use crate::common::Mesh;
use crate::common::build::{Build, ball, light, mesh};
use crate::common::listen::{Entries, Leaving, entries, listen_to};
use crate::common::oracle::{C64, Exit, Form, Solid, World, along, apply, field};
use glam::{DMat3, DVec3};
use gonio_embree::intersect::choose::Backend;
use gonio_embree::light::{Light, Polarization};
use gonio_embree::optics::field::{Field, Jones, Mueller, Stokes};
use gonio_embree::plan::stacks::Marks;
use gonio_embree::plan::{Limits, Options, Plan};

/// Branches of less power are not followed.
const FAINTEST: f64 = 1e-6;
/// Largest difference of fields, and of directions and places.
const ACCURACY: f64 = 1e-9;
const SAME: f64 = 1e-6;

const INCIDENCES: [(f64, f64); 5] = [(0.0, 0.0), (0.0, 70.0), (25.0, 10.0), (50.0, 160.0), (75.0, 290.0)];

/// Six pure states, and one that is polarized in part.
const STATES: [[f64; 4]; 7] = [
    [1.0, 1.0, 0.0, 0.0],
    [1.0, -1.0, 0.0, 0.0],
    [1.0, 0.0, 1.0, 0.0],
    [1.0, 0.0, -1.0, 0.0],
    [1.0, 0.0, 0.0, 1.0],
    [1.0, 0.0, 0.0, -1.0],
    [1.0, 0.2, -0.3, 0.5],
];

/// A sample for the tracer, and the same for the oracle.
struct Scene {
    build: Build,
    world: World,
}

impl Scene {
    fn within(n: f64) -> Self {
        let build = Build::within(n).open().patch(10.0, 10.0);
        Self { build, world: World { around: n, solids: Vec::new() } }
    }

    fn ball(mut self, center: [f64; 3], radius: f64, index: f64, priority: i32) -> Self {
        let center = DVec3::from_array(center);
        self.build = self.build.put(ball(center, radius), index).priority(priority);
        self.world.solids.push(Solid { form: Form::Ball { center, radius }, index, priority });
        self
    }

    /// A convex mesh.
    fn convex(mut self, body: Mesh, index: f64, priority: i32) -> Self {
        let middle = body.vertices.iter().sum::<DVec3>() / body.vertices.len() as f64;
        let plane = |t: &[u32; 3]| {
            let [a, b, c] = t.map(|i| body.vertices[i as usize]);
            let normal = (b - a).cross(c - a).normalize();
            let normal = if normal.dot(middle - a) > 0.0 { -normal } else { normal };
            (normal, normal.dot(a))
        };
        let form = Form::Convex(body.triangles.iter().map(plane).collect());
        self.world.solids.push(Solid { form, index, priority });
        self.build = self.build.put(mesh(body), index).priority(priority);
        self
    }
}

/// A box of these edges, turned and moved.
fn plate(size: [f64; 3], axis: [f64; 3], degrees: f64, center: [f64; 3]) -> Mesh {
    let turn = DMat3::from_axis_angle(DVec3::from_array(axis).normalize(), degrees.to_radians());
    Mesh::cube().map(|p| turn * ((p - 0.5) * DVec3::from_array(size)) + DVec3::from_array(center))
}

/// A triangular prism along y, its edge up, turned about z.
fn prism(degrees: f64) -> Mesh {
    let section = [(-4.0, -2.0), (4.0, -2.0), (0.0, 2.5)];
    let vertices = [-5.0, 5.0].map(|y| section.map(|(x, z)| DVec3::new(x, y, z))).concat();
    let sides = (0..3).flat_map(|i| [[i, (i + 1) % 3, (i + 1) % 3 + 3], [i, (i + 1) % 3 + 3, i + 3]]);
    let triangles = sides.chain([[0, 2, 1], [3, 4, 5]]).collect();
    let turn = DMat3::from_rotation_z(degrees.to_radians());
    Mesh { vertices, triangles }.map(|p| turn * p)
}

/// An exit of the tracer with that of the oracle, and the inputs p̂ and ŝ.
struct Match<'a, F> {
    field: F,
    exit: &'a Leaving<F>,
    oracle: &'a Exit,
    inputs: [DVec3; 2],
}

impl<F> Match<'_, F> {
    /// The field that one of the inputs has become.
    fn output(&self, input: usize) -> oracle::Field {
        apply(&self.oracle.matrix, &field(C64::ONE, self.inputs[input], C64::ZERO, DVec3::ZERO))
    }

    /// The Mueller matrix between the frames of the incidence and of the exit.
    fn mueller(&self) -> matrices::Mueller {
        let (x, y) = (self.exit.frame, self.exit.dir.cross(self.exit.frame));
        let [p, s] = [self.output(0), self.output(1)];
        matrices::of_jones(&[[along(&p, x), along(&s, x)], [along(&p, y), along(&s, y)]])
    }
}

/// s and p of an incidence in degrees, and the direction of propagation.
fn incident((theta, phi): (f64, f64)) -> (DVec3, [DVec3; 2]) {
    let ((sin, cos), (sin_phi, cos_phi)) = (theta.to_radians().sin_cos(), phi.to_radians().sin_cos());
    let k = -DVec3::new(sin * cos_phi, sin * sin_phi, cos);
    let s = DVec3::new(-sin_phi, cos_phi, 0.0);
    (k, [s.cross(k), s])
}

/// Pure parts of light of a Stokes vector, as fields: the coherency matrix by Cholesky.
fn parts([i, q, u, v]: [f64; 4], [p, s]: [DVec3; 2]) -> Vec<oracle::Field> {
    if i + q < 1e-9 {
        return vec![field(C64::ZERO, p, C64::from(i.sqrt()), s)];
    }
    // |E_p|² = (I + Q)/2 and 2 E_p E_s* = U + iV, and what is left of |E_s|².
    let a = (0.5 * (i + q)).sqrt();
    let b = C64::new(u, -v) / (2.0 * a);
    let rest = (0.5 * (i - q) - b.norm_sqr()).max(0.0).sqrt();
    vec![field(a.into(), p, b, s), field(C64::ZERO, p, rest.into(), s)]
}

fn exits_of<F>(exits: &[Leaving<F>], tree: u32) -> &[Leaving<F>] {
    let [first, last] = [tree, tree + 1].map(|t| exits.partition_point(|e| e.tree < t));
    &exits[first..last]
}

/// Every exit of every tree, each with the one of the oracle in the same place and direction. Returns how many.
fn compare<F: Field>(
    scene: &Scene,
    from: (f64, f64),
    polarization: Polarization,
    entries: &Entries,
    check: impl Fn(&Match<'_, F>) -> f64,
) -> usize {
    let light: Light = light(&[550.0], &[from], polarization);
    let sample = scene.build.sample(&light);
    let limits = Limits { depth: oracle::DEEPEST, ..Limits::whole_trees(FAINTEST) };
    let mut plan = Plan::new(&sample, &light, &Options { limits, ..Options::default() });
    plan.marks = Marks::default();
    let heard = listen_to::<F>(&plan, &sample, &light, Backend::Auto, entries);
    let (dir, inputs) = incident(from);
    let parts = parts(polarization.stokes(), inputs);
    for tree in 0..entries.len() as u32 {
        let exits = exits_of(&heard.exits, tree);
        let oracle = scene.world.tree(exits[0].anchor + sample.cell.center, dir, &parts, FAINTEST);
        assert_eq!(exits.len(), oracle.len(), "tree {tree} from {from:?}");
        for exit in exits {
            let place = exit.position + sample.cell.center;
            let same = |o: &&Exit| o.dir.distance(exit.dir) < SAME && (place - o.at).cross(exit.dir).length() < SAME;
            let &[(0, field)] = &exit.fields[..] else { panic!("one lane") };
            // A way and its reverse may end in one line.
            let errors = oracle.iter().filter(same).map(|oracle| check(&Match { field, exit, oracle, inputs }));
            let error = errors.fold(f64::INFINITY, f64::min);
            assert!(error < ACCURACY, "{error:e} in tree {tree} from {from:?}, {polarization}");
        }
    }
    heard.exits.len()
}

fn jones(m: &Match<'_, Jones>) -> f64 {
    let (x, y) = (m.exit.frame, m.exit.dir.cross(m.exit.frame));
    let half = C64::from(0.5f64.sqrt());
    let off = |c: usize| {
        let is = field(m.field.x[c], x, m.field.y[c], y);
        let expected = m.output(c).map(|e| e * half);
        (0..3).map(|i| (is[i] - expected[i]).norm()).fold(0.0, f64::max)
    };
    off(0).max(off(1))
}

fn stokes(m: &Match<'_, Stokes>, incident: [f64; 4]) -> f64 {
    let expected = matrices::applied(&m.mueller(), incident);
    m.field.components().iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// All states of light from all sides. Returns the largest retardance met, as the element that turns V into U.
fn check(scene: &Scene, trees: u32) -> f64 {
    let entries = entries(7, trees);
    let retarded = Cell::new(0.0f64);
    for from in INCIDENCES {
        let exits = compare::<Jones>(scene, from, Polarization::Unpolarized, &entries, jones);
        assert!(exits > entries.len(), "only {exits} exits from {from:?}");
        for state in STATES {
            let light = Polarization::Stokes(state);
            compare::<Stokes>(scene, from, light, &entries, |m| stokes(m, state));
        }
        compare::<Mueller>(scene, from, Polarization::Mueller, &entries, |m| {
            let expected = m.mueller();
            retarded.set(retarded.get().max((expected[11] / expected[0]).abs()));
            matrices::distance(&m.field.rows(), &expected)
        });
    }
    retarded.get()
}

#[test]
fn a_sphere() {
    let retarded = check(&Scene::within(1.0).ball([1.0, -0.5, 0.0], 4.0, 1.5, 0), 600);
    assert!(retarded == 0.0, "a single sphere reflects nothing totally");
}

/// Two touch, one has another in it.
#[test]
fn spheres() {
    let scene = Scene::within(1.0)
        .ball([0.0, 0.0, 3.0], 2.0, 1.5, 0)
        .ball([3.0, 0.0, 3.0], 1.0, 2.4, 0)
        .ball([-1.0, 1.0, -2.5], 3.0, 1.7, 0)
        .ball([-0.5, 1.5, -2.0], 1.25, 1.2, 1)
        .ball([2.5, -2.5, 0.0], 1.5, 1.33, 0);
    assert!(check(&scene, 300) > 0.5);
}

/// Light from a denser medium: total reflection at curved surfaces.
#[test]
fn bubbles() {
    let scene = Scene::within(1.6).ball([0.0, 0.0, 2.5], 2.5, 1.0, 0).ball([2.0, 1.0, -2.0], 2.0, 1.2, 0);
    assert!(check(&scene, 600) > 0.5);
}

/// Two plates that cross each other, tilted about different axes.
#[test]
fn crossed_plates() {
    let scene = Scene::within(1.0)
        .convex(plate([9.0, 7.0, 1.0], [1.0, 0.3, 0.1], 35.0, [0.0, 0.0, 1.0]), 1.5, 0)
        .convex(plate([8.0, 9.0, 1.5], [-0.2, 1.0, 0.4], 40.0, [0.5, 0.0, -1.0]), 2.0, 1);
    assert!(check(&scene, 300) > 0.5);
}

/// Total reflection within a prism, and a sphere under it.
#[test]
fn a_prism() {
    let scene = Scene::within(1.0).convex(prism(25.0), 1.7, 0).ball([0.5, 0.5, -5.0], 2.5, 1.5, 0);
    assert!(check(&scene, 300) > 0.5);
}
