//! Finished rows on disk, so that a run that was stopped goes on where it was.

use std::io::Write;
use std::path::{Path, PathBuf};

use anyhow::Result;
use fs_err::{File, OpenOptions};
use halflight_metrics::write_file;
use serde::{Deserialize, Serialize};

use crate::experiment::Experiment;
use crate::results::{Finished, Provenance, hash};

/// Experiment, scenes and program that all rows of a file have in common. Rows under another header are of no use.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct Header {
    /// Experiment with all its keys.
    experiment: serde_json::Value,
    /// Hashes of the scene files' texts; 0 for bundled scenes, which the program holds.
    scenes: Vec<u64>,
    /// Program and machine.
    provenance: Provenance,
}

impl Header {
    /// Returns the header of an experiment, run by this program on this machine.
    ///
    /// # Errors
    /// The experiment cannot be put into JSON.
    pub(super) fn new(experiment: &Experiment, provenance: &Provenance) -> Result<Self> {
        let text = |name: &str| std::fs::read_to_string(name).map_or(0, |text| hash(text.as_str()));
        Ok(Self {
            experiment: serde_json::to_value(experiment)?,
            scenes: experiment.scenes.iter().map(|scene| text(&scene.name)).collect(),
            provenance: provenance.clone(),
        })
    }
}

/// File with a header and one finished row a line.
#[derive(Debug)]
pub(super) struct State {
    file: File,
    rows: Vec<Finished>,
    set_aside: Option<SetAside>,
}

/// Lines of an earlier file that this run cannot use, and the file that they were copied to with all others.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct SetAside {
    /// Number of lines below the header.
    pub lines: usize,
    /// Path of the copy.
    pub copy: PathBuf,
}

impl State {
    /// Opens the file or makes it. Rows under the same header are taken over. Lines that cannot be used, under another header
    /// or not readable as rows, are kept in a copy of the whole file: `.old`, or `.old2` and so on where there is one. A last
    /// line that was cut short is dropped.
    ///
    /// # Errors
    /// The file cannot be read or written.
    pub(super) fn open(path: &Path, header: &Header) -> Result<Self> {
        let bytes = if path.exists() { fs_err::read(path)? } else { Vec::new() };
        let text = String::from_utf8_lossy(&bytes);
        let mut lines = text.split_inclusive('\n');
        let known = lines.next().and_then(|line| serde_json::from_str::<Header>(line).ok());
        let same = known.as_ref() == Some(header);
        let (mut rows, mut lost) = (Vec::new(), usize::from(!same && known.is_none() && !text.is_empty()));
        for line in lines.filter(|line| !line.trim().is_empty()) {
            match serde_json::from_str::<Finished>(line) {
                Ok(row) if same => rows.push(row),
                Err(_) if same && !line.ends_with('\n') => {}
                _ => lost += 1,
            }
        }
        let set_aside = if lost > 0 {
            let copy = unused(path);
            write_file(&copy, &bytes)?;
            Some(SetAside { lines: lost, copy })
        } else {
            None
        };
        let mut content = serde_json::to_string(header)? + "\n";
        for row in &rows {
            content += &(serde_json::to_string(row)? + "\n");
        }
        write_file(path, content.as_bytes())?;
        let file = OpenOptions::new().append(true).open(path)?;
        Ok(Self { file, rows, set_aside })
    }

    /// Returns the rows so far.
    #[cfg(test)]
    pub(super) fn rows(&self) -> &[Finished] {
        &self.rows
    }

    /// Returns the lines of the earlier file that were set aside, if any.
    pub(super) fn set_aside(&self) -> Option<&SetAside> {
        self.set_aside.as_ref()
    }

    /// Returns a row if it is finished; the last one of several.
    pub(super) fn row(&self, setting: &str, row: &str) -> Option<&Finished> {
        self.rows.iter().rev().find(|finished| finished.setting == setting && finished.row == row)
    }

    /// Adds a row and makes sure that it is on disk.
    ///
    /// # Errors
    /// The file cannot be written.
    pub(super) fn append(&mut self, row: Finished) -> Result<()> {
        let line = serde_json::to_string(&row)? + "\n";
        self.file.write_all(line.as_bytes())?;
        self.file.sync_data()?;
        self.rows.push(row);
        Ok(())
    }
}

