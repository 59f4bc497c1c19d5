//! How the power of a ray is divided at an interface.

use super::{
    Absorption, Beams, Behind, Bend, Bits, Effects, Field, Flight, Loss, Pair, Partition, Plane, Recorder, Slot, draw,
};
use crate::optics::field::Passage;

/// While a tree splits, both beams of a plane face are followed unless one has less than this share of the power. Far below
/// what can be measured: the reflection of an antireflection coating is a small share that people want to know well.
const SPLIT_ABOVE: f64 = 1e-9;

/// What an interface does to each lane.
pub(super) enum Action<'a, P> {
    /// The same to all.
    Uniform(Beams<P>),
    /// By number of the lane.
    PerLane(&'a [Beams<P>]),
}

/// Who takes what is neither reflected nor transmitted.
#[derive(Clone, Copy)]
pub(super) enum Absorber<'a> {
    /// Nobody: what is missing is rounding.
    None,
    /// A body of this group.
    One(u16),
    /// The layers of a stack, and what is behind it.
    Layers(Absorption<'a>),
}

/// The slots of the reflected and the transmitted beam.
pub(super) type BeamSlots = [Option<Slot>; 2];

pub(super) const REFLECTED: usize = 0;
pub(super) const TRANSMITTED: usize = 1;

impl<F: Field, E: Effects, R: Recorder<F>> Partition<'_, '_, F, E, R> {
    /// Gives each lane its share in the reflected and the transmitted beam, or lets it choose one; sends both on.
    #[inline(always)]
    pub(super) fn divide(
        &mut self,
        plane: &Plane,
        action: &Action<'_, F::Passage>,
        behind: Option<Behind<'_>>,
        bend: Bend<'_>,
        absorber: Absorber<'_>,
    ) {
        let slot = self.slot;
        let Flight { events, branch, .. } = self.stream.flights[slot];
        let limits = &self.kernel.plan.limits;
        let splits = events < self.kernel.splits;
        let least = if self.is_plane() { SPLIT_ABOVE } else { SPLIT_ABOVE.max(limits.least_share) };
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
                let powers = field.powers();
                let all = powers[0] + powers[1];
                let part = |shares: Pair<f64>| shares.p * powers[0] + shares.s * powers[1];
                let reflected = part(r.shares());
                let transmitted = if bend.lets_through(lane) { part(t.shares()) } else { 0.0 };
                let mut kept = all;
                self.stream.drop_lane(slot, lane);
                if E::ABSORBS && !matches!(absorber, Absorber::None) {
                    kept = reflected + transmitted;
                    self.absorb(absorber, lane, powers, all - kept);
                }
                if kept <= 0.0 {
                    continue;
                }
                let both = splits && reflected.min(transmitted) > least * kept;
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
        self.send(plane, behind.as_ref(), bend, splits, beams);
    }

    /// Tells who absorbs `power` of a lane, `powers` of which came along p and along s.
    #[cold]
    fn absorb(&mut self, absorber: Absorber<'_>, lane: u16, [p, s]: [f64; 2], power: f64) {
        match absorber {
            Absorber::None => {}
            Absorber::One(group) => self.recorder.absorb(group, lane, power),
            Absorber::Layers(absorption) => {
                let mut rest = power;
                for (group, share) in absorption.layers(lane) {
                    let part = share.p * p + share.s * s;
                    self.recorder.absorb(group, lane, part);
                    rest -= part;
                }
                self.recorder.absorb(absorption.behind, lane, rest);
            }
        }
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
}
