//! The one place that states the order of the stages.

mod builder;
mod error;

use std::sync::Arc;
use std::time::Instant;

use glam::Vec3;
use halflight_core::camera::Camera;
use halflight_core::fragment::Fragments;
use halflight_core::frame::{Frame, LightSampling};
use halflight_core::gbuffer::{GBuffer, GBufferError};
use halflight_core::light::AreaLight;
use halflight_core::light_texture::LightTexture;
use halflight_core::pattern::Pattern;
use halflight_core::pyramid::Pyramid;
use halflight_core::scene::Scene;
use halflight_core::stages::Visibility;
use halflight_core::stats::{FrameStats, LevelWork};
use halflight_core::subpixel;
use halflight_core::values::Values;

use crate::antialias::Antialias;
use crate::beam::Beam;
use crate::compose::{self, Totals, luminance};
use crate::emission::SeenLights;
use crate::flush::{self, FlushLight};
use crate::indirect::Surroundings;
use crate::irradiance::{self, Shading};
use crate::prepared::PreparedScene;
use crate::refine::{Lattice, Quality};
use crate::requests::Requests;
use crate::specular::{LobeLight, Specular};
use crate::textured::SeenTexture;
use crate::{gbuffer, pyramid, upsample};
pub use builder::PipelineBuilder;
pub use error::PipelineError;

/// The widest and highest image: cells hold their place in 16 bits.
pub const MAX_SIZE: u32 = 32_768;

/// Worker threads that a machine of fewer cores may have; starting many more takes longer than rendering.
const THREADS: usize = 64;

/// The number of threads to start where `asked` are: no more than the machine has cores, or 64 where it has fewer.
pub fn useful_threads(asked: usize) -> usize {
    asked.min(std::thread::available_parallelism().map_or(THREADS, |cores| cores.get().max(THREADS)))
}

/// Checks that a scene can be rendered: it has lights, and these, the mesh and the camera are in order.
///
/// # Errors
/// The first fault found.
pub fn check_scene(scene: &Scene) -> Result<(), PipelineError> {
    check_lights(scene)?;
    scene.mesh.validate()?;
    Ok(scene.camera.validate()?)
}

fn check_lights(scene: &Scene) -> Result<(), PipelineError> {
    if scene.lights.is_empty() {
        return Err(PipelineError::NoLight);
    }
    Ok(scene.validate_lights()?)
}

/// Checks that a backend answers for all lights.
fn check_supported(visibility: &dyn Visibility, lights: &[AreaLight]) -> Result<(), PipelineError> {
    let refused = |(index, light): (usize, &AreaLight)| {
        visibility.supports_light(light).map_err(|source| PipelineError::UnsupportedLight { index, source })
    };
    lights.iter().enumerate().try_for_each(refused)
}

/// Rendered frame. All layers are row by row from the top left.
#[derive(Clone, Debug, Default)]
pub struct Image {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Direct irradiance per channel, W/m²; zero where nothing is seen. At the pixel's centre, with antialiasing as well; frames of a GPU have
    /// the mean over sub-samples there.
    pub irradiance: Vec<Vec3>,
    /// Indirect irradiance per channel, W/m², at the pixel's centre: light that has been reflected at least once; zero where nothing is seen. Empty
    /// where none was asked for.
    pub indirect: Vec<Vec3>,
    /// Radiance that reaches the camera, per channel, W/m²/sr: albedo/π · irradiance, direct and indirect, and what is reflected specularly, or what a light emits that is seen
    /// before the surface; with antialiasing the mean of that over a pixel's sub-samples. A mean of products is not the product of the means, so
    /// that it does not follow from other layers. Empty without antialiasing, indirect light, glossy surfaces and visible lights, where it is albedo/π · irradiance.
    pub radiance: Vec<Vec3>,
    /// Specularly reflected radiance per channel, W/m²/sr, at the pixel's centre; empty where no surface is glossy.
    pub specular: Vec<Vec3>,
    /// Radiance that lights emit towards the camera, per channel, W/m²/sr, as a part of [`Image::radiance`]; zero where none is seen; empty where no
    /// light is [visible](AreaLight::visible).
    pub emission: Vec<Vec3>,
    /// Visible part of the unshadowed light, `ΣUF/ΣU` by luminance, at the pixel's centre; empty unless layers were asked for.
    pub visibility: Vec<f32>,
    /// Level of the fragment each pixel lies in, the finest over the lights; `u8::MAX` where nothing is seen; empty
    /// unless layers were asked for.
    pub level: Vec<u8>,
    /// Times and counts.
    pub stats: FrameStats,
}

