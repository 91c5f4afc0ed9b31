//! The stages of Halflight on the CPU: the definition of correct.

pub mod bvh;
mod dispatch;
pub mod horizon;
pub mod irradiance;
pub mod pyramid;
mod samples;
pub mod unshadowed;
pub mod upsample;
