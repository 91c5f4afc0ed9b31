//! Soft shadows from area lights by multi-resolution screen-space fragments, with pluggable stages.
//!
//! The facade that downstream code depends on: everything else is re-exported from here.

pub use halflight_core::glam;
pub use halflight_core::{
    camera, certificate, fragment, frame, gbuffer, hash, light, mask, pattern, pyramid, scene, stages, stats,
    values,
};
pub use halflight_cpu as cpu;
pub use halflight_cpu::{
    beam, bvh, config, flush, irradiance, pipeline, prepared, raster4d, refine, unshadowed, upsample, voxel,
};
#[cfg(feature = "gpu")]
pub use halflight_gpu as gpu;
#[cfg(feature = "image")]
pub use halflight_image as image;
pub use halflight_metrics as metrics;
pub use halflight_scene as scene_file;
