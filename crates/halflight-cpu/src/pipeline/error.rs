//! Reasons why frames are not rendered.

use halflight_core::camera::CameraError;
use halflight_core::fragment::FragmentError;
use halflight_core::gbuffer::GBufferError;
use halflight_core::light::LightError;
use halflight_core::pattern::PatternError;
use halflight_core::scene::MeshError;
use halflight_core::stages::{Unsupported, UnsupportedLight};
use halflight_core::subpixel::SubSampleError;

use super::MAX_SIZE;
use crate::bvh::BvhError;
use crate::raster4d::Raster4dError;
use crate::voxel::VoxelError;

/// Why a pipeline cannot be built or a frame not be rendered.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum PipelineError {
    /// The image has no pixels or is too large.
    #[error("an image of {width}x{height} pixels cannot be rendered: both sides must be 1 to {MAX_SIZE}")]
    Size {
        /// Width asked for.
        width: u32,
        /// Height asked for.
        height: u32,
    },
    /// The scene has no light.
    #[error("the scene has no light")]
    NoLight,
    /// A light cannot be used.
    #[error(transparent)]
    Light(#[from] LightError),
    /// The mesh is inconsistent.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// The BVH is not one of the scene.
    #[error(transparent)]
    Bvh(#[from] BvhError),
    /// The camera looks nowhere.
    #[error(transparent)]
    Camera(#[from] CameraError),
    /// The number of light samples is out of range.
    #[error(transparent)]
    Pattern(#[from] PatternError),
    /// The stages do not fit together.
    #[error(transparent)]
    Unsupported(#[from] Unsupported),
    /// The visibility backend cannot answer for a light.
    #[error("light {index}: {source}")]
    UnsupportedLight {
        /// Index of the light in the scene.
        index: usize,
        /// The backend's refusal.
        source: UnsupportedLight,
    },
    /// 4D rasterization cannot be set up.
    #[error(transparent)]
    Raster4d(#[from] Raster4dError),
    /// Voxels cannot be set up.
    #[error(transparent)]
    Voxel(#[from] VoxelError),
    /// The refiner's fragments refer to what does not exist.
    #[error(transparent)]
    Fragments(#[from] FragmentError),
    /// The caller's G-buffer cannot be used.
    #[error(transparent)]
    GBuffer(#[from] GBufferError),
    /// Pixels cannot have so many sub-samples.
    #[error(transparent)]
    SubSamples(#[from] SubSampleError),
    /// A caller's G-buffer has no sub-samples.
    #[error(
        "a G-buffer of your own cannot be antialiased, since it has one surface a pixel: build the pipeline with antialias(1), or \
         render a larger image and average its pixels"
    )]
    GivenSubSamples,
    /// Points of indirect light lie where an approximate backend knows nothing.
    #[error(
        "indirect light takes an exact visibility backend, and {0} is approximate: choose bvh, beam, auto or raster4d"
    )]
    InexactIndirect(&'static str),
    /// Worker threads could not be started.
    #[error("worker threads could not be started: {0}")]
    Threads(#[from] rayon::ThreadPoolBuildError),
}
