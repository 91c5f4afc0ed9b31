//! Research toolkit: references and experiments.

pub mod ablate;
mod culled;
pub mod exactness;
pub mod furnished;
pub mod program;
pub mod reference;
pub mod robustness;
pub mod unlit;
pub mod voxel_errors;
