//! The program in a folder of its own.

#![allow(dead_code, reason = "not every test uses everything")]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use serde_json::Value;

/// A folder of one test, empty, in which the program runs.
pub(crate) struct Place(PathBuf);

impl Place {
    pub(crate) fn new(test: &str) -> Self {
        let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join(format!("program-{test}"));
        let _ = fs::remove_dir_all(&folder);
        fs::create_dir_all(&folder).unwrap();
        Self(folder)
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.join(name)
    }

    pub(crate) fn files(&self) -> Vec<String> {
        let files = fs::read_dir(&self.0).unwrap();
        let mut names: Vec<String> =
            files.map(|file| file.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    /// Runs the program with arguments separated by spaces.
    pub(crate) fn run(&self, arguments: &str) -> Output {
        let mut command = Command::new(env!("CARGO_BIN_EXE_halflight"));
        command.args(arguments.split_whitespace()).current_dir(&self.0).output().unwrap()
    }

    /// Standard output of a run that must succeed.
    pub(crate) fn good(&self, arguments: &str) -> String {
        let output = self.run(arguments);
        assert!(output.status.success(), "{arguments}: {}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    }

    /// Standard error of a run that must fail, without a panic.
    pub(crate) fn bad(&self, arguments: &str) -> String {
        failed(arguments, &self.run(arguments))
    }

    /// Runs a line of a shell, in which the program is `$H`.
    #[cfg(unix)]
    pub(crate) fn shell(&self, line: &str) -> Output {
        let mut command = Command::new("sh");
        command.arg("-c").arg(line).env("H", env!("CARGO_BIN_EXE_halflight"));
        command.current_dir(&self.0).output().unwrap()
    }
}

/// Standard error of a run that failed as it should: with a message, and not by a panic or a signal.
pub(crate) fn failed(arguments: &str, output: &Output) -> String {
    let message = String::from_utf8_lossy(&output.stderr).into_owned();
    // 1 is our own error, 2 one of the command line; a panic is 101.
    assert!(matches!(output.status.code(), Some(1 | 2)), "{arguments}: {:?} {message}", output.status);
    let said = message.lines().any(|line| line.starts_with("error: ")) && !message.contains("panicked");
    assert!(said, "{arguments}: {message}");
    message
}

pub(crate) fn json(path: &Path) -> Value {
    serde_json::from_str(&fs::read_to_string(path).unwrap()).unwrap()
}
