//! All rows of an experiment.

use super::provenance::Provenance;
use super::record::Finished;
use crate::experiment::plan::Setting;

/// All rows of an experiment.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// The settings.
    pub settings: Vec<Setting>,
    /// Rows in the order of the plan, setting by setting.
    pub rows: Vec<Finished>,
    /// Who made them. All rows have the same.
    pub provenance: Provenance,
}
