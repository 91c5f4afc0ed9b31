//! What is rendered on both sides.

use halflight::config::{PipelineConfig, RefinerConfig};
use halflight::irradiance::Shading;
use halflight::pipeline::Pipeline;
use halflight_gpu::{Inputs, Renderer, Surfaces};
use halflight_tests::Stage;

use crate::device::Bench;

/// Scenes of different kinds: things on a floor, a hall, foliage.
pub(crate) const SCENES: [&str; 3] = ["toys", "atrium", "tree"];

/// Every pixel its own samples.
pub(crate) fn full(width: u32, height: u32, shading: Shading) -> PipelineConfig {
    PipelineConfig { width, height, refiner: RefinerConfig::Full, shading, ..PipelineConfig::default() }
}

/// The same frame on both sides.
pub(crate) struct Twins {
    pub(crate) stage: Stage,
    pub(crate) cpu: Pipeline,
    pub(crate) gpu: Renderer,
}

impl Twins {
    /// Renders frame 0; with `kept` the GPU has the CPU's G-buffer.
    pub(crate) fn render(bench: &Bench, scene: &str, config: &PipelineConfig, kept: bool) -> Self {
        Self::of(bench, Stage::bundled(scene).unwrap(), config, kept)
    }

    /// The same for any scene.
    pub(crate) fn of(bench: &Bench, stage: Stage, config: &PipelineConfig, kept: bool) -> Self {
        let mut cpu = config.builder(stage.scene.clone(), stage.bvh.clone()).build().unwrap();
        cpu.render().unwrap();
        let mut gpu = Renderer::new(&bench.gpu.device, &bench.gpu.queue, &stage.scene, config).unwrap();
        let surfaces = if kept {
            bench.keep(&gpu, cpu.gbuffer());
            Surfaces::Kept
        } else {
            Surfaces::Scene
        };
        bench.render(&mut gpu, &Inputs { surfaces, ..Inputs::default() });
        Self { stage, cpu, gpu }
    }
}
