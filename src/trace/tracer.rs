//! Follows the rays of a chunk of trees, generation by generation: all that need a search are asked together.

use std::marker::PhantomData;

use glam::DVec3;

use super::effects::Effects;
use super::films::Films;
use super::inside::{Around, Inside};
use super::interact::{Interface, Partition, Scratch};
use super::kernel::Kernel;
use super::random::TreeKey;
use super::record::{Exit, Loss, Recorder};
use super::report::Stacks;
use super::stream::{Border, Flight, Slot, Stream};
use crate::geometry::{Crossing, Order, PrimId, Ray};
use crate::intersect::Coherence;
use crate::light::{Incidence, Polarization};
use crate::optics::field::Field;
use crate::plan::Plan;

/// The working memory of one thread.
pub struct Tracer<'k, 'a, F: Field, E> {
    kernel: &'k Kernel<'a>,
    stream: Stream<F>,
    films: Films<F>,
    scratch: Scratch<F>,
    /// Rays that wait for an answer, those that will wait next, and those that may not need one.
    asked: Vec<Slot>,
    next: Vec<Slot>,
    ready: Vec<Slot>,
    /// Rays that have left.
    left: Vec<Slot>,
    keys: Vec<TreeKey>,
    /// Where each tree entered, µm.
    anchors: Vec<DVec3>,
    first_tree: u32,
    segments: usize,
    /// What the ray at hand would be inside of behind the interface it meets.
    inside: Inside,
    effects: PhantomData<E>,
}

