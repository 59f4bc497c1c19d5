//! Thin films in the geometry: searched along the normal, solved once per stack and cosine.

use std::collections::{BTreeMap, HashMap};

use glam::DVec3;

use super::inside::{Around, Inside, Solids};
use super::media::{Beams, Media, Slant};
use crate::geometry::{All, Crossing, PrimId, Ray, SurfaceId};
use crate::intersect::Scene;
use crate::optics::field::Field;
use crate::optics::film::{Incidence, Layer, solve};
use crate::optics::{C64, Coefficients, Pair};
use crate::plan::stacks::PARALLEL;
use crate::sample::MediumId;

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
    /// Its direction.
    pub slant: Slant,
}

/// How far a search goes.
#[derive(Clone, Copy, Debug)]
pub struct Reach {
    /// Distance along the normal, µm.
    pub depth: f64,
    /// Difference of optical paths, there and back, µm.
    pub coherence: f64,
}

/// Finds stacks, and remembers solved ones. One per worker: no lock, no sharing; what it answers is a pure
/// function of the question.
pub struct Films<F: Field> {
    found: All,
    stack: Stack,
    crossings: Vec<Crossing>,
    solved: Solved<F>,
    /// The media of the stack at hand.
    sequence: Vec<u16>,
    stacks: Stacks,
}

/// The stacks that were met.
#[derive(Clone, Debug, PartialEq)]
pub struct Stacks {
    /// How often each sequence of media was met.
    pub hits: BTreeMap<Vec<u16>, u64>,
    /// Thickness of the thinnest layer, µm; infinite without any.
    pub thinnest: f64,
}

impl Default for Stacks {
    fn default() -> Self {
        Self { hits: BTreeMap::new(), thinnest: f64::INFINITY }
    }
}

impl Stacks {
    fn add(&mut self, layers: &[(MediumId, f64)], key: &mut Vec<u16>) {
        key.clear();
        key.extend(layers.iter().map(|l| l.0.0));
        self.thinnest = layers.iter().fold(self.thinnest, |least, l| least.min(l.1));
        if let Some(n) = self.hits.get_mut(key) {
            *n += 1;
        } else if self.hits.len() < MOST_COUNTED {
            self.hits.insert(key.clone(), 1);
        }
    }

    /// Adds what others met.
    pub fn merge(&mut self, other: Self) {
        self.thinnest = self.thinnest.min(other.thinnest);
        for (media, n) in other.hits {
            *self.hits.entry(media).or_default() += n;
        }
    }
}

/// Different sequences of media counted.
const MOST_COUNTED: usize = 1 << 10;

impl<F: Field> Films<F> {
    /// An empty memory.
    pub fn new() -> Self {
        let crossing = Crossing { prim: PrimId(0), owner: 0, face: 0, enters: true };
        let (last, surface, inside) = (MediumId(0), SurfaceId::NONE, Inside::NOTHING);
        Self {
            found: All::default(),
            stack: Stack { layers: Vec::new(), last, depth: 0.0, surface, crossing, inside },
            crossings: Vec::new(),
            solved: Solved { key: Vec::new(), known: HashMap::new() },
            sequence: Vec::new(),
            stacks: Stacks::default(),
        }
    }

    /// Looks for a stack under a point and solves it for every lane; `None` if there is no layer.
    pub fn find(
        &mut self,
        scene: &Scene,
        solids: &Solids,
        media: &Media,
        start: &Start<'_>,
        reach: Reach,
    ) -> Option<(&Stack, &[Beams<F::Passage>])> {
        if !self.search(scene, solids, media, start, reach) {
            return None;
        }
        self.stacks.add(&self.stack.layers, &mut self.sequence);
        let Stack { layers, last, .. } = &self.stack;
        let solution = self.solved.get_or_solve(media, start.first, layers, *last, start.slant);
        Some((&self.stack, solution))
    }

    /// A single interface for every lane.
    pub fn interface(&mut self, media: &Media, first: MediumId, last: MediumId, slant: Slant) -> &[Beams<F::Passage>] {
        self.solved.get_or_solve(media, first, &[], last, slant)
    }

