//! `gonio-embree batch`: the measurements of a job file, on this machine.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::Instant;

use clap::Args;

use super::board::Board;
use super::prepared::{Wanted, earlier, prepare};
use super::{forecast, sweep};
use crate::cli::keep::Checkpoint;
use crate::cli::progress::duration;
use crate::cli::setup::all_threads;
use crate::cli::stop::Stop;
use crate::cli::{Failure, tell};

/// Options of a batch.
#[derive(Debug, Args)]
pub struct Options {
    /// What is to be measured: [defaults], and [[measurement]]s with options by the names of the command line
    #[arg(value_name = "JOBS.toml")]
    jobs: PathBuf,
    /// Measurements at the same time, which share the threads
    #[arg(long = "jobs", default_value_t = 1, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    at_once: u16,
    /// Threads of all together [default: all cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Only tell what would be measured, and about how long it takes
    #[arg(long)]
    dry_run: bool,
    /// Table of all results, with .nc and .svg beside it [default: JOBS-table.csv]
    #[arg(long, value_name = "FILE.csv")]
    table: Option<PathBuf>,
    /// Show no progress
    #[arg(long)]
    quiet: bool,
}

/// How a measurement ended.
enum End {
    /// Its result is there; it was before.
    Earlier,
    Measured,
    /// Its result may be there, but is not good enough.
    Failed(String),
    Stopped,
}

/// Measures everything that has not been measured.
pub fn run(options: &Options) -> Result<(), Failure> {
    let start = Instant::now();
    let table = options.table.clone().unwrap_or_else(|| sweep::beside(&options.jobs));
    // Where the user is; the job file may lie elsewhere.
    let table = std::path::absolute(&table).unwrap_or(table);
    let wanted = prepare(&options.jobs)?;
    let threads = options.threads.map_or_else(all_threads, usize::from);
    if options.dry_run {
        return forecast::run(&wanted, threads);
    }
    let stop = Stop::listen();
    let at_once = usize::from(options.at_once).min(wanted.len());
    let board = Mutex::new(Board::new(options.quiet, wanted.iter().map(forecast::rough_work).collect()));
    let ends: Vec<Mutex<End>> = wanted.iter().map(|_| Mutex::new(End::Stopped)).collect();
    let next = AtomicUsize::new(0);
    let share = threads.div_ceil(at_once);
    let work = || {
        loop {
            let number = next.fetch_add(1, Ordering::Relaxed);
            let Some(job) = wanted.get(number).filter(|_| !stop.is_asked()) else { break };
            let end = measure(job, number, share, &stop, &board);
            *ends[number].lock().unwrap_or_else(PoisonError::into_inner) = end;
        }
    };
    thread::scope(|scope| (0..at_once).for_each(|_| drop(scope.spawn(work))));
    board.lock().unwrap_or_else(PoisonError::into_inner).clear();
    let ends: Vec<End> = ends.into_iter().map(|e| e.into_inner().unwrap_or_else(PoisonError::into_inner)).collect();
    let count = |is: fn(&End) -> bool| ends.iter().filter(|e| is(e)).count();
    let (measured, before) = (count(|e| matches!(e, End::Measured)), count(|e| matches!(e, End::Earlier)));
    let failures: Vec<String> = (wanted.iter().zip(&ends))
        .filter_map(|(w, end)| if let End::Failed(why) = end { Some(format!("{}: {why}", w.name)) } else { None })
        .collect();
    if stop.is_asked() && ends.iter().any(|e| matches!(e, End::Stopped)) {
        // No time for a table of what there is.
        failures.iter().for_each(|f| tell(f));
        return Err(Failure::Stopped("stopped; what is done is kept, and the same command goes on from there".into()));
    }
    let tables = sweep::write(&table, &options.jobs, &wanted)?;
    if !options.quiet {
        let earlier = if before > 0 { format!(", {before} had been before") } else { String::new() };
        tell(&format!(
            "{measured} of {} measured{earlier}, in {}; {tables}",
            wanted.len(),
            duration(start.elapsed().as_secs_f64())
        ));
    }
    if failures.is_empty() {
        return Ok(());
    }
    Err(Failure::Quality(format!("{} of {} failed:\n{}", failures.len(), wanted.len(), failures.join("\n"))))
}

fn measure(job: &Wanted, number: usize, threads: usize, stop: &Stop, board: &Mutex<Board>) -> End {
    let board = || board.lock().unwrap_or_else(PoisonError::into_inner);
    board().show(number, &job.name, None);
    let measured = catch_unwind(AssertUnwindSafe(|| -> Result<End, Failure> {
        let work = job.work(threads)?;
        // One that ran out of time is tried again.
        if let Some(measured) = earlier(&work).filter(|m| work.has_reached(m)) {
            // Of two that did the same at once the other may have been killed.
            Checkpoint::beside(&work.output, work.key(), None).remove();
            work.draw_if_missing(&measured)?;
            work.gate(&measured)?;
            board().skip(number);
            return Ok(End::Earlier);
        }
        let done = work.run(job.options.every(), stop, &mut |p| board().show(number, &job.name, Some(*p)))?;
        work.judge(&done).map(|()| End::Measured)
    }));
    let end = match measured {
        Ok(Ok(End::Earlier)) => return End::Earlier,
        Ok(Ok(end)) => end,
        Ok(Err(Failure::Stopped(_))) => return End::Stopped,
        Ok(Err(failure)) => End::Failed(failure.to_string()),
        Err(_) => End::Failed("the program failed; what it said is above".into()),
    };
    board().end(number, matches!(end, End::Failed(_)));
    end
}
