//! Where the beams of an interface go.

use super::divide::{BeamSlots, REFLECTED, TRANSMITTED};
use super::{
    Behind, Bend, Bits, Effects, Field, Flight, Interface, Loss, PARTING, Partition, Plane, Ray, Recorder, Refraction,
    Slot, decision, unit,
};
use crate::trace::kernel::Stop;
use crate::trace::stream::Stream;

/// Directions of refraction of some lanes: the least and the greatest sine, each with its cosine.
#[derive(Clone, Copy)]
struct Fan {
    low: [f64; 2],
    high: [f64; 2],
}

impl Fan {
    fn new(at: [f64; 2]) -> Self {
        Self { low: at, high: at }
    }

    fn with(self, at: [f64; 2]) -> Self {
        Self {
            low: if at[0] < self.low[0] { at } else { self.low },
            high: if at[0] > self.high[0] { at } else { self.high },
        }
    }

    /// The direction in its middle, behind an interface with this sine of the angle of incidence.
    fn middle(self, sin: f64) -> Refraction {
        let [s, c] = [0, 1].map(|i| self.low[i] + self.high[i]);
        let norm = s.hypot(c);
        Refraction { ratio: s / norm / sin, cos: c / norm }
    }

    /// Distance of its ends, which for small angles is the angle between them.
    fn width(self) -> f64 {
        (self.high[0] - self.low[0]).hypot(self.high[1] - self.low[1])
    }
}

/// Lanes share a refracted direction only if it could go back the way it came for each of them: their sines must differ by
/// less than this times the square of the cosine before. Else light that grazes into a sphere would find no way out.
const REVERSIBLE: f64 = 0.1;

/// A lane whose indices before and behind differ by less than this part goes straight on, and no other lane may turn it: what
/// is not scattered at all is told apart.
const UNBENT: f64 = 1e-12;

/// Directions behind an interface.
struct Fans<'a> {
    /// Sine and cosine of the angle of incidence.
    sin: f64,
    cos: f64,
    bends: &'a [Option<Refraction>],
}

impl Fans<'_> {
    /// Sine and cosine of the angle of refraction of a lane that has one.
    fn direction(&self, lane: u16) -> [f64; 2] {
        let bend = self.bends[usize::from(lane)].unwrap_or(Refraction { ratio: 1.0, cos: 1.0 });
        [bend.ratio * self.sin, bend.cos]
    }

    /// Whether the interface is none for a lane.
    fn is_unbent(&self, lane: u16) -> bool {
        self.bends[usize::from(lane)].is_some_and(|bend| (bend.ratio - 1.0).abs() < UNBENT)
    }

    /// The fan of the first of some lanes, not wider than `width`, and the first lane beyond it.
    fn bundle(&self, mut lanes: impl Iterator<Item = u16>, width: f64) -> (Fan, Option<u16>) {
        let reversible = REVERSIBLE * self.cos * self.cos;
        let first = lanes.next();
        let mut fan = Fan::new(first.map_or([self.sin, self.cos], |lane| self.direction(lane)));
        let unbent = first.is_some_and(|lane| self.is_unbent(lane));
        for lane in lanes {
            let wider = fan.with(self.direction(lane));
            if unbent != self.is_unbent(lane) || wider.width() > width || wider.high[0] - wider.low[0] > reversible {
                return (fan, Some(lane));
            }
            fan = wider;
        }
        (fan, None)
    }
}

impl<F: Field, E: Effects, R: Recorder<F>> Partition<'_, '_, F, E, R> {
    /// Sets the directions of both beams; gives up those that need not be followed.
    #[inline]
    pub(super) fn send(
        &mut self,
        plane: &Plane,
        behind: Option<&Behind<'_>>,
        bend: Bend<'_>,
        splits: bool,
        beams: BeamSlots,
    ) {
        if beams == [None; 2] {
            return self.stream.remove(self.slot);
        }
        // The reflected beam is sent on first: what is pushed last is taken first.
        if let (Some(slot), Some(behind)) = (beams[TRANSMITTED], behind) {
            match bend {
                Bend::Never => {}
                Bend::Same(refraction) => self.transmit(slot, plane, behind, refraction, splits),
                Bend::PerLane(bends) => self.part(slot, plane, behind, bends, splits),
            }
        }
        if let Some(slot) = beams[REFLECTED] {
            self.reflect(slot, plane, splits);
        }
    }

