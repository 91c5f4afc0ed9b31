//! What a run says while it works.

use indicatif::{ProgressBar, ProgressStyle};

use crate::program::say;

/// A progress bar that counts finished rows, and lines above it.
#[derive(Debug)]
pub struct Progress {
    bar: ProgressBar,
}

impl Progress {
    /// A bar on standard error, for so many rows, of which some are finished. Hidden where that is no terminal.
    pub fn new(rows: u64, finished: u64) -> Self {
        let bar = ProgressBar::new(rows).with_position(finished);
        let template = "{bar:30} {pos}/{len} rows, {elapsed} · {wide_msg}";
        bar.set_style(
            ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar()),
        );
        bar.enable_steady_tick(std::time::Duration::from_millis(250));
        Self { bar }
    }

    /// A run that says nothing.
    pub fn hidden() -> Self {
        Self { bar: ProgressBar::hidden() }
    }

    /// What is being done now.
    pub fn now(&self, what: impl Into<String>) {
        self.bar.set_message(what.into());
    }

    /// A line that stays.
    pub fn say(&self, line: &str) {
        self.bar.suspend(|| say(line));
    }

    /// So many more rows are finished.
    pub fn advance(&self, rows: u64) {
        self.bar.inc(rows);
    }

    /// The run is over.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}
