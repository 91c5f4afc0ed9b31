//! Finished rows on disk, so that a run that was stopped goes on where it was.

use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};

use halflight_metrics::write_file;
use serde::{Deserialize, Serialize};

use super::experiment::Experiment;
use super::provenance::{Provenance, hash};
use super::record::Finished;
use super::{AblateError, error};

/// What all rows of a file have in common. Rows under another header are of no use.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Header {
    /// The whole experiment.
    experiment: serde_json::Value,
    /// Hashes of the scene files' texts; 0 for bundled scenes, which the program holds.
    scenes: Vec<u64>,
    /// The program and the machine.
    provenance: Provenance,
}

impl Header {
    /// The header of an experiment, run by this program on this machine.
    ///
    /// # Errors
    /// The experiment cannot be put into JSON.
    pub fn new(experiment: &Experiment, provenance: &Provenance) -> Result<Self, AblateError> {
        let text = |name: &str| std::fs::read_to_string(name).map_or(0, |text| hash(text.as_str()));
        Ok(Self {
            experiment: serde_json::to_value(experiment)?,
            scenes: experiment.scenes.iter().map(|scene| text(&scene.name)).collect(),
            provenance: provenance.clone(),
        })
    }
}

/// A file with a header and one finished row a line.
#[derive(Debug)]
pub struct State {
    path: PathBuf,
    file: File,
    rows: Vec<Finished>,
    set_aside: usize,
}

impl State {
    /// Opens the file or makes it. Rows under the same header are taken over, a line cut short is dropped; a file with
    /// another header is copied to one that ends in `.old`.
    ///
    /// # Errors
    /// The file cannot be read or written.
    pub fn open(path: &Path, header: &Header) -> Result<Self, AblateError> {
        let text = if path.exists() {
            std::fs::read_to_string(path).map_err(error::at(path))?
        } else {
            String::new()
        };
        let mut lines = text.lines();
        let known = lines.next().and_then(|line| serde_json::from_str::<Header>(line).ok());
        let mut rows: Vec<Finished> = lines.map_while(|line| serde_json::from_str(line).ok()).collect();
        let mut set_aside = 0;
        if known.as_ref() != Some(header) {
            set_aside = rows.len();
            if set_aside > 0 {
                write_file(&path.with_extension("jsonl.old"), text.as_bytes())?;
            }
            rows.clear();
        }
        let mut content = serde_json::to_string(header)? + "\n";
        for row in &rows {
            content += &(serde_json::to_string(row)? + "\n");
        }
        write_file(path, content.as_bytes())?;
        let file = OpenOptions::new().append(true).open(path).map_err(error::at(path))?;
        Ok(Self { path: path.to_path_buf(), file, rows, set_aside })
    }

    /// The rows so far.
    pub fn rows(&self) -> &[Finished] {
        &self.rows
    }

    /// How many rows under another header there were.
    pub fn set_aside(&self) -> usize {
        self.set_aside
    }

    /// The row, if it is finished; the last time, if it was so several times.
    pub fn row(&self, setting: &str, row: &str) -> Option<&Finished> {
        self.rows.iter().rev().find(|finished| finished.setting == setting && finished.row == row)
    }

    /// Adds a row and makes sure that it is on disk.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn append(&mut self, row: Finished) -> Result<(), AblateError> {
        let line = serde_json::to_string(&row)? + "\n";
        self.file.write_all(line.as_bytes()).map_err(error::at(&self.path))?;
        self.file.sync_data().map_err(error::at(&self.path))?;
        self.rows.push(row);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::record::tests::finished;
    use super::*;

    fn header(change: impl Fn(&mut Experiment, &mut Provenance)) -> Header {
        let mut experiment = Experiment::resolve("default").unwrap();
        let mut provenance = Provenance {
            commit: "a".to_string(),
            machine: "m".to_string(),
            threads: 2,
            device: "cpu".to_string(),
            program: 1,
        };
        change(&mut experiment, &mut provenance);
        Header::new(&experiment, &provenance).unwrap()
    }

    fn file(name: &str) -> PathBuf {
        std::env::temp_dir().join(format!("halflight-state-{name}-{}.jsonl", std::process::id()))
    }

    #[test]
    fn rows_are_taken_over_and_a_torn_line_is_dropped() {
        let (path, header) = (file("torn"), header(|_, _| {}));
        let rows = [finished("nichols", "delaunay", 1.0, 0.1), finished("full", "bilinear", 2.0, 1.0 / 3.0)];
        let mut state = State::open(&path, &header).unwrap();
        for row in &rows {
            state.append(row.clone()).unwrap();
        }
        drop(state);
        let whole = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, whole.clone() + "{\"setting\":\"hall\",\"row\":\"sf").unwrap();
        let mut state = State::open(&path, &header).unwrap();
        assert_eq!(state.rows(), rows);
        assert!(state.row("hall", "full-bilinear").is_some() && state.row("hall", "sfvt-gass").is_none());
        assert_eq!(std::fs::read_to_string(&path).unwrap(), whole);
        state.append(rows[0].clone()).unwrap();
        assert_eq!(State::open(&path, &header).unwrap().rows().len(), 3);
        std::fs::remove_file(&path).unwrap();
    }

    #[test]
    fn a_changed_experiment_commit_or_program_invalidates() {
        let path = file("changed");
        let changes: [fn(&mut Experiment, &mut Provenance); 4] = [
            |experiment, _| experiment.repetitions += 1,
            |_, provenance| provenance.commit.push_str("-dirty"),
            |_, provenance| provenance.program = 2,
            |_, provenance| provenance.threads = 1,
        ];
        for change in changes {
            let mut state = State::open(&path, &header(|_, _| {})).unwrap();
            state.append(finished("nichols", "delaunay", 1.0, 0.1)).unwrap();
            let changed = State::open(&path, &header(change)).unwrap();
            assert_eq!((changed.rows().len(), changed.set_aside()), (0, 1));
            let old = path.with_extension("jsonl.old");
            assert!(std::fs::read_to_string(&old).unwrap().contains("delaunay"));
            std::fs::remove_file(&old).unwrap();
        }
        std::fs::remove_file(&path).unwrap();
    }
}
