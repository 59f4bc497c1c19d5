//! Finds stacks of thin films in the geometry: parallel interfaces, one behind the other, along a probe.
//!
//! The probe goes along the normal of the first interface: one for all wavelengths and both polarizations, also where
//! no ray could go (a gap beyond the critical angle, metal). The paper's probe is the refracted ray
//! ([`Probe::Refracted`]): it sees the same stacks where all light travels.

use glam::DVec3;

use super::inside::{Around, Inside, Solids};
use super::media::{Media, Slant};
use crate::geometry::{All, Crossing, Hit, Kind, Order, PrimId, Ray, SurfaceId};
use crate::intersect::Scene;
use crate::light::Coherence;
use crate::optics::batch::Film;
use crate::optics::fresnel::other_leg;
use crate::optics::{C64, outgoing_root};
use crate::plan::PARALLEL;
use crate::plan::Probe;
use crate::sample::{MediumId, Sample};

/// A stack found under a point of a face.
#[derive(Clone, Debug)]
pub struct Stack {
    /// Its layers, from the side of the light; thickness in µm.
    pub layers: Vec<Film>,
    /// The medium behind it.
    pub last: MediumId,
    /// The surface of its last interface.
    pub surface: SurfaceId,
    /// A face of its last interface.
    pub crossing: Crossing,
    /// Where the transmitted ray starts: where the probe met the last interface.
    pub exit: DVec3,
    /// How far that is, along the direction of the light, from straight below the first point, µm.
    pub walked: f64,
    /// By how many periods of the sample it was moved, to lie within the seams.
    pub shift: [i32; 2],
    /// What the ray is inside of behind it.
    pub inside: Inside,
    /// Whether the same stack is met everywhere around: its faces are parallel to the last bit.
    pub uniform: bool,
    /// Whether a face of it ends somewhere.
    bounded: bool,
    /// The group of the body that each layer belongs to.
    pub groups: Vec<u16>,
    /// What each layer is inside of.
    within: Vec<Inside>,
}

/// Where a search starts.
pub struct Start<'a> {
    /// Point on the first interface.
    pub point: DVec3,
    /// Its normal, towards the light.
    pub normal: DVec3,
    /// Its surface.
    pub surface: SurfaceId,
    /// A face of it.
    pub crossing: Crossing,
    /// What a ray is inside of behind it.
    pub inside: &'a Inside,
    /// The medium of the light.
    pub first: MediumId,
    /// The direction of the light.
    pub dir: DVec3,
    /// Its angle of incidence.
    pub slant: Slant,
    /// A lane whose indices stand for all.
    pub lane: u16,
}

/// How far a search goes.
#[derive(Clone, Copy, Debug)]
pub struct Reach {
    /// Distance along the normal, µm.
    pub depth: f64,
    /// Difference of optical paths, there and back, µm.
    pub coherence: f64,
    /// Whether the edges of the stack will be asked for.
    pub edges: bool,
}

/// What is asked: the same for all searches of a run.
#[derive(Clone, Copy)]
pub struct World<'a> {
    /// The sample.
    pub sample: &'a Sample,
    /// Its geometry.
    pub scene: &'a Scene,
    /// Its solids.
    pub solids: &'a Solids,
    /// Its media.
    pub media: &'a Media,
    /// How stacks are searched.
    pub probe: Probe,
    /// How thick they may be.
    pub coherence: Coherence,
}

/// Distances that differ by less are one but for rounding, µm.
const SAME: f64 = 1e-9;

/// Shells are films up to this part of their radius.
const THICKEST_SHELL: f64 = 0.02;

/// Searches, and keeps its memory from one search to the next.
pub struct Finder {
    found: All,
    crossings: Vec<Crossing>,
    stack: Stack,
}

/// An interface met by a probe.
struct Met<'a> {
    probe: Ray,
    /// Cosine of the angle between probe and normal.
    cos: f64,
    order: Order,
    /// Of the layer in front of it, µm.
    thickness: f64,
    /// Whether that is the same everywhere.
    uniform: bool,
    /// The medium behind it.
    next: MediumId,
    inside: &'a Inside,
    /// Whether the edges of the stack will be asked for.
    edges: bool,
}

impl Finder {
    /// Nothing found yet.
    pub fn new() -> Self {
        let crossing = Crossing { prim: PrimId(0), owner: 0, face: 0, enters: true };
        Self {
            found: All::default(),
            crossings: Vec::new(),
            stack: Stack {
                layers: Vec::new(),
                last: MediumId(0),
                surface: SurfaceId::NONE,
                crossing,
                exit: DVec3::ZERO,
                walked: 0.0,
                shift: [0, 0],
                inside: Inside::NOTHING,
                uniform: true,
                bounded: false,
                groups: Vec::new(),
                within: Vec::new(),
            },
        }
    }

