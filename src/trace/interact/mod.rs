//! A ray at an interface: into a reflected and a transmitted beam, or into one of them by lot.
//!
//! While a tree may still split, both beams go on with their shares of the power. After that each lane goes one
//! way, chosen with the probability of its share, and keeps all its power: so every tree conserves energy for
//! every lane, exactly. All lanes of a ray use one random number; lanes that choose differently, or that refraction
//! parts, go on as several rays. What a lane does depends on its own coefficients only, so it follows the same path
//! alone or in a bundle, but that a bundle may turn it by what the plan allows, to either side.

mod bundle;
mod divide;
mod send;

use std::marker::PhantomData;

use glam::DVec3;

use super::beams::{BeamTable, Beams};
use super::effects::Effects;
use super::films::{Absorption, Films, Found};
use super::finder::{Reach, Start};
use super::inside::{Around, Inside};
use super::kernel::Kernel;
use super::media::{Refraction, Slant};
use super::random::{TreeKey, decision};
use super::record::{Loss, Recorder};
use super::stream::{Bits, Flight, Slot, Stream};
use crate::geometry::{Crossing, PrimId, Ray, SurfaceId};
use crate::optics::field::Field;
use crate::optics::{C64, Coefficients, Pair};
use crate::plan::Edges;
use crate::sample::{Matter, MediumId};

use bundle::Bundle;
use divide::{Absorber, Action, Encounter};

/// An interface between two different media, met by a ray.
pub struct Interface<'a> {
    /// Direction of the ray.
    pub dir: DVec3,
    /// Where, µm.
    pub point: DVec3,
    /// Normal of the interface, towards the ray.
    pub normal: DVec3,
    /// Its surface.
    pub surface: SurfaceId,
    /// One of its faces.
    pub crossing: Crossing,
    /// Whether a stack of films may begin here.
    pub may_be_film: bool,
    /// Whether the face is so narrow that ray optics is in doubt.
    pub narrow: bool,
    /// What a ray is inside of behind it.
    pub inside: &'a Inside,
    /// What is behind it.
    pub around: Around,
}

/// Numbers that are drawn once for a tree: whether it looks for the edges of films, and how far its waves are coherent.
const EDGE: u32 = 2;
const COHERENCE: u32 = 3;
/// The number of an interface that parts wavelengths.
const PARTING: u32 = 4;
/// One in so many trees looks for the edges of films that are only to be told of.
const SAMPLED: f64 = 64.0;

/// Below this sine of the angle of incidence any plane of incidence will do.
const NORMAL: f64 = 1e-12;

/// Where the transmitted beam starts.
struct Behind<'a> {
    point: DVec3,
    surface: SurfaceId,
    at: PrimId,
    inside: &'a Inside,
    medium: MediumId,
    /// Periods by which it was moved.
    shift: [i32; 2],
}

/// How the transmitted beam is bent.
#[derive(Clone, Copy)]
enum Bend<'a> {
    /// There is none.
    Never,
    /// All lanes alike.
    Same(Refraction),
    /// By number of the lane; none in total reflection.
    PerLane(&'a [Option<Refraction>]),
}

impl Bend<'_> {
    fn same(refraction: Option<Refraction>) -> Self {
        refraction.map_or(Self::Never, Self::Same)
    }

    /// Whether a lane goes on behind the interface.
    #[inline(always)]
    fn lets_through(&self, lane: u16) -> bool {
        match self {
            Self::Never => false,
            Self::Same(_) => true,
            Self::PerLane(all) => all[usize::from(lane)].is_some(),
        }
    }
}

/// Working memory of one thread.
pub struct Scratch<F: Field> {
    beams: BeamTable<F::Passage>,
    bends: Vec<Option<Refraction>>,
    bundle: Bundle,
}

impl<F: Field> Scratch<F> {
    /// For so many lanes.
    pub fn new(lanes: usize) -> Self {
        Self { beams: BeamTable::new(lanes), bends: vec![None; lanes], bundle: Bundle::new::<F>(lanes) }
    }
}

/// The work of parting one ray.
pub struct Partition<'w, 'k, F, E, R> {
    /// What all rays share.
    pub kernel: &'w Kernel<'k>,
    /// The rays.
    pub stream: &'w mut Stream<F>,
    /// The one that met the interface.
    pub slot: Slot,
    /// The interface.
    pub interface: &'w Interface<'w>,
    /// Random numbers of its tree.
    pub numbers: TreeKey,
    /// Who listens.
    pub recorder: &'w mut R,
    /// The rays that go on.
    pub ready: &'w mut Vec<Slot>,
    /// Which effects are simulated.
    pub effects: PhantomData<E>,
}

