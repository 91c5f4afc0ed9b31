//! The one place that states the order of the stages on the GPU.

use halflight_core::frame::LightSampling;
use halflight_core::light::AreaLight;
use halflight_core::pattern::Pattern;
use halflight_core::scene::{Camera, Scene};
use halflight_cpu::config::{PipelineConfig, VisibilityConfig};
use halflight_cpu::flush::{FlushLight, separate_lights};
use halflight_cpu::irradiance::Shading;
use halflight_cpu::pipeline::{MAX_SIZE, PipelineError, check_scene};

use crate::GpuError;
use crate::bindings::Slot;
use crate::buffers::{Buffers, Size, filled};
use crate::frame::{Frame, Key};
use crate::gbuffer::Rasterizer;
use crate::gpu::check_limits;
use crate::present::Present;
use crate::programs;
use crate::recorder::{Groups, Recorder};
use crate::refine::{Refine, Tracer};
use crate::scene::SceneBuffers;
use crate::shader::shader_module;
use crate::stage::{Compiler, Stage};
use crate::stats::{Clock, PendingStats, Timed};
use crate::upsample::Upsample;
use crate::visibility::Visibility;

/// What changes from frame to frame.
#[derive(Clone, Copy, Debug, Default)]
pub struct Inputs<'a> {
    /// Where the scene is seen from; the scene's own camera by default.
    pub camera: Option<Camera>,
    /// Number of the frame: frames differ in their light samples.
    pub frame: u32,
    /// Where the G-buffer comes from.
    pub surfaces: Surfaces<'a>,
}

/// Where the G-buffer comes from.
#[derive(Clone, Copy, Debug, Default)]
pub enum Surfaces<'a> {
    /// The scene is rasterized.
    #[default]
    Scene,
    /// It is in [`Renderer::position`] and [`Renderer::normal`] already.
    Kept,
    /// The caller has drawn it, in textures of the image's size that can be bound and need not be filtered. What it sees must be
    /// the scene, seen by the camera. Shadow rays start off the surface by 12 units of 2⁻²⁴ of the point's largest coordinate
    /// and 8 of its depth: points must be rounded no worse than single precision does.
    Points {
        /// World-space points.
        position: &'a wgpu::TextureView,
        /// Geometric unit normals towards the viewer; zero where nothing is seen.
        normal: &'a wgpu::TextureView,
    },
    /// The same with depths.
    Depths {
        /// Distances along the view direction, metres.
        depth: &'a wgpu::TextureView,
        /// As above.
        normal: &'a wgpu::TextureView,
    },
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
    /// One number a pixel: the level of the cell that it lies in, `u32::MAX` for none.
    Owners,
    /// One float a pixel: irradiance per radiance, or the visible fraction.
    Plane,
    /// How many queries `beam` or `raster4d` has left to rays last, then which.
    Spilled,
    /// What an error target takes: kind, columns and rows of the light samples come first.
    Chosen,
    /// Voxels, behind four numbers and one more a light: texels row by row, slices in words of 64 bits.
    Voxels,
}

/// Renders one scene on one device, frame after frame, in buffers that are kept.
#[derive(Debug)]
pub struct Renderer {
    device: wgpu::Device,
    scene: SceneBuffers,
    lights: Vec<AreaLight>,
    flush: Vec<FlushLight>,
    camera: Camera,
    sampling: LightSampling,
    pattern: Pattern,
    seed: u32,
    stages: Stages,
    buffers: Buffers,
    clock: Option<Clock>,
    present: Option<Present>,
}

