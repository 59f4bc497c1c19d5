//! Follows the rays of a chunk of trees, generation by generation.

use glam::DVec3;

use super::films::{Films, OPAQUE, Optics};
use super::inside::Ledger;
use super::interact::{Beams, Interface};
use super::record::{Exit, Loss, Recorder};
use super::stream::{Flight, Load, Stream};
use crate::geometry::{Crossing, Nearest, Order, PrimId, Query, Ray, SurfaceId};
use crate::intersect::{Coherence, Scene};
use crate::light::{Incidence, Light, Polarization};
use crate::optics::jones::Jones;
use crate::plan::Plan;
use crate::sample::{Matter, Sample};

/// Everything the tracer reads: shared by all workers, changed by none.
pub struct Kernel<'a> {
    pub(super) scene: &'a Scene,
    pub(super) sample: &'a Sample,
    pub(super) plan: &'a Plan,
    pub(super) ledger: Ledger,
    pub(super) optics: Optics,
    /// Surfaces of more than one face: leaving a body there may enter another.
    shared: Vec<bool>,
    follow_phase: bool,
}

impl<'a> Kernel<'a> {
    /// For a sample, the scene of its primitives, and the plan for it.
    pub fn new(sample: &'a Sample, scene: &'a Scene, plan: &'a Plan, light: &Light) -> Self {
        let wavelengths: Vec<f64> = light.wavelengths.um().collect();
        let index: Vec<Vec<_>> =
            sample.media.iter().map(|m| plan.lanes.iter().map(|&w| m.index[w]).collect()).collect();
        let optics = Optics {
            wavelengths: plan.lanes.iter().map(|&w| wavelengths[w]).collect(),
            opaque: sample.media.iter().map(|m| m.index.iter().any(|n| n.im > OPAQUE * n.re)).collect(),
            varies: index.iter().map(|n| n.iter().any(|x| x != &n[0])).collect(),
            absorbs: sample.media.iter().map(|m| m.absorbs()).collect(),
            index,
        };
        let shared = shared_surfaces(scene);
        Self { scene, sample, plan, ledger: Ledger::new(sample), optics, shared, follow_phase: false }
    }

    /// The same, with lengths and anchors reported at exits, from which the phase follows.
    #[must_use]
    pub fn with_phase(self) -> Self {
        Self { follow_phase: true, ..self }
    }

    /// The plan.
    pub fn plan(&self) -> &'a Plan {
        self.plan
    }

    /// Number of lanes.
    pub fn lanes(&self) -> usize {
        self.plan.lanes.len()
    }
}

/// Which surfaces belong to more than one face.
fn shared_surfaces(scene: &Scene) -> Vec<bool> {
    let primitives = scene.primitives();
    let mut faces = vec![0u8; primitives.surface_count() + 1];
    for i in 0..primitives.len() as u32 {
        for surface in primitives.faces(PrimId(i)) {
            let n = &mut faces[surface.0 as usize];
            *n = n.saturating_add(1);
        }
    }
    faces.into_iter().map(|n| n > 1).collect()
}

/// What ends a segment if no interface does.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Border {
    /// Nothing more can be met.
    Out,
    /// The ray goes on, moved by these periods.
    Seam([i32; 2]),
}

/// Where a segment ends.
#[derive(Clone, Copy)]
enum End {
    Border,
    Analytic(Order, Crossing),
    Asked(usize),
}

/// The working memory of one thread.
pub struct Tracer<'k, 'a, const C: usize> {
    kernel: &'k Kernel<'a>,
    now: Stream<C>,
    next: Stream<C>,
    queries: Vec<Query>,
    answers: Vec<Nearest>,
    ends: Vec<(End, Border)>,
    films: Films,
    beams: Beams<C>,
    keys: Vec<TreeKey>,
    first_tree: u32,
}

/// Random numbers of a tree, as far as its rays need them.
#[derive(Clone, Copy, Debug)]
pub struct TreeKey {
    /// Key of all later decisions.
    pub key: u64,
    /// First decision of the branches 2 and 3.
    pub first: [f64; 2],
}

impl<'k, 'a, const C: usize> Tracer<'k, 'a, C> {
    /// Memory for one thread.
    pub fn new(kernel: &'k Kernel<'a>) -> Self {
        let media = if kernel.follow_phase { kernel.sample.media.len() } else { 0 };
        Self {
            kernel,
            now: Stream::new(media),
            next: Stream::new(media),
            queries: Vec::new(),
            answers: Vec::new(),
            ends: Vec::new(),
            films: Films::new(),
            beams: Beams::default(),
            keys: Vec::new(),
            first_tree: 0,
        }
    }

