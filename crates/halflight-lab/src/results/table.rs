//! Small tables, the same in a CSV file and on the page.

use std::path::Path;

use halflight_metrics::write_file;

use crate::error::AblateError;

/// A table of text.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Table {
    /// Titles of the columns.
    pub columns: Vec<String>,
    /// The lines.
    pub lines: Vec<Line>,
}

/// A line of a table.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Line {
    /// Whether a paper says it, or we.
    pub from_paper: bool,
    /// One text a column; empty where there is no figure.
    pub cells: Vec<String>,
}

impl Table {
    /// A table of ours.
    pub fn new<const N: usize>(columns: [&str; N], lines: impl IntoIterator<Item = [String; N]>) -> Self {
        let line = |cells: [String; N]| Line { from_paper: false, cells: cells.to_vec() };
        Self { columns: columns.map(str::to_string).to_vec(), lines: lines.into_iter().map(line).collect() }
    }

    /// Writes it as CSV.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn write_csv(&self, path: &Path) -> Result<(), AblateError> {
        let mut writer = csv::Writer::from_writer(Vec::new());
        writer.write_record(&self.columns)?;
        for line in &self.lines {
            writer.write_record(&line.cells)?;
        }
        let bytes = writer.into_inner().map_err(|fault| csv::Error::from(fault.into_error()))?;
        write_file(path, &bytes)?;
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_hold_all_lines() {
        let mut table = Table::new(["name", "ms"], [["a < b", "1.5"].map(str::to_string)]);
        table.lines.push(Line { from_paper: true, cells: vec!["theirs, all".to_string(), String::new()] });
        let path = std::env::temp_dir().join(format!("halflight-table-{}.csv", std::process::id()));
        table.write_csv(&path).unwrap();
        let text = std::fs::read_to_string(&path).unwrap();
        std::fs::remove_file(&path).unwrap();
        assert_eq!(text, "name,ms\na < b,1.5\n\"theirs, all\",\n");
    }
}