impl<'k, 'a, F: Field, E: Effects> Tracer<'k, 'a, F, E> {
    /// Memory for one thread.
    pub fn new(kernel: &'k Kernel<'a>) -> Self {
        Self {
            kernel,
            stream: Stream::new(kernel.lanes(), kernel.followed()),
            films: Films::new(&kernel.plan.films, kernel.lanes()),
            scratch: Scratch::new(kernel.lanes()),
            asked: Vec::new(),
            next: Vec::new(),
            ready: Vec::new(),
            left: Vec::new(),
            keys: Vec::new(),
            anchors: Vec::new(),
            first_tree: 0,
            segments: 0,
            inside: Inside::NOTHING,
            effects: PhantomData,
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
        recorder: &mut impl Recorder<F>,
    ) {
        self.segments = 0;
        self.first_tree = first_tree;
        self.launch(incidence, polarization, entries);
        let mut coherence = Coherence::Coherent;
        while !self.asked.is_empty() {
            recorder.search(&self.stream.queries, &self.asked);
            let Stream { queries, answers, .. } = &mut self.stream;
            self.kernel.scene.nearest(queries, &self.asked, coherence, answers);
            coherence = Coherence::Scattered;
            self.segments += self.asked.len();
            for i in 0..self.asked.len() {
                self.resolve(self.asked[i], recorder);
                self.go_on(recorder);
            }
            // All at once: a dome is large, and while one ray waits for its facet others can look for theirs.
            for i in 0..self.left.len() {
                self.exit(self.left[i], recorder);
            }
            self.left.clear();
            std::mem::swap(&mut self.asked, &mut self.next);
            self.next.clear();
        }
        recorder.segments(self.segments);
    }

    /// Exchanges the list to which stacks are added that are met.
    pub fn swap_stacks(&mut self, stacks: &mut Stacks) {
        std::mem::swap(&mut self.films.stacks, stacks);
    }

    fn launch(
        &mut self,
        incidence: &Incidence,
        polarization: Polarization,
        entries: impl Iterator<Item = ([f64; 2], TreeKey)>,
    ) {
        let kernel = self.kernel;
        let (dir, frame) = (incidence.propagation(), incidence.p_direction());
        let field = F::incident(polarization.stokes());
        let cell = &kernel.sample.cell;
        self.keys.clear();
        self.anchors.clear();
        for (tree, ([x, y], key)) in entries.enumerate() {
            let origin = DVec3::new((x - 0.5) * cell.size.x, (y - 0.5) * cell.size.y, cell.heights.1);
            self.keys.push(key);
            self.anchors.push(origin);
            let ray = Ray { origin, dir };
            let (limit, border) = kernel.border(&ray);
            let query = kernel.scene.primitives().query(ray).within(limit);
            let flight = Flight {
                frame,
                at: PrimId(u32::MAX),
                medium: kernel.sample.above,
                inside: Inside::NOTHING,
                tree: self.first_tree + tree as u32,
                branch: 1,
                events: 0,
                walk: [0, 0],
                border,
                spread: 0.0,
                doubtful: false,
                edge: false,
            };
            let slot = self.stream.insert(query, flight);
            (0..kernel.lanes() as u16).for_each(|lane| self.stream.put(slot, lane, field));
            self.asked.push(slot);
        }
    }

    /// Takes a ray over the interface, or the border, that was found for it.
    fn resolve(&mut self, slot: Slot, recorder: &mut impl Recorder<F>) {
        let answer = &self.stream.answers[slot];
        match (answer.order(), answer.crossings()) {
            (None, _) => self.reach_border(slot, recorder),
            (Some(order), &[crossing]) => self.meet(slot, order, &[crossing], recorder),
            (Some(_), _) if answer.overflow() => self.lose(slot, Loss::Numeric, recorder),
            (Some(order), _) => {
                let answer = *answer;
                self.meet(slot, order, answer.crossings(), recorder);
            }
        }
    }

    /// Sends rays on: through convex bodies with nothing in them at once, else to where they wait to be asked.
    fn go_on(&mut self, recorder: &mut impl Recorder<F>) {
        while let Some(slot) = self.ready.pop() {
            if let Some((order, crossing)) =
                self.kernel.leave_lonely(&self.stream.queries[slot], &self.stream.flights[slot])
            {
                self.segments += 1;
                self.meet(slot, order, &[crossing], recorder);
                continue;
            }
            let (limit, border) = self.kernel.border(&self.stream.queries[slot].ray);
            self.stream.queries[slot].limit = limit;
            self.stream.flights[slot].border = border;
            self.next.push(slot);
        }
    }

    /// An interface at `order`.
    fn meet(&mut self, slot: Slot, order: Order, crossings: &[Crossing], recorder: &mut impl Recorder<F>) {
        self.travel(slot, order.t, recorder);
        let kernel = self.kernel;
        let primitives = kernel.scene.primitives();
        let flight = &mut self.stream.flights[slot];
        self.inside.clone_from(&flight.inside);
        let around = match kernel.solids.open_surface(crossings) {
            Some(solid) => Around::Opaque(solid),
            None => match kernel.solids.cross(&mut self.inside, crossings) {
                Ok(()) => kernel.solids.around(&self.inside),
                Err(_) => return self.lose(slot, Loss::Medium, recorder),
            },
        };
        if around == Around::Medium(flight.medium) {
            // Equal media: straight on.
            flight.inside.clone_from(&self.inside);
            self.stream.queries[slot].from = order;
            return self.next.push(slot);
        }
        if flight.events >= kernel.plan.limits.depth {
            return self.lose(slot, Loss::Depth, recorder);
        }
        let ray = self.stream.queries[slot].ray;
        let crossing = crossings[0];
        let (point, normal) = primitives.settle(crossing, order.surface, ray.at(order.t));
        let normal = if normal.dot(ray.dir) > 0.0 { -normal } else { normal };
        let Plan { marks, features, .. } = kernel.plan;
        let interface = Interface {
            dir: ray.dir,
            point,
            normal,
            surface: order.surface,
            crossing,
            may_be_film: E::FILMS && marks.any() && crossings.iter().any(|c| marks.marked(c.prim, c.face)),
            narrow: features.any() && crossings.iter().all(|c| features.is_small(c.prim, c.face)),
            inside: &self.inside,
            around,
        };
        let numbers = self.keys[(flight.tree - self.first_tree) as usize];
        let mut partition = Partition {
            kernel,
            stream: &mut self.stream,
            slot,
            interface: &interface,
            numbers,
            recorder,
            ready: &mut self.ready,
            effects: PhantomData::<E>,
        };
        partition.run(&mut self.films, &mut self.scratch);
    }

    /// Accounts for the way to distance `t`.
    #[inline]
    fn travel(&mut self, slot: Slot, t: f64, recorder: &mut impl Recorder<F>) {
        let medium = self.stream.flights[slot].medium;
        if self.kernel.follow_phase {
            self.stream.add_length(slot, medium, t - self.stream.queries[slot].from.t);
        }
        if E::ABSORBS && self.kernel.media.absorbs(medium) {
            self.absorb(slot, t - self.stream.queries[slot].from.t, recorder);
        }
    }

    /// Beer and Lambert.
    fn absorb(&mut self, slot: Slot, length: f64, recorder: &mut impl Recorder<F>) {
        let media = &self.kernel.media;
        let Flight { medium, inside, .. } = &self.stream.flights[slot];
        let (medium, group) = (*medium, self.kernel.solids.group_around(inside));
        for word in 0..self.stream.words() {
            for bit in super::stream::Bits(self.stream.word(slot, word)) {
                let lane = (64 * word) as u16 + bit;
                let field = self.stream.field(slot, lane);
                let decay = -2.0 * media.wave_number(lane) * media.index(medium, lane).im * length;
                recorder.absorb(group, lane, field.power() * -decay.exp_m1());
                self.stream.put(slot, lane, field.scaled(decay.exp()));
            }
        }
    }

    /// The end of a way on which nothing is met.
    fn reach_border(&mut self, slot: Slot, recorder: &mut impl Recorder<F>) {
        match self.stream.flights[slot].border {
            Border::Out => self.left.push(slot),
            Border::Seam(shift) => self.wrap(slot, shift, recorder),
        }
    }

    /// Moves a ray that reached a seam in free flight.
    fn wrap(&mut self, slot: Slot, shift: [i32; 2], recorder: &mut impl Recorder<F>) {
        let query = self.stream.queries[slot];
        self.travel(slot, query.limit, recorder);
        let cell = &self.kernel.sample.cell;
        let mut origin = query.ray.at(query.limit) + cell.offset(shift);
        // Within the seams, whatever the rounding.
        let seam = cell.seam();
        origin.x = origin.x.clamp(-seam.x, seam.x);
        origin.y = origin.y.clamp(-seam.y, seam.y);
        let ray = Ray { origin, ..query.ray };
        let (limit, border) = self.kernel.border(&ray);
        let flight = &mut self.stream.flights[slot];
        flight.walk = [flight.walk[0] - shift[0], flight.walk[1] - shift[1]];
        flight.border = border;
        if self.kernel.walked_out(flight.walk, origin) {
            return self.leave_sideways(slot, recorder);
        }
        self.stream.queries[slot] = self.kernel.scene.primitives().query(ray).within(limit);
        self.next.push(slot);
    }

    fn exit(&mut self, slot: Slot, recorder: &mut impl Recorder<F>) {
        let sample = self.kernel.sample;
        let (query, flight) = (&self.stream.queries[slot], &self.stream.flights[slot]);
        let outside = match query.ray.dir.z {
            z if z > 0.0 => sample.above,
            z if z < 0.0 => sample.below,
            _ => return self.leave_sideways(slot, recorder),
        };
        if flight.medium != outside {
            return self.lose(slot, Loss::Medium, recorder);
        }
        recorder.exit(&Exit {
            tree: flight.tree,
            dir: query.ray.dir,
            frame: flight.frame,
            position: query.ray.at(query.from.t) + sample.cell.offset(flight.walk),
            anchor: self.anchors[(flight.tree - self.first_tree) as usize],
            slot,
            stream: &self.stream,
        });
        self.stream.remove(slot);
    }

    fn lose(&mut self, slot: Slot, why: Loss, recorder: &mut impl Recorder<F>) {
        self.stream.loads(slot).for_each(|(lane, field)| recorder.lose(why, lane, field.power()));
        self.stream.remove(slot);
    }

    fn leave_sideways(&mut self, slot: Slot, recorder: &mut impl Recorder<F>) {
        self.stream.loads(slot).for_each(|(lane, field)| recorder.side(lane, field.power()));
        self.stream.remove(slot);
    }
}
