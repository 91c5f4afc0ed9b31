//! The research toolkit: image files, pictures, references and experiments.

pub mod ablate;
mod culled;
pub mod exactness;
pub mod exr_file;
pub mod furnished;
pub mod memory;
pub mod picture;
pub mod program;
pub mod reference;
pub mod robustness;
pub mod unlit;
pub mod voxel_errors;

/// Name and version, as stored in files.
pub const PROGRAM: &str = concat!("halflight ", env!("CARGO_PKG_VERSION"));

/// The commit that the program was built from, where that is known.
pub const COMMIT: Option<&str> = option_env!("HALFLIGHT_COMMIT");
