//! The GPU against the CPU, which defines what is correct.
//!
//! Without a graphics adapter each test says that it was skipped; with `HALFLIGHT_REQUIRE_GPU=1` that is a failure. An error
//! that wgpu reports fails the test that caused it.

#![allow(clippy::unwrap_used, clippy::panic)]

mod constants;
mod controls;
mod device;
mod exact;
mod faults;
mod gbuffers;
mod limits;
mod masks;
mod moving;
mod outside;
mod rays;
mod refiners;
mod robust;
mod scenes;
mod targets;
mod upsamplers;
mod voxels;
mod whole;