/// All stages of a configuration.
#[derive(Debug)]
struct Stages {
    rasterize: Rasterizer,
    resolve: Stage,
    /// Of points, and of depths.
    take: [Stage; 2],
    refine: Refine,
    tracer: Tracer,
    upsample: Upsample,
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
        Self::with_modules(device, queue, scene, config, &[])
    }

    /// The same with a visibility backend from outside, in the place of the configured one: `module` is WGSL with a function
    /// `fn occluded(origin: vec3<f32>, end: vec3<f32>) -> bool`, which says whether the open segment between two points meets
    /// anything. A line `//@ reads nodes triangles` gives it the scene's BVH and corners, `visibility/bvh` in
    /// [`shader_module`](crate::shader_module) shows how these are laid out.
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
        let config = PipelineConfig { visibility: VisibilityConfig::Bvh, ..*config };
        Self::with_modules(device, queue, scene, &config, &[("visibility/bvh", module)])
    }

    /// The same with any other modules in the place of those of the same names: see [`shader_module`](crate::shader_module).
    ///
    /// # Errors
    /// As [`Renderer::with_visibility`]; and where there is no module of a name.
    pub fn with_modules(
        device: &wgpu::Device,
        queue: &wgpu::Queue,
        scene: &Scene,
        config: &PipelineConfig,
        modules: &[(&str, &str)],
    ) -> Result<Self, GpuError> {
        for (name, _) in modules {
            shader_module(name)?;
        }
        check_scene(scene)?;
        check_limits(&device.limits())?;
        let pattern = config.sampling.pattern().map_err(PipelineError::from)?;
        let (lights, flush) = separate_lights(scene, None);
        let moved;
        let scene = if flush.is_empty() {
            scene
        } else {
            moved = Scene { lights, ..scene.clone() };
            &moved
        };
        let stages = Stages::new(&Compiler { device, replaced: modules }, scene, config)?;
        let buffers = SceneBuffers::new(device, scene)?;
        let size = stages.size(config.width, config.height, pattern, scene.lights.len())?;
        let mut renderer = Self {
            device: device.clone(),
            buffers: Buffers::new(device, &buffers, size)?,
            scene: buffers,
            lights: scene.lights.clone(),
            flush,
            camera: scene.camera,
            sampling: config.sampling,
            pattern,
            seed: config.seed,
            stages,
            clock: Clock::new(device, queue),
            present: None,
        };
        renderer.bind();
        Ok(renderer)
    }

    /// Changes the size of the image; nothing is done where it is the same.
    ///
    /// # Errors
    /// The image has no pixels or is too large; the renderer is then as it was.
    pub fn resize(&mut self, width: u32, height: u32) -> Result<(), GpuError> {
        let size = self.stages.size(width, height, self.pattern, self.lights.len())?;
        if size != self.buffers.size {
            self.buffers = Buffers::new(&self.device, &self.scene, size)?;
            self.bind();
        }
        Ok(())
    }

    /// Irradiance per channel, W/m², as four floats a pixel, row by row from the top left; zero where nothing is seen. The
    /// fourth is 1. It is valid until the image is resized.
    pub fn image(&self) -> &wgpu::Buffer {
        &self.buffers.image
    }

    /// Surface points, world space, moved off their surfaces to where shadow rays start (the CPU's
    /// [`receiver_origin`](halflight_core::gbuffer::receiver_origin)), with the distance along the view direction as fourth
    /// component; below 0 where nothing is seen.
    pub fn position(&self) -> &wgpu::Buffer {
        &self.buffers.position
    }

    /// Unit normals towards the viewer, as the bits of their components, and the triangle's number in the mesh; `u32::MAX`
    /// where nothing is seen. Where triangles are not known, pixels need numbers of their own.
    pub fn normal(&self) -> &wgpu::Buffer {
        &self.buffers.normal
    }

    /// Linear RGB albedo, four floats a pixel; zero where nothing is seen.
    pub fn albedo(&self) -> &wgpu::Buffer {
        &self.buffers.albedo
    }

    /// The lights that are flush with geometry, which does not hide them: each is worth a warning.
    pub fn flush_lights(&self) -> &[FlushLight] {
        &self.flush
    }

    /// Width and height of the image in pixels.
    pub fn size(&self) -> (u32, u32) {
        (self.buffers.size.width, self.buffers.size.height)
    }

    /// A buffer that later stages read, as the last light of the last frame left it: for tests and debuggers.
    pub fn inside(&self, what: Inside) -> &wgpu::Buffer {
        match what {
            Inside::Queries => &self.buffers.queries,
            Inside::Wanted => &self.buffers.wanted,
            Inside::Visible => &self.buffers.visible,
            Inside::Samples => &self.buffers.samples,
            Inside::Owners => &self.buffers.owners,
            Inside::Plane => &self.buffers.plane,
            Inside::Spilled => &self.buffers.spilled,
            Inside::Chosen => &self.buffers.chosen,
            Inside::Voxels => &self.buffers.voxels,
        }
    }

    /// Records a frame. It neither submits, maps nor waits.
    ///
    /// # Errors
    /// The device is full or lost; nothing has been recorded then.
    pub fn record(&mut self, encoder: &mut wgpu::CommandEncoder, inputs: &Inputs) -> Result<(), GpuError> {
        let Self { stages, buffers, clock, .. } = self;
        if let Some(clock) = clock {
            clock.start();
        }
        let Size { width, height, queries, .. } = buffers.size;
        let camera = inputs.camera.as_ref().unwrap_or(&self.camera);
        let general = Frame::new(camera, (width, height), self.scene.size, self.pattern);
        let general = Frame { capacity: queries, ..general };
        let key = Key { seed: self.seed, frame: inputs.frame, sharing: self.sampling.sharing };
        let frames: Vec<Frame> = (0..)
            .zip(&self.lights)
            .flat_map(|(number, light)| {
                stages.refine.frames(general.with_light(number, light, key), self.pattern)
            })
            .collect();
        let space = stages.tracer.visibility.space(camera, buffers.size);
        let written = [
            ("uniforms", &frame_bytes(buffers, &frames), &buffers.frames),
            ("voxels", &space, &buffers.space),
        ];
        write(&self.device, encoder, &written)?;
        encoder.clear_buffer(&buffers.counters, 0, None);

        let mut recorder = Recorder { encoder, buffers, clock: clock.as_mut() };
        match inputs.surfaces {
            Surfaces::Kept => {}
            Surfaces::Scene => {
                stages.rasterize.run(&mut recorder, self.scene.vertices);
                recorder.run(&stages.resolve, Timed::Gbuffer, 0, Groups::Tiles(0));
            }
            Surfaces::Points { position: point, normal } | Surfaces::Depths { depth: point, normal } => {
                let depth = matches!(inputs.surfaces, Surfaces::Depths { .. });
                let take = &mut stages.take[usize::from(depth)];
                take.bind_given(
                    &self.device,
                    buffers,
                    &[(Slot::GivenPoint, point), (Slot::GivenNormal, normal)],
                );
                recorder.run(take, Timed::Gbuffer, 0, Groups::Tiles(0));
            }
        }
        stages.refine.prepare(&mut recorder);
        let coarsest = stages.refine.coarsest();
        stages.tracer.visibility.prepare(&mut recorder, stages.refine.uniforms());
        for light in 0..self.lights.len() as u32 {
            let first = light * stages.refine.uniforms();
            stages.tracer.visibility.start(&mut recorder, first);
            stages.refine.record(&mut recorder, &stages.tracer, first);
            stages.upsample.record(&mut recorder, first, coarsest);
            recorder.run(&stages.compose, Timed::Compose, first, Groups::Tiles(0));
        }
        stages.refine.finish(&mut recorder);
        Ok(())
    }

    /// Records a copy of the image to a texture of this format that can be rendered to.
    ///
    /// # Errors
    /// A shader cannot be read.
    pub fn present(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        target: &wgpu::TextureView,
        format: wgpu::TextureFormat,
    ) -> Result<(), GpuError> {
        let present = match self.present.take().filter(|present| present.format == format) {
            Some(present) => present,
            None => Present::new(&Compiler { device: &self.device, replaced: &[] }, format)?,
        };
        present.record(&self.device, encoder, &self.buffers, target);
        self.present = Some(present);
        Ok(())
    }

    /// Records what it takes to read the statistics of the frame recorded last.
    pub fn read_stats(&self, encoder: &mut wgpu::CommandEncoder) -> PendingStats {
        let expects = self.stages.refine.expects();
        PendingStats::record(&self.device, encoder, &self.buffers.counters, self.clock.as_ref(), expects)
    }

    fn bind(&mut self) {
        let Stages { rasterize, resolve, take: _, refine, tracer, upsample, compose } = &mut self.stages;
        rasterize.bind(&self.device, &self.buffers);
        let Tracer { dispatch, visibility, irradiance } = tracer;
        let others = [resolve, dispatch, irradiance, compose].into_iter().chain(visibility.stages());
        for stage in others.chain(refine.stages()).chain(upsample.stages()) {
            stage.bind(&self.device, &self.buffers);
        }
    }
}

