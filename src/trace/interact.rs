//! A ray at an interface: into a reflected and a transmitted beam, or into one of them by lot.
//!
//! While a tree may still split, both beams go on with their shares of the power. After that each lane goes one
//! way, chosen with the probability of its share, and keeps all its power: so every tree conserves energy for
//! every lane, exactly. All lanes of a ray use one random number; lanes that choose differently go on as two rays.
//! What a lane does depends on its own coefficients only, so it follows the same path alone or in a bundle.

use glam::DVec3;

use super::films::{Films, Found};
use super::finder::{Reach, Start};
use super::inside::{Around, Inside};
use super::kernel::{Kernel, Stop};
use super::media::{Beams, Refraction, Slant};
use super::random::{TreeKey, decision};
use super::record::{Loss, Recorder};
use super::stream::{Bits, Flight, Slot, Stream};

use crate::geometry::{Crossing, PrimId, Ray, SurfaceId};
use crate::optics::batch::Film;
use crate::optics::field::{Field, Passage};
use crate::optics::{C64, Coefficients, Pair};
use crate::plan::Edges;
use crate::sample::{Matter, MediumId};

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

/// While a tree splits, both beams are followed unless one has less than this share of the power. Far below what can be
/// measured: the reflection of an antireflection coating is a small share that people want to know well.
const SPLIT_ABOVE: f64 = 1e-9;

/// Numbers that are drawn once for a tree: whether it looks for the edges of films, and how far its waves are coherent.
const EDGE: u32 = 2;
const COHERENCE: u32 = 3;
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
    refraction: Refraction,
    /// Periods by which it was moved.
    shift: [i32; 2],
}

/// What an interface does to each lane.
enum Action<'a, P> {
    /// The same to all.
    Uniform(Beams<P>),
    /// By number of the lane.
    PerLane(&'a [Beams<P>]),
}

/// The work of parting one ray.
pub struct Partition<'w, 'k, F, R> {
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
}

/// The slots of the reflected and the transmitted beam.
pub type BeamSlots = [Option<Slot>; 2];

const REFLECTED: usize = 0;
const TRANSMITTED: usize = 1;

impl<F: Field, R: Recorder<F>> Partition<'_, '_, F, R> {
    /// Parts the light; returns the slots of the beams that go on.
    pub fn run(&mut self, films: &mut Films<F>) -> BeamSlots {
        match self.interface.around {
            Around::Medium(last) => self.refract(films, last),
            Around::Opaque(solid) => match self.kernel.sample.solids[solid as usize].matter {
                Matter::Diffuse(share) => self.scatter(share),
                Matter::Mirror(share) => self.mirror(share),
                Matter::Medium(_) => unreachable!("a medium is not opaque"),
            },
        }
    }

    /// A perfect conductor's signs.
    fn mirror(&mut self, share: f64) -> BeamSlots {
        self.doubt();
        let a = C64::new(share.sqrt(), 0.0);
        let c = Coefficients { r: Pair { s: -a, p: a }, t: Pair { s: C64::ZERO, p: C64::ZERO } };
        let plane = self.plane();
        self.divide(&plane, &Action::Uniform(Beams::new(&c)), None, true)
    }