/// Buffers that live as long as the pipeline.
#[derive(Default)]
struct Buffers {
    gbuffer: GBuffer,
    pyramid: Pyramid,
    fragments: Fragments,
    /// Values of the samples.
    values: Values,
    /// Values of the pixels.
    planes: Values,
    totals: Totals,
    specular: Specular,
    antialias: Antialias,
}

/// A renderer for one scene, ready for one frame after another.
pub struct Pipeline {
    state: State,
    pool: Option<rayon::ThreadPool>,
}

struct State {
    builder: PipelineBuilder,
    pattern: Pattern,
    flush: Vec<FlushLight>,
    index: u32,
    buffers: Buffers,
    image: Image,
}

impl Pipeline {
    /// Starts choosing stages for a scene. Geometry is shared with it.
    pub fn builder(scene: &PreparedScene) -> PipelineBuilder {
        PipelineBuilder {
            scene: scene.scene().clone(),
            visibility: Box::new(Beam::or_rays(Arc::clone(scene.bvh()))),
            bvh: Arc::clone(scene.bvh()),
            rest: Arc::clone(scene.rest()),
            size: (640, 480),
            refiner: Box::new(Lattice::new(Quality::default().lattice())),
            upsampler: Box::new(upsample::Lattice::default()),
            indirect: None,
            shading: Shading::default(),
            sampling: LightSampling::default(),
            seed: 0,
            antialias: 1,
            threads: None,
            layers: false,
            fault: None,
        }
    }

    /// Renders the next frame. Frames differ in their light samples, if these are random at all.
    ///
    /// # Errors
    /// A refiner asked for a pattern that it had not announced and the backend cannot answer.
    pub fn render(&mut self) -> Result<&Image, PipelineError> {
        self.run(None)
    }

    /// Renders the next frame of surfaces that the caller has drawn: a G-buffer of the image's size, as
    /// [`GBuffer::from_surfaces`] or another pipeline makes it. What it sees should be the scene, seen by the scene's camera
    /// ([`Pipeline::set_camera`]); the scene's geometry casts the shadows.
    ///
    /// # Errors
    /// As [`Pipeline::render`]; and where the G-buffer has another size or holds values that cannot be used, or the pipeline was built with
    /// antialiasing.
    pub fn render_gbuffer(&mut self, gbuffer: &GBuffer) -> Result<&Image, PipelineError> {
        if self.state.builder.antialias > 1 {
            return Err(PipelineError::GivenSubSamples);
        }
        let (found, expected) = ((gbuffer.width, gbuffer.height), self.state.builder.size);
        if found != expected {
            return Err(GBufferError::Size { found, expected }.into());
        }
        gbuffer.validate()?;
        self.run(Some(gbuffer))
    }

    fn run(&mut self, given: Option<&GBuffer>) -> Result<&Image, PipelineError> {
        let Self { state, pool } = self;
        match pool {
            Some(pool) => pool.install(|| state.render(given))?,
            // Inside the global pool: from outside, each of hundreds of parallel loops would wake a worker and wait for it.
            None => rayon::scope(|_| state.render(given))?,
        }
        Ok(&self.state.image)
    }

    /// Replaces the scene, for one whose mesh has moved or another one. `visibility` is a backend over its BVH. Nothing of
    /// earlier frames goes into later ones.
    ///
    /// # Errors
    /// The scene cannot be rendered, or the backend does not fit the refiner; the pipeline is then as it was.
    pub fn set_scene(
        &mut self,
        scene: &PreparedScene,
        visibility: Box<dyn Visibility>,
    ) -> Result<(), PipelineError> {
        check_scene(scene.scene())?;
        let State { builder, pattern, flush, .. } = &mut self.state;
        builder.check_patterns(visibility.as_ref(), *pattern)?;
        check_supported(visibility.as_ref(), &scene.scene().lights)?;
        builder.scene = scene.scene().clone();
        (builder.scene.lights, *flush) = flush::separate_lights(scene.scene(), Some(scene.bvh()));
        (builder.bvh, builder.visibility) = (Arc::clone(scene.bvh()), visibility);
        builder.rest = Arc::clone(scene.rest());
        Ok(())
    }

