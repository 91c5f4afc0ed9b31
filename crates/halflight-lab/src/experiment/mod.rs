//! Experiments as data: a TOML file says what is varied and is expanded into settings and rows.
//!
//! A *setting* is a scene under a light at an image size; it has a reference of its own. A *row* is a pipeline, which is
//! rendered in every setting.

pub mod bundled;
mod check;
mod constants;
mod file;
mod paper;
pub mod plan;
mod schema;

pub(crate) use constants::refiner_name;
pub use constants::{parameter, quality};
pub use paper::{Paper, PaperRow};
pub use schema::{AnimationFrames, Axis, Experiment, Grid, ReferenceChoice, Scaling, SceneChoice};
