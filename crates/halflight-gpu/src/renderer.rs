//! Renderers: a scene on a device, what changes in it, and frames of it.

use std::sync::Arc;

use glam::Vec3;
use halflight_core::frame::LightSampling;
use halflight_core::light::AreaLight;
use halflight_core::light_texture::LightTexture;
use halflight_core::pattern::Pattern;
use halflight_core::scene::{Camera, Mesh, Scene};
use halflight_core::subpixel;
use halflight_cpu::config::{IndirectConfig, PipelineConfig, VisibilityConfig};
use halflight_cpu::flush::{FlushLight, separate_lights};
use halflight_cpu::irradiance::Shading;
use halflight_cpu::pipeline::{PipelineError, check_scene};
use halflight_cpu::upsample::SurfaceLimits;

use crate::bindings::Slot;
use crate::buffers::Buffers;
use crate::emission;
use crate::error::GpuError;
use crate::frame::{Frame, Key};
use crate::gbuffer::Surfaces;
use crate::gpu::check_limits;
use crate::inputs::{Inputs, Inside};
use crate::light::sides;
use crate::masked::Parted;
use crate::memory::Memory;
use crate::pass::Compiler;
use crate::present::{Present, Purpose};
use crate::recorder::Recorder;
use crate::scene::SceneBuffers;
use crate::shader::shader_module;
use crate::stages::Stages;
use crate::stats::{Clock, PendingStats};
use crate::textured::{Emitted, has_texture};
use crate::upsample::Upsample;

/// Renders one scene on one device, frame after frame, in buffers that are kept.
#[derive(Debug)]
pub struct Renderer {
    memory: Memory,
    /// The scene as it was given.
    scene: Scene,
    scene_buffers: SceneBuffers,
    /// Lights of the scene, moved off the triangles that they are flush with.
    lights: Vec<AreaLight>,
    /// Emission of textured lights.
    emitted: Emitted,
    /// True if the visibility backend answers for sphere lights.
    spheres: bool,
    flush: Vec<FlushLight>,
    sampling: LightSampling,
    pattern: Pattern,
    seed: u32,
    surface: SurfaceLimits,
    config: PipelineConfig,
    /// Modules from outside, and the names of those that they replace.
    modules: Vec<(String, String)>,
    stages: Stages,
    buffers: Buffers,
    clock: Option<Clock>,
    present: Option<Present>,
    /// True if the caller has drawn the surfaces of the last frame, whose albedo is not known then.
    white: bool,
}

impl Renderer {
    /// Uploads a scene, compiles the stages of a configuration and creates their buffers.
    ///
    /// Frames show the centres of pixels, whatever the configuration's `antialias` is:
    /// [`Gpu::render_antialiased`](crate::Gpu::render_antialiased) takes several.
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

    /// Makes a renderer with a visibility backend from outside, in the place of the configured one: `module` is WGSL with a
    /// function `fn occluded(origin: vec3<f32>, end: vec3<f32>) -> bool`, which says whether the open segment between two points meets
    /// anything. A line `//@ reads nodes triangles` gives it the scene's BVH and corners, `visibility/traversal` in
    /// [`shader_module`](crate::shader_module) shows how these are laid out.
    ///
    /// Triangles with an alpha mask are not the module's: what they hide is taken out afterwards. They are not below node 0, and come
    /// last among the corners, from triangle `masked.first` on (`//@ needs shared/masked`, in scenes that have some).
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

