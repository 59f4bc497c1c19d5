//! A ray at an interface: into a reflected and a transmitted beam, or into one of them by lot.
//!
//! While a tree may still split, both beams go on with their shares of the power. After that each lane goes one
//! way, chosen with the probability of its share, and keeps all its power: so every tree conserves energy for
//! every lane, exactly. All lanes of a ray use one random number; lanes that choose differently go on as two rays.
//! What a lane does depends on its own coefficients only, so it follows the same path alone or in a bundle.

use glam::DVec3;

use super::films::{Films, Start, one_interface};
use super::inside::Inside;
use super::kernel::{Kernel, TreeKey};
use super::random::decision;
use super::record::Recorder;
use super::stream::{Flight, Load};
use crate::geometry::{Crossing, Order, PrimId, Ray, SurfaceId};
use crate::optics::jones::Jones;
use crate::optics::{C64, Coefficients, Pair, fresnel};
use crate::sample::{Matter, MediumId};

/// A ray that has met an interface between two different media.
pub struct Interface<'a> {
    /// The ray.
    pub flight: &'a Flight,
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
    /// What a ray is inside of behind it.
    pub inside: Inside,
    /// What is behind it.
    pub matter: Matter,
}

/// A ray after the interface, with its lanes; not there if it has none.
#[derive(Debug)]
pub struct Beam<const C: usize> {
    /// The ray.
    pub flight: Flight,
    /// Its lanes.
    pub lanes: Vec<u16>,
    /// Their fields.
    pub fields: Vec<Jones<C>>,
}

/// Shares of the power between this and 1 minus this are followed both while a tree splits.
const SPLIT_ABOVE: f64 = 0.01;

/// Below this sine of the angle of incidence any plane of incidence will do.
const NORMAL: f64 = 1e-12;

/// The beams of one interface; their memory is reused from ray to ray.
#[derive(Debug)]
pub struct Beams<const C: usize> {
    reflected: Beam<C>,
    transmitted: Beam<C>,
}

/// Where the transmitted beam starts.
struct Behind {
    point: DVec3,
    surface: SurfaceId,
    at: PrimId,
    inside: Inside,
    medium: MediumId,
    /// Refractive index before over behind, and cosine of the angle of refraction; `None` in total reflection and
    /// where nothing is transmitted.
    refraction: Option<(f64, f64)>,
}

/// What the interface does to each lane.
enum Action<'a> {
    /// The same to all.
    Uniform(Coefficients),
    /// By number of the lane.
    PerLane(&'a [Coefficients]),
}

impl Action<'_> {
    #[inline]
    fn of(&self, lane: u16) -> &Coefficients {
        match self {
            Self::Uniform(c) => c,
            Self::PerLane(table) => &table[usize::from(lane)],
        }
    }
}

impl<const C: usize> Default for Beams<C> {
    fn default() -> Self {
        let nowhere = Ray { origin: DVec3::ZERO, dir: DVec3::Z };
        let beam = || Beam {
            flight: Flight::start(nowhere, DVec3::X, MediumId(0), 0),
            lanes: Vec::new(),
            fields: Vec::new(),
        };
        Self { reflected: beam(), transmitted: beam() }
    }
}

impl<const C: usize> Beams<C> {
    /// The beams that carry light.
    pub fn parts(&self) -> impl Iterator<Item = &Beam<C>> {
        [&self.reflected, &self.transmitted].into_iter().filter(|b| !b.lanes.is_empty())
    }

    /// Parts the light of a ray.
    pub fn part(
        &mut self,
        kernel: &Kernel<'_>,
        films: &mut Films,
        interface: &Interface<'_>,
        load: Load<'_, C>,
        numbers: &TreeKey,
        recorder: &mut impl Recorder<C>,
    ) {
        for beam in [&mut self.reflected, &mut self.transmitted] {
            beam.lanes.clear();
            beam.fields.clear();
        }
        match interface.matter {
            Matter::Diffuse(share) => self.scatter(interface, share, load, numbers, recorder),
            Matter::Mirror(share) => {
                // A perfect conductor's signs.
                let a = C64::new(share.sqrt(), 0.0);
                let c = Coefficients { r: Pair { s: -a, p: a }, t: Pair { s: C64::ZERO, p: C64::ZERO } };
                self.divide(kernel, interface, &Action::Uniform(c), None, true, load, numbers, recorder);
            }
            Matter::Medium(last) => self.refract(kernel, films, interface, last, load, numbers, recorder),
        }
    }

