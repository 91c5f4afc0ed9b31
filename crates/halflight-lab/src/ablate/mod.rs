//! Experiments: what is varied is data, what comes out is a table, charts and a report.
//!
//! An [`Experiment`] is a TOML file. [`plan`](plan::plan) expands it into settings (a scene under a light) and
//! rows (a pipeline in a setting), [`run`](run::run) renders, times and measures them, [`output`] writes
//! `results.csv`, the charts and `report.html`.

pub mod bars;
pub mod bundled;
pub mod chart;
pub mod constants;
pub mod device;
mod draw;
mod drawing;
pub mod equal_error;
pub mod equal_time;
pub mod error;
pub mod expected;
pub mod experiment;
pub mod flicker;
mod loaded;
pub mod output;
pub mod paper;
pub mod pareto;
pub mod plan;
pub mod progress;
pub mod provenance;
pub mod record;
pub mod report;
pub mod run;
pub mod scaling;
pub mod state;
pub mod summary;
pub mod sweep;
pub mod table;
mod timing;

pub use error::AblateError;
pub use experiment::Experiment;
pub use record::{Finished, Record};
