//! The one place that states the order of the stages on the GPU.

use halflight_core::pattern::Pattern;
use halflight_core::scene::{Camera, Scene};
use halflight_core::{frame::LightSampling, light::AreaLight};
use halflight_cpu::config::{PipelineConfig, RefinerConfig, UpsamplerConfig, VisibilityConfig};
use halflight_cpu::gbuffer::View;
use halflight_cpu::irradiance::Shading;
use halflight_cpu::pipeline::{MAX_SIZE, PipelineError, check_scene};

use crate::GpuError;
use crate::buffers::{Buffers, Size};
use crate::frame::{Frame, Key};
use crate::gbuffer::Rasterizer;
use crate::programs;
use crate::scene::SceneBuffers;
use crate::stage::{Groups, Stage};
use crate::stats::{Clock, PendingStats, Timed};

/// What changes from frame to frame.
#[derive(Clone, Copy, Debug, Default)]
pub struct Inputs {
    /// Where the scene is seen from; the scene's own camera by default.
    pub camera: Option<Camera>,
    /// Number of the frame: frames differ in their light samples.
    pub frame: u32,
    /// Where the G-buffer comes from.
    pub surfaces: Surfaces,
}

/// Where the G-buffer comes from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Surfaces {
    /// The scene is rasterized.
    #[default]
    Scene,
    /// It is in [`Renderer::position`] and [`Renderer::normal`] already.
    Kept,
}

/// What stages hand on; all numbers have 32 bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Inside {
    /// Queries: pixel, key, samples asked for, place among the samples.
    Queries,
    /// Masks of the samples that were traced, 32 to a word, each query's after the last one's.
    Wanted,
    /// Masks of the samples that were seen, likewise.
    Visible,
    /// Samples: place in pixels (two floats), value (a float, below 0 for none), pixel. One a cell, level by level.
    Samples,
    /// One float a pixel: irradiance per radiance, or the visible fraction.
    Plane,
}

/// Renders one scene on one device, frame after frame, in buffers that are kept.
#[derive(Debug)]
pub struct Renderer {
    device: wgpu::Device,
    scene: SceneBuffers,
    lights: Vec<AreaLight>,
    camera: Camera,
    sampling: LightSampling,
    pattern: Pattern,
    seed: u32,
    stages: Stages,
    buffers: Buffers,
    clock: Option<Clock>,
}

/// All stages of a configuration.
#[derive(Debug)]
struct Stages {
    rasterize: Rasterizer,
    resolve: Stage,
    refine: Stage,
    dispatch: Stage,
    masks: Stage,
    irradiance: Stage,
    upsample: Stage,
    compose: Stage,
}

impl Renderer {
    /// Uploads a scene, compiles what a configuration takes and makes its buffers.
    ///
    /// # Errors
    /// The scene or the configuration cannot be rendered, on this device or at all.
    pub fn new(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        scene: &Scene,
        config: &PipelineConfig,
    ) -> Result<Self, GpuError> {
        let visibility = match config.visibility {
            VisibilityConfig::Bvh => None,
            _ => {
                let (stage, reason) = ("this visibility backend", "only `bvh` does so far");
                return Err(GpuError::Unsupported { stage, reason });
            }
        };
        Self::build(device, queue, scene, config, visibility)
    }

    /// The same with a backend from outside: `module` is WGSL with a function
    /// `fn occluded(origin: vec3<f32>, end: vec3<f32>) -> bool`, which says whether the open segment between two points meets
    /// anything. It may use the scene's `nodes` and `triangles`; [`visibility_module`](crate::visibility_module)
    /// shows how.
    ///
    /// # Errors
    /// As [`Renderer::new`]; and where the module does not compile, with the compiler's message.
    pub fn with_visibility(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        scene: &Scene,
        config: &PipelineConfig,
        module: &str,
    ) -> Result<Self, GpuError> {
        Self::build(device, queue, scene, config, Some(module))
    }

