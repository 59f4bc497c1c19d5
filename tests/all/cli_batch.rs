//! Many measurements from the command line: batches, checkpoints, shards.

use std::fs;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use crate::desk::{Desk, code, errors};

const JOBS: &str = r#"
[defaults]
trees = "2k"
wavelengths = "450:650:100"
output = "out/{name}.nc"

[[measurement]]
name = "ball-{radius}-{seed}"
sample = "ball.toml"
incident = "0:60:30"
vary.objects.ball.radius = [4, 5.5]
vary.seed = [1, 2]

[[measurement]]
name = "target"
sample = "ball.toml"
target-error = "10%"
"#;

const BALL: &str = r#"
[sample]
patch = { size = [12, 12], sides = "periodic" }

[[object]]
name = "ball"
shape = "sphere"
center = [0, 0, 0]
radius = 5
medium = "glass"

[media]
glass = 1.5
"#;

fn desk(name: &str) -> Desk {
    let desk = Desk::new(name);
    desk.write("jobs.toml", JOBS);
    desk.write("ball.toml", BALL);
    desk
}

fn text(output: &Output) -> String {
    String::from_utf8_lossy(&output.stdout).into()
}

fn fine(output: Output) -> Output {
    assert_eq!(code(&output), Some(0), "{}", errors(&output));
    output
}

/// All files of a directory and their bytes.
fn all(dir: &Path) -> Vec<(String, Vec<u8>)> {
    let mut files: Vec<_> = fs::read_dir(dir)
        .unwrap()
        .map(|e| e.unwrap().path())
        .map(|p| (p.file_name().unwrap().to_string_lossy().into_owned(), fs::read(&p).unwrap()))
        .collect();
    files.sort();
    files
}

fn names(files: &[(String, Vec<u8>)]) -> Vec<&str> {
    files.iter().map(|f| &f.0[..]).collect()
}

#[test]
fn a_batch_measures_everything_once_and_makes_a_table() {
    let desk = desk("batch");
    fine(desk.run(&["batch", "jobs.toml"]));
    let results = all(&desk.0.join("out"));
    assert_eq!(results.len(), 10, "{:?}", names(&results));
    let csv = String::from_utf8(desk.read("jobs-table.csv")).unwrap();
    assert_eq!(csv.lines().count(), 1 + 4 * 3 * 3 + 3);
    assert!(csv.starts_with("measurement,objects.ball.radius,seed,"), "{csv}");
    assert!(csv.contains("\nball-5.5-2,5.5,2,60,0,650,2000,"), "{csv}");
    assert!(
        desk.names().contains(&"jobs-table.svg".to_string()) && desk.names().contains(&"jobs-table.nc".to_string())
    );
    // Each is what the command alone gives.
    let of = |args: &[&str]| fine(desk.run(&[args, &["--wavelengths=450:650:100", "-o", "one.nc"]].concat()));
    of(&["--trees=2k", "--sample=ball.toml", "--incident=0:60:30", "--set=objects.ball.radius=5.5", "--seed=2"]);
    assert!(desk.read("one.nc") == desk.read("out/ball-5.5-2.nc"));
    // Again: nothing to do. From elsewhere: the same.
    let again = fine(desk.run(&["batch", "jobs.toml"]));
    assert!(errors(&again).contains("0 of 5 measured, 5 had been before"), "{}", errors(&again));
    let elsewhere = fine(desk.run(&["batch", desk.0.join("jobs.toml").to_str().unwrap(), "--jobs", "3"]));
    assert!(errors(&elsewhere).contains("5 had been before"), "{}", errors(&elsewhere));
    // Another sample is another measurement.
    desk.write("ball.toml", &BALL.replace("1.5", "1.6"));
    let other = fine(desk.run(&["batch", "jobs.toml", "--jobs", "2"]));
    assert!(errors(&other).contains("5 of 5 measured"), "{}", errors(&other));
    assert!(all(&desk.0.join("out")) != results);
}

