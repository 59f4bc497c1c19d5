//! Stacks of films that rays find in the geometry reflect and transmit as the film formula says.

use crate::common::Mesh;
use crate::common::build::{Build, cuboid, light, mesh, mesh_box};
use crate::common::listen::settings;
use crate::common::stats::student_two_sided;
use glam::DVec3;
use gonio_embree::bsdf::Scattering;
use gonio_embree::experiment::{BATCHES, measure};
use gonio_embree::light::{Incidence as Direction, Light, Polarization, SourceMode};
use gonio_embree::optics::film::{Incidence, Layer, solve};
use gonio_embree::optics::{C64, Pair};
use gonio_embree::sample::description::Shape;
use gonio_embree::sample::generate::bricks::Bricks;

const NM: [f64; 5] = [400.0, 420.0, 453.5, 550.0, 700.0];
const FROM: [(f64, f64); 5] = [(0.0, 0.0), (20.0, 77.0), (45.0, 180.0), (70.0, 300.0), (85.0, 10.0)];
const POLARIZATIONS: [Polarization; 3] = [Polarization::Unpolarized, Polarization::S, Polarization::P];
const TREES: u64 = 3200;

/// A stack: index around, below, and (index, thickness in µm) from the top.
struct Stack {
    around: f64,
    below: C64,
    layers: Vec<(C64, f64)>,
}

impl Stack {
    fn new(around: f64, below: f64, layers: &[(f64, f64)]) -> Self {
        let layers = layers.iter().map(|&(n, d)| (C64::from(n), d)).collect();
        Self { around, below: below.into(), layers }
    }

    /// 12 films of chitin and the gaps between them.
    fn morpho() -> Self {
        Self::new(1.0, 1.0, &[(1.53, 0.05), (1.0, 0.15)].repeat(12)[..23])
    }

    /// Seven layers of bricks with nothing between.
    fn hummingbird() -> Self {
        Self::new(1.0, 1.0, &[(2.0, 0.037), (1.5, 0.098), (2.0, 0.037)].repeat(7))
    }

    /// Metal and absorbing layers on a transparent ground.
    fn lossy() -> Self {
        let layers = vec![(C64::new(1.7, 0.02), 0.1), (C64::new(0.3, 2.9), 0.02), (C64::new(1.4, 0.0), 0.2)];
        Self { around: 1.0, below: C64::from(1.5), layers }
    }

    /// The formula: shares reflected and transmitted.
    fn expected(&self, theta_deg: f64, nm: f64, polarization: Polarization) -> (f64, f64) {
        let incidence = Incidence::from_cos(self.around, theta_deg.to_radians().cos());
        let layers: Vec<Layer> = self.layers.iter().map(|&(index, thickness)| Layer { index, thickness }).collect();
        let both = solve(&incidence, &layers, self.below, nm / 1e3);
        let [s, p] = polarization.shares();
        let choose = |x: Pair<f64>| s * x.s + p * x.p;
        (choose(both.map(|a| a.reflectance())), choose(both.map(|a| a.transmittance())))
    }

    /// As infinite films.
    fn films(&self) -> Build {
        Build::within(self.around).below(self.below).films(0.3, &self.layers)
    }

    /// Heights of the layers, from the top.
    fn heights(&self) -> Vec<(C64, f64, f64)> {
        let mut top = 0.3;
        let layer = |&(n, d): &(C64, f64)| {
            top -= d;
            (n, top, top + d)
        };
        self.layers.iter().map(layer).collect()
    }

    /// As boxes that fill the patch.
    fn boxes(&self) -> Build {
        let empty = Build::within(self.around).patch(4.0, 3.0);
        self.heights().into_iter().fold(empty, |b, (n, z0, z1)| b.put(cuboid([-2.0, -1.5, z0], [2.0, 1.5, z1]), n))
    }

