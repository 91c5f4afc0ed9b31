//! Progress of a run.

use indicatif::{ProgressBar, ProgressStyle};

use crate::program::say;

/// Progress bar that counts finished rows, and lines above it.
#[derive(Debug)]
pub struct Progress {
    bar: ProgressBar,
}

impl Progress {
    /// Returns a bar on standard error for `rows` rows, of which some are finished. It is hidden where that is no terminal.
    pub fn new(rows: u64, finished: u64) -> Self {
        let bar = ProgressBar::new(rows).with_position(finished);
        let template = "{bar:30} {pos}/{len} rows, {elapsed} · {wide_msg}";
        bar.set_style(
            ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar()),
        );
        bar.enable_steady_tick(std::time::Duration::from_millis(250));
        Self { bar }
    }

    /// Returns a bar that is never shown.
    pub fn hidden() -> Self {
        Self { bar: ProgressBar::hidden() }
    }

    /// Shows what is being done now.
    pub fn now(&self, what: impl Into<String>) {
        self.bar.set_message(what.into());
    }

    /// Prints a line that stays.
    pub fn say(&self, line: &str) {
        self.bar.suspend(|| say(line));
    }

    /// Counts more finished rows.
    pub fn advance(&self, rows: u64) {
        self.bar.inc(rows);
    }

    /// Removes the bar at the end of the run.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}