    fn refract(&mut self, films: &mut Films<F>, last: MediumId) -> BeamSlots {
        let kernel = self.kernel;
        let media = &kernel.media;
        let first = self.stream.flights[self.slot].medium;
        let Interface { point, normal, surface, crossing, inside, .. } = *self.interface;
        let (lane, alone) = self.stream.first_lane(self.slot);
        let plane = self.plane();
        if self.interface.may_be_film {
            let dir = self.interface.dir;
            let start = Start { point, normal, surface, crossing, inside, first, dir, slant: plane.slant, lane };
            if self.finds_stack(films, &start) {
                let power: f64 = self.stream.loads(self.slot).map(|(_, field)| field.power()).sum();
                let Found { stack, beams } = films.solve(&kernel.world(), &start, power / self.kernel.lanes() as f64);
                let refraction = media.refraction(first, stack.last, lane, plane.slant);
                let behind = refraction.map(|refraction| Behind {
                    point: stack.exit,
                    surface: stack.surface,
                    at: stack.crossing.prim,
                    inside: &stack.inside,
                    medium: stack.last,
                    refraction,
                    shift: stack.shift,
                });
                let layer_absorbs = |l: &Film| media.absorbs(MediumId(l.medium as u16));
                let absorbs = media.is_opaque(stack.last) || stack.layers.iter().any(layer_absorbs);
                return self.divide(&plane, &Action::PerLane(beams), behind, absorbs);
            }
        }
        self.doubt();
        let (action, refraction) = if media.varies(first, last) && !alone {
            let table = films.interface(media, first, last, plane.slant);
            (Action::PerLane(table), media.refraction(first, last, lane, plane.slant))
        } else {
            let (beams, refraction) = media.interface::<F>(first, last, lane, plane.slant);
            (Action::Uniform(beams), refraction)
        };
        let behind = refraction.map(|refraction| Behind {
            point,
            surface,
            at: crossing.prim,
            inside,
            medium: last,
            refraction,
            shift: [0, 0],
        });
        self.divide(&plane, &action, behind, media.is_opaque(last))
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
    #[inline]
    fn doubt(&mut self) {
        let doubtful = &mut self.stream.flights[self.slot].doubtful;
        if self.interface.narrow && !std::mem::replace(doubtful, true) {
            self.stream.loads(self.slot).for_each(|(lane, field)| self.recorder.doubt(lane, field.power()));
        }
    }

    /// Gives each lane its share in the reflected and the transmitted beam, or lets it choose one.
    #[inline(always)]
    fn divide(
        &mut self,
        plane: &Plane,
        action: &Action<'_, F::Passage>,
        behind: Option<Behind<'_>>,
        absorbs: bool,
    ) -> BeamSlots {
        let slot = self.slot;
        let Flight { events, branch, .. } = self.stream.flights[slot];
        let splits = events < self.kernel.plan.limits.splits;
        let mut beams = [None; 2];
        let mut lot = None;
        for word in 0..self.stream.words() {
            for bit in Bits(self.stream.word(slot, word)) {
                let lane = (64 * word) as u16 + bit;
                let Beams { reflected: r, transmitted: t } = match action {
                    Action::Uniform(beams) => beams,
                    Action::PerLane(table) => &table[usize::from(lane)],
                };
                let field = self.stream.field(slot, lane).rotated(plane.cos, plane.sin);
                let [p, s] = field.powers();
                let part = |shares: Pair<f64>| shares.p * p + shares.s * s;
                let reflected = part(r.shares());
                let transmitted = if behind.is_some() { part(t.shares()) } else { 0.0 };
                let kept = if absorbs { reflected + transmitted } else { p + s };
                self.stream.drop_lane(slot, lane);
                if absorbs {
                    self.recorder.absorb(lane, p + s - kept);
                }
                if kept <= 0.0 {
                    continue;
                }
                let both = splits && reflected.min(transmitted) > SPLIT_ABOVE * kept;
                if both {
                    self.follow(&mut beams, REFLECTED, lane, field.times(r), reflected);
                    self.follow(&mut beams, TRANSMITTED, lane, field.times(t), transmitted);
                } else if transmitted == 0.0
                    || *lot.get_or_insert_with(|| draw(branch, events, self.numbers)) * kept < reflected
                {
                    self.give(&mut beams, REFLECTED, lane, field.times(r).scaled(kept / reflected));
                } else {
                    self.give(&mut beams, TRANSMITTED, lane, field.times(t).scaled(kept / transmitted));
                }
            }
        }
        self.send(plane, behind.as_ref(), splits, beams)
    }

    /// Gives a lane to a beam if it is not too faint.
    #[inline(always)]
    fn follow(&mut self, beams: &mut BeamSlots, side: usize, lane: u16, field: F, power: f64) {
        if power >= self.kernel.plan.limits.faintest {
            self.give(beams, side, lane, field);
        } else {
            self.recorder.lose(Loss::Depth, lane, power);
        }
    }

    /// Gives a lane to a beam. Whichever beam gets the first lane keeps the slot of the ray.
    #[inline(always)]
    fn give(&mut self, beams: &mut BeamSlots, side: usize, lane: u16, field: F) {
        let slot = match (beams[side], beams[1 - side]) {
            (Some(slot), _) => slot,
            (None, None) => self.slot,
            (None, Some(_)) => self.stream.fork(self.slot),
        };
        beams[side] = Some(slot);
        self.stream.put(slot, lane, field);
    }

    /// Sets the directions of both beams; gives up those that need not be followed.
    #[inline]
    fn send(&mut self, plane: &Plane, behind: Option<&Behind<'_>>, splits: bool, beams: BeamSlots) -> BeamSlots {
        let Interface { dir, point, normal, surface, crossing, .. } = *self.interface;
        let at = crossing.prim;
        let cos = plane.slant.cos;
        // Of very deep trees only the last 32 turns tell branches apart.
        let next_branch = |branch: u32, side: u32| if splits { branch << 1 | side } else { branch };
        let primitives = self.kernel.scene.primitives();
        let reflected = beams[REFLECTED].filter(|&slot| {
            let dir = unit(dir + 2.0 * cos * normal);
            self.stream.queries[slot] = primitives.query_leaving(Ray { origin: point, dir }, surface);
            let f = &mut self.stream.flights[slot];
            (f.frame, f.at, f.branch, f.events) = (plane.s.cross(dir), at, next_branch(f.branch, 0), f.events + 1);
            self.settle(slot)
        });
        let transmitted = beams[TRANSMITTED].zip(behind).and_then(|(slot, b)| {
            let Refraction { ratio, cos: cos_t } = b.refraction;
            let dir = unit(ratio * dir + (ratio * cos - cos_t) * normal);
            self.stream.queries[slot] = primitives.query_leaving(Ray { origin: b.point, dir }, b.surface);
            let f = &mut self.stream.flights[slot];
            (f.frame, f.at, f.branch, f.events) = (plane.s.cross(dir), b.at, next_branch(f.branch, 1), f.events + 1);
            f.walk = [f.walk[0] - b.shift[0], f.walk[1] - b.shift[1]];
            f.medium = b.medium;
            f.inside.clone_from(b.inside);
            self.settle(slot).then_some(slot)
        });
        if beams == [None; 2] {
            self.stream.remove(self.slot);
        }
        [reflected, transmitted]
    }

    /// Whether a beam is to be followed; if not, its power is accounted for.
    #[inline(always)]
    fn settle(&mut self, slot: Slot) -> bool {
        let Stream { queries, flights, .. } = self.stream;
        match self.kernel.settle(&mut queries[slot], &mut flights[slot]) {
            Ok(()) => true,
            Err(stop) => {
                self.give_up(slot, stop);
                false
            }
        }
    }

    #[cold]
    fn give_up(&mut self, slot: Slot, stop: Stop) {
        for (lane, field) in self.stream.loads(slot) {
            match stop {
                Stop::Side => self.recorder.side(lane, field.power()),
                Stop::NoCopy => self.recorder.lose(Loss::Numeric, lane, field.power()),
            }
        }
        self.stream.remove(slot);
    }

    fn plane(&self) -> Plane {
        Plane::new(self.interface.dir, self.interface.normal, self.stream.flights[self.slot].frame)
    }

    /// Lambert reflection: a direction with density cos θ/π, unpolarized.
    fn scatter(&mut self, share: f64) -> BeamSlots {
        self.doubt();
        let slot = self.slot;
        for word in 0..self.stream.words() {
            for bit in Bits(self.stream.word(slot, word)) {
                let lane = (64 * word) as u16 + bit;
                let power = self.stream.field(slot, lane).power();
                self.recorder.absorb(lane, (1.0 - share) * power);
                self.stream.put(slot, lane, F::unpolarized(share * power));
            }
        }
        let Flight { events, branch, .. } = self.stream.flights[slot];
        if share == 0.0 {
            self.stream.remove(slot);
            return [None; 2];
        }
        let (r2, turn) = (draw(branch, events, self.numbers), decision(self.numbers.key, branch, events, 1));
        let (sin, cos) = (std::f64::consts::TAU * turn).sin_cos();
        let Interface { point, normal, surface, crossing, .. } = *self.interface;
        let (u, v) = normal.any_orthonormal_pair();
        let dir = unit(r2.sqrt() * (cos * u + sin * v) + (1.0 - r2).sqrt() * normal);
        let primitives = self.kernel.scene.primitives();
        self.stream.queries[slot] = primitives.query_leaving(Ray { origin: point, dir }, surface);
        let f = &mut self.stream.flights[slot];
        (f.frame, f.at, f.events) = (dir.any_orthonormal_vector(), crossing.prim, events + 1);
        [self.settle(slot).then_some(slot), None]
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