    fn build(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        scene: &Scene,
        config: &PipelineConfig,
        visibility: Option<&str>,
    ) -> Result<Self, GpuError> {
        check_scene(scene)?;
        let pattern = config.sampling.pattern().map_err(PipelineError::from)?;
        let stages = Stages::new(device, config, visibility)?;
        let buffers = SceneBuffers::new(device, scene)?;
        let size = size(config.width, config.height, scene.lights.len())?;
        let mut renderer = Self {
            device: device.clone(),
            buffers: Buffers::new(device, &buffers, size, pattern)?,
            scene: buffers,
            lights: scene.lights.clone(),
            camera: scene.camera,
            sampling: config.sampling,
            pattern,
            seed: config.seed,
            stages,
            clock: Clock::new(device, queue),
        };
        renderer.bind();
        Ok(renderer)
    }

    /// Changes the size of the image; nothing is done where it is the same.
    ///
    /// # Errors
    /// The image has no pixels or is too large; the renderer is then as it was.
    pub fn resize(&mut self, width: u32, height: u32) -> Result<(), GpuError> {
        let size = size(width, height, self.lights.len())?;
        if size != self.buffers.size {
            self.buffers = Buffers::new(&self.device, &self.scene, size, self.pattern)?;
            self.bind();
        }
        Ok(())
    }

    /// Irradiance per channel, W/m², as four floats a pixel, row by row from the top left; zero where nothing is seen. The
    /// fourth is 1. It is valid until the image is resized.
    pub fn image(&self) -> &wgpu::Buffer {
        &self.buffers.image
    }

    /// Points, world space, with the distance along the view direction as fourth component; below 0 where nothing is seen.
    pub fn position(&self) -> &wgpu::Buffer {
        &self.buffers.position
    }

    /// Unit normals towards the viewer, as the bits of their components, and the triangle's number in the mesh; `u32::MAX`
    /// where nothing is seen. Where triangles are not known, pixels need numbers of their own.
    pub fn normal(&self) -> &wgpu::Buffer {
        &self.buffers.normal
    }

    /// A buffer that later stages read, as the last light of the last frame left it: for tests and debuggers.
    pub fn inside(&self, what: Inside) -> &wgpu::Buffer {
        match what {
            Inside::Queries => &self.buffers.queries,
            Inside::Wanted => &self.buffers.wanted,
            Inside::Visible => &self.buffers.visible,
            Inside::Samples => &self.buffers.samples,
            Inside::Plane => &self.buffers.plane,
        }
    }

    /// Records a frame. It neither submits, maps nor waits.
    ///
    /// # Errors
    /// None so far.
    pub fn record(&mut self, encoder: &mut wgpu::CommandEncoder, inputs: &Inputs) -> Result<(), GpuError> {
        let Self { stages, buffers, clock, .. } = self;
        if let Some(clock) = clock {
            clock.start();
        }
        let Size { width, height, .. } = buffers.size;
        let view = View::new(inputs.camera.as_ref().unwrap_or(&self.camera), width, height);
        let general = Frame::new(&view, (width, height), self.scene.size, self.pattern);
        let key = Key { seed: self.seed, frame: inputs.frame, sharing: self.sampling.sharing };
        let general = Frame { capacity: buffers.size.queries, ..general };
        let frames: Vec<Frame> =
            (0..).zip(&self.lights).map(|(number, light)| general.with_light(number, light, key)).collect();
        write_frames(&self.device, encoder, buffers, &frames);
        encoder.clear_buffer(&buffers.counters, 0, None);

        let tiles = Groups::Count(width.div_ceil(8), height.div_ceil(8));
        if inputs.surfaces == Surfaces::Scene {
            stages.rasterize.run(encoder, buffers, self.scene.vertices, clock.as_mut());
            stages.resolve.pass(encoder, clock.as_mut(), Timed::Gbuffer, buffers, 0, tiles);
        }
        for light in 0..frames.len() as u32 {
            encoder.clear_buffer(&buffers.counters, 0, Some(4));
            stages.refine.pass(encoder, clock.as_mut(), Timed::Refine, buffers, light, tiles);
            stages.dispatch.pass(encoder, clock.as_mut(), Timed::Refine, buffers, light, Groups::Count(1, 1));
            let (rays, queries) = (Groups::Indirect(0), Groups::Indirect(1));
            stages.masks.pass(encoder, clock.as_mut(), Timed::Visibility, buffers, light, rays);
            stages.irradiance.pass(encoder, clock.as_mut(), Timed::Irradiance, buffers, light, queries);
            stages.upsample.pass(encoder, clock.as_mut(), Timed::Upsample, buffers, light, tiles);
            stages.compose.pass(encoder, clock.as_mut(), Timed::Compose, buffers, light, tiles);
        }
        Ok(())
    }