    /// The stack of the last search.
    pub fn stack(&self) -> &Stack {
        &self.stack
    }

    /// Lists the interfaces along the probe that are parallel to the first, while the sum of optical paths there and back
    /// stays within reach and the faces are as good as plane. Metal is a layer like others: light that no ray could follow may still come through. Says
    /// whether there is a layer.
    pub fn search(&mut self, world: &World<'_>, start: &Start<'_>, reach: Reach) -> bool {
        let Around::Medium(second) = world.solids.around(start.inside) else { return false };
        self.begin(start, second);
        match world.probe {
            Probe::Normal => self.search_along_normal(world, start, reach),
            Probe::Refracted => self.search_along_rays(world, start, reach),
        }
        self.settle(world);
        !self.stack.layers.is_empty()
    }

    fn begin(&mut self, start: &Start<'_>, second: MediumId) {
        let stack = &mut self.stack;
        stack.layers.clear();
        stack.groups.clear();
        stack.within.clear();
        (stack.last, stack.exit, stack.walked) = (second, start.point, 0.0);
        (stack.crossing, stack.surface, stack.shift) = (start.crossing, start.surface, [0, 0]);
        (stack.uniform, stack.bounded) = (true, false);
        stack.inside.clone_from(start.inside);
    }

    fn search_along_normal(&mut self, world: &World<'_>, start: &Start<'_>, reach: Reach) {
        let down = Ray { origin: start.point, dir: -start.normal };
        let query = world.scene.primitives().query_leaving(down, start.surface).within(reach.depth);
        let mut found = std::mem::take(&mut self.found);
        let mut inside = start.inside.clone();
        let (mut depth, mut path) = (0.0, 0.0);
        for interface in world.scene.all(&query, &mut found).chunk_by(|a, b| a.order == b.order) {
            let order = interface[0].order;
            match self.cross(world, &mut inside, interface) {
                None => break,
                Some(next) if next == self.stack.last => continue,
                Some(next) => {
                    let (thickness, uniform) =
                        self.thickness(world, order.surface, quantized(order.t) - quantized(depth));
                    path += self.path(world, start, thickness);
                    let edges = reach.edges;
                    let met = Met { probe: down, cos: 1.0, order, thickness, uniform, next, inside: &inside, edges };
                    if world.coherence.counted(path, order.t) > reach.coherence || !self.add(world, start, &met) {
                        break;
                    }
                    depth = order.t;
                }
            }
        }
        self.found = found;
    }

    /// From interface to interface, refracted at each, until there is no refracted ray.
    fn search_along_rays(&mut self, world: &World<'_>, start: &Start<'_>, reach: Reach) {
        let primitives = world.scene.primitives();
        let mut found = std::mem::take(&mut self.found);
        let mut inside = start.inside.clone();
        let (mut depth, mut path, mut surface) = (0.0, 0.0, start.surface);
        while let Some((dir, cos)) = refracted(world, start, self.stack.last) {
            let probe = Ray { origin: self.stack.exit, dir };
            let query = primitives.query_leaving(probe, surface).within((reach.depth - depth) / cos);
            let mut went_on = false;
            for interface in world.scene.all(&query, &mut found).chunk_by(|a, b| a.order == b.order) {
                let order = interface[0].order;
                match self.cross(world, &mut inside, interface) {
                    Some(next) if next == self.stack.last => continue,
                    Some(next) => {
                        let (thickness, uniform) = self.thickness(world, order.surface, quantized(order.t * cos));
                        path += self.path(world, start, thickness);
                        let edges = reach.edges;
                        let met = Met { probe, cos, order, thickness, uniform, next, inside: &inside, edges };
                        let counted = world.coherence.counted(path, depth + thickness);
                        went_on = counted <= reach.coherence && self.add(world, start, &met);
                        self.settle(world);
                        went_on = went_on && self.come_home(world);
                        (depth, surface) = (depth + thickness, self.stack.surface);
                    }
                    None => {}
                }
                break;
            }
            if !went_on {
                break;
            }
        }
        self.found = found;
    }

    /// Moves the point where the probe is onto its surface, from which it is off by rounding.
    fn settle(&mut self, world: &World<'_>) {
        let Stack { crossing, surface, exit, .. } = self.stack;
        self.stack.exit = world.scene.primitives().snap(crossing, surface, exit);
    }