impl Stages {
    fn new(compiler: &Compiler, scene: &Scene, config: &PipelineConfig) -> Result<Self, GpuError> {
        let shading = [("SHADING", if config.shading == Shading::Ratio { 1.0 } else { 0.0 })];
        let stage = |program, constants: &[(&str, f64)]| compiler.stage(program, constants);
        let take = |depth: f64| stage(programs::IMPORT, &[("DEPTH", depth)]);
        Ok(Self {
            refine: Refine::new(compiler, config)?,
            upsample: Upsample::new(compiler, config)?,
            rasterize: Rasterizer::new(compiler)?,
            resolve: stage(programs::RESOLVE, &[])?,
            take: [take(0.0)?, take(1.0)?],
            tracer: Tracer {
                dispatch: stage(programs::DISPATCH, &[])?,
                visibility: Visibility::new(compiler, scene, config)?,
                irradiance: stage(programs::IRRADIANCE, &shading)?,
            },
            compose: stage(programs::COMPOSE, &shading)?,
        })
    }

    /// What an image of this size takes.
    fn size(&self, width: u32, height: u32, pattern: Pattern, lights: usize) -> Result<Size, GpuError> {
        if !(1..=MAX_SIZE).contains(&width) || !(1..=MAX_SIZE).contains(&height) {
            return Err(PipelineError::Size { width, height }.into());
        }
        let size = self.tracer.visibility.size(self.upsample.size(self.refine.size(width, height, pattern)));
        Ok(Size { frames: lights as u32 * self.refine.uniforms(), ..size })
    }
}

