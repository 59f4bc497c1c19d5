//! What a batch of many tiny measurements costs beside the measurements themselves: 500 of a sphere, each by a command of its
//! own, and all by one batch; and a batch that has nothing to do.
//!
//! ```text
//! cargo bench --bench batch
//! ```
#![allow(missing_docs, clippy::print_stdout)]

use std::fs;
use std::process::Command;
use std::time::Instant;

const COUNT: usize = 500;

const SPHERE: &str = r#"
[sample]
patch = { size = [10, 10] }
[[object]]
shape = "sphere"
center = [0, 0, 0]
radius = 4
medium = "glass"
[media]
glass = 1.5
"#;

fn main() {
    let dir = std::env::temp_dir().join(format!("gonio-bench-batch-{}", std::process::id()));
    fs::create_dir_all(&dir).unwrap();
    fs::write(dir.join("sphere.toml"), SPHERE).unwrap();
    let seeds: Vec<String> = (1..=COUNT).map(|i| i.to_string()).collect();
    let jobs = format!(
        "[[measurement]]\nname = \"all-{{seed}}\"\nsample = \"sphere.toml\"\ntrees = 500\nwavelengths = 550\nvary.seed = [{}]\n",
        seeds.join(",")
    );
    fs::write(dir.join("jobs.toml"), jobs).unwrap();
    let run = |args: &[&str]| {
        let start = Instant::now();
        let done = Command::new(env!("CARGO_BIN_EXE_gonio-embree")).args(args).current_dir(&dir).output().unwrap();
        assert!(done.status.success(), "{}", String::from_utf8_lossy(&done.stderr));
        start.elapsed().as_secs_f64()
    };
    let one = |seed: &String| {
        let output = format!("one-{seed}.nc");
        run(&["--sample=sphere.toml", "--trees=500", "--wavelengths=550", "--seed", seed, "-o", &output])
    };
    let parts: f64 = seeds.iter().map(one).sum();
    let batch = run(&["batch", "jobs.toml"]);
    let again = run(&["batch", "jobs.toml"]);
    println!("{COUNT} commands {parts:.2} s, one batch {batch:.2} s: {:.2} of it; again {again:.2} s", batch / parts);
    fs::remove_dir_all(&dir).unwrap();
}
