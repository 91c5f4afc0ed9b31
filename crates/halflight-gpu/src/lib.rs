//! The stages of Halflight as wgpu compute passes on the caller's device, equal to their twins on the CPU.
//!
//! The caller brings a [`wgpu::Device`] and its queue (or takes [`Gpu::find`]'s), and a command encoder; [`Renderer::record`]
//! adds a frame to it and neither submits, maps nor waits:
//!
//! ```no_run
//! use halflight_gpu::{Gpu, Inputs, Renderer};
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let (scene, config) = (halflight_core::scene::Scene::default(), halflight_cpu::config::PipelineConfig::default());
//! let gpu = Gpu::find()?;
//! let mut renderer = Renderer::new(&gpu.device, &gpu.queue, &scene, &config)?;
//! let mut encoder = gpu.device.create_command_encoder(&Default::default());
//! renderer.record(&mut encoder, &Inputs::default())?;
//! gpu.queue.submit([encoder.finish()]);
//! let irradiance: Vec<[f32; 4]> = gpu.read(renderer.image())?;
//! # Ok(())
//! # }
//! ```

mod antialias;
mod bindings;
mod buffers;
mod compose;
mod crowds;
mod download;
mod emission;
mod error;
mod frame;
mod gbuffer;
mod gpu;
mod hierarchy;
mod inputs;
mod light;
mod masked;
mod memory;
mod needs;
mod pass;
mod present;
mod program;
mod recorder;
mod refine;
mod renderer;
mod scene;
mod shader;
mod specular;
mod stages;
mod stats;
#[cfg(test)]
mod tests;
mod textured;
mod upsample;
mod visibility;

pub use wgpu;

pub use error::GpuError;
pub use gbuffer::Surfaces;
pub use gpu::{Gpu, optional_features, required_features, required_limits};
pub use inputs::{Inputs, Inside};
pub use renderer::Renderer;
pub use shader::shader_module;
pub use stats::{GpuStats, PendingStats};
