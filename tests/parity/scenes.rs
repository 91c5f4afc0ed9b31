//! Frames rendered on both sides.

use std::collections::BTreeMap;
use std::sync::Mutex;

use halflight::config::{PipelineConfig, RefinerConfig, UpsamplerConfig};
use halflight::frame::{Frame, Sharing};
use halflight::irradiance::{self, Shading};
use halflight::pattern::{Pattern, PatternKind};
use halflight::pipeline::Pipeline;
use halflight::pyramid::Pyramid;
use halflight::values::Values;
use halflight_gpu::{Gpu, Inputs, Renderer, Surfaces, shader_module};
use halflight_tests::Stage;

use crate::device::Bench;

/// Scenes of different kinds: objects on a floor, a hall, foliage.
pub(crate) const SCENES: [&str; 3] = ["toys", "atrium", "tree"];

/// Bundled scene, or `few toys`, built once for all tests.
pub(crate) fn bundled(name: &'static str) -> Stage {
    static MADE: Mutex<BTreeMap<&str, Stage>> = Mutex::new(BTreeMap::new());
    let make = || match name {
        "few toys" => {
            let loaded = halflight::scene_file::parse(FEW_TOYS, name, "".as_ref()).unwrap();
            Stage::new(loaded.scene).unwrap()
        }
        _ => Stage::bundled(name).unwrap(),
    };
    MADE.lock().unwrap().entry(name).or_insert_with(make).clone()
}

/// Scene `few toys`: that of `toys` with 20,000 triangles instead of 263,000. 4D rasterization, which looks at all triangles in a receiver's
/// cell, takes a ninth of the time with them on a software driver, and renderers are made in less than half of it.
const FEW_TOYS: &str = "
[camera]
eye = [-0.7, 1.9, 3.9]
target = [-0.05, 0.0, 0.75]
fov_y_deg = 42.0

[[light]]
corner = [-3.0, 2.6, -0.6]
edge_u = [1.2, 0, 0]
edge_v = [0, 0, 1.2]
radiance = [30, 29, 27]

[[mesh]]
generator = \"toys\"
triangles = 20000
";

/// Per-pixel configuration.
pub(crate) fn per_pixel(width: u32, height: u32, shading: Shading) -> PipelineConfig {
    PipelineConfig {
        width,
        height,
        refiner: RefinerConfig::PerPixel,
        upsampler: UpsamplerConfig::RbfRobust(Default::default()),
        shading,
        ..PipelineConfig::default()
    }
}

/// Sample values of the CPU's last frame.
pub(crate) fn values(twins: &Twins, shading: Shading) -> Values {
    let gbuffer = twins.cpu.gbuffer();
    let frame = Frame {
        scene: &twins.stage.scene,
        gbuffer,
        pyramid: &Pyramid::default(),
        // Pattern and key are irrelevant once masks exist: queries have their own.
        pattern: Pattern { kind: PatternKind::Grid, columns: 1, rows: 1 },
        sharing: Sharing::Frame,
        index: 0,
        seed: 0,
    };
    let mut values = Values::default();
    irradiance::evaluate(
        &frame,
        twins.cpu.fragments(),
        shading,
        &halflight::stages::RefineOutput::default(),
        &mut values,
    );
    values
}

/// Frame rendered on both sides.
pub(crate) struct Twins {
    pub(crate) stage: Stage,
    pub(crate) cpu: Pipeline,
    pub(crate) gpu: Renderer,
    /// True if the GPU uses the CPU's G-buffer.
    kept: bool,
}

impl Twins {
    /// Renders frame 0; with `kept` the GPU uses the CPU's G-buffer.
    pub(crate) fn render(bench: &Bench, scene: &'static str, config: &PipelineConfig, kept: bool) -> Self {
        Self::of(bench, bundled(scene), config, kept)
    }

    /// Renders frame 0 of any scene.
    pub(crate) fn of(bench: &Bench, stage: Stage, config: &PipelineConfig, kept: bool) -> Self {
        let mut cpu = config.builder(&stage.prepared).build().unwrap();
        cpu.render().unwrap();
        let gpu = bench.renderer(&stage.scene, config).unwrap();
        let mut twins = Self { stage, cpu, gpu, kept };
        twins.render_gpu(bench);
        twins
    }

    /// Renders on the GPU again, with a part of a shader module replaced.
    pub(crate) fn alter(
        &mut self,
        bench: &Bench,
        config: &PipelineConfig,
        [module, right, wrong]: [&str; 3],
    ) {
        let text = shader_module(module).unwrap();
        assert!(text.contains(right), "{module}: {right}");
        let modules = [(module, &*text.replace(right, wrong))];
        let Gpu { device, queue, .. } = &bench.gpu;
        self.gpu = Renderer::with_modules(device, queue, &self.stage.scene, config, &modules).unwrap();
        self.render_gpu(bench);
    }

    /// Renders frame 0 on the GPU.
    pub(crate) fn render_gpu(&mut self, bench: &Bench) {
        let surfaces = if self.kept {
            bench.keep(&self.gpu, self.cpu.gbuffer());
            Surfaces::Kept
        } else {
            Surfaces::Scene
        };
        bench.render(&mut self.gpu, &Inputs { surfaces, ..Inputs::default() });
    }
}
