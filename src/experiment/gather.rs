//! The tracing of a whole measurement: tallies are put together in their order, units into batches, batches into rounds,
//! rounds into measurements.

use std::time::Instant;

use super::apart::apart;
use super::state::{Dome, State};
use super::{Bench, Progress};
use crate::dome::{Apart, Detector, Locator, Shape, Tally};
use crate::optics::field::Field;
use crate::plan::{Plan, State as Carried};
use crate::trace::{Effects, Job, Kernel, Stacks, Unit, run, with_kernel};

/// Traces what is still to be traced of `state` by `plan`, until all is done or `watch`, which is told after each unit how
/// far the work is, says `false`.
pub fn advance(bench: &Bench<'_>, plan: &Plan, state: &mut State, mut watch: impl FnMut(Progress, &State) -> bool) {
    let (sample, light, settings) = (bench.sample, bench.light, bench.settings);
    let kernel = bench.kernel(plan);
    let components = if plan.kernel.state == Carried::Mueller { 16 } else { 1 };
    let groups = if plan.kernel.absorbs { sample.groups.names.len() } else { 0 };
    let shape = Shape { lanes: kernel.lanes(), components, groups };
    let locator = Locator::new(settings.dome_level);
    let arm = settings.arm.as_ref();
    let apart: Vec<Apart> = light.incidences.iter().map(|i| apart(sample, plan, i, arm)).collect();
    let apertures: Vec<usize> = apart.iter().map(|a| a.apertures.len()).collect();
    let dome = Dome { shape, level: settings.dome_level, apertures: &apertures };
    let ([spent, tracing], begun) = (state.times(), Instant::now());
    let times = || [spent, tracing].map(|before| before + begun.elapsed().as_secs_f64());
    let mut go_on = true;
    while go_on && state.open(dome, times()) {
        let units = state.units(settings.seed);
        let mut taken = 0;
        let mut take = |unit: &Unit, tally: Tally, stacks: Stacks| {
            state.take(unit, &tally, &stacks, times());
            taken += 1;
            go_on = go_on && state.progress().is_none_or(|p| watch(p, state));
            go_on
        };
        let take: &mut Take<'_> = &mut take;
        let (kernel, locator, apart, units) = (&kernel, &locator, &apart[..], &units[..]);
        with_kernel(plan.kernel, Trace { bench, kernel, locator, shape, apart, units, take });
        if taken == units.len() {
            state.end_round();
        }
    }
}

/// Units to be traced, and who takes what they yield.
struct Trace<'t, 'k> {
    bench: &'t Bench<'t>,
    kernel: &'t Kernel<'k>,
    locator: &'t Locator,
    shape: Shape,
    apart: &'t [Apart],
    units: &'t [Unit],
    take: &'t mut Take<'t>,
}

type Take<'t> = dyn FnMut(&Unit, Tally, Stacks) -> bool + 't;

impl Job for Trace<'_, '_> {
    type Yield = ();

    fn run<F: Field, E: Effects>(self) {
        let Self { bench, kernel, locator, shape, apart, units, take } = self;
        debug_assert_eq!(F::COMPONENTS, shape.components);
        run::<F, E, _>(kernel, bench.light, units, &bench.pool, || Detector::new(locator, shape, apart), take);
    }
}
