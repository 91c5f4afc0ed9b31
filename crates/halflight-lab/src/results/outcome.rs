//! Outcome of a run.

use itertools::Itertools as _;

use super::indirect::IndirectRow;
use super::provenance::Provenance;
use super::record::Finished;
use super::specular::SpecularRow;
use crate::experiment::plan::Setting;

/// All rows of an experiment, as far as they are finished.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Settings of the experiment.
    pub settings: Vec<Setting>,
    /// Finished rows in the order of the plan, setting by setting.
    pub rows: Vec<Finished>,
    /// Rows of specular passes, known when all others are.
    pub specular: Vec<SpecularRow>,
    /// Rows of indirect light, known when all others are.
    pub indirect: Vec<IndirectRow>,
    /// Program and machine that made all rows.
    pub provenance: Provenance,
}

impl Outcome {
    /// Returns short names of the settings: those of their scenes without parameters where that tells them apart.
    pub fn names(&self) -> Vec<&str> {
        let labels = || self.settings.iter().map(|setting| setting.label.as_str());
        let scenes = || labels().map(|label| label.split(' ').next().unwrap_or(label));
        if scenes().all_unique() { scenes().collect() } else { labels().collect() }
    }

    /// Returns the rows of a setting.
    pub fn rows_of(&self, setting: &Setting) -> Vec<&Finished> {
        self.rows.iter().filter(|row| row.setting == setting.slug).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiment::{Experiment, plan};

    #[test]
    fn names_are_short_where_that_is_clear() {
        let names = |experiment: &str| {
            let settings = plan::settings(&Experiment::resolve(experiment).unwrap());
            let (rows, specular, indirect) = (Vec::new(), Vec::new(), Vec::new());
            let outcome = Outcome { settings, rows, specular, indirect, provenance: Provenance::default() };
            outcome.names().into_iter().map(str::to_string).collect_vec()
        };
        assert_eq!(names("default"), ["atrium", "nave", "hairball"]);
        assert_eq!(names("koa-fig16"), ["nave light ×1", "nave light ×1.75"]);
    }
}