#[test]
fn failures_are_told_at_the_end_and_stop_nothing_else() {
    let desk = desk("batch-failures");
    let jobs = format!(
        "{JOBS}\n[[measurement]]\nname = \"none\"\nsample = \"none.toml\"\n[[measurement]]\nname = \"last\"\nsample = \"ball.toml\"\n"
    );
    let jobs = jobs.replace("name = \"target\"", "name = \"target\"\nmax-rounds = 1").replace("10%", "0.01%");
    desk.write("jobs.toml", &jobs);
    let run = desk.run(&["batch", "jobs.toml"]);
    assert_eq!(code(&run), Some(1));
    let told = errors(&run);
    for part in ["2 of 7 failed", "none: none.toml: cannot be read", "target: --target-error 0.01% was not reached"] {
        assert!(told.contains(part), "{part}: {told}");
    }
    assert!(names(&all(&desk.0.join("out"))).contains(&"last.nc"));
    // More rounds are another measurement; the same number is not.
    desk.write("jobs.toml", "[[measurement]]\nsample = \"ball.toml\"\nmax-rounds = 1\n");
    let told = |desk: &Desk| errors(&fine(desk.run(&["batch", "jobs.toml"])));
    assert!(told(&desk).contains("1 of 1 measured") && told(&desk).contains("1 had been before"));
    desk.write("jobs.toml", "[[measurement]]\nsample = \"ball.toml\"\nmax-rounds = 2\n");
    assert!(told(&desk).contains("1 of 1 measured"));
    desk.write("jobs.toml", &jobs);
    let dry = desk.run(&["batch", "jobs.toml", "--dry-run"]);
    assert_eq!(code(&dry), Some(2), "{}", errors(&dry));
    assert!(
        text(&dry).contains("cannot be measured") && text(&dry).contains("7 measurements, about"),
        "{}",
        text(&dry)
    );
}

#[test]
fn a_dry_run_tells_what_it_takes_and_leaves_nothing() {
    let desk = desk("batch-dry");
    let dry = fine(desk.run(&["batch", "jobs.toml", "--dry-run", "--threads", "2"]));
    assert_eq!(text(&dry).lines().count(), 7, "{}", text(&dry));
    assert!(text(&dry).contains("with 2 threads"));
    assert!(all(&desk.0.join("out")).is_empty());
}

#[test]
fn what_is_wrong_with_a_job_file_is_told() {
    let desk = desk("batch-wrong");
    for (jobs, told) in [
        (
            "[[measurement]]\nsample = \"ball.toml\"\nincidnet = 3\n",
            "jobs.toml:1: `ball`: unexpected argument '--incidnet'",
        ),
        ("[[measurement]]\nsample = \"ball.toml\"\ntrees = \"many\"\n", "invalid value 'many' for '--trees <N>'"),
        ("[[measurement]]\nsample = \"ball.toml\"\nvary.objects.bal.radius = [2]\n", "did you mean `ball`?"),
        (
            "[[measurement]]\nsample = \"ball.toml\"\nvary.objects.ball.radius = [-2]\n",
            "ball.toml:9: radius = -2: expected a length greater than 0",
        ),
        ("trees = 3\n", "jobs.toml:1: unknown key `trees`"),
    ] {
        desk.write("jobs.toml", jobs);
        let run = desk.run(&["batch", "jobs.toml"]);
        assert!(matches!(code(&run), Some(1 | 2)) && errors(&run).contains(told), "{jobs}: {}", errors(&run));
    }
    assert_eq!(code(&desk.run(&["batch", "none.toml"])), Some(2));
}

/// A batch that takes some seconds.
fn long_jobs(desk: &Desk, trees: &str) {
    let jobs = JOBS.replace("\"2k\"", &format!("\"{trees}\"\ncheckpoint = \"0.2s\"")).replace("\"10%\"", "\"3%\"");
    let sixth = "[[measurement]]\nname = \"small\"\nsample = \"ball.toml\"\nset.objects.ball.radius = 2\n";
    desk.write("jobs.toml", &(jobs + sixth));
}

#[cfg(unix)]
fn signal(child: &std::process::Child, name: &str) {
    // The shell has it where there is no program of that name.
    Command::new("sh").args(["-c", &format!("kill -{name} {}", child.id())]).status().unwrap();
}

fn start(desk: &Desk, args: &[&str]) -> std::process::Child {
    Command::new(env!("CARGO_BIN_EXE_gonio-embree"))
        .args(args)
        .current_dir(&desk.0)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap()
}

/// Stopped by each signal again and again, a measurement, and then a batch, comes to the same bytes.
#[test]
#[cfg(unix)]
fn what_is_stopped_goes_on() {
    let (calm, desk) = (desk("batch-calm"), desk("batch-stopped"));
    let one = ["--sample=ball.toml", "--trees=600k", "--incident=0,40", "--checkpoint=off", "-o", "one.nc"];
    fine(calm.run(&one));
    let mut stops = 0;
    for name in ["TERM", "INT", "USR1"].into_iter().cycle() {
        let child = start(&desk, &one);
        // Longer and longer, so that it ends on a slow machine, too.
        sleep(Duration::from_millis(250 + 50 * stops));
        signal(&child, name);
        let asked = Instant::now();
        let output = child.wait_with_output().unwrap();
        assert!(asked.elapsed() < Duration::from_secs(5));
        match code(&output) {
            Some(0) => break,
            Some(75) => stops += 1,
            other => panic!("{other:?}: {}", errors(&output)),
        }
        assert!(errors(&output).contains("is kept, and the same command goes on") || stops == 1, "{}", errors(&output));
        assert!(stops < 100, "it never ends");
    }
    assert!(stops > 0);
    assert!(desk.read("one.nc") == calm.read("one.nc"));
    assert!(desk.names().iter().all(|n| !n.contains("checkpoint") && !n.contains("part")), "{:?}", desk.names());
}

