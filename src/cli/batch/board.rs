//! How far many measurements are.

use std::collections::BTreeMap;
use std::time::Instant;

use gonio_embree::experiment::Progress;
use gonio_embree::units::significant;

use crate::cli::progress::{Line, duration};

/// What is done and what is going on; shown in one line.
pub struct Board {
    line: Line,
    start: Instant,
    /// Work of each measurement, in any unit.
    work: Vec<f64>,
    done: f64,
    completed: usize,
    failed: usize,
    running: BTreeMap<usize, (String, Option<Progress>)>,
}

impl Board {
    /// Nothing is done of measurements that take so much work each.
    pub fn new(quiet: bool, work: Vec<f64>) -> Self {
        let line = Line::new(quiet);
        Self { line, start: Instant::now(), work, done: 0.0, completed: 0, failed: 0, running: BTreeMap::new() }
    }

    /// A measurement has begun, or has come so far.
    pub fn show(&mut self, number: usize, name: &str, progress: Option<Progress>) {
        self.running.insert(number, (name.into(), progress));
        let text = self.text();
        self.line.put(|| text);
    }

    /// A measurement has ended.
    pub fn end(&mut self, number: usize, failed: bool) {
        self.running.remove(&number);
        self.done += self.work[number];
        self.completed += 1;
        self.failed += usize::from(failed);
    }

    /// A measurement takes no work, because it was done before.
    pub fn skip(&mut self, number: usize) {
        self.work[number] = 0.0;
        self.end(number, false);
    }

    /// Leaves no trace on a terminal.
    pub fn clear(&self) {
        self.line.clear();
    }

    fn text(&self) -> String {
        let share = |p: &Progress| p.done as f64 / p.total.max(p.done).max(1) as f64;
        let going: f64 =
            self.running.iter().filter_map(|(&i, (_, p))| p.as_ref().map(|p| share(p) * self.work[i])).sum();
        let (done, all) = (self.done + going, self.work.iter().sum::<f64>());
        let mut text = format!("{} of {} done", self.completed, self.work.len());
        if self.failed > 0 {
            text += &format!(", {} failed", self.failed);
        }
        if done > 0.0 {
            let left = self.start.elapsed().as_secs_f64() * (all - done).max(0.0) / done;
            text += &format!(", {} left", duration(left));
        }
        for (name, progress) in self.running.values() {
            text += &format!("; {name}");
            let Some(p) = progress else { continue };
            text += &format!(" {:.0} %", 100.0 * share(p));
            text += &p.error.map(|e| format!(", error {} %", significant(100.0 * e, 2))).unwrap_or_default();
            let left = p.seconds * p.total.saturating_sub(p.done) as f64 / p.done as f64;
            text += &format!(", {} left", duration(left));
        }
        text
    }
}
