//! The line that says how far the work is.

use std::io::{self, IsTerminal as _, Write as _};
use std::sync::mpsc;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use gonio_embree::experiment::Progress;
use gonio_embree::experiment::accuracy::Climbed;
use gonio_embree::units::significant;

/// Shows progress on standard error: on a terminal in one line that changes, else in a line now and then.
pub struct Line {
    shown: Instant,
    quiet: bool,
    terminal: bool,
}

impl Line {
    /// Nothing is shown yet, nor ever if `quiet`.
    pub fn new(quiet: bool) -> Self {
        Self { shown: Instant::now(), quiet, terminal: io::stderr().is_terminal() }
    }

    /// Shows how far the work is, unless that was done a moment ago.
    pub fn show(&mut self, progress: &Progress, incidences: usize) {
        self.put(|| text(progress, incidences));
    }

    /// Shows a text, unless another was shown a moment ago.
    pub fn put(&mut self, text: impl FnOnce() -> String) {
        let pause = Duration::from_millis(if self.terminal { 100 } else { 5000 });
        if self.quiet || self.shown.elapsed() < pause {
            return;
        }
        self.shown = Instant::now();
        let text = text();
        let mut err = io::stderr();
        let _ = if self.terminal { write!(err, "\r\x1b[K{text}") } else { writeln!(err, "{text}") };
    }

    /// The same of a ladder.
    pub fn tell(&mut self, at: &Climbed) {
        let left = at.seconds / at.done as f64 * (at.total - at.done) as f64;
        self.put(|| format!("measurement {} of {}, {} left", at.done, at.total, duration(left)));
    }

    /// Leaves no trace on a terminal.
    pub fn clear(&self) {
        if self.terminal && !self.quiet {
            let _ = write!(io::stderr(), "\r\x1b[K");
        }
    }
}

/// What goes before all tracing.
pub const SETTING_UP: &str = "building the sample and planning";

/// Says what is being done, and for how long, while nothing tells how far it is; nothing if it is done in a moment.
pub struct Waiting(Option<(mpsc::Sender<()>, JoinHandle<()>)>);

impl Waiting {
    /// Until this is dropped. Never says a word if `quiet`.
    pub fn new(what: &'static str, quiet: bool) -> Self {
        if quiet {
            return Self(None);
        }
        let (done, waiting) = mpsc::channel();
        let mut line = Line::new(false);
        let speak = move || {
            let start = Instant::now();
            // A file shall not be filled with that.
            let mut pause = Duration::from_secs(if line.terminal { 1 } else { 10 });
            while waiting.recv_timeout(pause) == Err(mpsc::RecvTimeoutError::Timeout) {
                line.put(|| format!("{what}, {}", duration(start.elapsed().as_secs_f64().round())));
                pause = if line.terminal { pause } else { 2 * pause };
            }
            line.clear();
        };
        // Who cannot have another thread waits in silence.
        Self(std::thread::Builder::new().spawn(speak).ok().map(|thread| (done, thread)))
    }
}

impl Drop for Waiting {
    fn drop(&mut self) {
        if let Some((done, thread)) = self.0.take() {
            drop(done);
            let _ = thread.join();
        }
    }
}

fn text(p: &Progress, incidences: usize) -> String {
    let rate = p.done as f64 / p.seconds;
    let left = p.total.saturating_sub(p.done) as f64 / rate;
    let error = p.error.map(|e| format!("error {} %, ", significant(100.0 * e, 2))).unwrap_or_default();
    format!(
        "tracing {:.0} %, {error}incidence {} of {incidences}, {:.3} M trees/s, {} left",
        100.0 * p.done as f64 / p.total.max(p.done) as f64,
        (p.incidences + 1).min(incidences),
        rate / 1e6,
        duration(left)
    )
}

/// A time for people.
pub fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 10.0 => format!("{s:.1} s"),
        s if s < 120.0 => format!("{s:.0} s"),
        s if s < 7200.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}