    /// Traces one tree per entry point (coordinates of the footprint in [0, 1)²), to the end. Trees are numbered
    /// from `first_tree`.
    pub fn trace(
        &mut self,
        incidence: &Incidence,
        polarization: Polarization,
        first_tree: u32,
        entries: impl Iterator<Item = ([f64; 2], TreeKey)>,
        recorder: &mut impl Recorder<C>,
    ) {
        self.first_tree = first_tree;
        self.launch(incidence, polarization, entries);
        let mut coherence = Coherence::Coherent;
        while !self.now.is_empty() {
            self.intersect(coherence, recorder);
            coherence = Coherence::Scattered;
            self.next.clear();
            for i in 0..self.now.flights().len() {
                self.advance(i, recorder);
            }
            std::mem::swap(&mut self.now, &mut self.next);
        }
    }

    /// The media sequences of the stacks met so far, with how often each was met.
    pub fn into_stack_counts(self) -> Vec<(Vec<u16>, u64)> {
        self.films.into_counts().into_iter().map(|(media, n)| (media.into(), n)).collect()
    }

    fn launch(
        &mut self,
        incidence: &Incidence,
        polarization: Polarization,
        entries: impl Iterator<Item = ([f64; 2], TreeKey)>,
    ) {
        let kernel = self.kernel;
        let (dir, frame) = (incidence.propagation(), incidence.p_direction());
        let field = match polarization {
            Polarization::Unpolarized => Jones::depolarized(1.0),
            Polarization::S => Jones::linear(false),
            Polarization::P => Jones::linear(true),
        };
        let fields = vec![field; kernel.lanes()];
        let lengths = vec![0.0; if kernel.follow_phase { kernel.sample.media.len() } else { 0 }];
        let cell = &kernel.sample.cell;
        self.now.clear();
        self.keys.clear();
        for (tree, ([x, y], key)) in entries.enumerate() {
            self.keys.push(key);
            let origin = DVec3::new((x - 0.5) * cell.size.x, (y - 0.5) * cell.size.y, cell.heights.1);
            let flight = Flight::start(Ray { origin, dir }, frame, kernel.sample.above, self.first_tree + tree as u32);
            for bundle in &kernel.plan.bundles {
                let load = Load { lanes: bundle, fields: &fields[..bundle.len()], lengths: &lengths };
                self.now.push(flight, load);
            }
        }
    }

    /// Finds where each segment ends.
    fn intersect(&mut self, coherence: Coherence, recorder: &mut impl Recorder<C>) {
        self.queries.clear();
        self.ends.clear();
        for flight in self.now.flights() {
            let (limit, border) = self.kernel.border(&flight.ray);
            let end = match self.kernel.leave_lonely(flight, limit) {
                Some((order, crossing)) => End::Analytic(order, crossing),
                None => {
                    self.queries.push(flight.query(limit));
                    End::Asked(self.queries.len() - 1)
                }
            };
            self.ends.push((end, border));
        }
        self.kernel.scene.nearest(&self.queries, coherence, &mut self.answers);
        for (end, _) in &mut self.ends {
            if let End::Asked(i) = *end
                && self.answers[i].order().is_none()
            {
                *end = End::Border;
            }
        }
        recorder.segments(self.now.flights().len());
    }

    /// Takes ray `i` over the end of its segment.
    fn advance(&mut self, i: usize, recorder: &mut impl Recorder<C>) {
        let flight = self.now.flights()[i];
        match self.ends[i] {
            (End::Border, Border::Out) => self.exit(i, &flight, recorder),
            (End::Border, Border::Seam(shift)) => {
                let (limit, _) = self.kernel.border(&flight.ray);
                self.travel(i, &flight, limit, recorder);
                self.wrap(i, flight, limit, shift, recorder);
            }
            (End::Analytic(order, crossing), _) => self.meet(i, &flight, order, &[crossing], recorder),
            (End::Asked(q), _) => {
                let answer = self.answers[q];
                if answer.overflow() {
                    return lose_all(self.now.load(i), Loss::Numeric, recorder);
                }
                let Some(order) = answer.order() else { return };
                self.meet(i, &flight, order, answer.crossings(), recorder);
            }
        }
    }