    /// Moves a probe that has gone beyond a seam; says whether it can go on.
    fn come_home(&mut self, world: &World<'_>) -> bool {
        let stack = &mut self.stack;
        let cell = &world.sample.cell;
        if !cell.is_beyond(stack.exit) {
            return true;
        }
        let shift = cell.shift_home(stack.exit);
        let Some(prim) = world.sample.copy(stack.crossing.prim, shift) else { return false };
        stack.exit += cell.offset(shift);
        stack.crossing.prim = prim;
        stack.surface = world.scene.primitives().faces(prim)[usize::from(stack.crossing.face)];
        stack.shift = [stack.shift[0] + shift[0], stack.shift[1] + shift[1]];
        true
    }

    /// What is behind an interface; `None` where no wave can follow.
    fn cross(&mut self, world: &World<'_>, inside: &mut Inside, interface: &[Hit]) -> Option<MediumId> {
        self.crossings.clear();
        self.crossings.extend(interface.iter().map(|h| h.crossing));
        world.solids.cross(inside, &self.crossings).ok()?;
        match world.solids.around(inside) {
            Around::Medium(next) => Some(next),
            Around::Opaque(_) => None,
        }
    }

    /// Thickness of the layer in front of the interface at hand: from its faces, if they are parallel to the last bit (then
    /// it is the same everywhere), else as `probed`.
    fn thickness(&self, world: &World<'_>, surface: SurfaceId, probed: f64) -> (f64, bool) {
        let before = (self.stack.surface, self.stack.crossing.prim);
        match world.scene.primitives().separation(before, (surface, self.crossings[0].prim)) {
            // The far side of a sphere is not what is meant.
            Some(thickness) if (thickness - probed).abs() < SAME => (thickness, true),
            _ => (probed, false),
        }
    }

    /// Optical path there and back through the last layer, 2 n d cos θ.
    fn path(&self, world: &World<'_>, start: &Start<'_>, thickness: f64) -> f64 {
        let kx = world.media.index(start.first, start.lane).re * start.slant.sin;
        let q2 = world.media.index(self.stack.last, start.lane).re.powi(2) - kx * kx;
        2.0 * thickness * q2.max(0.0).sqrt()
    }

    /// Adds the layer in front of an interface, if that is parallel to the first.
    fn add(&mut self, world: &World<'_>, start: &Start<'_>, met: &Met<'_>) -> bool {
        let primitives = world.scene.primitives();
        let (crossing, Order { t, surface }) = (self.crossings[0], met.order);
        let point = met.probe.at(t);
        let cos = match primitives.plane(surface) {
            Some(plane) => plane.normal.dot(start.normal),
            None => primitives.normal(crossing.prim, crossing.face, point).dot(start.normal),
        };
        if cos.abs() < PARALLEL || !self.is_flat_enough(world, start, met, point) {
            return false;
        }
        let stack = &mut self.stack;
        stack.groups.push(world.solids.group_around(&stack.inside));
        if met.edges {
            stack.within.push(stack.inside.clone());
        }
        stack.layers.push(Film { medium: usize::from(stack.last.0), thickness: met.thickness });
        (stack.last, stack.surface, stack.crossing) = (met.next, surface, crossing);
        stack.exit = point;
        stack.walked += t * other_leg(met.cos);
        stack.uniform &= met.uniform;
        stack.bounded |= primitives.locate(crossing.prim).0 != Kind::Layer;
        stack.inside.clone_from(met.inside);
        true
    }

    /// Whether curvature can be neglected down to an interface: depth h and shift aside s are small beside the radius R,
    /// h/R < 0.02 and s h/R < λ/16.
    fn is_flat_enough(&self, world: &World<'_>, start: &Start<'_>, met: &Met<'_>, point: DVec3) -> bool {
        let primitives = world.scene.primitives();
        if [start.surface, met.order.surface].iter().all(|&s| primitives.plane(s).is_some()) {
            return true;
        }
        let curvature = |c: Crossing, p: DVec3| primitives.curvature(c.prim, c.face, p);
        let curvature = curvature(self.crossings[0], point).max(curvature(start.crossing, start.point));
        let kx = world.media.index(start.first, start.lane).re * start.slant.sin;
        let films = self.stack.layers.iter().map(|l| (MediumId(l.medium as u16), l.thickness));
        let (mut depth, mut aside) = (0.0, 0.0);
        for (medium, thickness) in films.chain([(self.stack.last, met.thickness)]) {
            let n = world.media.index(medium, start.lane).re;
            depth += thickness;
            aside += if n > kx { thickness * kx / ((n - kx) * (n + kx)).sqrt() } else { 0.0 };
        }
        let wavelength = world.media.wavelengths()[usize::from(start.lane)];
        depth * curvature < THICKEST_SHELL && 2.0 * aside * depth * curvature < wavelength / 16.0
    }