impl<F: Field, E: Effects, R: Recorder<F>> Partition<'_, '_, F, E, R> {
    /// Parts the light.
    pub fn run(&mut self, films: &mut Films<F>, scratch: &mut Scratch<F>) {
        match self.interface.around {
            Around::Medium(last) => self.refract(films, scratch, last),
            Around::Opaque(solid) => match self.kernel.sample.solids[solid as usize].matter {
                Matter::Diffuse(share) => self.scatter(share, self.kernel.solids.group(solid)),
                Matter::Mirror(share) => self.mirror(&mut scratch.bundle, share, self.kernel.solids.group(solid)),
                Matter::Medium(_) => unreachable!("a medium is not opaque"),
            },
        }
    }

    /// A perfect conductor's signs.
    fn mirror(&mut self, bundle: &mut Bundle, share: f64, group: u16) {
        self.doubt();
        let a = C64::new(share.sqrt(), 0.0);
        let c = Coefficients { r: Pair { s: -a, p: a }, t: Pair { s: C64::ZERO, p: C64::ZERO } };
        let (action, absorber) = (Action::Uniform(Beams::new(&c)), Absorber::One(group));
        let encounter = Encounter { plane: &self.plane(), action, bend: Bend::Never, absorber };
        self.divide(bundle, &encounter, None);
    }

    fn refract(&mut self, films: &mut Films<F>, scratch: &mut Scratch<F>, last: MediumId) {
        let plane = self.plane();
        if E::FILMS && self.interface.may_be_film && self.pass_stack(films, scratch, &plane) {
            return;
        }
        self.doubt();
        let media = &self.kernel.media;
        let first = self.stream.flights[self.slot].medium;
        let Interface { point, surface, crossing, inside, .. } = *self.interface;
        let behind = Behind { point, surface, at: crossing.prim, inside, medium: last, shift: [0, 0] };
        let absorber = self.ends_in(last, inside);
        let (lane, alone) = self.stream.first_lane(self.slot);
        if E::PARTS && !alone && media.varies(first, last) {
            for lane in self.stream.lanes(self.slot) {
                let (beams, bend) = media.interface::<F>(first, last, lane, plane.slant);
                scratch.beams.set(usize::from(lane), &beams);
                scratch.bends[usize::from(lane)] = bend;
            }
            let (action, bend) = (Action::PerLane(&scratch.beams), Bend::PerLane(&scratch.bends));
            let encounter = Encounter { plane: &plane, action, bend, absorber };
            return self.divide(&mut scratch.bundle, &encounter, Some(&behind));
        }
        let (beams, refraction) = media.interface::<F>(first, last, lane, plane.slant);
        let (action, bend) = (Action::Uniform(beams), Bend::same(refraction));
        let encounter = Encounter { plane: &plane, action, bend, absorber };
        self.divide(&mut scratch.bundle, &encounter, Some(&behind));
    }