    /// Replaces the lights. Nothing that grows with the mesh is copied or built.
    ///
    /// # Errors
    /// No light is given, or one cannot be used or has no answers of the backend; the pipeline is then as it was.
    pub fn set_lights(&mut self, lights: &[AreaLight]) -> Result<(), PipelineError> {
        let State { builder, flush, .. } = &mut self.state;
        let changed = Scene { lights: lights.to_vec(), ..builder.scene.clone() };
        check_lights(&changed)?;
        check_supported(builder.visibility.as_ref(), lights)?;
        builder.scene = changed;
        (builder.scene.lights, *flush) = flush::separate_lights(&builder.scene, Some(&builder.bvh));
        Ok(())
    }

    /// Replaces the lights and their textures, as for the next frame of a video. Nothing that grows with the mesh is copied or built.
    ///
    /// # Errors
    /// No light is given, or one cannot be used or has a texture that is not there; the pipeline is then as it was.
    pub fn set_textured_lights(
        &mut self,
        lights: &[AreaLight],
        textures: &[Arc<LightTexture>],
    ) -> Result<(), PipelineError> {
        let before = std::mem::replace(&mut self.state.builder.scene.light_textures, textures.to_vec());
        self.set_lights(lights).inspect_err(|_| self.state.builder.scene.light_textures = before)
    }

    /// Replaces the camera. Nothing that grows with the mesh is copied or built.
    ///
    /// # Errors
    /// The camera looks nowhere; the pipeline is then as it was.
    pub fn set_camera(&mut self, camera: Camera) -> Result<(), PipelineError> {
        camera.validate()?;
        self.state.builder.scene.camera = camera;
        Ok(())
    }

    /// The lights that are flush with geometry, which does not hide them: each is worth a warning.
    pub fn flush_lights(&self) -> &[FlushLight] {
        &self.state.flush
    }

    /// The last frame's image.
    pub fn image(&self) -> &Image {
        &self.state.image
    }

    /// The last frame's G-buffer; that of the last frame that traced its own where the caller has brought one since.
    pub fn gbuffer(&self) -> &GBuffer {
        &self.state.buffers.gbuffer
    }

    /// The last frame's fragments, those of the last light.
    pub fn fragments(&self) -> &Fragments {
        &self.state.buffers.fragments
    }

    /// Number of the next frame.
    pub fn frame_index(&self) -> u32 {
        self.state.index
    }

    /// Sets the number of the next frame: the same number, scene and settings give the same image.
    pub fn set_frame_index(&mut self, index: u32) {
        self.state.index = index;
    }
}

