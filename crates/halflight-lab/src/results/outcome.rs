//! Outcome of a run.

use super::provenance::Provenance;
use super::record::Finished;
use crate::experiment::plan::Setting;

/// All rows of an experiment, as far as they are finished.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Settings of the experiment.
    pub settings: Vec<Setting>,
    /// Finished rows in the order of the plan, setting by setting.
    pub rows: Vec<Finished>,
    /// Program and machine that made all rows.
    pub provenance: Provenance,
}

impl Outcome {
    /// Returns the rows of a setting.
    pub fn rows_of(&self, setting: &Setting) -> Vec<&Finished> {
        self.rows.iter().filter(|row| row.setting == setting.slug).collect()
    }
}
