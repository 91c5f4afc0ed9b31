//! Renders the only frame of a scene and writes what is asked for.

use halflight_cpu::pipeline::Pipeline;
#[cfg(feature = "gpu")]
use halflight_gpu::{Gpu, Inputs, Renderer};
use halflight_lab::program::say;

use crate::Outcome;
use crate::output::{Frame, Output};
use crate::paths;
use crate::scene::Ready;
use crate::statistics::summary;

/// Renders on the CPU.
pub(crate) fn on_cpu(output: &Output, ready: &Ready, pipeline: &mut Pipeline) -> Outcome {
    pipeline.render()?;
    finish(output, ready, output.name, &Frame::of(pipeline))
}

/// Renders on the fastest GPU.
///
/// # Errors
/// No GPU is found, or the configuration has stages that it has not got.
#[cfg(feature = "gpu")]
pub(crate) fn on_gpu(output: &Output, ready: &Ready) -> Outcome {
    let gpu = Gpu::find()?;
    let mut renderer = Renderer::new(&gpu.device, &gpu.queue, ready.prepared.scene(), &output.config)?;
    let (mut image, gbuffer, stats) =
        gpu.render_antialiased(&mut renderer, &Inputs::default(), output.config.antialias)?;
    if stats.lost > 0 {
        return Err(format!("{} queries did not fit into the device's buffers", stats.lost).into());
    }
    image.stats = stats.frame;
    let name = format!("{} on {}", output.name, gpu.adapter.get_info().name);
    finish(output, ready, &name, &Frame { image: &image, gbuffer: &gbuffer, fragments: None })
}

/// Says what was rendered, writes it, and says where to.
fn finish(output: &Output, ready: &Ready, name: &str, frame: &Frame) -> Outcome {
    say(&summary(name, &output.config, &frame.image.stats, output.build_ms));
    paths::say_written(&output.write(frame, &ready.prepared, None)?);
    Ok(())
}