    /// The same of triangles.
    fn meshes(&self) -> Build {
        let empty = Build::within(self.around).patch(4.0, 3.0);
        self.heights().into_iter().fold(empty, |b, (n, z0, z1)| b.put(mesh_box([-2.0, -1.5, z0], [2.0, 1.5, z1]), n))
    }

    /// As boxes that join without gaps: each layer is cut elsewhere, and over the edge of the patch.
    fn joined(&self) -> Build {
        let mut build = Build::within(self.around).patch(4.0, 3.0);
        for (k, (n, z0, z1)) in self.heights().into_iter().enumerate() {
            let (x, y) = (0.37 * k as f64, 0.23 * k as f64);
            for (x0, x1) in [(0.0, 1.7), (1.7, 2.6), (2.6, 4.0)] {
                for (y0, y1) in [(0.0, 1.1), (1.1, 3.0)] {
                    build = build.put(cuboid([x + x0, y + y0, z0], [x + x1, y + y1, z1]), n);
                }
            }
        }
        build
    }
}

/// Thicknesses found in the geometry are taken to 2⁻⁴⁰ µm, 1e-12; times k₀ and the number of passes that is 1e-10.
/// Shares below 1e-9 are not followed.
const ROUNDING: f64 = 1e-9;

/// Light of lines, coherent through any stack.
fn line(polarization: Polarization) -> Light {
    Light { source: SourceMode::Line, ..light(&NM, &FROM, polarization) }
}

fn scatterings(build: &Build, light: &Light) -> Vec<Scattering> {
    measure(&build.sample(light), light, &settings(TREES), |_| {}).unwrap().bsdf.incidences
}

/// Specular and undeflected power are those of the formula, at every wavelength, incidence and polarization.
fn check(name: &str, build: &Build, stack: &Stack) {
    for polarization in POLARIZATIONS {
        for s in scatterings(build, &line(polarization)) {
            for (i, &nm) in NM.iter().enumerate() {
                let (r, t) = stack.expected(s.incidence.theta_deg, nm, polarization);
                let at = format!("{name}, {polarization}, {:?}, {nm} nm", s.incidence);
                let (specular, straight) = (s.ledger.specular[i], s.ledger.undeflected[i]);
                assert!((specular.value - r).abs() < ROUNDING, "{at}: {specular:?} for {r}");
                assert!((straight.value - t).abs() < ROUNDING, "{at}: {straight:?} for {t}");
                let lost = s.ledger.lost_medium[i].value + s.ledger.lost_numeric[i].value;
                assert_eq!((lost, s.facets.iter().map(|f| f.trees).sum::<u64>()), (0.0, 0), "{at}");
            }
        }
    }
}

#[test]
fn films_follow_the_formula() {
    for (name, stack) in [("morpho", Stack::morpho()), ("hummingbird", Stack::hummingbird()), ("lossy", Stack::lossy())]
    {
        check(name, &stack.films(), &stack);
    }
}

/// The same stack as films, as boxes, of triangles, and of boxes that join.
#[test]
fn it_does_not_matter_how_films_are_described() {
    for (name, stack) in [("morpho", Stack::morpho()), ("hummingbird", Stack::hummingbird())] {
        check(&format!("{name}, boxes"), &stack.boxes(), &stack);
        check(&format!("{name}, meshes"), &stack.meshes(), &stack);
        check(&format!("{name}, joined boxes"), &stack.joined(), &stack);
    }
}

/// Bricks whose cores reach from brick to brick, though the layers are shifted by half a brick.
#[test]
fn bricks_without_side_walls_are_films() {
    let bricks = Bricks { shell: DVec3::new(0.0, 0.0, 0.037), ..Bricks::default() };
    check("bricks", &Build::within(1.0).bricks(&bricks, 2.0, 1.5), &Stack::hummingbird());
}

