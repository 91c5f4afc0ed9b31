//! `halflight render --device gpu`.

use halflight_core::scene::Scene;
use halflight_cpu::config::PipelineConfig;
use halflight_gpu::{Gpu, Inputs, Renderer};

use crate::render::Rendered;

/// Renders a scene on the fastest GPU.
///
/// # Errors
/// There is none, or the configuration has stages that it has not got.
pub(crate) fn render(scene: &Scene, config: &PipelineConfig) -> Result<Rendered, Box<dyn std::error::Error>> {
    let gpu = Gpu::find()?;
    let mut renderer = Renderer::new(&gpu.device, &gpu.queue, scene, config)?;
    let stats = gpu.render(&mut renderer, &Inputs::default())?;
    if stats.lost > 0 {
        return Err(format!("{} queries did not fit into the device's buffers", stats.lost).into());
    }
    let (mut image, gbuffer) = gpu.download(&renderer)?;
    image.stats = stats.frame;
    Ok(Rendered { image, gbuffer, device: gpu.adapter.get_info().name })
}
