//! Cuts the work into units, hands them to threads, and delivers what they measured in a fixed order: the result
//! is the same for any number of threads.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Condvar, Mutex, PoisonError, mpsc};

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
/// Units that may be finished before the one to be delivered next.
const AHEAD: usize = 256;

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

/// Traces `units` on all threads of `pool`. `detector` makes one recorder per thread; `deliver` gets the parts, and the
/// stacks of films that were met, in the order of the units, and stops the work by returning `false`.
pub fn run<F: Field, E: Effects, D: Detect<F>>(
    kernel: &Kernel<'_>,
    light: &Light,
    units: &[Unit],
    pool: &rayon::ThreadPool,
    detector: impl Fn() -> D + Sync,
    mut deliver: impl FnMut(&Unit, D::Part, Stacks) -> bool,
) {
    let next = AtomicUsize::new(0);
    let delivered = Mutex::new(0usize);
    let progress = Condvar::new();
    let (sender, receiver) = mpsc::channel();
    let work = |sender: mpsc::Sender<(usize, (D::Part, Stacks))>| {
        let mut worker = Worker { tracer: Tracer::<F, E>::new(kernel), detector: detector(), order: Vec::new() };
        loop {
            let i = next.fetch_add(1, Ordering::Relaxed);
            let Some(unit) = units.get(i) else { break };
            let mut done = delivered.lock().unwrap_or_else(PoisonError::into_inner);
            while i > *done + AHEAD {
                done = progress.wait(done).unwrap_or_else(PoisonError::into_inner);
            }
            drop(done);
            let part = worker.trace(light, unit);
            if sender.send((i, (part, worker.tracer.take_stacks()))).is_err() {
                break;
            }
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
            while let Some((part, stacks)) = waiting.remove(&wanted) {
                let go_on = deliver(&units[wanted], part, stacks);
                wanted += 1;
                if !go_on {
                    next.store(units.len(), Ordering::Relaxed);
                }
            }
            *delivered.lock().unwrap_or_else(PoisonError::into_inner) = wanted;
            progress.notify_all();
        }
    });
}

struct Worker<'k, 'a, F: Field, E, D> {
    tracer: Tracer<'k, 'a, F, E>,
    detector: D,
    order: Vec<(u32, TreeNumbers)>,
}

impl<F: Field, E: Effects, D: Detect<F>> Worker<'_, '_, F, E, D> {
    /// Traces the trees of a unit, neighbours in the footprint together, so that their rays run together.
    fn trace(&mut self, light: &Light, unit: &Unit) -> D::Part {
        self.order.clear();
        self.order.extend((unit.first..unit.first + unit.count).map(|tree| {
            let numbers = TreeNumbers::new(unit.batch, tree);
            (morton(numbers.entry), numbers)
        }));
        self.order.sort_unstable_by_key(|(place, numbers)| (*place, numbers.key()));
        let incidence = unit.batch.incidence as usize;
        self.detector.begin(incidence);
        for (i, trees) in self.order.chunks(STREAM).enumerate() {
            let entries = trees.iter().map(|(_, n)| (n.entry, TreeKey { key: n.key(), first: n.first() }));
            let first = (i * STREAM) as u32;
            self.tracer.trace(&light.incidences[incidence], light.polarization, first, entries, &mut self.detector);
        }
        self.detector.finish(u64::from(unit.count))
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

    #[test]
    fn morton_keeps_squares_together() {
        assert_eq!(morton([0.0, 0.0]), 0);
        assert_eq!(morton([0.999_999, 0.999_999]), u32::MAX);
        assert_eq!(morton([0.6, 0.1]) >> 30, 1);
        assert_eq!(morton([0.1, 0.6]) >> 30, 2);
    }
}