    /// Accounts for the way to distance `t`.
    fn travel(&mut self, i: usize, flight: &Flight, t: f64, recorder: &mut impl Recorder<C>) {
        let length = t - flight.from.t;
        self.now.add_length(i, flight.medium, length);
        let medium = usize::from(flight.medium.0);
        if !self.kernel.optics.absorbs[medium] {
            return;
        }
        let optics = &self.kernel.optics;
        let (fields, lanes) = self.now.fields_mut(i);
        for (field, &lane) in fields.iter_mut().zip(lanes) {
            let k0 = std::f64::consts::TAU / optics.wavelengths[usize::from(lane)];
            let decay = k0 * optics.index[medium][usize::from(lane)].im * length;
            recorder.absorb(lane, field.power() * -(-2.0 * decay).exp_m1());
            *field = field.scaled((-decay).exp());
        }
    }

    /// An interface at `order`.
    fn meet(&mut self, i: usize, flight: &Flight, order: Order, crossings: &[Crossing], recorder: &mut impl Recorder<C>) {
        self.travel(i, flight, order.t, recorder);
        let kernel = self.kernel;
        let primitives = kernel.scene.primitives();
        let crossing = crossings[0];
        let opaque = kernel.open_opaque(crossings);
        let (inside, matter) = match opaque {
            Some(matter) => (flight.inside, matter),
            None => match kernel.ledger.cross(&flight.inside, crossings, primitives) {
                Ok(inside) => (inside, kernel.ledger.matter(&inside)),
                Err(_) => return lose_all(self.now.load(i), Loss::Medium, recorder),
            },
        };
        if matter == Matter::Medium(flight.medium) {
            // Equal media: straight on.
            let flight = Flight { from: order, inside, ..*flight };
            return self.next.push(flight, self.now.load(i));
        }
        if flight.events >= kernel.plan.limits.depth {
            return lose_all(self.now.load(i), Loss::Depth, recorder);
        }
        let point = primitives.snap(crossing, order.surface, flight.ray.at(order.t));
        let normal = primitives.normal(crossing.prim, crossing.face, point);
        let normal = if normal.dot(flight.ray.dir) > 0.0 { -normal } else { normal };
        let interface = Interface {
            flight,
            point,
            normal,
            surface: order.surface,
            crossing,
            may_be_film: crossings.iter().any(|c| kernel.plan.marks.marked(c.prim, c.face)),
            inside,
            matter,
        };
        let numbers = &self.keys[(flight.tree - self.first_tree) as usize];
        self.beams.part(kernel, &mut self.films, &interface, self.now.load(i), numbers, recorder);
        for beam in self.beams.parts() {
            let load = Load { lanes: &beam.lanes, fields: &beam.fields, lengths: self.now.load(i).lengths };
            match kernel.stay_in_cell(beam.flight) {
                Some(flight) if kernel.walked_out(&flight) => aside(load, recorder),
                Some(flight) => self.next.push(flight, load),
                None => lose_all(load, Loss::Numeric, recorder),
            }
        }
    }

    /// Moves a ray that reached a seam in free flight.
    fn wrap(&mut self, i: usize, flight: Flight, t: f64, shift: [i32; 2], recorder: &mut impl Recorder<C>) {
        let mut origin = flight.ray.at(t) + self.kernel.sample.cell.offset(shift);
        // Exactly one seam inwards, whatever the rounding.
        let seam = self.kernel.sample.cell.seam();
        origin.x = origin.x.clamp(-seam.x, seam.x);
        origin.y = origin.y.clamp(-seam.y, seam.y);
        let moved = Flight {
            ray: Ray { origin, ..flight.ray },
            walk: [flight.walk[0] - shift[0], flight.walk[1] - shift[1]],
            from: Order { t: 0.0, surface: SurfaceId::NONE },
            last: SurfaceId::NONE,
            ..flight
        };
        let load = self.now.load(i);
        if self.kernel.walked_out(&moved) { aside(load, recorder) } else { self.next.push(moved, load) }
    }

    fn exit(&mut self, i: usize, flight: &Flight, recorder: &mut impl Recorder<C>) {
        let kernel = self.kernel;
        let load = self.now.load(i);
        let up = flight.ray.dir.z > 0.0;
        if flight.ray.dir.z == 0.0 {
            return aside(load, recorder);
        }
        if flight.medium != (if up { kernel.sample.above } else { kernel.sample.below }) {
            return lose_all(load, Loss::Medium, recorder);
        }
        let unwrapped = flight.ray.origin + kernel.sample.cell.offset(flight.walk);
        recorder.exit(&Exit {
            tree: flight.tree,
            dir: flight.ray.dir,
            frame: flight.frame,
            position: unwrapped,
            anchor: flight.anchor,
            lengths: load.lengths,
            lanes: load.lanes,
            fields: load.fields,
        });
    }
}

