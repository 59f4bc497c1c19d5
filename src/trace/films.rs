//! Thin films in the geometry: searched along the normal, solved once per stack and cosine.

use std::collections::HashMap;

use glam::DVec3;

use super::inside::{Inside, Ledger};
use crate::geometry::{All, Crossing, Query, Ray, SurfaceId};
use crate::intersect::Scene;
use crate::optics::film::{Incidence, Layer, solve};
use crate::optics::{C64, Coefficients, Pair, fresnel};
use crate::plan::stacks::PARALLEL;
use crate::sample::{Matter, MediumId};

/// Media at the traced wavelengths.
pub struct Optics {
    /// Vacuum wavelengths, µm.
    pub wavelengths: Vec<f64>,
    /// Index of each medium at each lane.
    pub index: Vec<Vec<C64>>,
    /// Media in which no ray is followed: k/n above [`OPAQUE`] at some wavelength.
    pub opaque: Vec<bool>,
    /// Media whose index is not the same at all lanes.
    pub varies: Vec<bool>,
    /// Media that absorb at some lane.
    pub absorbs: Vec<bool>,
}

/// k/n above which a body counts as opaque: its light is absorbed within a few wavelengths.
pub const OPAQUE: f64 = 0.05;

impl Optics {
    /// Index of a medium at a lane.
    #[inline]
    pub fn index(&self, medium: MediumId, lane: u16) -> C64 {
        self.index[usize::from(medium.0)][usize::from(lane)]
    }

    /// Whether rays end in a medium.
    #[inline]
    pub fn is_opaque(&self, medium: MediumId) -> bool {
        self.opaque[usize::from(medium.0)]
    }
}

/// A stack found under a point of a face.
#[derive(Clone, Debug)]
pub struct Stack {
    /// Its layers, from the side of the light: medium and thickness, µm.
    pub layers: Vec<(MediumId, f64)>,
    /// The medium behind it.
    pub last: MediumId,
    /// Distance of its last interface, µm.
    pub depth: f64,
    /// The surface of its last interface.
    pub surface: SurfaceId,
    /// A face of its last interface.
    pub crossing: Crossing,
    /// What the ray is inside of behind it.
    pub inside: Inside,
}

impl Stack {
    fn empty() -> Self {
        let crossing = Crossing { prim: crate::geometry::PrimId(0), face: 0, enters: true };
        let (last, surface, inside) = (MediumId(0), SurfaceId::NONE, Inside::NOTHING);
        Self { layers: Vec::new(), last, depth: 0.0, surface, crossing, inside }
    }
}

/// Finds stacks, and remembers solved ones. One per worker: no lock, no sharing; what it answers is a pure
/// function of the question.
pub struct Films {
    found: All,
    stack: Stack,
    solved: Solved,
    counts: HashMap<Box<[u16]>, u64>,
}

/// Solutions kept before the memory is emptied.
const MOST_SOLVED: usize = 1 << 14;
/// Different sequences of media counted.
const MOST_COUNTED: usize = 1 << 10;

/// Where a search starts.
pub struct Start<'a> {
    /// Point on the first interface.
    pub point: DVec3,
    /// Its normal, towards the light.
    pub normal: DVec3,
    /// Its surface.
    pub surface: SurfaceId,
    /// What a ray is inside of behind it.
    pub inside: &'a Inside,
    /// The medium of the light.
    pub first: MediumId,
    /// Cosine of the angle of incidence.
    pub cos: f64,
}

impl Films {
    /// An empty memory.
    pub fn new() -> Self {
        Self {
            found: All::default(),
            stack: Stack::empty(),
            solved: Solved::default(),
            counts: HashMap::new(),
        }
    }

    /// Looks for a stack under a point and solves it: interfaces along the normal that are parallel to the first,
    /// while the sum of optical paths there and back stays within `coherence` µm. `None` if there is no layer.
    pub fn find(
        &mut self,
        scene: &Scene,
        ledger: &Ledger,
        optics: &Optics,
        start: &Start<'_>,
        reach: f64,
        coherence: f64,
    ) -> Option<(&Stack, &[Coefficients])> {
        if !self.search(scene, ledger, optics, start, reach, coherence) {
            return None;
        }
        self.count();
        let solution = self.solved.get_or_solve(optics, start.first, &self.stack.layers, self.stack.last, start.cos);
        Some((&self.stack, solution))
    }

    /// Coefficients of a bare interface at every lane.
    pub fn interface(&mut self, optics: &Optics, first: MediumId, last: MediumId, cos: f64) -> &[Coefficients] {
        self.solved.get_or_solve(optics, first, &[], last, cos)
    }

