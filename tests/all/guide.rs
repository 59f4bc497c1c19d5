//! The commands of the documents do what the documents say.
//!
//! Blocks marked `sh` are run line by line, in one fresh directory per document; blocks whose mark has a second word, such as
//! `toml beads.toml`, are files that the reader saves under that name. Blocks marked otherwise (`console`, `python`) are not run
//! here: `tests/consumers/guide_snippets.py` runs the Python.

#![cfg(unix)]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

const HOME: &str = env!("CARGO_MANIFEST_DIR");

/// Trees that are traced in place of those in the documents, but in the slow tier: what is tested is that commands work.
const FEW: &str = "2000";

/// An error in place of those in the documents.
const ROUGH: &str = "50%";

/// A fenced block: its mark, and its text.
struct Block {
    mark: String,
    text: String,
}

fn blocks(document: &str) -> Vec<Block> {
    let mut all = Vec::new();
    let mut lines = document.lines();
    while let Some(line) = lines.next() {
        if let Some(mark) = line.strip_prefix("```") {
            let text: Vec<&str> = lines.by_ref().take_while(|line| *line != "```").collect();
            all.push(Block { mark: mark.trim().into(), text: text.join("\n") + "\n" });
        }
    }
    all
}

/// The commands of a block for the shell; lines that end in a backslash go on.
fn commands(text: &str) -> Vec<String> {
    let joined = text.replace("\\\n", " ");
    joined.lines().map(str::trim).filter(|line| !line.is_empty() && !line.starts_with('#')).map(String::from).collect()
}

/// The same command with few trees.
fn hurried(command: &str) -> String {
    let mut words: Vec<&str> = command.split_whitespace().collect();
    words.iter_mut().filter(|word| **word == "--quick").for_each(|word| *word = "--seeds=2");
    if let Some(at) = words.iter().position(|word| *word == "--target-error") {
        words[at + 1] = ROUGH;
    } else if let Some(at) = words.iter().position(|word| *word == "--trees") {
        words[at + 1] = FEW;
    } else if words.contains(&"--mesh") || words.contains(&"--sample") {
        words.extend(["--trees", FEW]);
    }
    words.join(" ")
}

/// The files a command names as its output.
fn outputs(command: &str) -> Vec<&str> {
    let words: Vec<&str> = command.split_whitespace().collect();
    words.windows(2).filter(|pair| ["-o", "--output", "--plot"].contains(&pair[0])).map(|pair| pair[1]).collect()
}

/// A directory of its own for a document, with the assets.
struct Desk(PathBuf);

impl Desk {
    fn new(name: &str) -> Self {
        let dir = std::env::temp_dir().join(format!("gonio-guide-{name}-{}", std::process::id()));
        fs::create_dir_all(&dir).unwrap();
        std::os::unix::fs::symlink(Path::new(HOME).join("assets"), dir.join("assets")).unwrap();
        Self(dir)
    }

    /// Runs one command; returns all it printed.
    fn run(&self, command: &str) -> String {
        let program = Path::new(env!("CARGO_BIN_EXE_gonio-embree"));
        let path = format!("{}:{}", program.parent().unwrap().display(), std::env::var("PATH").unwrap());
        let output = Command::new("sh").args(["-c", command]).current_dir(&self.0).env("PATH", path).output().unwrap();
        let [out, err] = [&output.stdout, &output.stderr].map(|bytes| String::from_utf8_lossy(bytes));
        assert!(output.status.success(), "{command}\n{}\n{err}", output.status);
        for file in outputs(command) {
            assert!(self.0.join(file).is_file(), "{command}\nhas not written {file}");
        }
        format!("{out}{err}")
    }

    /// Follows a document; returns all that its commands printed.
    fn follow(&self, document: &str, change: impl Fn(&str) -> String) -> String {
        let mut printed = String::new();
        for block in blocks(document) {
            match block.mark.split_once(' ') {
                Some((_, file)) => fs::write(self.0.join(file), &block.text).unwrap(),
                None if block.mark == "sh" => {
                    commands(&block.text).iter().for_each(|command| printed += &self.run(&change(command)));
                }
                None => {}
            }
        }
        printed
    }
}