    /// Records what it takes to read the statistics of the frame recorded last.
    pub fn read_stats(&self, encoder: &mut wgpu::CommandEncoder) -> PendingStats {
        PendingStats::record(&self.device, encoder, &self.buffers.counters, self.clock.as_ref())
    }

    fn bind(&mut self) {
        let Stages { rasterize, resolve, refine, dispatch, masks, irradiance, upsample, compose } =
            &mut self.stages;
        rasterize.bind(&self.device, &self.buffers);
        for stage in [resolve, refine, dispatch, masks, irradiance, upsample, compose] {
            stage.bind(&self.device, &self.buffers);
        }
    }
}

impl Stages {
    fn new(
        device: &wgpu::Device,
        config: &PipelineConfig,
        visibility: Option<&str>,
    ) -> Result<Self, GpuError> {
        let unsupported = |stage, reason| Err(GpuError::Unsupported { stage, reason });
        match config.refiner {
            RefinerConfig::Full => {}
            _ => return unsupported("this refiner", "only `full` does so far"),
        }
        if config.upsampler == UpsamplerConfig::Delaunay {
            return unsupported("delaunay", "a triangulation is made one point after another; use `lattice`");
        }
        let shading = [("SHADING", if config.shading == Shading::Ratio { 1.0 } else { 0.0 })];
        Ok(Self {
            rasterize: Rasterizer::new(device)?,
            resolve: Stage::new(device, programs::RESOLVE, &[])?,
            refine: Stage::new(device, programs::FULL, &[])?,
            dispatch: Stage::new(device, programs::DISPATCH, &[])?,
            masks: Stage::with_visibility(device, programs::BVH_MASKS, &[], visibility)?,
            irradiance: Stage::new(device, programs::IRRADIANCE, &shading)?,
            upsample: Stage::new(device, programs::COPY, &[])?,
            compose: Stage::new(device, programs::COMPOSE, &shading)?,
        })
    }
}

/// What an image of this size takes.
fn size(width: u32, height: u32, lights: usize) -> Result<Size, GpuError> {
    if !(1..=MAX_SIZE).contains(&width) || !(1..=MAX_SIZE).contains(&height) {
        return Err(PipelineError::Size { width, height }.into());
    }
    Ok(Size { width, height, queries: width * height, frames: lights as u32 })
}

/// Copies the uniforms by the encoder, so that several frames can be recorded before one submission.
fn write_frames(
    device: &wgpu::Device,
    encoder: &mut wgpu::CommandEncoder,
    buffers: &Buffers,
    frames: &[Frame],
) {
    let stride = buffers.frame_stride as usize;
    let mut bytes = vec![0; stride * frames.len()];
    for (slot, frame) in bytes.chunks_exact_mut(stride).zip(frames) {
        slot[..size_of::<Frame>()].copy_from_slice(bytemuck::bytes_of(frame));
    }
    let staging = wgpu::util::DeviceExt::create_buffer_init(
        device,
        &wgpu::util::BufferInitDescriptor {
            label: Some("uniforms"),
            contents: &bytes,
            usage: wgpu::BufferUsages::COPY_SRC,
        },
    );
    encoder.copy_buffer_to_buffer(&staging, 0, &buffers.frames, 0, staging.size());
}
