//! A pilot: some trees of their own tell whether effects matter that the plan has left open.
//!
//! Polarization: rays carry a [bound](Range) of what it could do to their power. Dispersion and absorption: the same trees
//! are traced with and without; the effect is left out only if the difference, and its error, are small (a test of
//! equivalence: not to have seen a difference is no reason).

use super::Bench;
use super::apart::apart;
use crate::dome::{Apart, Detector, Entry, Locator, Shape, Tally};
use crate::optics::field::{Range, State, Stokes};
use crate::plan::{Name, Plan, Verdict};
use crate::trace::{All, Batch, Detect, Exit, Recorder, Unit, run};

/// Independent scrambles of a pilot; their numbers begin where no measurement gets.
const BATCHES: u32 = 16;
const FIRST_SCRAMBLE: u32 = 1 << 16;

/// Standard errors added to a bound: with 15 degrees of freedom it is too small once in 2000 times.
const SIGMAS: f64 = 4.0;

/// Directions in which less than this share of the light goes are not judged by themselves.
const FAINT: f64 = 1e-6;

/// Level of the dome on which the light is compared with and without an effect.
const LEVEL: u8 = 1;

/// Closes what the plan has left open.
pub fn decide(bench: &Bench<'_>, mut plan: Plan) -> Plan {
    let open: Vec<Name> = plan.effects.iter().filter(|e| e.open).map(|e| e.name).collect();
    for name in open {
        let (verdict, trees) = stages(bench.settings.trees).into_iter().fold((None, 0), |last, trees| match last {
            (Some(Finding { least, .. }), _) if least > tolerance(bench) => last,
            _ => (Some(look(bench, &plan, name, trees)), trees),
        });
        let Some(Finding { most, .. }) = verdict else { continue };
        let on = most > tolerance(bench);
        let found =
            if most >= 1.0 { "nothing bounds it".into() } else { format!("it changes up to {}", percent(most)) };
        let reason = format!("a pilot of {trees} trees per incidence: {found}");
        let verdict = Verdict { on, reason, bound: most.min(1.0) };
        plan.settle(name, verdict, bench.sample, bench.light);
    }
    plan
}

/// What may be left out.
fn tolerance(bench: &Bench<'_>) -> f64 {
    bench.settings.options.error / 5.0
}

fn percent(share: f64) -> String {
    let digits = crate::units::significant(100.0 * share, 2);
    format!("{digits} % of the light")
}

/// Trees per incidence of a quick look, and of one that can prove something: 3 % of the whole work.
fn stages(trees: u64) -> [u32; 2] {
    [(trees / 256).clamp(16, 512) as u32, (trees / 32).clamp(16, 8192) as u32].map(|n| n.next_multiple_of(BATCHES))
}

/// What an effect changes, as a share of the reflected or the transmitted light.
struct Finding {
    /// It changes this much at least, but for noise.
    least: f64,
    /// And at most.
    most: f64,
}

fn look(bench: &Bench<'_>, plan: &Plan, name: Name, trees: u32) -> Finding {
    if name == Name::Polarization {
        let [capped, bounds] = polarization(bench, plan, trees);
        return Finding { least: Finding::new(&capped, trees).least, most: Finding::new(&bounds, trees).most };
    }
    let reduced = plan.switched(name, bench.sample, bench.light);
    Finding::new(&difference(bench, plan, &reduced, trees), trees)
}

impl Finding {
    fn new(changes: &[Change], trees: u32) -> Self {
        // What is so rare that no tree has shown it: with 95 % certainty less than 3 of so many, of which each is taken to
        // send as much light here as the others, and to lose all of it.
        let unseen = 3.0 / f64::from(trees);
        let seen = changes.iter().filter(|c| c.light > FAINT);
        seen.fold(Self { least: 0.0, most: 0.0 }, |f, c| Self {
            least: f.least.max((c.change - SIGMAS * c.se) / c.light),
            most: f.most.max((c.change + SIGMAS * c.se) / c.light + unseen),
        })
    }
}

/// By how much the light in some directions changes.
struct Change {
    change: f64,
    se: f64,
    /// All light on this side of the sample.
    light: f64,
}

impl Change {
    /// From one change per batch.
    fn new(batches: impl Iterator<Item = f64> + Clone, light: f64) -> Self {
        let n = f64::from(BATCHES);
        let mean = batches.clone().sum::<f64>() / n;
        let variance = batches.map(|x| (x - mean) * (x - mean)).sum::<f64>() / (n - 1.0) / n;
        Self { change: mean.abs(), se: variance.sqrt(), light }
    }
}

