//! `gonio-embree run`: one shard of a plan.

use std::env;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use clap::{ArgGroup, Args};
use gonio_embree::experiment::State;
use gonio_embree::experiment::sealed::{Broken, Key, Kind, seal, unseal};
use gonio_embree::intersect::choose::Backend;
use gonio_embree::jobs::plan::{Plan, Slice};
use gonio_embree::jobs::shard::{Made, Shard};

use super::board::Board;
use super::prepared::{Wanted, enter, options};
use crate::cli::keep::Checkpoint;
use crate::cli::setup::all_threads;
use crate::cli::stop::Stop;
use crate::cli::work::{Interval, Work, trace};
use crate::cli::{Failure, tell, write};

/// Options of a shard.
#[derive(Debug, Args)]
#[command(group(ArgGroup::new("which").args(["shard", "shard_from_env"]).required(true)))]
pub struct Options {
    /// The plan
    #[arg(value_name = "PLAN.json")]
    plan: PathBuf,
    /// Which shard, counted from 0, of how many
    #[arg(long, value_name = "I/N")]
    shard: Option<Numbered>,
    /// The shard whose number Slurm tells: SLURM_ARRAY_TASK_ID, and GONIO_SHARD_OFFSET if that is set
    #[arg(long)]
    shard_from_env: bool,
    /// Threads [default: what Slurm has given, or all cores]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Keep what is traced as often as this
    #[arg(long, default_value = "60s", value_name = "TIME|off")]
    checkpoint: Interval,
    /// When stopped by SIGUSR1, as Slurm does before the time is over: let Slurm begin this job again
    #[arg(long)]
    requeue: bool,
    /// Show no progress
    #[arg(long)]
    quiet: bool,
}

/// A number below another, such as `3/8`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Numbered {
    number: usize,
    of: usize,
}

impl std::str::FromStr for Numbered {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts = text.split_once('/').and_then(|(i, n)| Some((i.trim().parse().ok()?, n.trim().parse().ok()?)));
        match parts {
            Some((number, of)) if number < of => Ok(Self { number, of }),
            _ => Err("expected I/N with I from 0 to N - 1, such as 3/8".into()),
        }
    }
}

/// A plan with the places of its shards.
pub struct Shelf {
    pub plan: Plan,
    pub key: Key,
    directory: PathBuf,
}

impl Shelf {
    /// Reads a plan. From now on the program is in the directory to which its paths belong.
    pub fn open(path: &Path) -> Result<Self, Failure> {
        let path = std::path::absolute(path).unwrap_or_else(|_| path.into());
        let text = fs::read_to_string(&path)
            .map_err(|e| Failure::Input(format!("{}: cannot be read: {e}", path.display())))?;
        let plan = Plan::from_json(&text).map_err(|e| Failure::Mixed(format!("{}: {e}", path.display())))?;
        let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let home = path.parent().unwrap_or(Path::new("."));
        enter(&home.join(&plan.directory))?;
        Ok(Self { key: plan.hash(), plan, directory: home.join(format!("{stem}.shards")) })
    }

    /// Where the shards are.
    pub fn directory(&self) -> &Path {
        &self.directory
    }

    /// The file of a shard.
    pub fn file(&self, number: usize) -> PathBuf {
        let width = (self.plan.shards.len() - 1).to_string().len();
        self.directory.join(format!("shard-{number:0width$}"))
    }

    fn sign(&self, number: usize) -> PathBuf {
        self.file(number).with_extension("running")
    }

    /// What a shard has left; nothing if it has not been there.
    ///
    /// # Errors
    /// Why what is there is not to be believed.
    pub fn shard(&self, number: usize) -> Result<Option<Shard>, String> {
        let path = self.file(number);
        let bytes = match fs::read(&path) {
            Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(None),
            read => read.map_err(|e| format!("{}: cannot be read: {e}", path.display()))?,
        };
        let shard: Shard = unseal(Kind::Shard, &self.key, &bytes).map_err(|broken| {
            let told = if broken == Broken::Foreign { "belongs to another plan".into() } else { broken.to_string() };
            format!("{}: {told}", path.display())
        })?;
        if shard.made.shard != number {
            return Err(format!("{}: is a copy of shard {}", path.display(), shard.made.shard));
        }
        Ok(Some(shard))
    }