    fn reflect(&mut self, slot: Slot, plane: &Plane, splits: bool) {
        let Interface { dir, point, normal, surface, crossing, .. } = *self.interface;
        let dir = unit(dir + 2.0 * plane.slant.cos * normal);
        let primitives = self.kernel.scene.primitives();
        self.stream.queries[slot] = primitives.query_leaving(Ray { origin: point, dir }, surface);
        let f = &mut self.stream.flights[slot];
        (f.frame, f.at, f.events) = (plane.s.cross(dir), crossing.prim, f.events + 1);
        f.branch = next_branch(f.branch, 0, splits);
        self.settle(slot);
    }

    fn transmit(&mut self, slot: Slot, plane: &Plane, behind: &Behind<'_>, refraction: Refraction, splits: bool) {
        let Refraction { ratio, cos } = refraction;
        let Interface { dir, normal, .. } = *self.interface;
        let dir = unit(ratio * dir + (ratio * plane.slant.cos - cos) * normal);
        let primitives = self.kernel.scene.primitives();
        self.stream.queries[slot] = primitives.query_leaving(Ray { origin: behind.point, dir }, behind.surface);
        let f = &mut self.stream.flights[slot];
        (f.frame, f.at, f.events) = (plane.s.cross(dir), behind.at, f.events + 1);
        f.branch = next_branch(f.branch, 1, splits);
        f.walk = [f.walk[0] - behind.shift[0], f.walk[1] - behind.shift[1]];
        f.medium = behind.medium;
        f.inside.clone_from(behind.inside);
        self.settle(slot);
    }

    /// Parts the lanes of a transmitted beam, in their order, into bundles that each go in their middle direction. The first
    /// one is narrower by lot, so that a lane is now on this side of the middle, now on that: its mean direction is its own.
    #[inline(never)]
    fn part(&mut self, slot: Slot, plane: &Plane, behind: &Behind<'_>, bends: &[Option<Refraction>], splits: bool) {
        let fans = Fans { sin: plane.slant.sin, cos: plane.slant.cos, bends };
        let widest = self.widest(slot);
        let Flight { events, branch, .. } = self.stream.flights[slot];
        let mut width = widest * decision(self.numbers.key, branch, events, PARTING);
        loop {
            let (fan, end) = fans.bundle(self.stream.lanes(slot), width);
            // The last bundle keeps the slot.
            let bundle = if end.is_some() { self.stream.fork(slot) } else { slot };
            if let Some(end) = end {
                self.move_lanes(slot, bundle, end);
            }
            let (first, _) = self.stream.first_lane(bundle);
            let last = self.stream.lanes(bundle).last().unwrap_or(first);
            let spread = &mut self.stream.flights[bundle].spread;
            *spread = spread.hypot(0.5 * fan.width());
            // The ends of the spectrum have neighbours on one side only.
            let refraction = if first == 0 || first == last {
                bends[usize::from(first)]
            } else if usize::from(last) + 1 == self.kernel.lanes() {
                bends[usize::from(last)]
            } else {
                Some(fan.middle(plane.slant.sin))
            };
            if let Some(refraction) = refraction {
                self.transmit(bundle, plane, behind, refraction, splits);
            }
            if end.is_none() {
                return;
            }
            width = widest;
        }
    }

    /// How wide a bundle may become at one refraction: so that its edges turn by half of what is left, and lanes stay
    /// together for some more. Turns at many interfaces add up like steps of a random walk. Plane faces part all lanes:
    /// behind a pane each goes on exactly as it came.
    fn widest(&self, slot: Slot) -> f64 {
        if self.is_plane() {
            return 0.0;
        }
        let (most, spread) = (self.kernel.plan.limits.spread, self.stream.flights[slot].spread);
        ((most - spread) * (most + spread)).max(0.0).sqrt()
    }

    /// Moves all lanes before `end` to another slot.
    fn move_lanes(&mut self, from: Slot, to: Slot, end: u16) {
        for word in 0..self.stream.words() {
            for bit in Bits(self.stream.word(from, word)) {
                let lane = (64 * word) as u16 + bit;
                if lane < end {
                    let field = self.stream.field(from, lane);
                    self.stream.drop_lane(from, lane);
                    self.stream.put(to, lane, field);
                }
            }
        }
    }

    /// Sends a beam on, or, if it is not to be followed, accounts for its power.
    #[inline(always)]
    pub(super) fn settle(&mut self, slot: Slot) {
        let Stream { queries, flights, .. } = self.stream;
        match self.kernel.settle(&mut queries[slot], &mut flights[slot]) {
            Ok(()) => self.ready.push(slot),
            Err(stop) => self.give_up(slot, stop),
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
}

/// Of very deep trees only the last 32 turns tell branches apart.
fn next_branch(branch: u32, side: u32, splits: bool) -> u32 {
    if splits { branch << 1 | side } else { branch }
}