    #[expect(clippy::too_many_arguments, reason = "all of it changes from ray to ray")]
    fn refract(
        &mut self,
        kernel: &Kernel<'_>,
        films: &mut Films,
        interface: &Interface<'_>,
        last: MediumId,
        load: Load<'_, C>,
        numbers: &TreeKey,
        recorder: &mut impl Recorder<C>,
    ) {
        let optics = &kernel.optics;
        let flight = interface.flight;
        let first = flight.medium;
        let lane = load.lanes[0];
        let cos = interface.cos();
        let refraction = |last: MediumId| {
            if optics.is_opaque(last) {
                return None;
            }
            let (n1, n2) = (optics.index(first, lane).re, optics.index(last, lane).re);
            fresnel::refracted_cos(n1, n2, cos).map(|cos_t| (n1 / n2, cos_t))
        };
        if interface.may_be_film {
            let start = Start {
                point: interface.point,
                normal: interface.normal,
                surface: interface.surface,
                inside: &interface.inside,
                first,
                cos,
            };
            let (reach, coherence) = (kernel.sample.cell.reach, kernel.plan.coherence_length);
            if let Some((stack, table)) = films.find(kernel.scene, &kernel.ledger, optics, &start, reach, coherence) {
                // Straight below: there the phase of t is referred to, and there the media were found.
                let point = interface.point - stack.depth * interface.normal;
                let behind = Behind {
                    point: kernel.scene.primitives().snap(stack.crossing, stack.surface, point),
                    surface: stack.surface,
                    at: stack.crossing.prim,
                    inside: stack.inside,
                    medium: stack.last,
                    refraction: refraction(stack.last),
                };
                let absorbs = optics.is_opaque(stack.last)
                    || stack.layers.iter().any(|(m, _)| optics.absorbs[usize::from(m.0)]);
                let action = Action::PerLane(table);
                return self.divide(kernel, interface, &action, Some(behind), absorbs, load, numbers, recorder);
            }
        }
        let behind = Behind {
            point: interface.point,
            surface: interface.surface,
            at: interface.crossing.prim,
            inside: interface.inside,
            medium: last,
            refraction: refraction(last),
        };
        let varies = optics.varies[usize::from(first.0)] || optics.varies[usize::from(last.0)];
        let action = if varies && load.lanes.len() > 1 {
            Action::PerLane(films.interface(optics, first, last, cos))
        } else {
            Action::Uniform(one_interface(optics, first, last, cos, lane))
        };
        self.divide(kernel, interface, &action, Some(behind), optics.is_opaque(last), load, numbers, recorder);
    }

    /// Gives each lane its share in the reflected and the transmitted beam, or lets it choose one.
    #[expect(clippy::too_many_arguments, reason = "all of it changes from ray to ray")]
    #[inline]
    fn divide(
        &mut self,
        kernel: &Kernel<'_>,
        interface: &Interface<'_>,
        action: &Action<'_>,
        behind: Option<Behind>,
        absorbs: bool,
        load: Load<'_, C>,
        numbers: &TreeKey,
        recorder: &mut impl Recorder<C>,
    ) {
        let flight = interface.flight;
        let splits = flight.events < kernel.plan.limits.splits;
        let plane = Plane::new(interface);
        let transmits = behind.as_ref().is_some_and(|b| b.refraction.is_some());
        let mut lot = None;
        for (&lane, field) in load.lanes.iter().zip(load.fields) {
            let c = action.of(lane);
            let field = field.rotated(plane.cos, plane.sin);
            let [p, s] = field.powers();
            let reflected = c.r.p.norm_sqr() * p + c.r.s.norm_sqr() * s;
            let transmitted = if transmits { c.t.p.norm_sqr() * p + c.t.s.norm_sqr() * s } else { 0.0 };
            let kept = reflected + transmitted;
            if absorbs {
                recorder.absorb(lane, p + s - kept);
            }
            if kept <= 0.0 {
                continue;
            }
            let share = reflected / kept;
            if splits && share > SPLIT_ABOVE && share < 1.0 - SPLIT_ABOVE {
                self.reflected.add(lane, field.times(c.r));
                self.transmitted.add(lane, field.times(c.t));
                continue;
            }
            if *lot.get_or_insert_with(|| draw(flight, numbers)) < share {
                self.reflected.add(lane, field.times(c.r).scaled((1.0 / share).sqrt()));
            } else {
                self.transmitted.add(lane, field.times(c.t).scaled((1.0 / (1.0 - share)).sqrt()));
            }
        }
        self.place(interface, &plane, behind, splits);
    }