/// Returns the first name after `path` for a copy that no file has.
fn unused(path: &Path) -> PathBuf {
    let mut copy = path.with_extension("jsonl.old");
    for number in 2.. {
        if !copy.exists() {
            break;
        }
        copy = path.with_extension(format!("jsonl.old{number}"));
    }
    copy
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::results::record::tests::finished;

    fn header(change: impl Fn(&mut Experiment, &mut Provenance)) -> Header {
        let mut experiment = Experiment::resolve("default").unwrap();
        let mut provenance = Provenance { threads: 2, program: 1, ..Provenance::default() };
        change(&mut experiment, &mut provenance);
        Header::new(&experiment, &provenance).unwrap()
    }

    /// Path of a state in an empty folder.
    fn file() -> (tempfile::TempDir, PathBuf) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("state.jsonl");
        (folder, path)
    }

    #[test]
    fn rows_are_taken_over_and_a_torn_line_is_dropped() {
        let ((_folder, path), header) = (file(), header(|_, _| {}));
        let rows =
            [finished("nichols", "delaunay", 1.0, 0.1), finished("per-pixel", "bilinear", 2.0, 1.0 / 3.0)];
        let mut state = State::open(&path, &header).unwrap();
        for row in &rows {
            state.append(row.clone()).unwrap();
        }
        drop(state);
        let whole = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, whole.clone() + "{\"setting\":\"hall\",\"row\":\"sf").unwrap();
        let mut state = State::open(&path, &header).unwrap();
        assert_eq!(state.rows(), rows);
        assert!(
            state.row("hall", "per-pixel-bilinear").is_some() && state.row("hall", "sfvt-gass").is_none()
        );
        assert_eq!(std::fs::read_to_string(&path).unwrap(), whole);
        state.append(rows[0].clone()).unwrap();
        assert_eq!(State::open(&path, &header).unwrap().rows().len(), 3);
    }

    #[test]
    fn a_changed_experiment_commit_or_program_invalidates() {
        let (_folder, path) = file();
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
            assert_eq!(changed.rows().len(), 0);
            assert_eq!(changed.set_aside().unwrap().lines, 1);
            let old = path.with_extension("jsonl.old");
            assert!(std::fs::read_to_string(&old).unwrap().contains("delaunay"));
            std::fs::remove_file(&old).unwrap();
        }
    }

    #[test]
    fn a_line_that_cannot_be_read_costs_no_other_row() {
        let ((_folder, path), header) = (file(), header(|_, _| {}));
        let mut state = State::open(&path, &header).unwrap();
        for refiner in ["nichols", "per-pixel"] {
            state.append(finished(refiner, "bilinear", 1.0, 0.1)).unwrap();
        }
        let whole = std::fs::read(&path).unwrap();
        let lines: Vec<&[u8]> = whole.split_inclusive(|&byte| byte == b'\n').collect();
        // Bytes that are no text, as a full disk leaves them.
        let broken = [lines[0], lines[1], b"{\"setting\": \xff\xfe\n", lines[2]].concat();
        std::fs::write(&path, &broken).unwrap();
        let state = State::open(&path, &header).unwrap();
        assert_eq!(state.rows().len(), 2);
        let aside = state.set_aside().unwrap();
        assert_eq!((aside.lines, std::fs::read(&aside.copy).unwrap()), (1, broken));
    }

    #[test]
    fn rows_that_another_version_wrote_are_kept_and_no_copy_is_written_over() {
        let ((_folder, path), header) = (file(), header(|_, _| {}));
        let files = ["{\"version\": 9}\n{\"a\": 1}\n{\"a\": 2}\n", "no header at all\n"];
        let copies = files.map(|content| {
            std::fs::write(&path, content).unwrap();
            let state = State::open(&path, &header).unwrap();
            let aside = state.set_aside().unwrap().clone();
            assert_eq!(std::fs::read_to_string(&aside.copy).unwrap(), content);
            aside
        });
        assert_eq!((copies[0].lines, copies[1].lines), (3, 1));
        assert_ne!(copies[0].copy, copies[1].copy);
    }
}
