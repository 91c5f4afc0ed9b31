//! The stages of Halflight on the CPU: the definition of correct.

pub mod bvh;
pub mod upsample;