    /// Whether a layer of the stack ends, along the plane of incidence, so near that light which goes to and fro in the
    /// stack would get there: within X (1 + 2M), where X is the way aside in one pass and M the number of passes after
    /// which a hundredth of the light is left.
    pub fn near_edge(&mut self, world: &World<'_>, start: &Start<'_>) -> bool {
        let stack = &self.stack;
        if !stack.bounded || start.slant.sin == 0.0 {
            return false;
        }
        let reach = reach_aside(world, start, stack);
        if reach <= 0.0 {
            return false;
        }
        let aside = (start.dir + start.slant.cos * start.normal) / start.slant.sin;
        let mut found = std::mem::take(&mut self.found);
        let mut depth = 0.0;
        let mut near = false;
        for (layer, within) in self.stack.layers.iter().zip(&self.stack.within) {
            let middle = start.point - (depth + 0.5 * layer.thickness) * start.normal;
            depth += layer.thickness;
            near = near || [aside, -aside].iter().any(|&dir| ends(world, within, middle, dir, reach, &mut found));
        }
        self.found = found;
        near
    }
}

/// Whether the medium changes along a ray.
fn ends(world: &World<'_>, within: &Inside, origin: DVec3, dir: DVec3, limit: f64, found: &mut All) -> bool {
    let query = world.scene.primitives().query(Ray { origin, dir }).within(limit);
    let here = world.solids.around(within);
    let mut inside = within.clone();
    world.scene.all(&query, found).chunk_by(|a, b| a.order == b.order).any(|interface| {
        let crossings: Vec<Crossing> = interface.iter().map(|h| h.crossing).collect();
        world.solids.cross(&mut inside, &crossings).is_err() || world.solids.around(&inside) != here
    })
}

/// Direction of the refracted ray in a medium, and its cosine; `None` beyond the critical angle and where rays end.
fn refracted(world: &World<'_>, start: &Start<'_>, medium: MediumId) -> Option<(DVec3, f64)> {
    let refraction = world.media.refraction(start.first, medium, start.lane, start.slant)?;
    let dir = refraction.ratio * start.dir + (refraction.ratio * start.slant.cos - refraction.cos) * start.normal;
    (refraction.cos > 0.0).then(|| (dir.normalize(), refraction.cos))
}

/// Most passes that are counted.
const MOST_PASSES: f64 = 20.0;

/// How far aside light gets in a stack before a hundredth of it is left, µm.
fn reach_aside(world: &World<'_>, start: &Start<'_>, stack: &Stack) -> f64 {
    let kx = world.media.index(start.first, start.lane).re * start.slant.sin;
    let kz = |medium: usize| {
        let n = world.media.index(MediumId(medium as u16), start.lane);
        outgoing_root((n - kx) * (n + kx))
    };
    let behind = stack.layers.iter().map(|l| l.medium).skip(1).chain([usize::from(stack.last.0)]);
    let (mut aside, mut before, mut strongest) = (0.0, kz(usize::from(start.first.0)), 0.0f64);
    let reflection = |a: C64, b: C64| if a + b == C64::ZERO { 0.0 } else { ((a - b) / (a + b)).norm() };
    for (layer, next) in stack.layers.iter().zip(behind) {
        let (here, after) = (kz(layer.medium), kz(next));
        if here.re > here.im {
            aside += layer.thickness * kx / here.re;
        }
        strongest = strongest.max(reflection(before, here) * reflection(here, after));
        before = here;
    }
    let passes = if strongest > 0.0 { (0.01f64.ln() / strongest.min(0.999).ln()).min(MOST_PASSES) } else { 0.0 };
    aside * (1.0 + 2.0 * passes)
}

/// Distances to 2⁻⁴⁰ µm (a millionth of a picometre), so that one stack seen from different points is one.
fn quantized(t: f64) -> f64 {
    const STEPS: f64 = (1u64 << 40) as f64;
    /// The last bit of what is added to this is a step.
    const ROUND: f64 = 6_755_399_441_055_744.0 / STEPS;
    if t < 1024.0 { (t + ROUND) - ROUND } else { (t * STEPS).round() / STEPS }
}
