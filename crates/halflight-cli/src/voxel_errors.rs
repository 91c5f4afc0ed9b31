//! Failures of voxel marching: which frames can have a map of them, and their account.

use halflight_cpu::config::{Named, PipelineConfig, RefinerConfig, VisibilityConfig};
use halflight_cpu::voxel::VoxelConfig;
use halflight_cpu::voxel::error_map::VoxelErrorCounts;
use halflight_lab::reference::voxel_errors::{Failures, OFF};
use serde::Serialize;

/// Receivers that voxel marching gets wrong by more than the threshold, by cause, as they go into the statistics.
#[derive(Serialize)]
pub(crate) struct VoxelFailures {
    threshold: f32,
    receivers: u64,
    failures: u64,
    self_occlusion: u64,
    thickness: u64,
    out_of_view: u64,
    missed: u64,
}

impl VoxelFailures {
    pub(crate) fn new(failures: &Failures) -> Self {
        let VoxelErrorCounts { receivers, self_occlusion, thickness, out_of_view, missed } = failures.counts;
        let failures = failures.counts.failures();
        Self { threshold: OFF, receivers, failures, self_occlusion, thickness, out_of_view, missed }
    }

    /// Returns a line for people.
    pub(crate) fn line(&self) -> String {
        let Self { threshold, receivers, failures, self_occlusion, thickness, out_of_view, missed } = self;
        let share = 100.0 * *failures as f64 / (*receivers).max(1) as f64;
        format!(
            "  failures   {failures} of {receivers} receivers ({share:.2} %) off by more than {threshold}: {self_occlusion} \
             shade themselves (red), {thickness} behind thin geometry (yellow), {out_of_view} lit from out of view (blue), \
             {missed} missed by steps or bias (green)"
        )
    }
}

/// Returns the voxels' constants where a frame of this configuration can have a failure map.
///
/// # Errors
/// A message that says what to choose instead.
pub(crate) fn voxels(config: &PipelineConfig) -> Result<VoxelConfig, String> {
    let VisibilityConfig::Voxel(voxels) = config.visibility else {
        return Err(format!(
            "--voxel-error-map is about voxel marching, and {} does not fail: add --visibility voxel",
            config.visibility.name()
        ));
    };
    if config.refiner != RefinerConfig::PerPixel {
        return Err(format!(
            "--voxel-error-map needs a mask of every pixel, which {} has not: add --refiner per-pixel",
            config.refiner.name()
        ));
    }
    Ok(voxels)
}