/// What the uniforms hold.
fn frame_bytes(buffers: &Buffers, frames: &[Frame]) -> Vec<u8> {
    let stride = buffers.frame_stride as usize;
    let mut bytes = vec![0; stride * frames.len()];
    for (slot, frame) in bytes.chunks_exact_mut(stride).zip(frames) {
        slot[..size_of::<Frame>()].copy_from_slice(bytemuck::bytes_of(frame));
    }
    bytes
}

/// Copies to buffers by the encoder, so that several frames can be recorded before one submission.
///
/// # Errors
/// The device is full or lost; nothing has been recorded then.
fn write(
    device: &wgpu::Device,
    encoder: &mut wgpu::CommandEncoder,
    contents: &[(&'static str, &Vec<u8>, &wgpu::Buffer)],
) -> Result<(), GpuError> {
    let some = contents.iter().filter(|(_, bytes, _)| !bytes.is_empty());
    let staged = |&(what, bytes, to): &(&'static str, &Vec<u8>, _)| {
        filled(device, what, bytes, wgpu::BufferUsages::COPY_SRC).map(|staging| (staging, to))
    };
    for (staging, to) in some.map(staged).collect::<Result<Vec<_>, _>>()? {
        encoder.copy_buffer_to_buffer(&staging, 0, to, 0, staging.size());
    }
    Ok(())
}