    /// Makes a renderer with other modules in the place of those of the same names: see [`shader_module`](crate::shader_module).
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
        subpixel::offsets(config.antialias).map_err(PipelineError::from)?;
        check_limits(&device.limits())?;
        if config.indirect != IndirectConfig::None {
            return Err(GpuError::Unsupported {
                stage: "indirect light",
                reason: "render on the CPU, or choose the configuration's indirect = \"none\"",
            });
        }
        let pattern = config.sampling.pattern().map_err(PipelineError::from)?;
        let (lights, flush) = separate_lights(scene, None);
        let spheres = matches!(config.visibility, VisibilityConfig::Bvh | VisibilityConfig::Auto);
        refuse_lights(&lights, spheres)?;
        let compiler = Compiler { device, textured: has_texture(&lights), replaced: modules };
        let parted = Parted::of(&scene.mesh);
        let stages = Stages::new(&compiler, scene, &parted, config, pattern)?;
        let memory = Memory::new(device);
        let scene_buffers = SceneBuffers::new(&memory, &scene.mesh, &parted)?;
        let texels = config.shading == Shading::Sampled;
        let emitted = Emitted::new(&memory, scene, &lights, &stages.refiner.patterns(pattern), texels)?;
        let needs = stages.needs(config.width, config.height, pattern, &lights)?;
        let mut buffers = Buffers::new(&memory, &scene_buffers.slots, needs)?;
        emitted.bind(&mut buffers, &memory);
        Ok(Self {
            buffers,
            memory,
            scene: scene.clone(),
            scene_buffers,
            lights,
            emitted,
            spheres,
            flush,
            config: *config,
            modules: modules.iter().map(|&(name, text)| (name.to_owned(), text.to_owned())).collect(),
            sampling: config.sampling,
            pattern,
            seed: config.seed,
            surface: Upsample::surface_limits(&config.upsampler),
            stages,
            clock: Clock::new(device, queue),
            present: None,
            white: false,
        })
    }

    /// Changes the size of the image; nothing is done where it is the same.
    ///
    /// # Errors
    /// The image has no pixels or is too large; the renderer is then as it was.
    pub fn resize(&mut self, width: u32, height: u32) -> Result<(), GpuError> {
        let needs = self.stages.needs(width, height, self.pattern, &self.lights)?;
        if needs != self.buffers.needs {
            self.buffers = Buffers::new(&self.memory, &self.scene_buffers.slots, needs)?;
            self.emitted.bind(&mut self.buffers, &self.memory);
        }
        Ok(())
    }

    /// Replaces the lights of the scene, by any number of lights. Frames recorded from now on show them.
    ///
    /// No shader is compiled but by the first light that is textured, or that the camera sees. Buffers grow only where there are more lights than ever before,
    /// where that light comes or, with `raster4d`, the first two-sided one. Lights that are flush with geometry are found as in [`Renderer::new`], in one pass over the
    /// triangles on the CPU.
    ///
    /// # Errors
    /// No light is given, a light cannot be rendered, or the device has no room for so many; the renderer is then as it was.
    pub fn set_lights(&mut self, lights: &[AreaLight]) -> Result<(), GpuError> {
        let light_textures = self.scene.light_textures.clone();
        let camera = self.scene.camera;
        check_scene(&Scene { lights: lights.to_vec(), light_textures, camera, ..Scene::default() })?;
        let before = std::mem::replace(&mut self.scene.lights, lights.to_vec());
        self.place_lights(true).inspect_err(|_| self.scene.lights = before)
    }

    /// Replaces the lights of the scene and their textures, as for the next frame of a video; otherwise as [`Renderer::set_lights`].
    ///
    /// # Errors
    /// As [`Renderer::set_lights`]; and where a light has a texture that is not there.
    pub fn set_textured_lights(
        &mut self,
        lights: &[AreaLight],
        textures: &[Arc<LightTexture>],
    ) -> Result<(), GpuError> {
        let before = std::mem::replace(&mut self.scene.light_textures, textures.to_vec());
        self.set_lights(lights).inspect_err(|_| self.scene.light_textures = before)
    }

    /// Replaces the camera of the scene, which frames without a camera of their own ([`Inputs::camera`]) are seen from.
    ///
    /// # Errors
    /// The camera cannot be rendered; the renderer is then as it was.
    pub fn set_camera(&mut self, camera: Camera) -> Result<(), GpuError> {
        camera.validate().map_err(PipelineError::from)?;
        self.scene.camera = camera;
        Ok(())
    }

    /// Camera of the scene.
    pub(crate) fn camera(&self) -> Camera {
        self.scene.camera
    }

    /// Moves the vertices of the scene: records the upload of the same triangles with other corners, world space, metres, one a
    /// vertex. Frames recorded after that show them; `encoder` must be submitted, before or with these.
    ///
    /// The BVH keeps its tree and gets new boxes. Images are those of a new renderer, but shadow rays take longer the
    /// farther triangles move against each other, and of surfaces at equal depths another may be seen.
    ///
    /// # Errors
    /// The number of positions is another than that of the vertices; a position is not finite or too far away, which the error
    /// names; or the device is full or lost. The renderer is then as it was.
    pub fn update_geometry(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        positions: &[Vec3],
    ) -> Result<(), GpuError> {
        let (found, expected) = (positions.len(), self.scene.mesh.positions.len());
        if found != expected {
            return Err(GpuError::Vertices { found, expected });
        }
        let before = std::mem::replace(&mut self.mesh().positions, positions.to_vec());
        self.upload_geometry(encoder).inspect_err(|_| self.mesh().positions = before)
    }

    fn mesh(&mut self) -> &mut Mesh {
        Arc::make_mut(&mut self.scene.mesh)
    }

    /// Checks and uploads the mesh of the scene.
    fn upload_geometry(&mut self, encoder: &mut wgpu::CommandEncoder) -> Result<(), GpuError> {
        self.scene.mesh.validate().map_err(PipelineError::from)?;
        let (lights, flush) = (self.lights.clone(), self.flush.clone());
        self.place_lights(false)?;
        let updated = self.scene_buffers.update(&self.memory, encoder, &self.scene.mesh);
        updated.inspect_err(|_| (self.lights, self.flush) = (lights, flush))
    }

    /// Moves the lights of the scene off the triangles that they are flush with, and makes room for them where they have `changed`.
    fn place_lights(&mut self, changed: bool) -> Result<(), GpuError> {
        let (lights, flush) = separate_lights(&self.scene, None);
        if !changed {
            // Their emission does not depend on the geometry.
            (self.lights, self.flush) = (lights, flush);
            return Ok(());
        }
        refuse_lights(&lights, self.spheres)?;
        self.stages.prepare_lights(&self.memory.device, &lights)?;
        let (width, height) = self.size();
        let compiled = (has_texture(&lights) && !self.stages.is_textured())
            .then(|| self.compile_textured())
            .transpose()?;
        let stages = compiled.as_ref().unwrap_or(&self.stages);
        let texels = self.config.shading == Shading::Sampled;
        let patterns = stages.refiner.patterns(self.pattern);
        let emitted = Emitted::new(&self.memory, &self.scene, &lights, &patterns, texels)?;
        let needs = stages.needs(width, height, self.pattern, &lights)?;
        self.buffers.grow(&self.memory, needs)?;
        emitted.bind(&mut self.buffers, &self.memory);
        (self.lights, self.flush, self.emitted) = (lights, flush, emitted);
        if let Some(compiled) = compiled {
            self.stages = compiled;
        }
        Ok(())
    }

    /// Compiles the stages once more, with those of textured lights.
    fn compile_textured(&self) -> Result<Stages, GpuError> {
        let replaced: Vec<(&str, &str)> =
            self.modules.iter().map(|(name, text)| (&**name, &**text)).collect();
        let compiler = Compiler { device: &self.memory.device, textured: true, replaced: &replaced };
        Stages::new(&compiler, &self.scene, &Parted::of(&self.scene.mesh), &self.config, self.pattern)
    }

    /// Bytes of all buffers that the renderer has created so far, those to upload from included: for tests.
    #[doc(hidden)]
    pub fn bytes_created(&self) -> u64 {
        self.memory.created()
    }

    /// Irradiance per channel, W/m², as four floats a pixel, row by row from the top left; zero where nothing is seen. The
    /// fourth is 1. It is valid until the image is resized.
    pub fn image(&self) -> &wgpu::Buffer {
        &self.buffers[Slot::Image]
    }

    /// Surface points, world space, moved off their surfaces to where shadow rays start (the CPU's
    /// [`receiver_origin`](halflight_core::gbuffer::receiver_origin)), with the distance along the view direction as fourth
    /// component; below 0 where nothing is seen.
    pub fn position(&self) -> &wgpu::Buffer {
        &self.buffers[Slot::Position]
    }

    /// Geometric unit normals towards the viewer, as the bits of their components, and the triangle's number in the mesh; `u32::MAX`
    /// where nothing is seen. Where triangles are not known, pixels need numbers of their own. In scenes with smooth surfaces, unit shading
    /// normals of all pixels follow, which frames of [`Surfaces::Scene`](crate::Surfaces::Scene) and [`Surfaces::Kept`](crate::Surfaces::Kept)
    /// are lit by.
    pub fn normal(&self) -> &wgpu::Buffer {
        &self.buffers[Slot::Normal]
    }

    /// Linear RGB albedo, four floats a pixel; zero where nothing is seen.
    pub fn albedo(&self) -> &wgpu::Buffer {
        &self.buffers[Slot::Albedo]
    }

    /// Specular reflection of surfaces: linear RGB reflectance at normal incidence, and roughness, four floats a pixel; black where a surface is matte
    /// or nothing is seen. None in scenes without glossy surfaces. Frames of [`Surfaces::Kept`](crate::Surfaces::Kept) read it.
    pub fn gloss(&self) -> Option<&wgpu::Buffer> {
        self.stages.is_glossy().then(|| &self.buffers[Slot::Gloss])
    }

    /// Specularly reflected radiance, W/m²/sr, as four floats a pixel, to be added to albedo/π times the [image](Self::image). None in scenes without
    /// glossy surfaces.
    pub fn specular(&self) -> Option<&wgpu::Buffer> {
        self.stages.is_glossy().then(|| &self.buffers[Slot::Specular])
    }

    /// Radiance that the nearest light before the surface emits towards the camera, per channel, W/m²/sr, as four floats a pixel; the fourth is
    /// its distance along the view direction, metres, and 0 where no light is seen. None where no light is
    /// [visible](AreaLight::visible).
    pub fn emission(&self) -> Option<&wgpu::Buffer> {
        emission::any_visible(&self.lights).then(|| &self.buffers[Slot::Emission])
    }

    /// The lights that are flush with geometry, which does not hide them: each is worth a warning.
    pub fn flush_lights(&self) -> &[FlushLight] {
        &self.flush
    }

    /// Width and height of the image in pixels.
    pub fn size(&self) -> (u32, u32) {
        (self.buffers.needs.width, self.buffers.needs.height)
    }

    /// Returns a buffer that later stages read, as the last light of the last frame left it: for tests and debuggers.
    pub fn inside(&self, what: Inside) -> &wgpu::Buffer {
        &self.buffers[what.slot()]
    }

    /// Records a frame: nothing is submitted, mapped or waited for.
    ///
    /// # Errors
    /// The device is full or lost; nothing has been recorded then.
    pub fn record(&mut self, encoder: &mut wgpu::CommandEncoder, inputs: &Inputs) -> Result<(), GpuError> {
        let Self { memory, scene, scene_buffers, lights, emitted, stages, buffers, clock, .. } = self;
        let emitted = &*emitted;
        if let Some(clock) = clock {
            clock.start();
        }
        let needs = &buffers.needs;
        let camera = inputs.camera.as_ref().unwrap_or(&scene.camera);
        let general = Frame {
            scene_size: scene_buffers.extent.diagonal,
            largest: scene_buffers.extent.largest,
            lights: lights.len() as u32,
            sides: sides(lights),
            shading: stages.gbuffer.shading(&inputs.surfaces, needs),
            capacity: needs.records(Slot::Queries) as u32,
            ..Frame::new(camera, (needs.width, needs.height), self.pattern, self.surface)
        };
        let key = Key { seed: self.seed, frame: inputs.frame, sharing: self.sampling.sharing };
        let frames: Vec<Frame> = (0..)
            .zip(lights.iter())
            .flat_map(|(number, light)| {
                let frames =
                    stages.refiner.frames(general.with_light(number, light).with_key(key), self.pattern);
                frames.into_iter().map(move |frame| emitted.with_texture(number, frame))
            })
            .collect();
        let space = stages.tracer.visibility.space(camera, needs, lights);
        let written: [(_, &[u8], _); 2] = [
            ("uniforms", &frame_bytes(buffers, &frames), &buffers.frames),
            (Slot::Space.label(), &space, &buffers[Slot::Space]),
        ];
        memory.write(encoder, &written)?;

        let device = &memory.device;
        let mut recorder =
            Recorder { encoder, device, buffers, lights, textured: false, clock: clock.as_mut() };
        recorder.clear(Slot::Counters);
        stages.record(&mut recorder, &inputs.surfaces, scene_buffers.corners);
        self.white = matches!(inputs.surfaces, Surfaces::Points { .. } | Surfaces::Depths { .. });
        Ok(())
    }

    /// Records a picture of the last frame in a texture of this format that can be rendered to: the radiance of each pixel, W/m²/sr, which is
    /// albedo/π times the [image](Self::image), with what is reflected [specularly](Self::specular), or of the light that the pixel
    /// [sees](Self::emission). After frames whose surfaces the caller has drawn ([`Surfaces::Points`] and [`Surfaces::Depths`]) the albedo
    /// is 1.
    ///
    /// A radiance of 1 is white, as in the pictures of `halflight render`: formats of fixed range get sRGB values from 0 to 1, by the device for formats
    /// that end in `Srgb` and by the shader for others. Formats of floats get the radiance itself.
    ///
    /// # Errors
    /// A shader cannot be read, or the device does not allow 4 storage buffers in a stage.
    pub fn present(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        target: &wgpu::TextureView,
        format: wgpu::TextureFormat,
    ) -> Result<(), GpuError> {
        let (glossy, lamps) = (self.stages.is_glossy(), emission::any_visible(&self.lights));
        let purpose = Purpose { format, glossy, lamps, white: self.white };
        let present = match self.present.take().filter(|present| present.purpose == purpose) {
            Some(present) => present,
            None => Present::new(
                &Compiler { device: &self.memory.device, textured: false, replaced: &[] },
                purpose,
            )?,
        };
        present.record(&self.memory.device, encoder, &self.buffers, target);
        self.present = Some(present);
        Ok(())
    }

    /// Records the copies that are needed to read the statistics of the frame recorded last.
    pub fn read_stats(&self, encoder: &mut wgpu::CommandEncoder) -> PendingStats {
        let expects = self.stages.refiner.expects();
        let counters = &self.buffers[Slot::Counters];
        PendingStats::record(&self.memory.device, encoder, counters, self.clock.as_ref(), expects)
    }
}

/// Returns the contents of the uniforms.
fn frame_bytes(buffers: &Buffers, frames: &[Frame]) -> Vec<u8> {
    let stride = buffers.frame_stride as usize;
    let mut bytes = vec![0; stride * frames.len()];
    for (slot, frame) in bytes.chunks_exact_mut(stride).zip(frames) {
        slot[..size_of::<Frame>()].copy_from_slice(bytemuck::bytes_of(frame));
    }
    bytes
}

/// Refuses spheres where the backend has no answers for them.
fn refuse_lights(lights: &[AreaLight], spheres: bool) -> Result<(), GpuError> {
    if !spheres && lights.iter().any(|light| light.as_sphere().is_some()) {
        return Err(GpuError::Unsupported {
            stage: "a sphere light with beam, raster4d or voxel",
            reason: "every receiver has light samples of its own; use bvh or auto, which trace rays",
        });
    }
    Ok(())
}
