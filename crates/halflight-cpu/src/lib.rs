//! The stages of Halflight on the CPU: the definition of correct.

pub mod bvh;
mod compose;
pub mod config;
mod dispatch;
pub mod gbuffer;
pub mod horizon;
pub mod irradiance;
pub mod pipeline;
pub mod pyramid;
pub mod refine;
mod samples;
pub mod simd;
pub mod unshadowed;
pub mod upsample;
