//! Comparisons of rows: equal error, equal time, Pareto fronts, scaling, flicker, a paper's figures, summaries in words.

pub mod equal_error;
pub mod equal_time;
pub mod families;
pub mod findings;
pub mod flicker;
pub mod format;
mod measure;
pub mod paper;
pub mod pareto;
pub mod path;
pub mod scaling;
pub mod summary;
pub mod sweep;

pub use measure::Measure;