    fn search(
        &mut self,
        scene: &Scene,
        ledger: &Ledger,
        optics: &Optics,
        start: &Start<'_>,
        reach: f64,
        coherence: f64,
    ) -> bool {
        let Matter::Medium(second) = ledger.matter(start.inside) else { return false };
        if optics.is_opaque(second) {
            return false;
        }
        let n1 = optics.index(start.first, 0).re;
        let kx2 = n1 * n1 * (1.0 - start.cos) * (1.0 + start.cos);
        let mut query = Query::leaving(Ray { origin: start.point, dir: -start.normal }, start.surface);
        query.limit = reach;
        let hits = scene.all(&query, &mut self.found);
        let primitives = scene.primitives();
        let stack = &mut self.stack;
        stack.layers.clear();
        stack.last = second;
        stack.depth = 0.0;
        let mut inside = *start.inside;
        let mut path = 0.0;
        let mut crossings: Vec<Crossing> = Vec::new();
        for interface in hits.chunk_by(|a, b| a.order == b.order) {
            let order = interface[0].order;
            crossings.clear();
            crossings.extend(interface.iter().map(|h| h.crossing));
            let Ok(after) = ledger.cross(&inside, &crossings, primitives) else { break };
            let (Matter::Medium(layer), Matter::Medium(next)) = (ledger.matter(&inside), ledger.matter(&after)) else { break };
            inside = after;
            if layer == next {
                continue;
            }
            let point = query.ray.at(order.t);
            let normal = primitives.normal(crossings[0].prim, crossings[0].face, point);
            if normal.dot(start.normal).abs() < PARALLEL {
                break;
            }
            let thickness = quantized(order.t) - quantized(stack.depth);
            let q2 = optics.index(layer, 0).re.powi(2) - kx2;
            path += 2.0 * thickness * q2.max(0.0).sqrt();
            if path > coherence {
                break;
            }
            stack.layers.push((layer, thickness));
            stack.last = next;
            stack.depth = order.t;
            stack.surface = order.surface;
            stack.crossing = crossings[0];
            stack.inside = after;
            if optics.is_opaque(next) {
                break;
            }
        }
        !stack.layers.is_empty()
    }

    fn count(&mut self) {
        let media: Vec<u16> = self.stack.layers.iter().map(|l| l.0.0).collect();
        if let Some(n) = self.counts.get_mut(&media[..]) {
            *n += 1;
        } else if self.counts.len() < MOST_COUNTED {
            self.counts.insert(media.into(), 1);
        }
    }

    /// How often each sequence of media was met.
    pub fn into_counts(self) -> HashMap<Box<[u16]>, u64> {
        self.counts
    }
}

/// Solutions by stack and cosine.
#[derive(Default)]
struct Solved {
    key: Vec<u64>,
    known: HashMap<Box<[u64]>, Box<[Coefficients]>>,
}

impl Solved {
    /// Coefficients of a stack (or, without layers, of an interface) at every lane.
    fn get_or_solve(
        &mut self,
        optics: &Optics,
        first: MediumId,
        layers: &[(MediumId, f64)],
        last: MediumId,
        cos: f64,
    ) -> &[Coefficients] {
        self.key.clear();
        self.key.extend([cos.to_bits(), u64::from(first.0) << 16 | u64::from(last.0)]);
        self.key.extend(layers.iter().flat_map(|(m, d)| [u64::from(m.0), d.to_bits()]));
        if !self.known.contains_key(&self.key[..]) {
            if self.known.len() >= MOST_SOLVED {
                self.known.clear();
            }
            let lanes = 0..optics.wavelengths.len() as u16;
            let solution = lanes.map(|lane| solve_lane(optics, first, layers, last, cos, lane)).collect();
            self.known.insert(self.key.clone().into(), solution);
        }
        &self.known[&self.key[..]]
    }
}

/// Distances to 2⁻⁴⁰ µm (a millionth of a picometre), so that one stack seen from different points is one.
fn quantized(t: f64) -> f64 {
    const STEPS: f64 = (1u64 << 40) as f64;
    (t * STEPS).round() / STEPS
}

/// Coefficients of one interface for one lane.
pub fn one_interface(optics: &Optics, first: MediumId, last: MediumId, cos: f64, lane: u16) -> Coefficients {
    let (n1, n2) = (optics.index(first, lane), optics.index(last, lane));
    if optics.is_opaque(last) {
        return Coefficients { r: fresnel::into_complex(n1.re, n2, cos), t: Pair { s: C64::ZERO, p: C64::ZERO } };
    }
    if n1.im == 0.0 && n2.im == 0.0 {
        let d = fresnel::dielectric(n1.re, n2.re, cos);
        return Coefficients { r: d.r, t: d.t.map(C64::from) };
    }
    fresnel::weakly_absorbing(n1, n2, cos).0
}

fn solve_lane(
    optics: &Optics,
    first: MediumId,
    layers: &[(MediumId, f64)],
    last: MediumId,
    cos: f64,
    lane: u16,
) -> Coefficients {
    if layers.is_empty() {
        return one_interface(optics, first, last, cos, lane);
    }
    let incidence = Incidence::from_cos(optics.index(first, lane).re, cos);
    let layers: Vec<Layer> =
        layers.iter().map(|&(m, thickness)| Layer { index: optics.index(m, lane), thickness }).collect();
    let both = solve(&incidence, &layers, optics.index(last, lane), optics.wavelengths[usize::from(lane)]);
    let t = if optics.is_opaque(last) { Pair { s: C64::ZERO, p: C64::ZERO } } else { both.map(|a| a.t_power()) };
    Coefficients { r: both.map(|a| a.r), t }
}
