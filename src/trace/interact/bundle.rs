//! How the power of many lanes is divided, as many of them at once as the processor has room for.

use pulp::{Arch, Simd, WithSimd};

use super::divide::{Action, Encounter, REFLECTED, Rule};
use super::{Beams, Bend, Plane};
use crate::optics::field::{Field, Shares as _, State, load, store};
use crate::optics::lanes::{Lanes, Number as _, padded};

/// The lanes of a ray at an interface; each list is [padded].
pub struct Bundle {
    arch: Arch,
    apart: usize,
    /// Fields in the plane of incidence.
    fields: Vec<f64>,
    /// Power along p, along s, reflected, and transmitted.
    powers: [Vec<f64>; 4],
    /// What the power of a lane that goes one way is multiplied by in its beam, so that it keeps all.
    gains: Vec<f64>,
    /// 1 for lanes that are refracted, else 0.
    through: Vec<f64>,
    /// Which lanes are reflected, and which are transmitted: a bit each. Nothing is said of lanes that the ray does not carry.
    pub(super) chosen: Vec<[u64; 2]>,
}

type WidePassage<F, S> = <<F as Field>::Of<Lanes<S>> as State<Lanes<S>>>::Passage;

impl Bundle {
    /// For so many lanes of this kind.
    pub fn new<F: Field>(lanes: usize) -> Self {
        let apart = padded(lanes);
        let list = || vec![0.0; apart];
        Self {
            arch: Arch::new(),
            apart,
            fields: vec![0.0; F::PARTS * apart],
            powers: std::array::from_fn(|_| list()),
            gains: list(),
            through: list(),
            chosen: vec![[0; 2]; lanes.div_ceil(64)],
        }
    }

    /// Power of a lane along p, along s, reflected, and transmitted.
    pub(super) fn powers(&self, lane: u16) -> [f64; 4] {
        self.powers.each_ref().map(|list| list[usize::from(lane)])
    }

    /// Turns the fields of a ray into the plane of incidence, and decides where each lane goes. If nothing `absorbs`, all
    /// power is kept, whatever rounding says.
    pub(super) fn decide<F: Field>(
        &mut self,
        fields: &[f64],
        encounter: &Encounter<'_, F::Passage>,
        rule: &Rule,
        absorbs: bool,
    ) {
        match encounter.bend {
            Bend::Never => self.through.fill(0.0),
            Bend::Same(_) => self.through.fill(1.0),
            Bend::PerLane(all) => {
                self.through.iter_mut().zip(all).for_each(|(to, bend)| *to = f64::from(u8::from(bend.is_some())));
            }
        }
        self.chosen.fill([0; 2]);
        let arch = self.arch;
        arch.dispatch(Decide::<F> { bundle: self, fields, encounter, rule, absorbs });
    }

    /// Writes the fields of the beam on one side.
    pub(super) fn hand_over<F: Field>(&self, side: usize, action: &Action<'_, F::Passage>, to: &mut [f64]) {
        self.arch.dispatch(HandOver::<F> { bundle: self, side, action, to });
    }
}

struct Decide<'a, F: Field> {
    bundle: &'a mut Bundle,
    fields: &'a [f64],
    encounter: &'a Encounter<'a, F::Passage>,
    rule: &'a Rule,
    absorbs: bool,
}

impl<F: Field> WithSimd for Decide<'_, F> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) {
        let Self { bundle, fields, encounter, rule, absorbs } = self;
        let Plane { cos, sin, .. } = *encounter.plane;
        let apart = bundle.apart;
        let (zero, one) = (Lanes::splat(s, 0.0), Lanes::splat(s, 1.0));
        let splits = Lanes::splat(s, if rule.splits { 1.0 } else { 0.0 });
        for block in 0..apart / S::F64_LANES {
            let field: F::Of<Lanes<S>> = load(s, fields, block, apart);
            let field = field.rotated(cos, sin);
            store(s, &field, &mut bundle.fields, block, apart);
            let beams: Beams<WidePassage<F, S>> = encounter.action.at(s, block);
            let [along_p, along_s] = field.powers();
            let (r, t) = (beams.reflected.shares(), beams.transmitted.shares());
            let reflected = r.p * along_p + r.s * along_s;
            let transmitted = (t.p * along_p + t.s * along_s) * Lanes::load(s, &bundle.through, block);
            let all = along_p + along_s;
            let kept = if absorbs { reflected + transmitted } else { all };
            let both = (reflected.min(transmitted) * splits).gt(kept * rule.least);
            let reflects = transmitted.eq(zero).or(reflected.gt(kept * rule.lot));
            let [list_p, list_s, list_r, list_t] = &mut bundle.powers;
            along_p.store(list_p, block);
            along_s.store(list_s, block);
            reflected.store(list_r, block);
            transmitted.store(list_t, block);
            let gain = kept.over(reflects.choose(reflected, transmitted));
            both.choose(one, gain).store(&mut bundle.gains, block);
            let lives = kept.gt(zero);
            let sides = lives.and(both.or(reflects)).bits_with(lives.and(both.or(!reflects)));
            let (word, shift) = (block * S::F64_LANES / 64, block * S::F64_LANES % 64);
            bundle.chosen[word][0] |= sides[0] << shift;
            bundle.chosen[word][1] |= sides[1] << shift;
        }
    }
}

struct HandOver<'a, F: Field> {
    bundle: &'a Bundle,
    side: usize,
    action: &'a Action<'a, F::Passage>,
    to: &'a mut [f64],
}