impl Drop for Desk {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

fn read(name: &str) -> String {
    fs::read_to_string(Path::new(HOME).join(name)).unwrap()
}

/// Names of files that the text, not its blocks, sets as code.
fn files_named(document: &str) -> Vec<&str> {
    const ENDS: [&str; 14] = [
        ".nc", ".svg", ".html", ".toml", ".obj", ".mtl", ".yml", ".csv", ".npy", ".bsdf", ".pbsdf", ".xml", ".rad",
        ".md",
    ];
    // What is between the first and the second backtick of a line, the third and the fourth, ...
    let prose = document.split("\n```").step_by(2).flat_map(str::lines);
    let code = prose.flat_map(|line| line.split('`').skip(1).step_by(2));
    code.filter(|text| !text.contains(' ') && ENDS.iter().any(|end| text.ends_with(end))).collect()
}

/// Targets of links and pictures that are files.
fn links(document: &str) -> impl Iterator<Item = &str> {
    let targets = document.split("](").skip(1).filter_map(|rest| rest.split_once(')'));
    targets.map(|(target, _)| target.split('#').next().unwrap_or("")).filter(|t| !t.is_empty() && !t.contains("://"))
}

#[test]
fn the_commands_of_the_guide_work() {
    let (desk, guide) = (Desk::new("guide"), read("docs/guide.md"));
    desk.follow(&guide, hurried);
    let named = files_named(&guide);
    assert!(named.len() > 10, "{named:?}");
    for file in named {
        let there = desk.0.join(file).is_file() || Path::new(HOME).join(file).is_file();
        assert!(there, "docs/guide.md names {file}, which no command has written and no block holds");
    }
}

#[test]
fn the_commands_for_many_measurements_work() {
    let desk = Desk::new("batch");
    // Where there is no GNU parallel, one after the other.
    let is_there = Command::new("parallel").arg("--version").output().is_ok();
    let one_by_one = "for i in 0 1 2 3; do gonio-embree run night.plan.json --shard $i/4; done";
    let printed = desk.follow(&read("docs/batch.md"), |command| {
        if command.contains("parallel") && !is_there { one_by_one.into() } else { command.into() }
    });
    assert!(printed.contains("5 measurements, about") && printed.contains("5 measurements from 4 shards"), "{printed}");
    for file in
        ["night-table.csv", "night-table.nc", "night-table.svg", "night/feather.nc", "night/web-0.5-2.svg", "submit.sh"]
    {
        assert!(desk.0.join(file).is_file(), "{file}");
    }
}

#[test]
fn the_commands_of_the_readme_work() {
    let desk = Desk::new("readme");
    // The reader's own sample.
    fs::copy(Path::new(HOME).join("assets/samples/morpho.toml"), desk.0.join("sheet.toml")).unwrap();
    let with_program = |command: &str| command.replace("cargo run --release --", "gonio-embree");
    let ours = |command: &str| command.starts_with("gonio-embree ");
    let mut run = 0;
    for block in blocks(&read("README.md")).iter().filter(|block| block.mark == "sh") {
        for command in commands(&block.text).iter().map(|c| with_program(c)).filter(|c| ours(c)) {
            desk.run(&if command.contains('"') { command } else { hurried(&command) });
            run += 1;
        }
    }
    assert!(run >= 8, "only {run} commands were found");
}

#[test]
fn links_of_the_documents_lead_to_files() {
    for name in [
        "README.md",
        "docs/guide.md",
        "docs/conventions.md",
        "docs/accuracy.md",
        "docs/batch.md",
        "docs/performance.md",
    ] {
        let text = read(name);
        let folder = Path::new(HOME).join(name).parent().unwrap().to_owned();
        for target in links(&text) {
            assert!(folder.join(target).exists(), "{name}: {target} is not there");
        }
    }
}

/// With all trees the program prints what the guide shows: each line of the blocks marked `text`, but those that are cut (`...`);
/// and it draws the pictures that are called `guide-` and the name of the file.
#[test]
#[ignore = "slow: all trees of the guide"]
fn the_guide_shows_what_the_program_prints() {
    let (desk, guide) = (Desk::new("shown"), read("docs/guide.md"));
    let printed = desk.follow(&guide, |command| command.into());
    let shown = blocks(&guide).into_iter().filter(|block| block.mark == "text");
    let lines: Vec<String> = shown.flat_map(|block| block.text.lines().map(String::from).collect::<Vec<_>>()).collect();
    assert!(lines.len() > 20, "{lines:?}");
    for line in lines.iter().filter(|line| line.trim() != "...") {
        let found = printed.lines().any(|l| l.trim_end() == line.trim_end());
        assert!(found, "docs/guide.md shows a line that no command has printed:\n{line}");
    }
    let pictures: Vec<&str> = links(&guide).filter(|target| target.starts_with("guide-")).collect();
    assert!(!pictures.is_empty());
    for picture in pictures {
        let drawn = fs::read_to_string(desk.0.join(&picture["guide-".len()..])).unwrap();
        assert!(
            drawn == read(&format!("docs/{picture}")),
            "docs/{picture} is not what the command draws: copy it again"
        );
    }
}