    /// Lists the interfaces along the normal that are parallel to the first, while the sum of optical paths there
    /// and back stays within reach. Metal is a layer like others: light that no ray could follow may still come
    /// through. Says whether there is a layer.
    fn search(&mut self, scene: &Scene, solids: &Solids, media: &Media, start: &Start<'_>, reach: Reach) -> bool {
        let Around::Medium(second) = solids.around(start.inside) else { return false };
        let kx = media.index(start.first, 0).re * start.slant.sin;
        let primitives = scene.primitives();
        let down = Ray { origin: start.point, dir: -start.normal };
        let query = primitives.query_leaving(down, start.surface).within(reach.depth);
        let stack = &mut self.stack;
        stack.layers.clear();
        (stack.last, stack.depth) = (second, 0.0);
        let mut inside = start.inside.clone();
        let mut layer = second;
        let mut path = 0.0;
        for interface in scene.all(&query, &mut self.found).chunk_by(|a, b| a.order == b.order) {
            let order = interface[0].order;
            self.crossings.clear();
            self.crossings.extend(interface.iter().map(|h| h.crossing));
            if solids.cross(&mut inside, &self.crossings).is_err() {
                break;
            }
            let Around::Medium(next) = solids.around(&inside) else { break };
            if layer == next {
                continue;
            }
            let crossing = self.crossings[0];
            let normal = primitives.normal(crossing.prim, crossing.face, down.at(order.t));
            let thickness = quantized(order.t) - quantized(stack.depth);
            let q2 = media.index(layer, 0).re.powi(2) - kx * kx;
            path += 2.0 * thickness * q2.max(0.0).sqrt();
            if normal.dot(start.normal).abs() < PARALLEL || path > reach.coherence {
                break;
            }
            stack.layers.push((layer, thickness));
            (stack.last, stack.depth, stack.surface) = (next, order.t, order.surface);
            stack.crossing = crossing;
            stack.inside.clone_from(&inside);
            layer = next;
        }
        !stack.layers.is_empty()
    }

    /// What was met.
    pub fn into_stacks(self) -> Stacks {
        self.stacks
    }
}

/// What a stack does to each lane.
type PerLane<F> = Box<[Beams<<F as Field>::Passage>]>;

/// Solutions by stack and cosine.
struct Solved<F: Field> {
    key: Vec<u64>,
    known: HashMap<Box<[u64]>, PerLane<F>>,
}

/// Solutions kept before the memory is emptied.
const MOST_SOLVED: usize = 1 << 14;

impl<F: Field> Solved<F> {
    /// A stack (or, without layers, an interface) at every lane.
    fn get_or_solve(
        &mut self,
        media: &Media,
        first: MediumId,
        layers: &[(MediumId, f64)],
        last: MediumId,
        slant: Slant,
    ) -> &[Beams<F::Passage>] {
        self.key.clear();
        self.key.extend([slant.cos.to_bits(), u64::from(first.0) << 16 | u64::from(last.0)]);
        self.key.extend(layers.iter().flat_map(|(m, d)| [u64::from(m.0), d.to_bits()]));
        if !self.known.contains_key(&self.key[..]) {
            if self.known.len() >= MOST_SOLVED {
                self.known.clear();
            }
            let lanes = 0..media.lanes() as u16;
            let solution = lanes.map(|lane| solve_lane::<F>(media, first, layers, last, slant, lane)).collect();
            self.known.insert(self.key.clone().into(), solution);
        }
        &self.known[&self.key[..]]
    }
}

fn solve_lane<F: Field>(
    media: &Media,
    first: MediumId,
    layers: &[(MediumId, f64)],
    last: MediumId,
    slant: Slant,
    lane: u16,
) -> Beams<F::Passage> {
    if layers.is_empty() {
        return media.interface::<F>(first, last, lane, slant).0;
    }
    let incidence = Incidence::from_cos(media.index(first, lane).re, slant.cos);
    let layers: Vec<Layer> =
        layers.iter().map(|&(m, thickness)| Layer { index: media.index(m, lane), thickness }).collect();
    let both = solve(&incidence, &layers, media.index(last, lane), media.wavelength(lane));
    let t = if media.is_opaque(last) { Pair { s: C64::ZERO, p: C64::ZERO } } else { both.map(|a| a.t_power()) };
    Beams::new(&Coefficients { r: both.map(|a| a.r), t })
}

/// Distances to 2⁻⁴⁰ µm (a millionth of a picometre), so that one stack seen from different points is one.
fn quantized(t: f64) -> f64 {
    const STEPS: f64 = (1u64 << 40) as f64;
    (t * STEPS).round() / STEPS
}