impl<F: Field> WithSimd for HandOver<'_, F> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, s: S) {
        let Self { bundle, side, action, to } = self;
        let apart = bundle.apart;
        for block in 0..apart / S::F64_LANES {
            let field: F::Of<Lanes<S>> = load(s, &bundle.fields, block, apart);
            let Beams { reflected, transmitted } = action.at::<S, WidePassage<F, S>>(s, block);
            let passage = if side == REFLECTED { reflected } else { transmitted };
            let field = field.times(&passage).scaled(Lanes::load(s, &bundle.gains, block));
            store(s, &field, to, block, apart);
        }
    }
}

#[cfg(test)]
mod tests {
    use rand::rngs::Xoshiro256PlusPlus;
    use rand::{RngExt, SeedableRng};

    use glam::DVec3;

    use super::super::divide::{Absorber, TRANSMITTED};
    use super::*;
    use crate::optics::field::{Jones, Mueller, Power, Stokes, gather, scatter};
    use crate::optics::{C64, Coefficients, Pair};
    use crate::trace::beams::BeamTable;
    use crate::trace::media::{Refraction, Slant};

    /// One register and a part of the next one, in more than one word of bits.
    const LANES: usize = 77;

    /// Some lanes at an interface.
    struct Case<F: Field> {
        fields: Vec<F>,
        beams: Vec<Beams<F::Passage>>,
        bends: Vec<Option<Refraction>>,
        turn: [f64; 2],
        rule: Rule,
    }

    impl<F: Field> Case<F> {
        fn new(seed: u64) -> Self {
            let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
            let mut number = || 2.0 * rng.random::<f64>() - 1.0;
            let angle = 3.0 * number();
            let rule = Rule { splits: seed.is_multiple_of(2), least: 0.1, lot: number().abs() };
            let mut case =
                Self { fields: vec![], beams: vec![], bends: vec![], turn: [angle.cos(), angle.sin()], rule };
            for lane in 0..LANES {
                // Dark lanes, too.
                let power = if lane % 7 == 6 { 0.0 } else { 1.0 + number() };
                case.fields.push(F::incident([power, 0.5 * power * number(), 0.5 * power * number(), 0.0]));
                let mut pair = || Pair { s: C64::new(number(), number()), p: C64::new(number(), number()) };
                case.beams.push(Beams::new(&Coefficients { r: pair(), t: pair() }));
                case.bends.push((lane % 5 != 4).then_some(Refraction { ratio: 1.0, cos: 1.0 }));
            }
            case
        }

        /// One lane alone: its field in each beam.
        fn alone(&self, lane: usize, absorbs: bool) -> [Option<F>; 2] {
            let field = self.fields[lane].rotated(self.turn[0], self.turn[1]);
            let [p, s] = field.powers();
            let Beams { reflected, transmitted } = self.beams[lane];
            let part = |by: F::Passage| by.shares().p * p + by.shares().s * s;
            let (r, t) = (part(reflected), if self.bends[lane].is_some() { part(transmitted) } else { 0.0 });
            let kept = if absorbs { r + t } else { p + s };
            if kept <= 0.0 {
                [None; 2]
            } else if self.rule.splits && r.min(t) > self.rule.least * kept {
                [Some(field.times(&reflected)), Some(field.times(&transmitted))]
            } else if t == 0.0 || self.rule.lot * kept < r {
                [Some(field.times(&reflected).scaled(kept / r)), None]
            } else {
                [None, Some(field.times(&transmitted).scaled(kept / t))]
            }
        }

        fn check(&self, scalar: bool) {
            let apart = padded(LANES);
            let mut fields = vec![0.0; F::PARTS * apart];
            let mut table = BeamTable::new(LANES);
            for lane in 0..LANES {
                scatter(&self.fields[lane], &mut fields, lane, apart);
                table.set(lane, &self.beams[lane]);
            }
            let plane =
                Plane { s: DVec3::X, slant: Slant { cos: 1.0, sin: 0.0 }, cos: self.turn[0], sin: self.turn[1] };
            let (action, bend) = (Action::PerLane(&table), Bend::PerLane(&self.bends));
            let encounter = Encounter { plane: &plane, action, bend, absorber: Absorber::None };
            for absorbs in [false, true] {
                let mut bundle = Bundle::new::<F>(LANES);
                if scalar {
                    bundle.arch = Arch::Scalar;
                }
                bundle.decide::<F>(&fields, &encounter, &self.rule, absorbs);
                for side in [REFLECTED, TRANSMITTED] {
                    let mut out = fields.clone();
                    bundle.hand_over::<F>(side, &encounter.action, &mut out);
                    for lane in 0..LANES {
                        let goes = bundle.chosen[lane / 64][side] >> (lane % 64) & 1 == 1;
                        let alone = self.alone(lane, absorbs)[side];
                        assert_eq!(goes, alone.is_some(), "lane {lane}");
                        if let Some(alone) = alone {
                            assert_eq!(numbers(&gather::<F>(&out, lane, apart)), numbers(&alone), "lane {lane}");
                        }
                    }
                }
            }
        }
    }

    fn numbers<F: Field>(field: &F) -> Vec<f64> {
        let mut parts = vec![0.0; F::PARTS];
        field.write(&mut parts);
        parts
    }

    fn check<F: Field>() {
        for seed in 0..20 {
            Case::<F>::new(seed).check(seed % 4 < 2);
        }
    }

    #[test]
    fn lanes_go_together_as_they_go_alone() {
        check::<Power>();
        check::<Stokes>();
        check::<Mueller>();
        check::<Jones>();
    }
}