    /// Sets the directions and frames of both beams.
    fn place(&mut self, interface: &Interface<'_>, plane: &Plane, behind: Option<Behind>, splits: bool) {
        let flight = interface.flight;
        let d = flight.ray.dir;
        let cos = interface.cos();
        let branch = |side: u32| if splits { 2 * flight.branch + side } else { flight.branch };
        let base = Flight { from: Order { t: 0.0, surface: SurfaceId::LAST }, events: flight.events + 1, ..*flight };
        if !self.reflected.lanes.is_empty() {
            let dir = unit(d + 2.0 * cos * interface.normal);
            self.reflected.flight = Flight {
                ray: Ray { origin: interface.point, dir },
                frame: plane.s.cross(dir),
                last: interface.surface,
                at: interface.crossing.prim,
                branch: branch(0),
                ..base
            };
        }
        let Some(behind) = behind else { return };
        let Some((ratio, cos_t)) = behind.refraction else { return };
        let dir = unit(ratio * d + (ratio * cos - cos_t) * interface.normal);
        self.transmitted.flight = Flight {
            ray: Ray { origin: behind.point, dir },
            frame: plane.s.cross(dir),
            last: behind.surface,
            at: behind.at,
            inside: behind.inside,
            medium: behind.medium,
            branch: branch(1),
            ..base
        };
    }

    /// Lambert reflection: a direction with density cos θ/π, unpolarized.
    fn scatter(
        &mut self,
        interface: &Interface<'_>,
        share: f64,
        load: Load<'_, C>,
        numbers: &TreeKey,
        recorder: &mut impl Recorder<C>,
    ) {
        let flight = interface.flight;
        for (&lane, field) in load.lanes.iter().zip(load.fields) {
            let power = field.power();
            recorder.absorb(lane, (1.0 - share) * power);
            if share > 0.0 {
                self.reflected.add(lane, Jones::depolarized(share * power));
            }
        }
        let (r2, turn) = (draw(flight, numbers), decision(numbers.key, flight.branch, flight.events, 1));
        let (sin, cos) = (std::f64::consts::TAU * turn).sin_cos();
        let (u, v) = interface.normal.any_orthonormal_pair();
        let dir = unit(r2.sqrt() * (cos * u + sin * v) + (1.0 - r2).sqrt() * interface.normal);
        self.reflected.flight = Flight {
            ray: Ray { origin: interface.point, dir },
            frame: dir.any_orthonormal_vector(),
            from: Order { t: 0.0, surface: SurfaceId::LAST },
            last: interface.surface,
            at: interface.crossing.prim,
            events: flight.events + 1,
            ..*flight
        };
    }
}

impl<const C: usize> Beam<C> {
    #[inline]
    fn add(&mut self, lane: u16, field: Jones<C>) {
        self.lanes.push(lane);
        self.fields.push(field);
    }
}

impl Interface<'_> {
    /// Cosine of the angle of incidence.
    fn cos(&self) -> f64 {
        (-self.normal.dot(self.flight.ray.dir)).clamp(0.0, 1.0)
    }
}

/// The plane of incidence.
struct Plane {
    /// Unit vector across it.
    s: DVec3,
    /// p̂ = cos·x̂ + sin·ŷ in the frame of the ray.
    cos: f64,
    sin: f64,
}

impl Plane {
    fn new(interface: &Interface<'_>) -> Self {
        let Flight { ray, frame: x, .. } = *interface.flight;
        let across = ray.dir.cross(interface.normal);
        let length = across.length();
        if length < NORMAL {
            return Self { s: ray.dir.cross(x), cos: 1.0, sin: 0.0 };
        }
        let s = across / length;
        let p = s.cross(ray.dir);
        let (cos, sin) = (x.dot(p), x.dot(s));
        // ŷ·p̂ = −x̂·ŝ, for both frames are right-handed about the ray. Kept a rotation to rounding.
        let norm = cos.hypot(sin);
        Self { s, cos: cos / norm, sin: -sin / norm }
    }
}

/// The random number of this interface: Sobol for the first decision after a split, then hashed.
fn draw(flight: &Flight, numbers: &TreeKey) -> f64 {
    match (flight.events, flight.branch) {
        (1, branch @ 2..=3) => numbers.first[branch as usize - 2],
        (event, branch) => decision(numbers.key, branch, event, 0),
    }
}

/// The direction with its length corrected; near 1 it only needs one step.
#[inline]
fn unit(v: DVec3) -> DVec3 {
    v * (1.5 - 0.5 * v.length_squared())
}
