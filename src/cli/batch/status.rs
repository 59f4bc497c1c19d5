//! `gonio-embree status`: how far the shards of a plan are.

use std::path::PathBuf;

use clap::Args;
use gonio_embree::jobs::plan::array_spec;

use super::shard::Shelf;
use crate::cli::{Failure, answer};

/// Options of a look at a plan.
#[derive(Debug, Args)]
pub struct Options {
    /// The plan
    #[arg(value_name = "PLAN.json")]
    plan: PathBuf,
    /// Only print the missing shards as `sbatch --array` takes them, such as 3,5-7; nothing if none is missing
    #[arg(long)]
    missing: bool,
}

/// Tells which shards are done, running and missing.
pub fn run(options: &Options) -> Result<(), Failure> {
    let shelf = Shelf::open(&options.plan)?;
    let (mut done, mut running, mut missing, mut broken) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    for number in 0..shelf.plan.shards.len() {
        match shelf.shard(number) {
            Ok(Some(_)) => done.push(number),
            unfinished => {
                broken.extend(unfinished.err());
                match shelf.runner(number) {
                    Some(who) => running.push((number, who)),
                    None => missing.push(number),
                }
            }
        }
    }
    let spec = array_spec(&missing);
    if options.missing {
        return answer(&if spec.is_empty() { spec } else { spec + "\n" });
    }
    let mut text = String::new();
    let mut line = |what: &str, numbers: &[usize]| {
        text += &format!("{what:<8} {:>5}  {}\n", numbers.len(), array_spec(numbers));
    };
    let numbers: Vec<usize> = running.iter().map(|(number, _)| *number).collect();
    line("done", &done);
    line("running", &numbers);
    line("missing", &missing);
    running.iter().for_each(|(number, who)| text += &format!("shard {number} is running: {who}\n"));
    broken.iter().for_each(|why| text += &format!("{why}\n"));
    if !missing.is_empty() {
        text += &format!("--array={spec}\n");
    }
    answer(&text)
}
