//! Program and machine that rows come from.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::process::Command;

use serde::{Deserialize, Serialize};

/// Program and machine that rows come from.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Provenance {
    /// Short commit, with `-dirty` where tracked files differ from it; `unknown` without git.
    pub commit: String,
    /// Processor, cores and system; neither host name nor path.
    pub machine: String,
    /// Worker threads.
    pub threads: usize,
    /// Device that renders: `cpu`, or `gpu` with the adapter's name.
    #[serde(default = "cpu")]
    pub device: String,
    /// Hash of the program's file, so that rows of different builds are not mixed.
    pub program: u64,
}

impl Provenance {
    /// Returns the provenance of the running program, which renders on a device of this name.
    pub fn of_this_run(device: String) -> Self {
        Self {
            device,
            commit: commit(),
            machine: machine(),
            threads: rayon::current_num_threads(),
            program: program().unwrap_or_default(),
        }
    }
}

/// Returns the device of rows that do not name one.
pub(crate) fn cpu() -> String {
    "cpu".to_string()
}

fn commit() -> String {
    let Some(commit) = git(&["rev-parse", "--short", "HEAD"]) else { return "unknown".to_string() };
    match git(&["status", "--porcelain", "--untracked-files=no"]) {
        Some(changes) if changes.is_empty() => commit,
        _ => format!("{commit}-dirty"),
    }
}

fn git(arguments: &[&str]) -> Option<String> {
    let output = Command::new("git").args(arguments).output().ok()?;
    let text = String::from_utf8(output.stdout).ok()?;
    output.status.success().then(|| text.trim().to_string())
}

fn machine() -> String {
    let model = std::fs::read_to_string("/proc/cpuinfo").ok().and_then(|text| {
        let line = text.lines().find(|line| line.starts_with("model name"))?;
        Some(line.split_once(':')?.1.trim().to_string())
    });
    let model = model.unwrap_or_else(|| std::env::consts::ARCH.to_string());
    let cores = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    format!("{model}, {cores} cores, {}", std::env::consts::OS)
}

fn program() -> Option<u64> {
    let bytes = std::fs::read(std::env::current_exe().ok()?).ok()?;
    Some(hash(&bytes))
}

/// Returns a hash that is the same in every run.
pub fn hash(value: &(impl Hash + ?Sized)) -> u64 {
    let mut hasher = DefaultHasher::new();
    value.hash(&mut hasher);
    hasher.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_names_commit_and_machine_without_paths() {
        let provenance = Provenance::of_this_run(cpu());
        assert!(!provenance.commit.is_empty() && !provenance.commit.contains(char::is_whitespace));
        assert!(provenance.machine.contains("cores") && !provenance.machine.contains('/'));
        assert_ne!(provenance.program, 0);
    }
}
