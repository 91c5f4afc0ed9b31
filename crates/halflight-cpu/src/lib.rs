//! The stages of Halflight on the CPU: the reference implementation.

pub mod beam;
pub mod brute_force;
pub mod bvh;
mod compose;
pub mod config;
mod corners;
pub mod flush;
pub mod gbuffer;
pub mod horizon;
pub mod irradiance;
mod multiversion;
mod occluder;
pub mod pipeline;
mod pool;
pub mod prepared;
pub mod pyramid;
pub mod raster4d;
pub mod refine;
pub mod requests;
mod samples;
mod shaft;
pub mod simd;
mod tangent_plane;
pub mod unshadowed;
pub mod upsample;
pub mod voxel;
