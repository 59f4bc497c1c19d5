//! Cuts the work into units, hands them to threads, and delivers what they measured in a fixed order: the result
//! is the same for any number of threads.

use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError, mpsc};
use std::time::{Duration, Instant};

use super::effects::Effects;
use super::kernel::Kernel;
use super::random::{Batch, TreeKey, TreeNumbers};
use super::record::Recorder;
use super::report::Stacks;
use super::tracer::Tracer;
use crate::light::Light;
use crate::optics::field::Field;

/// Trees of a unit: enough that its overhead does not show, few enough that threads stay busy to the end.
const UNIT: u32 = 8192;
/// Trees traced together: their rays, with all they carry, fit the cache of a core.
const STREAM: usize = 64;
/// Units that may be begun after the one to be delivered next.
const AHEAD: usize = 256;
/// Most units that a thread traces at once: in a large sample, what one has met is still near at hand for the next.
const TOGETHER: usize = 16;
/// Numbers per facet of all of them: what they yield is held until all are done.
const NUMBERS: usize = 256;
/// So long a thread may be silent, where units are that short.
const SILENCE: Duration = Duration::from_secs(1);

/// Some consecutive trees of one batch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Unit {
    /// The batch.
    pub batch: Batch,
    /// Its first tree.
    pub first: u32,
    /// How many.
    pub count: u32,
}

impl Unit {
    /// Cuts `trees` trees of a batch into units.
    pub fn cut(batch: Batch, trees: u32) -> impl Iterator<Item = Self> {
        (0..trees.div_ceil(UNIT)).map(move |i| Self { batch, first: i * UNIT, count: UNIT.min(trees - i * UNIT) })
    }
}

/// A recorder that yields what a unit has put into it.
pub trait Detect<F: Field>: Recorder<F> {
    /// What a unit yields.
    type Part: Send;
    /// Prepares for light of this incidence.
    fn begin(&mut self, incidence: usize);
    /// Yields what `trees` trees have put in.
    fn finish(&mut self, trees: u64) -> Self::Part;
}

/// Traces `units` on all threads of `pool`. `detector` makes recorders, one for each unit that is being traced; `deliver` gets
/// the parts, and the stacks of films that were met, in the order of the units, and stops the work by returning `false`.
pub fn run<F: Field, E: Effects, D: Detect<F>>(
    kernel: &Kernel<'_>,
    light: &Light,
    units: &[Unit],
    pool: &rayon::ThreadPool,
    detector: impl Fn() -> D + Sync,
    mut deliver: impl FnMut(&Unit, D::Part, Stacks) -> bool,
) {
    let queue = Queue::new(units.len(), pool.current_num_threads());
    let together = (NUMBERS / (kernel.lanes() * F::COMPONENTS)).clamp(1, TOGETHER);
    let (sender, receiver) = mpsc::channel();
    let work = |sender: mpsc::Sender<(usize, (D::Part, Stacks))>| {
        let mut worker = Worker::<F, E, D> { tracer: Tracer::new(kernel), desks: Vec::new() };
        let mut most = 1;
        loop {
            let taken = queue.take(most);
            if taken.is_empty() {
                break;
            }
            let (begun, group) = (Instant::now(), &units[taken.clone()]);
            worker.desks.resize_with(group.len().max(worker.desks.len()), || Desk::new(detector()));
            worker.trace(light, group);
            let parts = group.iter().zip(&mut worker.desks).map(|(unit, desk)| desk.clear(unit));
            if !taken.zip(parts).all(|part| sender.send(part).is_ok()) {
                break;
            }
            most = fitting(group.len(), begun.elapsed()).min(together);
        }
    };
    pool.in_place_scope(|scope| {
        for _ in 0..pool.current_num_threads() {
            let sender = sender.clone();
            scope.spawn(|_| work(sender));
        }
        drop(sender);
        let mut waiting = BTreeMap::new();
        let mut wanted = 0;
        for (i, part) in receiver {
            waiting.insert(i, part);
            let mut go_on = true;
            while let Some((part, stacks)) = waiting.remove(&wanted) {
                go_on &= deliver(&units[wanted], part, stacks);
                wanted += 1;
            }
            queue.delivered(wanted, go_on);
        }
    });
}

/// How many units can be traced in the time that a thread may be silent, if so many have taken so long.
fn fitting(units: usize, time: Duration) -> usize {
    let fit = units as f64 * SILENCE.as_secs_f64() / time.as_secs_f64();
    (fit as usize).max(1)
}

/// Which units are still to be traced.
struct Queue {
    units: usize,
    threads: usize,
    state: Mutex<Counts>,
    progress: Condvar,
}

/// How many units are taken, and how many of those are delivered.
#[derive(Default)]
struct Counts {
    taken: usize,
    delivered: usize,
}

impl Queue {
    fn new(units: usize, threads: usize) -> Self {
        Self { units, threads, state: Mutex::default(), progress: Condvar::new() }
    }

    /// The next units: not more than `most`, and so few that no thread is without work before the end. None if none is left.
    fn take(&self, most: usize) -> Range<usize> {
        let is_ahead = |c: &mut Counts| c.taken < self.units && c.taken > c.delivered + AHEAD;
        let counts = &mut *self.progress.wait_while(self.lock(), is_ahead).unwrap_or_else(PoisonError::into_inner);
        let first = counts.taken;
        counts.taken += most.min((self.units - first).div_ceil(2 * self.threads));
        first..counts.taken
    }

