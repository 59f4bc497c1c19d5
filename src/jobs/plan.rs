//! A plan: the measurements of a job file with all they depend on, and how they are cut into shards.

use std::ops::Range;

use serde::{Deserialize, Serialize};

use crate::experiment::sealed::{Key, key_of};

/// What stands in the file of a plan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// `gonio-plan-1`.
    pub schema: String,
    /// Version of the program that made it, and may run it.
    pub version: String,
    /// Directory of the job file: all paths are relative to it.
    pub directory: String,
    /// The measurements.
    pub measurements: Vec<Planned>,
    /// The shards: what each of them traces.
    pub shards: Vec<Vec<Slice>>,
    /// Hash of all of the above.
    pub key: String,
}

/// A measurement of a plan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Planned {
    /// What it is called.
    pub name: String,
    /// What stands on the command line after `gonio-embree`.
    pub arguments: Vec<String>,
    /// What is varied, with the value it has here.
    pub varied: Vec<(String, String)>,
    /// SHA-256 of the files of the sample.
    pub sample_sha256: String,
    /// Batches it has, if it can be cut: one that ends when an error is reached cannot.
    pub batches: Option<u32>,
    /// Work it is thought to take, in units of its own.
    pub work: f64,
}

/// A piece of a measurement.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Slice {
    /// Number of the measurement.
    pub measurement: usize,
    /// Some of its batches, if not all of it.
    pub batches: Option<Range<u32>>,
}

/// What plans of this kind are called.
pub const SCHEMA: &str = "gonio-plan-1";

impl Plan {
    /// Cuts `measurements` into `shards` shards of about equal work. `work` tells for each measurement the work of each of its
    /// batches, or of all of it if it cannot be cut.
    ///
    /// # Errors
    /// When there are more shards than pieces.
    pub fn new(
        directory: String,
        measurements: Vec<Planned>,
        work: &[Vec<f64>],
        shards: usize,
    ) -> Result<Self, String> {
        let pieces: usize = work.iter().map(Vec::len).sum();
        if shards == 0 || shards > pieces {
            return Err(format!(
                "{shards} shards: there are {pieces} pieces, so from 1 to {pieces} shards can be made"
            ));
        }
        let mut plan = Self {
            schema: SCHEMA.into(),
            version: env!("CARGO_PKG_VERSION").into(),
            directory,
            shards: cut(&measurements, work, shards),
            measurements,
            key: String::new(),
        };
        plan.key = hex(&plan.hash());
        Ok(plan)
    }

    /// Reads a plan, of which no byte may have been changed.
    ///
    /// # Errors
    /// Why it is none.
    pub fn from_json(text: &str) -> Result<Self, String> {
        let plan: Self = serde_json::from_str(text).map_err(|e| format!("is no plan: {e}"))?;
        if plan.schema != SCHEMA {
            return Err(format!("is no plan: its schema is `{}`, expected `{SCHEMA}`", plan.schema));
        }
        let version = env!("CARGO_PKG_VERSION");
        if plan.version != version {
            return Err(format!(
                "was made by version {}, and this is {version}: use that one, or plan again",
                plan.version
            ));
        }
        if hex(&plan.hash()) != plan.key {
            return Err("was changed after it had been made; plan again".into());
        }
        Ok(plan)
    }

    /// As it stands in its file.
    pub fn to_json(&self) -> String {
        serde_json::to_string_pretty(self).expect("plain numbers and texts") + "\n"
    }

    /// What its shards belong to.
    pub fn hash(&self) -> Key {
        let bare = Self { key: String::new(), ..self.clone() };
        key_of(&[&bare.to_json()])
    }
}