    /// What takes the power that an interface into a medium does not send on.
    #[inline(always)]
    fn ends_in(&self, last: MediumId, inside: &Inside) -> Absorber<'static> {
        if E::ABSORBS && self.kernel.media.is_opaque(last) {
            Absorber::One(self.kernel.solids.group_around(inside))
        } else {
            Absorber::None
        }
    }

    /// Passes the light through the stack that begins here, if one does.
    fn pass_stack(&mut self, films: &mut Films<F>, scratch: &mut Scratch<F>, plane: &Plane) -> bool {
        let kernel = self.kernel;
        let media = &kernel.media;
        let first = self.stream.flights[self.slot].medium;
        let Interface { dir, point, normal, surface, crossing, inside, .. } = *self.interface;
        let (lane, alone) = self.stream.first_lane(self.slot);
        let start = Start { point, normal, surface, crossing, inside, first, dir, slant: plane.slant, lane };
        if !self.finds_stack(films, &start) {
            return false;
        }
        let power: f64 = self.stream.loads(self.slot).map(|(_, field)| field.power()).sum();
        let Found { stack, beams, absorption } = films.solve(&kernel.world(), &start, power / kernel.lanes() as f64);
        let behind = Behind {
            point: stack.exit,
            surface: stack.surface,
            at: stack.crossing.prim,
            inside: &stack.inside,
            medium: stack.last,
            shift: stack.shift,
        };
        let absorber = match absorption {
            Some(absorption) if E::ABSORBS => Absorber::Layers(absorption),
            _ => self.ends_in(stack.last, &stack.inside),
        };
        let bend = if E::PARTS && !alone && media.varies(first, stack.last) {
            for lane in self.stream.lanes(self.slot) {
                scratch.bends[usize::from(lane)] = media.refraction(first, stack.last, lane, plane.slant);
            }
            Bend::PerLane(&scratch.bends)
        } else {
            Bend::same(media.refraction(first, stack.last, lane, plane.slant))
        };
        let encounter = Encounter { plane, action: Action::PerLane(beams), bend, absorber };
        self.divide(&mut scratch.bundle, &encounter, Some(&behind));
        true
    }

    /// Whether a stack begins here that is to be taken as one.
    fn finds_stack(&mut self, films: &mut Films<F>, start: &Start<'_>) -> bool {
        let kernel = self.kernel;
        let rules = &kernel.plan.films;
        let coherence = rules.coherence.length(decision(self.numbers.key, 0, 0, COHERENCE));
        let told = self.stream.flights[self.slot].edge;
        let (edges, weight) = match rules.edges {
            Edges::Reject => (true, 1.0),
            // Only told, so some trees stand for all.
            Edges::Column => (!told && decision(self.numbers.key, 0, 0, EDGE) < 1.0 / SAMPLED, SAMPLED),
        };
        let reach = Reach { depth: kernel.sample.cell.reach, coherence, edges };
        let world = kernel.world();
        if !films.search(&world, start, reach) {
            return false;
        }
        if !edges || !films.near_edge(&world, start) {
            return true;
        }
        if !std::mem::replace(&mut self.stream.flights[self.slot].edge, true) {
            self.stream.loads(self.slot).for_each(|(lane, field)| self.recorder.edge(lane, weight * field.power()));
        }
        rules.edges == Edges::Column
    }

    /// Tells of a ray that meets a narrow face for the first time.
    #[inline(always)]
    fn doubt(&mut self) {
        if self.interface.narrow && !std::mem::replace(&mut self.stream.flights[self.slot].doubtful, true) {
            self.tell_doubt();
        }
    }

    #[cold]
    fn tell_doubt(&mut self) {
        self.stream.loads(self.slot).for_each(|(lane, field)| self.recorder.doubt(lane, field.power()));
    }

    /// Whether the interface is plane.
    #[inline]
    fn is_plane(&self) -> bool {
        self.kernel.scene.primitives().plane(self.interface.surface).is_some()
    }

    fn plane(&self) -> Plane {
        Plane::new(self.interface.dir, self.interface.normal, self.stream.flights[self.slot].frame)
    }

    /// Lambert reflection: a direction with density cos θ/π, unpolarized.
    fn scatter(&mut self, share: f64, group: u16) {
        self.doubt();
        let slot = self.slot;
        for word in 0..self.stream.words() {
            for bit in Bits(self.stream.word(slot, word)) {
                let lane = (64 * word) as u16 + bit;
                let field = self.stream.field(slot, lane);
                self.recorder.absorb(group, lane, (1.0 - share) * field.power());
                self.stream.put(slot, lane, field.depolarized(share));
            }
        }
        if share == 0.0 {
            return self.stream.remove(slot);
        }
        let Flight { events, branch, .. } = self.stream.flights[slot];
        let (r2, turn) = (draw(branch, events, self.numbers), decision(self.numbers.key, branch, events, 1));
        let (sin, cos) = (std::f64::consts::TAU * turn).sin_cos();
        let Interface { point, normal, surface, crossing, .. } = *self.interface;
        let (u, v) = normal.any_orthonormal_pair();
        let dir = unit(r2.sqrt() * (cos * u + sin * v) + (1.0 - r2).sqrt() * normal);
        let primitives = self.kernel.scene.primitives();
        self.stream.queries[slot] = primitives.query_leaving(Ray { origin: point, dir }, surface);
        let f = &mut self.stream.flights[slot];
        (f.frame, f.at, f.events) = (dir.any_orthonormal_vector(), crossing.prim, events + 1);
        self.settle(slot);
    }
}

/// The plane of incidence.
struct Plane {
    /// Unit vector across it.
    s: DVec3,
    /// Angle of incidence.
    slant: Slant,
    /// p̂ = cos·x̂ + sin·ŷ in the frame of the ray.
    cos: f64,
    sin: f64,
}

impl Plane {
    /// Of a ray of direction `dir` with frame vector x̂ at an interface.
    #[inline]
    fn new(dir: DVec3, normal: DVec3, x: DVec3) -> Self {
        let across = dir.cross(normal);
        let slant = Slant { cos: (-normal.dot(dir)).clamp(0.0, 1.0), sin: across.length() };
        if slant.sin < NORMAL {
            return Self { s: dir.cross(x), slant, cos: 1.0, sin: 0.0 };
        }
        let s = across / slant.sin;
        // ŷ·p̂ = −x̂·ŝ, for both frames are right-handed about the ray.
        Self { s, slant, cos: x.dot(s.cross(dir)), sin: -x.dot(s) }
    }
}

/// The random number of this interface: Sobol for the first decision after a split, then hashed.
fn draw(branch: u32, events: u32, numbers: TreeKey) -> f64 {
    match (events, branch) {
        (1, branch @ 2..=3) => numbers.first[branch as usize - 2],
        (event, branch) => decision(numbers.key, branch, event, 0),
    }
}

/// The direction with its length corrected; near 1 it only needs one step.
#[inline]
fn unit(v: DVec3) -> DVec3 {
    v * (1.5 - 0.5 * v.length_squared())
}