impl State {
    /// A frame, stage by stage.
    fn render(&mut self, given: Option<&GBuffer>) -> Result<(), PipelineError> {
        let Self { builder, pattern, index, buffers, image, .. } = self;
        let PipelineBuilder { scene, bvh, refiner, visibility, upsampler, indirect, rest, .. } = builder;
        let mut antialias = (builder.antialias > 1).then_some(&mut buffers.antialias);
        let (width, height) = builder.size;
        let pixels = width as usize * height as usize;
        let mut stats = FrameStats::default();
        stats.peak_bytes = image.stats.peak_bytes;
        let start = Instant::now();

        let mut clock = Instant::now();
        if given.is_none() {
            gbuffer::trace(bvh, scene, width, height, &mut buffers.gbuffer);
        }
        let gbuffer = given.unwrap_or(&buffers.gbuffer);
        stats.stages_ms.gbuffer = lap(&mut clock);
        pyramid::build(gbuffer, refiner.coarsest_level(), &mut buffers.pyramid);
        stats.stages_ms.pyramid = lap(&mut clock);

        let frame = Frame {
            scene,
            gbuffer,
            pyramid: &buffers.pyramid,
            pattern: *pattern,
            sharing: builder.sampling.sharing,
            index: *index,
            seed: builder.seed,
        };
        visibility.prepare(&frame);
        let prepare_ms = lap(&mut clock);
        stats.stages_ms.visibility = prepare_ms;

        (image.width, image.height) = (width, height);
        image.irradiance.clear();
        image.irradiance.resize(pixels, Vec3::ZERO);
        // Matte scenes have no layer for it.
        image.specular.clear();
        image.specular.resize(gbuffer.specular.len(), Vec3::ZERO);
        if builder.layers {
            image.level.clear();
            image.level.resize(pixels, u8::MAX);
            for plane in [&mut buffers.totals.unshadowed, &mut buffers.totals.visible] {
                plane.clear();
                plane.resize(pixels, 0.0);
            }
        }
        let mut expected = Some(0.0);
        for number in 0..scene.lights.len() as u32 {
            clock = Instant::now();
            let mut requests = Requests::new(visibility.as_mut(), bvh);
            buffers.fragments.reset(width, height, number);
            let refined = refiner.refine(&frame, number, &mut requests, &mut buffers.fragments);
            let Requests { rays, masks_ms, certify_ms, refusal, .. } = requests;
            if let Some(refusal) = refusal {
                return Err(refusal.into());
            }
            buffers.fragments.validate(gbuffer)?;
            stats.rays += rays;
            stats.stages_ms.visibility += masks_ms;
            stats.stages_ms.certify += certify_ms;
            stats.stages_ms.refine += lap(&mut clock) - masks_ms - certify_ms;
            stats.certified += refined.certified;
            let levels = refined.levels.len().max(stats.levels.len());
            stats.levels.resize(levels, LevelWork::default());
            stats.levels.iter_mut().zip(refined.levels).for_each(|(sum, level)| *sum += *level);
            expected = expected.zip(refined.expected_error).map(|(sum, error)| sum + error);

            let fragments = &buffers.fragments;
            irradiance::evaluate(&frame, fragments, builder.shading, &refined, &mut buffers.values);
            stats.stages_ms.irradiance += lap(&mut clock);
            buffers.planes.reset(buffers.values.channels(), pixels);
            let planes = buffers.planes.all_mut();
            upsampler.upsample_channels(&frame, &buffers.fragments, &buffers.values, planes);
            stats.stages_ms.upsample += lap(&mut clock);

            let totals = builder.layers.then_some(&mut buffers.totals);
            let shading = builder.shading;
            let texture = SeenTexture::of(scene, number as usize);
            compose::add_light(
                &frame,
                number,
                shading,
                texture.as_ref(),
                &buffers.planes,
                &mut image.irradiance,
                totals,
            );
            stats.stages_ms.compose += lap(&mut clock);
            let lobes =
                (!image.specular.is_empty()).then(|| LobeLight::new(bvh, &frame, number, &buffers.fragments));
            if let Some(lobes) = &lobes {
                let (values, fractions) = (&buffers.values, builder.shading == Shading::Ratio);
                let out = &mut image.specular;
                stats.rays.specular +=
                    buffers.specular.add_light(lobes, &buffers.fragments, values, fractions, out);
                stats.stages_ms.specular += lap(&mut clock);
            }
            if let Some(antialias) = &mut antialias {
                if number == 0 {
                    // The only light is the whole irradiance.
                    // Edges before lights that the camera sees matter in the dark as well.
                    let whole = scene.lights.len() == 1 && !scene.lights[0].visible && indirect.is_none();
                    let irradiance = whole.then_some(&image.irradiance[..]);
                    antialias.prepare(bvh, &frame, builder.antialias, irradiance)?;
                }
                let mut requests = Requests::new(visibility.as_mut(), bvh);
                antialias.add_light(
                    &frame,
                    number,
                    shading,
                    texture.as_ref(),
                    &buffers.planes,
                    &mut requests,
                );
                stats.rays += requests.rays;
                if let Some(lobes) = &lobes {
                    stats.rays.specular += antialias.add_specular(lobes, &buffers.specular);
                }
                if let Some(refusal) = requests.refusal {
                    return Err(refusal.into());
                }
                stats.stages_ms.antialias += lap(&mut clock);
            }
            for (total, count) in stats.fragments.per_level.iter_mut().zip(buffers.fragments.per_level()) {
                *total += count;
            }
            for (total, count) in stats.fragments.cells.iter_mut().zip(buffers.fragments.cells_per_level()) {
                *total += count;
            }
            if builder.layers {
                merge_levels(gbuffer, &buffers.fragments, &mut image.level);
            }
        }
        image.indirect.clear();
        if let Some(stage) = indirect {
            clock = Instant::now();
            image.indirect.resize(pixels, Vec3::ZERO);
            let mut requests = Requests::new(visibility.as_mut(), bvh);
            let mut surroundings = Surroundings { frame: &frame, bvh, rest, requests: &mut requests };
            stats.indirect = stage.light(&mut surroundings, &mut image.indirect);
            stats.rays.skipped += requests.rays.skipped;
            if let Some(refusal) = requests.refusal {
                return Err(refusal.into());
            }
            stats.rays.indirect = stats.indirect.light_rays + stats.indirect.gather_rays;
            if let Some(antialias) = &mut antialias {
                antialias.add_indirect(&image.indirect, width as usize);
            }
            stats.stages_ms.indirect = lap(&mut clock);
        }
        stats.expected_nmse2 = expected.map(|error| {
            let energy: f64 = image.irradiance.iter().map(|rgb| f64::from(luminance(*rgb)).powi(2)).sum();
            if energy > 0.0 { error / energy } else { 0.0 }
        });
        image.radiance.clear();
        clock = Instant::now();
        image.emission.clear();
        let seen = SeenLights::new(scene, width, height);
        let parted = !(image.specular.is_empty() && image.indirect.is_empty());
        if antialias.is_some() || seen.is_some() || parted {
            let (irradiance, indirect) = (&image.irradiance, &image.indirect);
            compose::reflect(gbuffer, irradiance, indirect, &image.specular, &mut image.radiance);
        }
        if let Some(seen) = seen {
            let offsets = subpixel::offsets(builder.antialias)?;
            let traced = antialias.as_ref().map_or(&[][..], |antialias| antialias.traced());
            seen.add(gbuffer, offsets, traced, &mut image.radiance, &mut image.emission);
        }
        stats.stages_ms.compose += lap(&mut clock);
        if let Some(antialias) = &antialias {
            stats.antialias = antialias.resolve(&mut image.radiance, &mut image.emission);
            stats.stages_ms.antialias += lap(&mut clock);
        }
        stats.total_ms = start.elapsed().as_secs_f64() * 1e3;

        if builder.layers {
            let totals = buffers.totals.unshadowed.iter().zip(&buffers.totals.visible);
            image.visibility.clear();
            image
                .visibility
                .extend(totals.map(|(&all, &visible)| if all > 0.0 { visible / all } else { 0.0 }));
        }
        stats.fragments.total = stats.fragments.per_level.iter().sum();
        stats.rays.total = stats.rays.refine + stats.rays.last + stats.rays.specular + stats.rays.indirect;
        stats.visibility = visibility.stats();
        stats.visibility.prepare_ms = prepare_ms;
        let held = bvh.bytes()
            + buffers.bytes()
            + refiner.bytes()
            + visibility.bytes()
            + upsampler.bytes()
            + indirect.as_ref().map_or(0, |stage| stage.bytes())
            + (image.irradiance.capacity()
                + image.indirect.capacity()
                + image.radiance.capacity()
                + image.specular.capacity()
                + image.emission.capacity())
                * size_of::<Vec3>();
        stats.peak_bytes = stats.peak_bytes.max(held as u64);
        image.stats = stats;
        *index = index.wrapping_add(1);
        Ok(())
    }
}

impl Buffers {
    fn bytes(&self) -> usize {
        self.gbuffer.bytes()
            + self.pyramid.bytes()
            + self.fragments.bytes()
            + self.values.bytes()
            + self.planes.bytes()
            + self.specular.bytes()
            + self.antialias.bytes()
            + (self.totals.unshadowed.capacity() + self.totals.visible.capacity()) * 4
    }
}

/// Milliseconds since `clock`, which is set to now.
fn lap(clock: &mut Instant) -> f64 {
    let now = Instant::now();
    let ms = (now - *clock).as_secs_f64() * 1e3;
    *clock = now;
    ms
}

fn merge_levels(gbuffer: &GBuffer, fragments: &Fragments, levels: &mut [u8]) {
    for cell in fragments.cells() {
        let (x0, y0, x1, y1) = cell.pixels(fragments.width(), fragments.height());
        for y in y0..y1 {
            let row = gbuffer.index(x0, y)..gbuffer.index(x1, y);
            for (pixel, level) in row.clone().zip(&mut levels[row]) {
                if gbuffer.is_receiver(pixel) {
                    *level = cell.level.min(*level);
                }
            }
        }
    }
}