fn hex(key: &Key) -> String {
    key.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Contiguous slices of the pieces of all measurements, in their order: each piece goes where its middle falls, and no shard
/// stays empty.
fn cut(measurements: &[Planned], work: &[Vec<f64>], shards: usize) -> Vec<Vec<Slice>> {
    let pieces: usize = work.iter().map(Vec::len).sum();
    let total: f64 = work.iter().flatten().sum::<f64>();
    let (mut all, mut done, mut number): (Vec<Vec<Slice>>, f64, usize) = (vec![Vec::new(); shards], 0.0, 0);
    let mut shard = 0;
    for (measurement, (planned, work)) in measurements.iter().zip(work).enumerate() {
        for (batch, work) in (0..).zip(work) {
            let wanted = ((done + 0.5 * work) / total * shards as f64) as usize;
            // Of the shards that follow each needs a piece, and so did this one.
            let most = if all[shard].is_empty() { shard } else { shard + 1 };
            let least = (shards + number).saturating_sub(pieces);
            shard = wanted.clamp(shard, most).max(least).min(shards - 1);
            done += work;
            number += 1;
            let batches = planned.batches.map(|_| batch..batch + 1);
            match (all[shard].last_mut(), batches) {
                (Some(Slice { measurement: m, batches: Some(range) }), Some(next)) if *m == measurement => {
                    range.end = next.end
                }
                (_, batches) => all[shard].push(Slice { measurement, batches }),
            }
        }
    }
    // What is in one shard is not cut.
    for slice in all.iter_mut().flatten() {
        slice.batches =
            slice.batches.take().filter(|r| Some(r.end - r.start) != measurements[slice.measurement].batches);
    }
    all
}

/// Numbers as `sbatch --array` takes them, such as `3,5-7`.
pub fn array_spec(numbers: &[usize]) -> String {
    let runs = numbers.chunk_by(|a, b| a + 1 == *b);
    let text = |run: &[usize]| match run {
        [one] => one.to_string(),
        _ => format!("{}-{}", run[0], run[run.len() - 1]),
    };
    runs.map(text).collect::<Vec<_>>().join(",")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn planned(batches: Option<u32>) -> Planned {
        Planned {
            name: "a".into(),
            arguments: vec!["--mesh=a.obj".into()],
            varied: vec![("seed".into(), "1".into())],
            sample_sha256: "00".into(),
            batches,
            work: 1.0,
        }
    }

    fn plan(work: &[Vec<f64>], shards: usize) -> Plan {
        let measurements = work.iter().map(|w| planned((w.len() > 1).then_some(w.len() as u32))).collect();
        Plan::new(".".into(), measurements, work, shards).unwrap()
    }

    #[test]
    fn every_piece_is_in_one_shard_and_none_is_empty() {
        for (work, shards) in [
            (vec![vec![1.0; 96]], 8),
            (vec![vec![1.0; 32], vec![1e3], vec![0.1; 64], vec![1.0]], 5),
            (vec![vec![1.0; 3], vec![1e9], vec![1.0; 3]], 7),
            (vec![vec![1e9, 1.0, 1.0, 1.0]], 4),
            (vec![vec![1.0, 1.0, 1.0, 1e9]], 3),
            (vec![vec![0.0; 5]], 2),
        ] {
            let plan = plan(&work, shards);
            assert!(plan.shards.iter().all(|s| !s.is_empty()), "{work:?}: {:?}", plan.shards);
            let mut next = vec![0; work.len()];
            for slice in plan.shards.iter().flatten() {
                let all = work[slice.measurement].len() as u32;
                let range = slice.batches.clone().unwrap_or(0..all);
                assert_eq!(next[slice.measurement], range.start, "{:?}", plan.shards);
                next[slice.measurement] = range.end;
            }
            assert!(next.iter().zip(&work).all(|(n, w)| *n == w.len() as u32), "{:?}", plan.shards);
        }
    }

    #[test]
    fn shards_have_equal_work() {
        let work = vec![vec![2.0; 50], vec![1.0; 100], vec![4.0; 25]];
        let plan = plan(&work, 6);
        for shard in &plan.shards {
            let of =
                |s: &Slice| work[s.measurement][0] * s.batches.as_ref().map_or(100.0, |r| f64::from(r.end - r.start));
            let sum: f64 = shard.iter().map(of).sum();
            assert!((sum - 50.0).abs() <= 4.0, "{sum}: {:?}", plan.shards);
        }
    }

    #[test]
    fn a_plan_is_believed_as_it_was_made() {
        let plan = plan(&[vec![1.0; 4]], 2);
        let text = plan.to_json();
        assert_eq!(Plan::from_json(&text).unwrap(), plan);
        assert!(Plan::from_json(&text.replace("a.obj", "b.obj")).unwrap_err().contains("was changed"));
        assert!(Plan::from_json(&text.replace("gonio-plan-1", "gonio-plan-9")).unwrap_err().contains("schema"));
        assert!(Plan::from_json("{}").is_err() && Plan::from_json("").is_err());
        assert!(Plan::new(".".into(), vec![planned(None)], &[vec![1.0]], 2).unwrap_err().contains("from 1 to 1"));
    }

    #[test]
    fn arrays_are_told_by_their_ranges() {
        assert_eq!(array_spec(&[3, 5, 6, 7, 9]), "3,5-7,9");
        assert_eq!(array_spec(&[0]), "0");
        assert_eq!(array_spec(&[]), "");
    }
}
