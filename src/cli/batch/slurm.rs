//! `gonio-embree slurm-script`: how a plan runs on a cluster.

use std::path::{Path, PathBuf};

use clap::Args;

use super::shard::Shelf;
use crate::cli::{Failure, answer};

/// Options of the scripts.
#[derive(Debug, Args)]
pub struct Options {
    /// The plan
    #[arg(value_name = "PLAN.json")]
    plan: PathBuf,
    /// Cores of each shard
    #[arg(long, default_value_t = 4, value_name = "N", value_parser = clap::value_parser!(u16).range(1..))]
    cpus: u16,
    /// Memory of each shard, as Slurm takes it
    #[arg(long, default_value = "4G", value_name = "SIZE")]
    memory: String,
    /// Time limit of each shard, as Slurm takes it; before it is over the shard is kept, and goes on in a new job
    #[arg(long, default_value = "1:00:00", value_name = "TIME")]
    time: String,
    /// Partition [default: that of the cluster]
    #[arg(long, value_name = "NAME")]
    partition: Option<String>,
    /// Most tasks of an array: MaxArraySize of the cluster less 1
    #[arg(long, default_value_t = 1000, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    slice: u32,
    /// How long before its limit Slurm warns a shard, s
    #[arg(long, default_value_t = 120, value_name = "SECONDS")]
    warn: u32,
}

/// Prints a script that submits the shards and the merge.
pub fn run(options: &Options) -> Result<(), Failure> {
    let plan = std::path::absolute(&options.plan).unwrap_or_else(|_| options.plan.clone());
    let program = std::env::current_exe().map_err(|e| Failure::Cannot(format!("where this program is: {e}")))?;
    let shelf = Shelf::open(&plan)?;
    answer(&script(options, &program, &plan, shelf.directory(), shelf.plan.shards.len()))
}

/// What the shell takes as one word.
fn quoted(path: &Path) -> String {
    format!("'{}'", path.display().to_string().replace('\'', r"'\''"))
}

fn script(options: &Options, program: &Path, plan: &Path, logs: &Path, shards: usize) -> String {
    let Options { cpus, memory, time, slice, warn, .. } = options;
    let partition = options.partition.as_ref().map(|p| format!("\n#SBATCH --partition={p}")).unwrap_or_default();
    let last = shards - 1;
    let (program, plan, logs) = (quoted(program), quoted(plan), quoted(logs));
    format!(
        r#"#!/bin/bash
# Submits {shards} shards and, when all are done, their merge. Again: only what is missing is traced.
#   bash THIS            everything
#   bash THIS 3,5-7      these shards (see `gonio-embree status`), then the merge
set -euo pipefail
export GONIO={program} PLAN={plan}
logs={logs}
slice={slice}
mkdir -p "$logs"

# $1: tasks of the array; $2: number of the first shard
submit() {{
    sbatch --parsable --array="$1" --output="$logs/slurm-$2-%a.log" --export="ALL,GONIO_SHARD_OFFSET=$2" <<'SHARD'
#!/bin/bash
#SBATCH --job-name=gonio
#SBATCH --requeue
#SBATCH --open-mode=append
#SBATCH --signal=B:USR1@{warn}
#SBATCH --cpus-per-task={cpus}
#SBATCH --mem={memory}
#SBATCH --time={time}{partition}
exec "$GONIO" run "$PLAN" --shard-from-env --requeue
SHARD
}}

jobs=()
if (($# > 0)); then
    jobs+=("$(submit "$1" 0)")
else
    for ((first = 0; first <= {last}; first += slice)); do
        rest=$(({last} - first))
        jobs+=("$(submit "0-$((rest < slice ? rest : slice - 1))" $first)")
    done
fi
IFS=:
sbatch --parsable --dependency="afterok:${{jobs[*]}}" --kill-on-invalid-dep=yes --output="$logs/slurm-merge.log" --export=ALL <<'MERGE'
#!/bin/bash
#SBATCH --job-name=gonio-merge
#SBATCH --requeue
#SBATCH --open-mode=append
#SBATCH --cpus-per-task={cpus}
#SBATCH --mem={memory}
#SBATCH --time={time}{partition}
exec "$GONIO" merge "$PLAN"
MERGE
"#
    )
}