fn units(bench: &Bench<'_>, trees: u32) -> Vec<Unit> {
    let of = |incidence: u32| {
        (0..BATCHES).flat_map(move |i| {
            let batch = Batch { seed: bench.settings.seed, incidence, scramble: FIRST_SCRAMBLE + i };
            Unit::cut(batch, trees / BATCHES)
        })
    };
    (0..bench.light.incidences.len() as u32).flat_map(of).collect()
}

/// Bounds of what polarization changes, per incidence, lane and side: first with none that is more than all the power of
/// its ray (a few that are endless would hide the others in their noise), then as they are.
fn polarization(bench: &Bench<'_>, plan: &Plan, trees: u32) -> [Vec<Change>; 2] {
    let kernel = bench.kernel(plan);
    let lanes = kernel.lanes();
    let per_batch = f64::from(trees / BATCHES);
    let mut batches: Vec<Vec<[f64; 3]>> = Vec::new();
    let make = || Doubts { sums: vec![[0.0; 3]; 2 * lanes] };
    run::<Range, All, _>(&kernel, bench.light, &units(bench, trees), &bench.pool, make, |_, sums, _| {
        batches.push(sums);
        true
    });
    [1, 2].map(|kind| {
        let of_incidence = |all: &[Vec<[f64; 3]>]| -> Vec<Change> {
            let mean = |at: usize| all.iter().map(|b| b[at][0]).sum::<f64>() / f64::from(trees);
            (0..2 * lanes).map(|at| Change::new(all.iter().map(|b| b[at][kind] / per_batch), mean(at))).collect()
        };
        batches.chunks(BATCHES as usize).flat_map(of_incidence).collect()
    })
}

/// Power, and what polarization could add to it or take from it, capped and as it is, per side and lane.
struct Doubts {
    sums: Vec<[f64; 3]>,
}

impl Recorder<Range> for Doubts {
    fn exit(&mut self, exit: &Exit<'_, Range>) {
        let side = if exit.dir.z > 0.0 { 0 } else { self.sums.len() / 2 };
        for (lane, range) in exit.loads() {
            let terms = [1.0, range.most().min(1.0), range.most()].map(|x| x * range.power());
            self.sums[side + usize::from(lane)].iter_mut().zip(terms).for_each(|(sum, x)| *sum += x);
        }
    }
}

impl Detect<Range> for Doubts {
    type Part = Vec<[f64; 3]>;

    fn begin(&mut self, _: usize) {}

    fn finish(&mut self, _: u64) -> Self::Part {
        let empty = vec![[0.0; 3]; self.sums.len()];
        std::mem::replace(&mut self.sums, empty)
    }
}

/// Differences between two plans on the same trees, per incidence, wavelength and side: of all light on the side, and of
/// that in each part of a coarse dome.
fn difference(bench: &Bench<'_>, full: &Plan, reduced: &Plan, trees: u32) -> Vec<Change> {
    let [a, b] = [full, reduced].map(|plan| tallies(bench, plan, trees));
    let per_batch = f64::from(trees / BATCHES);
    let mut changes = Vec::new();
    for (a, b) in a.chunks(BATCHES as usize).zip(b.chunks(BATCHES as usize)) {
        for (&lane, &other) in full.lane_of.iter().zip(&reduced.lane_of) {
            for entry in [Entry::Reflected, Entry::Transmitted] {
                let light = a.iter().map(|t| t.entry(entry)[lane]).sum::<f64>() / f64::from(trees);
                let mut compare = |of: &dyn Fn(&Tally, usize) -> f64| {
                    let differences: Vec<f64> =
                        a.iter().zip(b).map(|(a, b)| (of(a, lane) - of(b, other)) / per_batch).collect();
                    changes.push(Change::new(differences.into_iter(), light));
                };
                compare(&|t, lane| t.entry(entry)[lane]);
                for code in 0..crate::dome::count(LEVEL) {
                    if is_above(code) == (entry == Entry::Reflected) {
                        compare(&|t, lane| t.facet(code).map_or(0.0, |power| power[lane]));
                    }
                }
            }
        }
    }
    changes
}

fn is_above(code: u32) -> bool {
    crate::dome::Facet { level: LEVEL, code }.center().z > 0.0
}

/// One tally per incidence and batch.
fn tallies(bench: &Bench<'_>, plan: &Plan, trees: u32) -> Vec<Tally> {
    let kernel = bench.kernel(plan);
    let locator = Locator::new(LEVEL);
    let apart: Vec<Apart> = bench.light.incidences.iter().map(|i| apart(bench.sample, plan, i, None)).collect();
    let make = || Detector::new(&locator, Shape::of_power(kernel.lanes()), &apart);
    let mut tallies = Vec::new();
    run::<Stokes, All, _>(&kernel, bench.light, &units(bench, trees), &bench.pool, make, |_, tally, _| {
        tallies.push(tally);
        true
    });
    tallies
}
