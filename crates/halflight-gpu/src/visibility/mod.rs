//! Visibility backends: a file each, with its passes, the buffers that it declares, and the order of the passes.

mod backend;
mod beam;
mod raster4d;
mod voxel;

use halflight_cpu::config::{Named as _, PipelineConfig, VisibilityConfig};

use crate::error::GpuError;
use crate::masked::Parted;
use crate::pass::Compiler;
pub(crate) use backend::Backend;

#[cfg(test)]
pub(crate) use voxel::Space;

/// Programs of all backends.
#[cfg(test)]
pub(crate) const PROGRAMS: &[&[crate::program::Program]] =
    &[backend::PROGRAMS, beam::PROGRAMS, raster4d::PROGRAMS, voxel::PROGRAMS];

/// Compiles the backend of a configuration for the triangles of a scene. Those with alpha masks are not a backend's: what they hide is
/// taken out afterwards.
///
/// # Errors
/// The backend's constants or the light samples are out of range, or a shader cannot be read or compiled.
pub(crate) fn backend(
    compiler: &Compiler,
    parted: &Parted,
    config: &PipelineConfig,
) -> Result<Box<dyn Backend>, GpuError> {
    Ok(match config.visibility {
        // Exact backends agree, so that the choice between them is free.
        VisibilityConfig::Bvh | VisibilityConfig::Auto => Box::new(backend::Rays::new(compiler)?),
        VisibilityConfig::Beam => Box::new(beam::Beam::new(compiler)?),
        VisibilityConfig::Raster4d(own) => {
            Box::new(raster4d::Raster4d::new(compiler, parted.opaque.len(), own, config.sampling)?)
        }
        VisibilityConfig::Voxel(own) => Box::new(voxel::Voxel::new(compiler, parted, own)?),
        _ => {
            let stage = config.visibility.name();
            return Err(GpuError::Unsupported {
                stage,
                reason: "this backend exists on the CPU only; use `auto`",
            });
        }
    })
}
