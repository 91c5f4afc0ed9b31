//! Small tables of text, and CSV files.

use std::path::Path;

use anyhow::{Context as _, Result};
use halflight_metrics::write_file;

/// Table of text.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Table {
    /// Titles of the columns.
    pub columns: Vec<String>,
    /// Lines from the top.
    pub lines: Vec<Line>,
}

/// Line of a table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Line {
    /// Set for figures of a paper.
    pub from_paper: bool,
    /// Texts, one a column; empty where there is no figure.
    pub cells: Vec<String>,
}

impl Table {
    /// Returns a table of figures of ours.
    pub fn new<const N: usize>(columns: [&str; N], lines: impl IntoIterator<Item = [String; N]>) -> Self {
        let line = |cells: [String; N]| Line { from_paper: false, cells: cells.to_vec() };
        Self { columns: columns.map(str::to_string).to_vec(), lines: lines.into_iter().map(line).collect() }
    }

    /// Writes the table as CSV.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write_csv(&self, path: &Path) -> Result<()> {
        write(path, false, |writer| {
            writer.write_record(&self.columns)?;
            self.lines.iter().try_for_each(|line| writer.write_record(&line.cells))
        })
    }
}

/// Writes a CSV file of what `fill` adds to it. Records that are serialised get a header where `headers` is set.
///
/// # Errors
/// The file cannot be written, or a record has no place in a table.
pub fn write(
    path: &Path,
    headers: bool,
    fill: impl FnOnce(&mut csv::Writer<Vec<u8>>) -> csv::Result<()>,
) -> Result<()> {
    let mut writer = csv::WriterBuilder::new().has_headers(headers).from_writer(Vec::new());
    fill(&mut writer).context("results cannot be written as CSV")?;
    write_file(path, &writer.into_inner()?)?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_hold_all_lines() {
        let mut table = Table::new(["name", "ms"], [["a < b", "1.5"].map(str::to_string)]);
        table.lines.push(Line { from_paper: true, cells: vec!["theirs, all".to_string(), String::new()] });
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("table.csv");
        table.write_csv(&path).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        assert_eq!(text, "name,ms\na < b,1.5\n\"theirs, all\",\n");
    }
}