    /// So many are delivered; unless it goes `on`, none is left.
    fn delivered(&self, count: usize, on: bool) {
        let mut counts = self.lock();
        counts.delivered = count;
        if !on {
            counts.taken = self.units;
        }
        drop(counts);
        self.progress.notify_all();
    }

    fn lock(&self) -> MutexGuard<'_, Counts> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

struct Worker<'k, 'a, F: Field, E, D> {
    tracer: Tracer<'k, 'a, F, E>,
    desks: Vec<Desk<D>>,
}

/// Where a unit is worked on.
struct Desk<D> {
    detector: D,
    stacks: Stacks,
    /// Its trees, neighbours in the footprint together, so that their rays run together.
    trees: Vec<(u32, TreeNumbers)>,
}

impl<D> Desk<D> {
    fn new(detector: D) -> Self {
        Self { detector, stacks: Stacks::default(), trees: Vec::new() }
    }

    /// Lays out a unit.
    fn lay_out<F: Field>(&mut self, unit: &Unit)
    where
        D: Detect<F>,
    {
        self.trees.clear();
        self.trees.extend((unit.first..unit.first + unit.count).map(|tree| {
            let numbers = TreeNumbers::new(unit.batch, tree);
            (morton(numbers.entry), numbers)
        }));
        self.trees.sort_unstable_by_key(|(place, numbers)| (*place, numbers.key()));
        self.detector.begin(unit.batch.incidence as usize);
    }

    /// Takes away what the unit has yielded.
    fn clear<F: Field>(&mut self, unit: &Unit) -> (D::Part, Stacks)
    where
        D: Detect<F>,
    {
        (self.detector.finish(u64::from(unit.count)), std::mem::take(&mut self.stacks))
    }
}

impl<F: Field, E: Effects, D: Detect<F>> Worker<'_, '_, F, E, D> {
    /// Traces units, one on each desk, by turns: some trees of each from the same part of the footprint. What a unit yields
    /// does not depend on those beside it.
    fn trace(&mut self, light: &Light, units: &[Unit]) {
        self.desks.iter_mut().zip(units).for_each(|(desk, unit)| desk.lay_out(unit));
        for first in (0..UNIT as usize).step_by(STREAM) {
            for (desk, unit) in self.desks.iter_mut().zip(units) {
                let Some(trees @ [_, ..]) = desk.trees.get(first..) else { continue };
                let trees = trees.iter().take(STREAM);
                let entries = trees.map(|(_, n)| (n.entry, TreeKey { key: n.key(), first: n.first() }));
                let incidence = &light.incidences[unit.batch.incidence as usize];
                self.tracer.swap_stacks(&mut desk.stacks);
                self.tracer.trace(incidence, light.polarization, first as u32, entries, &mut desk.detector);
                self.tracer.swap_stacks(&mut desk.stacks);
            }
        }
    }
}

/// Bits of both coordinates interleaved: close numbers are close places.
fn morton(place: [f64; 2]) -> u32 {
    let spread = |x: f64| {
        let x = (x * 65536.0) as u32;
        let x = (x | x << 8) & 0x00ff_00ff;
        let x = (x | x << 4) & 0x0f0f_0f0f;
        let x = (x | x << 2) & 0x3333_3333;
        (x | x << 1) & 0x5555_5555
    };
    spread(place[0]) | spread(place[1]) << 1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_fill_a_batch() {
        let batch = Batch { seed: 1, incidence: 0, scramble: 0 };
        let units: Vec<Unit> = Unit::cut(batch, 20_000).collect();
        assert_eq!(units.iter().map(|u| u.count).sum::<u32>(), 20_000);
        assert!(units.windows(2).all(|w| w[0].first + w[0].count == w[1].first));
        assert_eq!(Unit::cut(batch, 0).count(), 0);
    }

    /// Each unit once, in order, by as many as are wanted, and fewer towards the end.
    #[test]
    fn all_units_are_taken_and_the_last_ones_singly() {
        let queue = Queue::new(100, 2);
        let taken: Vec<Range<usize>> =
            std::iter::repeat_with(|| queue.take(TOGETHER)).take_while(|r| !r.is_empty()).collect();
        assert!(taken[0] == (0..TOGETHER) && taken.last() == Some(&(99..100)), "{taken:?}");
        assert!(taken.windows(2).all(|w| w[0].end == w[1].start && w[0].len() >= w[1].len()));
        assert_eq!(Queue::new(100, 64).take(TOGETHER), 0..1);
        assert!(Queue::new(0, 2).take(TOGETHER).is_empty());
    }

    #[test]
    fn a_stopped_queue_is_empty_and_nobody_waits_for_it() {
        let queue = Queue::new(10 * AHEAD, 1);
        while queue.lock().taken <= AHEAD {
            queue.take(TOGETHER);
        }
        std::thread::scope(|scope| {
            let waiting = scope.spawn(|| queue.take(1));
            queue.delivered(1, false);
            assert!(waiting.join().unwrap().is_empty());
        });
    }

    #[test]
    fn no_thread_is_silent_for_long() {
        assert_eq!(fitting(1, SILENCE / 3), 3);
        assert_eq!(fitting(4, 100 * SILENCE), 1);
        assert_eq!(fitting(4, Duration::ZERO), usize::MAX);
    }

    #[test]
    fn morton_keeps_squares_together() {
        assert_eq!(morton([0.0, 0.0]), 0);
        assert_eq!(morton([0.999_999, 0.999_999]), u32::MAX);
        assert_eq!(morton([0.6, 0.1]) >> 30, 1);
        assert_eq!(morton([0.1, 0.6]) >> 30, 2);
    }
}
