//! Parity of the GPU with the CPU, the reference implementation.
//!
//! Without a graphics adapter each test reports that it was skipped; with `HALFLIGHT_REQUIRE_GPU=1` that is a
//! failure. An error that wgpu reports fails the test that caused it.

#![allow(clippy::unwrap_used, clippy::panic)]

mod alpha;
mod antialias;
mod constants;
mod controls;
mod device;
mod emission;
mod exact;
mod faults;
mod gbuffers;
mod lights;
mod limits;
mod masks;
mod moving;
mod outside;
mod present;
mod rays;
mod refiners;
mod robust;
mod scenes;
mod specular;
mod targets;
mod textured;
mod upsamplers;
mod voxels;
mod whole;
