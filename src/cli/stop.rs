//! Asked to stop: by the user, by a queue, or because the machine shuts down.

use std::process;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread;
use std::time::Duration;

use super::{STOPPED, tell};

/// Whether somebody wants the program to end.
#[derive(Clone, Debug, Default)]
pub struct Stop(Arc<Asked>);

#[derive(Debug, Default)]
struct Asked {
    asked: AtomicBool,
    for_time: AtomicBool,
}

/// By then it has ended, whatever it is doing; queues give no more than five seconds.
const PATIENCE: Duration = Duration::from_millis(4500);

impl Stop {
    /// From now on signals are heard (SIGTERM, SIGINT and SIGUSR1 on Unix): work ends at the next place from which it can go
    /// on, and after some seconds, or a second signal, at once.
    pub fn listen() -> Self {
        let stop = Self::default();
        #[cfg(unix)]
        {
            use signal_hook::consts::{SIGINT, SIGTERM, SIGUSR1};
            let Ok(mut signals) = signal_hook::iterator::Signals::new([SIGTERM, SIGINT, SIGUSR1]) else { return stop };
            let asked = stop.clone();
            thread::spawn(move || {
                let mut signals = signals.forever();
                let first = signals.next();
                asked.0.for_time.store(first == Some(SIGUSR1), Ordering::Relaxed);
                asked.0.asked.store(true, Ordering::Relaxed);
                thread::spawn(|| end_after(PATIENCE));
                // Queues repeat themselves; people mean it.
                if signals.any(|signal| signal == SIGINT) {
                    end_after(Duration::ZERO);
                }
            });
        }
        stop
    }

    /// Whether it is time to stop.
    pub fn is_asked(&self) -> bool {
        self.0.asked.load(Ordering::Relaxed)
    }

    /// Whether it is because the time that a queue gives is nearly over (SIGUSR1).
    pub fn is_for_time(&self) -> bool {
        self.0.for_time.load(Ordering::Relaxed)
    }
}

/// What was kept before is still there.
fn end_after(time: Duration) {
    thread::sleep(time);
    tell("stopped before there was anything new to keep; run the same command again");
    process::exit(STOPPED.into());
}