/// Killed at any moment, without a chance to keep anything: what was kept before is there.
fn killed(name: &str, trees: &str, kills: u32) {
    let (calm, desk) = (desk(&format!("{name}-calm")), desk(name));
    long_jobs(&calm, trees);
    long_jobs(&desk, trees);
    let begin = Instant::now();
    fine(calm.run(&["batch", "jobs.toml"]));
    // Kills fall anywhere in the work, and all of them before its end.
    let longest = begin.elapsed().as_millis() as u64 * 2 / u64::from(kills) + 60;
    let mut state = 1u64;
    let mut done = 0;
    while done < kills {
        let mut child = start(&desk, &["batch", "jobs.toml"]);
        state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        sleep(Duration::from_millis((state >> 33) % longest));
        if child.try_wait().unwrap().is_none() {
            child.kill().unwrap();
            done += 1;
        } else {
            // It was faster than that: from the beginning.
            fs::remove_dir_all(desk.0.join("out")).unwrap();
        }
        child.wait().unwrap();
    }
    fine(desk.run(&["batch", "jobs.toml"]));
    let (a, b) = (all(&desk.0.join("out")), all(&calm.0.join("out")));
    assert_eq!(names(&a), names(&b));
    assert!(a == b && desk.names() == calm.names(), "{:?}", desk.names());
    assert!(desk.read("jobs-table.csv") == calm.read("jobs-table.csv"));
}

#[test]
fn what_is_killed_goes_on() {
    killed("batch-killed", "20k", 5);
}

#[test]
#[ignore = "slow: cargo test --release cli_batch:: -- --ignored (a minute)"]
fn fifty_kills_change_nothing() {
    killed("batch-killed-often", "300k", 50);
}

#[test]
fn two_batches_at_once_do_not_clash() {
    let (calm, desk) = (desk("batch-alone"), desk("batch-twice"));
    fine(calm.run(&["batch", "jobs.toml"]));
    let children = [0; 3].map(|_| start(&desk, &["batch", "jobs.toml"]));
    for child in children {
        fine(child.wait_with_output().unwrap());
    }
    assert!(all(&desk.0.join("out")) == all(&calm.0.join("out")));
    assert_eq!(desk.names(), calm.names());
}

/// A stale or broken checkpoint is never used.
#[test]
#[cfg(unix)]
fn checkpoints_that_cannot_be_believed_are_not() {
    let desk = desk("batch-stale");
    let args =
        |seed: &str| ["--sample=ball.toml", "--trees=2M", &format!("--seed={seed}"), "-o", "one.nc"].map(String::from);
    let stop = |seed: &str| {
        let args = args(seed);
        let child = start(&desk, &args.iter().map(String::as_str).collect::<Vec<_>>());
        sleep(Duration::from_millis(700));
        signal(&child, "TERM");
        let output = child.wait_with_output().unwrap();
        assert_eq!(code(&output), Some(75), "{}", errors(&output));
        desk.names().into_iter().find(|n| n.ends_with(".checkpoint")).unwrap()
    };
    let first = stop("1");
    let bytes = desk.read(&first);
    // Another seed does not see it, and leaves it alone.
    fs::rename(desk.0.join(&first), desk.0.join("kept")).unwrap();
    let second = stop("2");
    assert_ne!(first, second);
    // Under the name of the other it is foreign; cut off it is cut off.
    for (content, told) in
        [(bytes.clone(), "belongs to something else"), (bytes[..bytes.len() / 2].to_vec(), "its end is missing")]
    {
        fs::write(desk.0.join(&second), content).unwrap();
        let args = args("2");
        let run =
            fine(desk.run(&[&args.iter().map(String::as_str).collect::<Vec<_>>()[..], &["--trees=2M"]].concat()[..5]));
        assert!(errors(&run).contains(told) && errors(&run).contains("beginning anew"), "{}", errors(&run));
    }
}