fn lose_all<const C: usize>(load: Load<'_, C>, why: Loss, recorder: &mut impl Recorder<C>) {
    for (&lane, field) in load.lanes.iter().zip(load.fields) {
        recorder.lose(why, lane, field.power());
    }
}

fn aside<const C: usize>(load: Load<'_, C>, recorder: &mut impl Recorder<C>) {
    for (&lane, field) in load.lanes.iter().zip(load.fields) {
        recorder.side(lane, field.power());
    }
}

impl Kernel<'_> {
    /// How far a ray can go before it leaves the heights of the sample or reaches a seam, µm.
    fn border(&self, ray: &Ray) -> (f64, Border) {
        let cell = &self.sample.cell;
        if !cell.periodic {
            return (f64::INFINITY, Border::Out);
        }
        let (low, high) = cell.heights;
        let up = match ray.dir.z {
            z if z > 0.0 => (high - ray.origin.z) / z,
            z if z < 0.0 => (low - ray.origin.z) / z,
            _ => f64::INFINITY,
        };
        let mut nearest = (up, Border::Out);
        let seam = cell.seam();
        for axis in 0..2 {
            let d = ray.dir[axis];
            if d != 0.0 {
                let t = (seam[axis].copysign(d) - ray.origin[axis]) / d;
                if t < nearest.0 {
                    let mut shift = [0, 0];
                    shift[axis] = if d > 0.0 { -1 } else { 1 };
                    nearest = (t, Border::Seam(shift));
                }
            }
        }
        nearest
    }

    /// Where a ray leaves a convex body with nothing in it, if it is in one and leaves it within `limit`.
    #[inline]
    fn leave_lonely(&self, flight: &Flight, limit: f64) -> Option<(Order, Crossing)> {
        let solid = flight.inside.winner()?;
        let primitives = self.scene.primitives();
        let in_it = flight.last != SurfaceId::NONE && primitives.owner(flight.at) == solid;
        if !in_it || !self.sample.solids[solid as usize].lonely {
            return None;
        }
        let mut nearest = Nearest::none(limit);
        primitives.propose(&flight.query(limit), flight.at, &mut nearest);
        let order = nearest.order()?;
        let crossing = nearest.crossings()[0];
        (!crossing.enters && !self.shared[order.surface.0 as usize]).then_some((order, crossing))
    }

    /// What an opaque surface without an inside is made of, if one is met.
    fn open_opaque(&self, crossings: &[Crossing]) -> Option<Matter> {
        let owners = crossings.iter().map(|c| self.scene.primitives().owner(c.prim));
        owners.map(|o| &self.sample.solids[o as usize]).find(|s| !s.closed).map(|s| s.matter)
    }

    /// The ray, moved by a period if it starts beyond a seam (a stack of films across a wall can carry it there);
    /// `None` if the copy of the surface it starts on is missing.
    fn stay_in_cell(&self, flight: Flight) -> Option<Flight> {
        let cell = &self.sample.cell;
        let seam = cell.seam();
        let mut flight = flight;
        if !cell.periodic {
            return Some(flight);
        }
        for axis in 0..2 {
            let x = flight.ray.origin[axis];
            if x.abs() <= seam[axis] {
                continue;
            }
            let mut shift = [0, 0];
            shift[axis] = if x > 0.0 { -1 } else { 1 };
            let primitives = self.scene.primitives();
            let face = primitives.faces(flight.at).iter().position(|&s| s == flight.last)?;
            flight.at = self.sample.tiling.neighbour(flight.at, shift)?;
            flight.last = primitives.faces(flight.at)[face];
            flight.ray.origin += cell.offset(shift);
            flight.walk[axis] -= shift[axis];
        }
        Some(flight)
    }

    /// Whether a ray has gone so far sideways that its light counts as guided out of the sample.
    fn walked_out(&self, flight: &Flight) -> bool {
        let cell = &self.sample.cell;
        let far = self.plan.limits.walk;
        (0..2).any(|axis| {
            f64::from(flight.walk[axis].abs()) > far || (!cell.periodic && flight.ray.origin[axis].abs() > far * cell.size[axis])
        })
    }
}
