//! `gonio-embree merge`: the shards of a plan put together.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use clap::Args;
use gonio_embree::experiment::State;
use gonio_embree::jobs::plan::array_spec;
use gonio_embree::jobs::shard::Shard;

use super::shard::{Shelf, described};
use super::sweep;
use crate::cli::progress::Line;
use crate::cli::setup::all_threads;
use crate::cli::{Failure, tell};

/// Options of a merge.
#[derive(Debug, Args)]
pub struct Options {
    /// The plan
    #[arg(value_name = "PLAN.json")]
    plan: PathBuf,
    /// Make do with what is there: results tell that they are incomplete
    #[arg(long)]
    partial: bool,
    /// Table of all results, with .nc and .svg beside it [default: JOBS-table.csv]
    #[arg(long, value_name = "FILE.csv")]
    table: Option<PathBuf>,
    /// Show no progress
    #[arg(long)]
    quiet: bool,
}

/// Writes all results.
pub fn run(options: &Options) -> Result<(), Failure> {
    let jobs = jobs_of(&options.plan);
    let table = options.table.clone().unwrap_or_else(|| sweep::beside(&jobs));
    let table = std::path::absolute(&table).unwrap_or(table);
    let shelf = Shelf::open(&options.plan)?;
    let count = shelf.plan.shards.len();
    let mut line = Line::new(options.quiet);
    let (mut there, mut wrong, mut backends) = (Vec::new(), Vec::new(), BTreeMap::new());
    for number in 0..count {
        line.put(|| format!("checking shard {number} of {count}"));
        match shelf.shard(number) {
            Ok(Some(shard)) => {
                there.push(number);
                backends.entry(shard.made.backend).or_insert_with(Vec::new).push(number);
            }
            Ok(None) => {}
            Err(why) => wrong.push(why),
        }
    }
    line.clear();
    if backends.len() > 1 {
        let told = backends.iter().map(|(backend, n)| format!("{} by {backend}", array_spec(n))).collect::<Vec<_>>();
        let told = format!("shards were traced by different backends: {}", told.join("; "));
        return Err(Failure::Mixed(format!("{told}; delete those of one, and trace them again with the other")));
    }
    let missing: Vec<usize> = (0..count).filter(|n| !there.contains(n)).collect();
    if !missing.is_empty() {
        wrong.push(format!("{} of {count} shards are missing: --array={}", missing.len(), array_spec(&missing)));
        if !options.partial || there.is_empty() {
            return Err(Failure::Mixed(wrong.join("\n")));
        }
        wrong.iter().for_each(|why| tell(&format!("warning: {why}")));
    }
    if let Some(backend) = backends.keys().next() {
        check_backend(&shelf, backend)?;
    }
    let mut merge = Merge { shelf: &shelf, loaded: None, partial: !missing.is_empty() };
    let (mut wanted, mut failures) = (Vec::new(), Vec::new());
    for number in 0..shelf.plan.measurements.len() {
        let name = &shelf.plan.measurements[number].name;
        line.put(|| format!("merging measurement {} of {}: {name}", number + 1, shelf.plan.measurements.len()));
        let (job, judged) = merge.measurement(number)?;
        failures.extend(judged.err().map(|e| format!("{name}: {e}")));
        wanted.extend(job);
    }
    line.clear();
    let told = sweep::write(&table, &jobs, &wanted)?;
    if !options.quiet {
        tell(&format!("{} measurements from {} shards; {told}", wanted.len(), there.len()));
    }
    match failures.len() {
        0 => Ok(()),
        n => Err(Failure::Quality(format!("{n} of {} failed:\n{}", wanted.len(), failures.join("\n")))),
    }
}

/// The job file that a plan is called after: its tables have the same name.
fn jobs_of(plan: &Path) -> PathBuf {
    let stem = plan.with_extension("");
    if stem.extension().is_some_and(|e| e == "plan") { stem.with_extension("toml") } else { stem }
}

/// What is merged here has to be planned by the same library.
fn check_backend(shelf: &Shelf, backend: &str) -> Result<(), Failure> {
    let (_, work) = shelf.work(0, all_threads())?;
    let own = described(work.settings.backend);
    if own == backend {
        return Ok(());
    }
    Err(Failure::Mixed(format!("the shards were traced by {backend}, and this program has {own}: merge with that one")))
}

struct Merge<'s> {
    shelf: &'s Shelf,
    /// The shard that was read last: measurements follow each other.
    loaded: Option<(usize, Option<Shard>)>,
    partial: bool,
}

impl Merge<'_> {
    /// Writes a result; what of a measurement is nowhere is left out.
    fn measurement(
        &mut self,
        number: usize,
    ) -> Result<(Option<super::prepared::Wanted>, Result<(), Failure>), Failure> {
        let (pieces, slices) = self.pieces(number)?;
        if pieces.is_empty() {
            return Ok((None, Ok(())));
        }
        let (job, work) = self.shelf.work(number, all_threads())?;
        let some = pieces.len() < slices;
        let (state, incidences) = State::join(pieces, self.partial)
            .map_err(|e| Failure::Mixed(format!("{}: {e}", self.shelf.plan.measurements[number].name)))?;
        let note = some.then(|| {
            let all = work.settings.trees * work.scene.light.incidences.len() as u64;
            format!("{} of {all} trees: not all shards were there", state.trees())
        });
        let done = work.done(work.experiment()?.outcome(&state, Some(&incidences)), note);
        work.write(&done)?;
        let judged = work.judge(&done);
        Ok((Some(job), judged))
    }

    /// All that is there of a measurement, and of how many pieces it is made.
    fn pieces(&mut self, measurement: usize) -> Result<(Vec<State>, usize), Failure> {
        let (mut pieces, mut slices) = (Vec::new(), 0);
        for (number, shard) in self.shelf.plan.shards.iter().enumerate() {
            for (at, _) in shard.iter().enumerate().filter(|(_, slice)| slice.measurement == measurement) {
                slices += 1;
                pieces.extend(self.piece(number, at)?);
            }
        }
        Ok((pieces, slices))
    }

    fn piece(&mut self, number: usize, at: usize) -> Result<Option<State>, Failure> {
        if self.loaded.as_ref().is_none_or(|(loaded, _)| *loaded != number) {
            let shard = match self.shelf.shard(number) {
                Ok(shard) => shard,
                Err(_) if self.partial => None,
                Err(why) => return Err(Failure::Mixed(why)),
            };
            self.loaded = Some((number, shard));
        }
        let Some((_, Some(shard))) = &mut self.loaded else { return Ok(None) };
        let slices = &self.shelf.plan.shards[number];
        if shard.pieces.len() != slices.len() {
            return Err(Failure::Mixed(format!(
                "{}: does not have what the plan says",
                self.shelf.file(number).display()
            )));
        }
        Ok(Some(shard.pieces[at].clone()))
    }
}