#[test]
fn shards_give_the_same_bytes_as_one_machine() {
    let (calm, desk) = (desk("shards-calm"), desk("shards"));
    fine(calm.run(&["batch", "jobs.toml"]));
    fine(desk.run(&["plan", "jobs.toml", "--shards", "5"]));
    let run = |which: &str| desk.run(&["run", "jobs.plan.json", "--shard", which, "--threads", "1"]);
    for which in ["4/5", "0/5", "2/5"] {
        fine(run(which));
    }
    let status = |desk: &Desk| text(&fine(desk.run(&["status", "jobs.plan.json"])));
    assert!(
        status(&desk).contains("done         3  0,2,4") && status(&desk).ends_with("--array=1,3\n"),
        "{}",
        status(&desk)
    );
    let incomplete = desk.run(&["merge", "jobs.plan.json"]);
    assert_eq!(code(&incomplete), Some(65));
    assert!(errors(&incomplete).contains("2 of 5 shards are missing: --array=1,3"), "{}", errors(&incomplete));
    assert!(all(&desk.0.join("out")).is_empty(), "nothing is written");
    // Two at once, as a queue may do.
    let twice = [0; 2].map(|_| start(&desk, &["run", "jobs.plan.json", "--shard", "1/5"]));
    twice.into_iter().for_each(|child| drop(fine(child.wait_with_output().unwrap())));
    fine(run("3/5"));
    assert!(errors(&fine(run("3/5"))).contains("already done"));
    assert_eq!(text(&fine(desk.run(&["status", "jobs.plan.json", "--missing"]))), "");
    fine(desk.run(&["merge", "jobs.plan.json"]));
    let (a, b) = (all(&desk.0.join("out")), all(&calm.0.join("out")));
    assert_eq!(names(&a), names(&b));
    assert!(a == b && desk.read("jobs-table.csv") == calm.read("jobs-table.csv"));
    assert_eq!(all(&desk.0.join("jobs.plan.shards")).len(), 5, "nothing else is left");
}

#[test]
fn merge_refuses_what_does_not_belong_there() {
    let desk = desk("shards-bad");
    fine(desk.run(&["plan", "jobs.toml", "--shards", "4"]));
    for i in 0..4 {
        fine(desk.run(&["run", "jobs.plan.json", "--shard", &format!("{i}/4")]));
    }
    let file = |i: u32| desk.0.join(format!("jobs.plan.shards/shard-{i}"));
    let whole = fs::read(file(2)).unwrap();
    let refused = |told: &str| {
        let merge = desk.run(&["merge", "jobs.plan.json"]);
        assert_eq!(code(&merge), Some(65), "{}", errors(&merge));
        assert!(
            errors(&merge).contains(told) && errors(&merge).contains("shard-2") | told.contains("missing"),
            "{}",
            errors(&merge)
        );
        assert!(!desk.0.join("out").join("target.nc").exists(), "something was written");
    };
    let mut tampered = whole.clone();
    tampered[whole.len() / 2] ^= 1;
    fs::write(file(2), &tampered).unwrap();
    refused("is damaged");
    fs::write(file(2), &whole[..whole.len() - 100]).unwrap();
    refused("its end is missing");
    fs::copy(file(1), file(2)).unwrap();
    refused("is a copy of shard 1");
    fs::write(file(2), "anything").unwrap();
    refused("is no file of this kind");
    fs::remove_file(file(2)).unwrap();
    refused("1 of 4 shards are missing: --array=2");
    // One of another plan.
    desk.write("jobs.toml", &JOBS.replace("2k", "3k"));
    fine(desk.run(&["plan", "jobs.toml", "--shards", "4", "-o", "other.plan.json"]));
    fine(desk.run(&["run", "other.plan.json", "--shard", "2/4"]));
    fs::copy(desk.0.join("other.plan.shards/shard-2"), file(2)).unwrap();
    refused("belongs to another plan");
    let run = desk.run(&["run", "jobs.plan.json", "--shard", "2/4"]);
    assert_eq!(code(&run), Some(65), "{}", errors(&run));
    // What is broken is traced anew, and then all is well.
    fs::write(file(2), &tampered).unwrap();
    fine(desk.run(&["run", "jobs.plan.json", "--shard", "2/4"]));
    assert!(fs::read(file(2)).unwrap() != tampered);
    fine(desk.run(&["merge", "jobs.plan.json"]));
}