    /// Who traces a shard now, as far as is known.
    pub fn runner(&self, number: usize) -> Option<String> {
        let path = self.sign(number);
        let age = fs::metadata(&path).ok()?.modified().ok()?.elapsed().unwrap_or_default();
        (age < SILENT).then(|| fs::read_to_string(&path).unwrap_or_default())
    }

    /// A measurement of the plan, whose sample is still what it was.
    pub fn work(&self, measurement: usize, threads: usize) -> Result<(Wanted, Work), Failure> {
        let planned = &self.plan.measurements[measurement];
        let options = options(&planned.arguments).map_err(Failure::Mixed)?;
        let (name, arguments, varied) = (planned.name.clone(), planned.arguments.clone(), planned.varied.clone());
        let wanted = Wanted { name, arguments, varied, options };
        let work = wanted.work(threads)?;
        if work.origin.sha256 != planned.sample_sha256 {
            let files: Vec<String> = work.origin.files.iter().map(|f| f.display().to_string()).collect();
            let told = format!("{}: the sample is not what it was when the plan was made", planned.name);
            return Err(Failure::Mixed(format!("{told}: {}; plan again", files.join(", "))));
        }
        Ok((wanted, work))
    }
}

/// Who has not been heard of for so long runs no more.
const SILENT: Duration = Duration::from_secs(300);
/// How often it is told that a shard is running.
const HEARTBEAT: Duration = Duration::from_secs(15);

/// Tells others that a shard is running, as long as it is.
struct Sign {
    path: PathBuf,
    told: Instant,
}

impl Sign {
    fn put_up(path: PathBuf) -> Self {
        let sign = Self { path, told: Instant::now() };
        sign.tell();
        sign
    }

    fn tell(&self) {
        // That others do not know is no reason to end.
        let _ = fs::write(&self.path, format!("{}, process {}", host(), std::process::id()));
    }

    fn repeat(&mut self) {
        if self.told.elapsed() >= HEARTBEAT {
            self.told = Instant::now();
            self.tell();
        }
    }
}

impl Drop for Sign {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.path);
    }
}

/// Traces a shard, unless that has been done.
pub fn run(options: &Options) -> Result<(), Failure> {
    let shelf = Shelf::open(&options.plan)?;
    let number = options.number(&shelf.plan)?;
    let of = shelf.plan.shards.len();
    match shelf.shard(number) {
        Ok(Some(_)) => {
            tell(&format!("shard {number} of {of}: already done"));
            return Ok(());
        }
        Ok(None) => {}
        Err(why) if why.ends_with("another plan") => {
            return Err(Failure::Mixed(format!("{why}; move {} away", shelf.directory().display())));
        }
        Err(why) => tell(&format!("warning: {why}; tracing it anew")),
    }
    let failed = |e: std::io::Error| Failure::Cannot(format!("{}: {e}", shelf.directory().display()));
    fs::create_dir_all(shelf.directory()).map_err(failed)?;
    let stop = Stop::listen();
    let done = options.trace(&shelf, number, &stop);
    if matches!(done, Err(Failure::Stopped(_))) && options.requeue && stop.is_for_time() {
        requeue();
    }
    done
}

impl Options {
    fn number(&self, plan: &Plan) -> Result<usize, Failure> {
        let of = plan.shards.len();
        let number = match self.shard {
            Some(shard) if shard.of != of => {
                return Err(Failure::Input(format!("--shard {}/{}: the plan has {of} shards", shard.number, shard.of)));
            }
            Some(shard) => shard.number,
            None => from_queue(of)?,
        };
        if number < of {
            Ok(number)
        } else {
            Err(Failure::Input(format!("there is no shard {number}: the plan has {of}")))
        }
    }

