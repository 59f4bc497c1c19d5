//! How the power of a ray is divided at an interface.

use pulp::Simd;

use super::bundle::Bundle;
use super::{
    Absorption, Beams, Behind, Bend, Bits, Effects, Field, Flight, Loss, Pair, Partition, Plane, Recorder, Slot, draw,
};
use crate::optics::field::{Parts, Passage, Shares as _};
use crate::optics::lanes::Lanes;
use crate::trace::beams::BeamTable;

/// While a tree splits, both beams of a plane face are followed unless one has less than this share of the power. Far below
/// what can be measured: the reflection of an antireflection coating is a small share that people want to know well.
const SPLIT_ABOVE: f64 = 1e-9;

/// What an interface does to each lane.
pub(super) enum Action<'a, P> {
    /// The same to all.
    Uniform(Beams<P>),
    /// By number of the lane.
    PerLane(&'a BeamTable<P>),
}

impl<P: Passage> Action<'_, P> {
    /// For a block of lanes.
    #[inline(always)]
    pub fn at<S: Simd, W: Parts<Lanes<S>>>(&self, s: S, block: usize) -> Beams<W> {
        match self {
            Self::Uniform(beams) => beams.splat(s),
            Self::PerLane(table) => table.load(s, block),
        }
    }
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

/// Light at an interface, or a stack.
pub(super) struct Encounter<'a, P> {
    pub plane: &'a Plane,
    pub action: Action<'a, P>,
    pub bend: Bend<'a>,
    pub absorber: Absorber<'a>,
}

/// How power is divided, for all lanes of a ray alike.
pub(super) struct Rule {
    /// Whether both beams may be followed.
    pub splits: bool,
    /// Share of the power below which one is not.
    pub least: f64,
    /// The random number by which lanes choose.
    pub lot: f64,
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
        bundle: &mut Bundle,
        encounter: &Encounter<'_, F::Passage>,
        behind: Option<&Behind<'_>>,
    ) {
        let rule = self.rule();
        let beams = match self.stream.first_lane(self.slot) {
            (lane, true) => self.divide_lane(lane, &rule, encounter),
            (_, false) => self.divide_bundle(bundle, &rule, encounter),
        };
        self.send(encounter.plane, behind, encounter.bend, rule.splits, beams);
    }

    fn rule(&self) -> Rule {
        let Flight { events, branch, .. } = self.stream.flights[self.slot];
        let least = self.kernel.plan.limits.least_share;
        Rule {
            splits: events < self.kernel.splits,
            least: if self.is_plane() { SPLIT_ABOVE } else { SPLIT_ABOVE.max(least) },
            lot: draw(branch, events, self.numbers),
        }
    }

    /// A ray of one lane.
    #[inline(always)]
    fn divide_lane(&mut self, lane: u16, rule: &Rule, encounter: &Encounter<'_, F::Passage>) -> BeamSlots {
        let slot = self.slot;
        let Encounter { plane, action, bend, absorber } = encounter;
        let Beams { reflected: r, transmitted: t } = match action {
            Action::Uniform(beams) => *beams,
            Action::PerLane(table) => table.get(usize::from(lane)),
        };
        let field = self.stream.field(slot, lane).rotated(plane.cos, plane.sin);
        let powers = field.powers();
        let all = powers[0] + powers[1];
        let part = |shares: Pair<f64>| shares.p * powers[0] + shares.s * powers[1];
        let reflected = part(r.shares());
        let transmitted = if bend.lets_through(lane) { part(t.shares()) } else { 0.0 };
        let mut kept = all;
        if E::ABSORBS && !matches!(absorber, Absorber::None) {
            kept = reflected + transmitted;
            self.absorb(*absorber, lane, powers, all - kept);
        }
        if kept <= 0.0 {
            return [None; 2];
        }
        let both = rule.splits && reflected.min(transmitted) > rule.least * kept;
        if both {
            let faintest = self.kernel.plan.limits.faintest;
            let mut beams = [None; 2];
            let sides = [(REFLECTED, &r, reflected), (TRANSMITTED, &t, transmitted)];
            for (side, passage, power) in sides {
                if power < faintest {
                    self.recorder.lose(Loss::Depth, lane, power);
                    continue;
                }
                let to = if beams[REFLECTED].is_some() { self.stream.fork(slot) } else { slot };
                self.stream.put(to, lane, field.times(passage));
                beams[side] = Some(to);
            }
            return beams;
        }
        let reflects = transmitted == 0.0 || rule.lot * kept < reflected;
        let (passage, power) = if reflects { (&r, reflected) } else { (&t, transmitted) };
        self.stream.put(slot, lane, field.times(passage).scaled(kept / power));
        if reflects { [Some(slot), None] } else { [None, Some(slot)] }
    }

    /// A ray of several lanes, some of them at once.
    #[inline(never)]
    fn divide_bundle(&mut self, bundle: &mut Bundle, rule: &Rule, encounter: &Encounter<'_, F::Passage>) -> BeamSlots {
        let slot = self.slot;
        let Encounter { action, absorber, .. } = encounter;
        let absorbs = E::ABSORBS && !matches!(absorber, Absorber::None);
        bundle.decide::<F>(self.stream.numbers(slot), encounter, rule, absorbs);
        let faintest = self.kernel.plan.limits.faintest;
        let mut any = [false; 2];
        for word in 0..self.stream.words() {
            let carried = self.stream.word(slot, word);
            let [mut reflected, mut transmitted] = bundle.chosen[word].map(|bits| bits & carried);
            if absorbs {
                for bit in Bits(carried) {
                    let lane = (64 * word) as u16 + bit;
                    let [p, s, r, t] = bundle.powers(lane);
                    self.absorb(*absorber, lane, [p, s], p + s - (r + t));
                }
            }
            for bit in Bits(reflected & transmitted) {
                let lane = (64 * word) as u16 + bit;
                let [.., r, t] = bundle.powers(lane);
                for (mask, power) in [(&mut reflected, r), (&mut transmitted, t)] {
                    if power < faintest {
                        self.recorder.lose(Loss::Depth, lane, power);
                        *mask &= !(1 << bit);
                    }
                }
            }
            bundle.chosen[word] = [reflected, transmitted];
            any = [any[0] || reflected != 0, any[1] || transmitted != 0];
        }
        let beams = match any {
            [true, true] => [Some(slot), Some(self.stream.fork(slot))],
            [reflects, transmits] => [reflects.then_some(slot), transmits.then_some(slot)],
        };
        for (side, to) in beams.into_iter().enumerate() {
            if let Some(to) = to {
                bundle.hand_over::<F>(side, action, self.stream.numbers_mut(to));
                self.stream.set_lanes(to, bundle.chosen.iter().map(|sides| sides[side]));
            }
        }
        beams
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
}
