//! A directory in which a test runs the program.

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};

/// A directory of its own for a test, and the subcommand that is run there, if it is always the same.
pub struct Desk(pub PathBuf, Option<&'static str>);

impl Desk {
    pub fn new(name: &str) -> Self {
        Self::of(None, name)
    }

    /// A desk for a subcommand.
    pub fn of(command: impl Into<Option<&'static str>>, name: &str) -> Self {
        let command = command.into();
        let kind = command.unwrap_or("cli");
        let dir = std::env::temp_dir().join(format!("gonio-{kind}-{name}-{}", std::process::id()));
        fs::create_dir_all(&dir).unwrap();
        Self(dir, command)
    }

    pub fn run(&self, args: &[&str]) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_gonio-embree"));
        command.args(self.1).args(args).current_dir(&self.0).output().unwrap()
    }

    /// What it prints when all is well.
    pub fn printed(&self, args: &[&str]) -> String {
        let output = self.run(args);
        assert_eq!(code(&output), Some(0), "{args:?}: {}", errors(&output));
        String::from_utf8(output.stdout).unwrap()
    }

    /// What it complains about, with exit code 2 and nothing printed.
    pub fn complaint(&self, args: &[&str]) -> String {
        let output = self.run(args);
        assert_eq!(code(&output), Some(2), "{args:?}: {}", errors(&output));
        assert!(output.stdout.is_empty());
        errors(&output)
    }

    pub fn write(&self, name: &str, text: &str) {
        fs::write(self.0.join(name), text).unwrap();
    }

    pub fn read(&self, name: &str) -> Vec<u8> {
        fs::read(self.0.join(name)).unwrap()
    }

    pub fn names(&self) -> Vec<String> {
        let mut names: Vec<String> =
            fs::read_dir(&self.0).unwrap().map(|e| e.unwrap().file_name().to_string_lossy().into()).collect();
        names.sort();
        names
    }
}

impl Drop for Desk {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

pub fn code(output: &Output) -> Option<i32> {
    output.status.code()
}

pub fn errors(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into()
}