    fn trace(&self, shelf: &Shelf, number: usize, stop: &Stop) -> Result<(), Failure> {
        let slices = &shelf.plan.shards[number];
        let mut sign = Sign::put_up(shelf.sign(number));
        let mut checkpoint = Checkpoint::beside(&shelf.file(number), shelf.key, self.checkpoint.0);
        let here = made(number, shelf.plan.shards.len());
        let kept = checkpoint.read().filter(|s: &Shard| s.made.shard == number);
        let mut shard = kept.unwrap_or_else(|| Shard { made: here.clone(), pieces: Vec::new() });
        shard.made = Made { seconds: shard.made.seconds, ..here };
        let mut board = Board::new(self.quiet, slices.iter().map(|s| work_of(&shelf.plan, s)).collect());
        let threads = self.threads.map_or_else(all_threads, usize::from);
        for (at, slice) in slices.iter().enumerate() {
            let name = &shelf.plan.measurements[slice.measurement].name;
            if shard.pieces.get(at).is_some_and(State::is_finished) {
                board.skip(at);
                continue;
            }
            board.show(at, name, None);
            let (_, work) = shelf.work(slice.measurement, threads)?;
            shard.made.backend = described(work.settings.backend);
            let experiment = work.experiment()?;
            let fresh = || slice.batches.clone().map_or_else(|| experiment.start(), |b| experiment.start_part(b));
            let mut state = if shard.pieces.len() > at { shard.pieces.remove(at) } else { fresh() };
            let mut watch = |p: &_| {
                board.show(at, name, Some(*p));
                sign.repeat();
            };
            trace(&experiment, &mut state, stop, &mut watch, |state| {
                let pieces = shard.pieces.iter().chain([state]).collect();
                checkpoint.keep_now_and_then(&Shard { made: shard.made.clone(), pieces });
            });
            let finished = state.is_finished();
            shard.pieces.push(state);
            if !finished {
                board.clear();
                return checkpoint.stop(&shard);
            }
            board.end(at, false);
        }
        board.clear();
        shard.made.seconds[1] = now();
        write(&shelf.file(number), &seal(Kind::Shard, &shelf.key, &shard))?;
        checkpoint.remove();
        if !self.quiet {
            tell(&format!("shard {number} of {}: done", shelf.plan.shards.len()));
        }
        Ok(())
    }
}

/// Work of a slice, as the plan thinks.
fn work_of(plan: &Plan, slice: &Slice) -> f64 {
    let planned = &plan.measurements[slice.measurement];
    match (&slice.batches, planned.batches) {
        (Some(range), Some(all)) => planned.work * f64::from(range.end - range.start) / f64::from(all),
        _ => planned.work,
    }
}

/// Who intersects.
pub fn described(backend: Backend) -> String {
    format!("{} {}", backend.name(), backend.version())
}

/// The number that Slurm tells.
fn from_queue(of: usize) -> Result<usize, Failure> {
    let number = |name: &str| -> Result<Option<usize>, Failure> {
        let Ok(text) = env::var(name) else { return Ok(None) };
        text.parse().map(Some).map_err(|_| Failure::Input(format!("{name}={text}: expected a number from 0")))
    };
    let Some(task) = number("SLURM_ARRAY_TASK_ID")? else {
        let told =
            "--shard-from-env: SLURM_ARRAY_TASK_ID is not set, so this is no array job of Slurm; give --shard I/N";
        return Err(Failure::Input(told.into()));
    };
    let step = number("SLURM_ARRAY_TASK_STEP")?.unwrap_or(1);
    if step != 1 {
        return Err(Failure::Input(format!("the array has a step of {step}: give --array=0-{}", of - 1)));
    }
    Ok(task + number("GONIO_SHARD_OFFSET")?.unwrap_or(0))
}

/// Has Slurm begin this job again.
fn requeue() {
    let variable = |name| env::var(name).ok();
    let task =
        variable("SLURM_ARRAY_JOB_ID").zip(variable("SLURM_ARRAY_TASK_ID")).map(|(job, task)| format!("{job}_{task}"));
    let Some(job) = task.or_else(|| variable("SLURM_JOB_ID")) else { return };
    let asked = Command::new("scontrol").args(["requeue", &job]).status();
    if !asked.is_ok_and(|status| status.success()) {
        tell(&format!("warning: `scontrol requeue {job}` failed; submit the shard again"));
    }
}

fn host() -> String {
    fs::read_to_string("/proc/sys/kernel/hostname").map_or_else(|_| "this machine".into(), |name| name.trim().into())
}

fn now() -> u64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |d| d.as_secs())
}

/// Where a shard is traced.
fn made(shard: usize, of: usize) -> Made {
    let cpu = fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = cpu.lines().find_map(|line| line.strip_prefix("model name")).unwrap_or_default();
    let of_queue = ["SLURM_JOB_ID", "SLURM_ARRAY_JOB_ID", "SLURM_ARRAY_TASK_ID", "SLURM_RESTART_COUNT"];
    let told = of_queue.iter().filter_map(|name| Some(format!("{name}={}", env::var(name).ok()?)));
    Made {
        shard,
        of,
        backend: String::new(),
        host: host(),
        processor: model.trim_start_matches([' ', '\t', ':']).into(),
        job: told.collect::<Vec<_>>().join(" "),
        seconds: [now(), 0],
    }
}