#[test]
fn a_plan_holds_for_the_samples_it_was_made_of() {
    let desk = desk("plan-frozen");
    fine(desk.run(&["plan", "jobs.toml", "--shards", "3"]));
    for (args, told, expected) in [
        (vec!["--shard", "3/3"], "I from 0 to N - 1", 2),
        (vec!["--shard", "1/4"], "the plan has 3 shards", 2),
        (vec!["--shard-from-env"], "SLURM_ARRAY_TASK_ID is not set", 2),
    ] {
        let run = desk.run(&[&["run", "jobs.plan.json"], &args[..]].concat());
        assert_eq!(code(&run), Some(expected), "{}", errors(&run));
        assert!(errors(&run).contains(told), "{}", errors(&run));
    }
    let too_many = desk.run(&["plan", "jobs.toml", "--shards", "1000"]);
    assert!(code(&too_many) == Some(2) && errors(&too_many).contains("there are 385 pieces"), "{}", errors(&too_many));
    desk.write("ball.toml", &BALL.replace("1.5", "1.6"));
    let run = desk.run(&["run", "jobs.plan.json", "--shard", "0/3"]);
    assert!(code(&run) == Some(65) && errors(&run).contains("not what it was"), "{}", errors(&run));
    let plan = String::from_utf8(desk.read("jobs.plan.json")).unwrap();
    desk.write("jobs.plan.json", &plan.replace("--trees=2k", "--trees=1k"));
    let run = desk.run(&["run", "jobs.plan.json", "--shard", "0/3"]);
    assert!(code(&run) == Some(65) && errors(&run).contains("was changed after"), "{}", errors(&run));
}

#[test]
fn results_of_some_shards_tell_that_they_are_incomplete() {
    let desk = desk("shards-partial");
    let (balls, _) = JOBS.split_at(JOBS.find("[[measurement]]\nname = \"target\"").unwrap());
    desk.write("jobs.toml", balls);
    fine(desk.run(&["plan", "jobs.toml", "--shards", "7"]));
    fine(desk.run(&["run", "jobs.plan.json", "--shard", "0/7"]));
    let merge = fine(desk.run(&["merge", "jobs.plan.json", "--partial"]));
    assert!(errors(&merge).contains("warning: 6 of 7 shards are missing"), "{}", errors(&merge));
    let results = all(&desk.0.join("out"));
    assert_eq!(names(&results), ["ball-4-1.nc", "ball-4-1.svg"]);
    let provenance = String::from_utf8_lossy(&results[0].1).into_owned();
    assert!(provenance.contains("of 6000 trees: not all shards were there"));
    // It is not taken for the result.
    let batch = fine(desk.run(&["batch", "jobs.toml"]));
    assert!(errors(&batch).contains("4 of 4 measured, in"), "{}", errors(&batch));
}

#[test]
fn scripts_for_a_queue_say_what_it_needs() {
    let desk = desk("slurm");
    fine(desk.run(&["plan", "jobs.toml", "--shards", "8"]));
    let script =
        text(&fine(desk.run(&["slurm-script", "jobs.plan.json", "--slice", "3", "--partition", "lab", "--cpus", "2"])));
    for part in [
        "#SBATCH --requeue",
        "#SBATCH --open-mode=append",
        "#SBATCH --signal=B:USR1@120",
        "#SBATCH --cpus-per-task=2",
        "#SBATCH --partition=lab",
        "exec \"$GONIO\" run \"$PLAN\" --shard-from-env --requeue",
        "exec \"$GONIO\" merge \"$PLAN\"",
        "--dependency=\"afterok:",
        "--kill-on-invalid-dep=yes",
        "slice=3",
    ] {
        assert!(script.contains(part), "{part}: {script}");
    }
    desk.write("submit.sh", &script);
    // A queue that only tells what it was asked.
    desk.write("sbatch", "#!/bin/bash\necho \"$@\" >> asked; cat >> asked; echo 17\n");
    let path = format!("{}:{}", desk.0.display(), std::env::var("PATH").unwrap());
    let run = |args: &[&str]| {
        let _ = fs::remove_file(desk.0.join("asked"));
        Command::new("chmod").args(["+x", "sbatch"]).current_dir(&desk.0).status().unwrap();
        let done =
            Command::new("bash").arg("submit.sh").args(args).env("PATH", &path).current_dir(&desk.0).output().unwrap();
        assert!(done.status.success(), "{}", errors(&done));
        String::from_utf8(desk.read("asked")).unwrap()
    };
    let asked = run(&[]);
    for part in ["--array=0-2 ", "GONIO_SHARD_OFFSET=3", "--array=0-1 ", "GONIO_SHARD_OFFSET=6", "afterok:17:17:17"] {
        assert!(asked.contains(part), "{part}: {asked}");
    }
    assert!(run(&["3,5-7"]).contains("--array=3,5-7 "));
}