/// Glass, a gap of air, glass: beyond the critical angle the wave tunnels.
#[test]
fn frustrated_total_reflection_tunnels() {
    for gap in [0.02, 0.1, 0.3] {
        let stack = Stack::new(1.5, 1.5, &[(1.0, gap)]);
        for (name, build) in [("films", stack.films()), ("boxes", stack.boxes()), ("meshes", stack.meshes())] {
            check(&format!("gap of {gap} µm, {name}"), &build, &stack);
        }
        let (_, through) = stack.expected(45.0, 550.0, Polarization::S);
        assert!(through > 1e-4 && through < 0.999, "{through}");
    }
}

/// A prism with the cross-section `corners` (x, z).
fn prism(corners: [(f64, f64); 3]) -> Shape {
    let at = |y: f64| corners.map(|(x, z)| DVec3::new(x, y, z));
    let vertices = [at(-5.0), at(5.0)].concat();
    let sides = (0..3).flat_map(|i| {
        let j = (i + 1) % 3;
        [[i, j, j + 3], [i, j + 3, i + 3]]
    });
    mesh(Mesh { vertices, triangles: sides.chain([[2, 1, 0], [3, 4, 5]]).collect() })
}

/// A cube of glass cut along its diagonal, with a gap of air: shares of unit power that leave upwards, downwards and
/// to the sides. All faces are met at normal incidence, the gap at 45°, by four beams that turn into one another.
fn beam_splitter(nm: f64, gap: f64, polarization: Polarization) -> [f64; 3] {
    let (r, t) = Stack::new(1.5, 1.5, &[(1.0, gap)]).expected(45.0, nm, polarization);
    let face = 0.04;
    // Going down, up, to the left, to the right, towards the gap.
    let mut beams = [1.0 - face, 0.0, 0.0, 0.0];
    let mut out = [face, 0.0, 0.0];
    for _ in 0..100 {
        let [down, up, left, right] = beams;
        let [to_top, to_bottom] = [t * up + r * left, t * down + r * right];
        let [to_right, to_left] = [r * down + t * right, r * up + t * left];
        out[0] += (1.0 - face) * to_top;
        out[1] += (1.0 - face) * to_bottom;
        out[2] += (1.0 - face) * (to_left + to_right);
        beams = [to_top, to_bottom, to_right, to_left].map(|b| face * b);
    }
    out
}

/// Two bodies with a gap between them, seen at 45°, beyond the critical angle.
#[test]
fn a_beam_splitter_divides_light() {
    const GAP: f64 = 0.15;
    let (l, shift) = (5.0, GAP / 8f64.sqrt());
    let upper = [(l, l), (l, -l), (-l, l)].map(|(x, z)| (x + shift, z + shift));
    let lower = [(-l, -l), (-l, l), (l, -l)].map(|(x, z)| (x - shift, z - shift));
    let cube = Build::within(1.0).open().patch(1.0, 1.0).put(prism(upper), 1.5).put(prism(lower), 1.5);
    let comparisons = (2 * 2 * NM.len()) as f64;
    for polarization in [Polarization::S, Polarization::P] {
        let light = Light { incidences: vec![Direction { theta_deg: 0.0, phi_deg: 0.0 }], ..line(polarization) };
        let outcome = measure(&cube.sample(&light), &light, &settings(32_000), |_| {}).unwrap();
        let ledger = &outcome.bsdf.incidences[0].ledger;
        for (i, &nm) in NM.iter().enumerate() {
            let [up, down, aside] = beam_splitter(nm, GAP, polarization);
            assert!((up + down + aside - 1.0).abs() < 1e-12 && down > 0.02 && aside > 0.02);
            for (measured, expected) in [(ledger.specular[i], up), (ledger.undeflected[i], down)] {
                let t = (measured.value - expected) / measured.se;
                let p = student_two_sided(t, f64::from(BATCHES - 1));
                assert!(p > 1e-3 / comparisons, "{polarization}, {nm} nm: {measured:?} for {expected}, p = {p:e}");
            }
        }
    }
}
