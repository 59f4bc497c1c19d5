//! Where the beams of an interface go.

use super::divide::{BeamSlots, REFLECTED, TRANSMITTED};
use super::{
    Behind, Bend, Bits, Effects, Field, Interface, Loss, Partition, Plane, Ray, Recorder, Refraction, Slot, unit,
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

    /// Distance of its ends, which for small angles is the angle between them.
    fn width(self) -> f64 {
        (self.high[0] - self.low[0]).hypot(self.high[1] - self.low[1])
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

    /// Parts the lanes of a transmitted beam, in their order, into bundles whose directions differ by no more than what
    /// the plan allows from one end of the way to the other.
    #[inline(never)]
    fn part(&mut self, slot: Slot, plane: &Plane, behind: &Behind<'_>, bends: &[Option<Refraction>], splits: bool) {
        let left = (self.kernel.plan.limits.spread - self.stream.flights[slot].spread).max(0.0);
        let direction = |lane: u16| {
            let bend = bends[usize::from(lane)].unwrap_or(Refraction { ratio: 1.0, cos: 1.0 });
            [bend.ratio * plane.slant.sin, bend.cos]
        };
        loop {
            let (first, _) = self.stream.first_lane(slot);
            let mut fan = Fan::new(direction(first));
            let mut next = None;
            for lane in self.stream.lanes(slot).skip(1) {
                let wider = fan.with(direction(lane));
                if wider.width() > 2.0 * left {
                    next = Some(lane);
                    break;
                }
                fan = wider;
            }
            // The last bundle keeps the slot.
            let bundle = if next.is_some() { self.stream.fork(slot) } else { slot };
            if let Some(next) = next {
                self.move_lanes(slot, bundle, next);
            }
            let refraction = match fan.width() {
                0.0 => bends[usize::from(first)],
                width => {
                    self.stream.flights[bundle].spread += 0.5 * width;
                    Some(middle(fan, plane.slant.sin))
                }
            };
            if let Some(refraction) = refraction {
                self.transmit(bundle, plane, behind, refraction, splits);
            }
            if next.is_none() {
                return;
            }
        }
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

/// The direction in the middle of a fan.
fn middle(fan: Fan, sin: f64) -> Refraction {
    let [s, c] = [0, 1].map(|i| fan.low[i] + fan.high[i]);
    let norm = s.hypot(c);
    Refraction { ratio: s / norm / sin, cos: c / norm }
}

/// Of very deep trees only the last 32 turns tell branches apart.
fn next_branch(branch: u32, side: u32, splits: bool) -> u32 {
    if splits { branch << 1 | side } else { branch }
}
