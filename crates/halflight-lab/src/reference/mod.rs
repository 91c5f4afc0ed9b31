//! Converged references: every pixel its own light samples, pass after pass, until the noise is low enough.
//!
//! A pass gives each pixel [`PASS`] jittered samples per light under a key of its own, and adds `Σ g V` and `Σ g` in
//! double precision. The irradiance is `U · Σ g V / Σ g` with the analytic unshadowed irradiance `U`: a ratio of sums
//! over all passes, whose bias falls with their number (Heitz, Hill, McGuire 2018). Even and odd passes are kept apart:
//! two independent halves, from whose difference the noise of the whole is estimated.
//!
//! The state is saved while a reference is computed, and one that was stopped goes on bit for bit as if it had not been.

use std::f32::consts::FRAC_1_PI;
use std::path::{Path, PathBuf};

use glam::Vec3;
use halflight_core::frame::LightSampling;
use halflight_core::gbuffer::GBuffer;
use halflight_core::light::AreaLight;
use halflight_core::scene::Scene;
use halflight_core::subpixel;
use halflight_cpu::config::{PipelineConfig, RefinerConfig};
use halflight_cpu::flush;
use halflight_cpu::gbuffer;
use halflight_cpu::pipeline::PipelineError;
use halflight_cpu::prepared::PreparedScene;
use halflight_cpu::textured::SeenTexture;
use halflight_cpu::unshadowed::unshadowed;
use halflight_metrics::{
    CompareError, Image, ImageError, WriteError, flicker, grain, halves_noise, luminance,
};
use rayon::prelude::*;

use halflight_image::memory::{self, NotEnough};
use state::{State, planes};
use tracer::Tracer;

pub mod bounce;
mod state;
mod tracer;
pub mod unlit;
pub mod voxel_errors;

/// Largest number of samples that can be asked for.
pub const MAX_SAMPLES: u32 = 1 << 30;

/// Passes after which the state is saved.
const SAVE_EVERY: u32 = 4;

/// Seed of references. Configurations under test have small seeds, so that they share no light sample with it.
pub const SEED: u32 = 0x5eed_0000;

/// Light samples a pixel and pass: the more in one stratified pattern, the lower the noise of as many rays.
pub const PASS: u32 = 256;

/// Size, samples and seed of a reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ReferenceConfig {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Light samples a pixel and light, rounded up to whole pairs of passes of [`PASS`].
    pub samples: u32,
    /// Seed of the light samples; [`SEED`] by default. Must not be that of a configuration under test.
    pub seed: u32,
    /// Sub-samples of every pixel, each with its own share of the light samples: 1 (the pixel's centre), 4, 8 or 16.
    pub antialias: u32,
}

impl ReferenceConfig {
    /// Returns about how many bytes a reference of a scene with this many lights takes.
    fn bytes_needed(&self, lights: usize) -> u64 {
        /// Bytes a pixel and light: sums of both halves, and their copy on the way to the disk.
        const SUMS: u64 = 2 * 2 * 16;
        let sampling = LightSampling { count: PASS, ..LightSampling::default() };
        let config = PipelineConfig { sampling, ..every_pixel(self.width, self.height) };
        let pixels = u64::from(self.width) * u64::from(self.height);
        config.bytes_needed().saturating_add(pixels.saturating_mul(SUMS).saturating_mul(lights as u64))
    }
}

impl Default for ReferenceConfig {
    fn default() -> Self {
        Self { width: 640, height: 480, samples: 4096, seed: SEED, antialias: 1 }
    }
}

/// Converged image with an estimate of the noise that is left.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reference {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Irradiance per channel, W/m²; zero where nothing is seen.
    pub irradiance: Vec<Vec3>,
    /// Visible fraction of the unshadowed light, `ΣUF/ΣU` by luminance; zero where no light could arrive.
    pub visibility: Vec<f32>,
    /// Mean of the radiance over a pixel's sub-samples, W/m²/sr: albedo/π · irradiance, what is reflected specularly, and lights that the camera sees. Empty where
    /// the only one is its centre and it is albedo/π · irradiance.
    pub radiance: Vec<Vec3>,
    /// Light samples a pixel and light; more than asked for where the cache had more.
    pub samples: u32,
    /// Estimated NMSE₂ against the true image, from the two halves; 0 where no light arrives at all.
    pub noise_nmse2: f64,
    /// Estimated mean [`flicker`](flicker()) that its noise makes from frame to frame, where frames have samples of
    /// their own; from the two halves.
    pub noise_flicker: f64,
    /// Estimated [`grain`](grain()) that its noise makes, from the two halves; `None` where no pixel lies in a penumbra.
    pub noise_grain: Option<f64>,
}

/// Reason why there is no reference.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReferenceError {
    /// The scene, size or number of samples cannot be rendered.
    #[error(transparent)]
    Pipeline(#[from] PipelineError),
    /// No samples, or more than can be counted.
    #[error("{0} samples asked for; a reference has 1 to {max}", max = MAX_SAMPLES)]
    Samples(u32),
    /// The noise cannot be told, since a pixel is not finite.
    #[error("the noise of the reference cannot be told: {0}")]
    Noise(#[from] CompareError),
    /// The halves are no images, which cannot be at a size that the pipeline accepts.
    #[error(transparent)]
    Image(#[from] ImageError),
    /// The image does not fit into memory.
    #[error("{0}; choose a smaller --size")]
    Memory(#[from] NotEnough),
    /// The state cannot be read or is damaged.
    #[error("cannot go on from the saved state {}: {message}; remove the file to start again", path.display())]
    State {
        /// The file.
        path: PathBuf,
        /// Fault of the state.
        message: String,
    },
    /// The state cannot be saved.
    #[error("the state of the reference cannot be saved: {0}")]
    Write(#[from] WriteError),
}

/// Computes a reference, or takes it from `cache_dir` (created if it is missing), where its state is kept under a name
/// made of the content of scene, size and seed. One with at least as many samples is returned as it is; one with fewer
/// is continued. `progress` is told how many samples a pixel are done, and of how many. An image that no light reaches is
/// black and has no noise. With sub-samples, the state of each is kept.
///
/// # Errors
/// The scene or size cannot be rendered, memory does not suffice, or the state cannot be read or saved.
pub fn reference(
    prepared: &PreparedScene,
    config: &ReferenceConfig,
    cache_dir: Option<&Path>,
    progress: &mut dyn FnMut(u32, u32),
) -> Result<Reference, ReferenceError> {
    let &ReferenceConfig { width, height, samples, antialias, .. } = config;
    if samples == 0 || samples > MAX_SAMPLES {
        return Err(ReferenceError::Samples(samples));
    }
    let offsets = subpixel::offsets(antialias).map_err(PipelineError::from)?;
    if antialias == 1 {
        let mut reference = of_centres(prepared, config, cache_dir, progress)?;
        reference.radiance = match other_light(prepared, config)? {
            None => Vec::new(),
            Some(others) => {
                let seen = seen(prepared, [width, height]);
                let diffuse = reference.irradiance.iter().zip(&seen.albedo);
                let pairs = diffuse.map(|(&light, &albedo)| light * albedo * FRAC_1_PI).zip(others);
                pairs.map(|(diffuse, others)| others.with(diffuse)).collect()
            }
        };
        return Ok(reference);
    }
    let share = ReferenceConfig { samples: samples.div_ceil(antialias), antialias: 1, ..*config };
    let pixels = width as usize * height as usize;
    let mut mean = Reference { width, height, ..Reference::default() };
    (mean.irradiance, mean.radiance) = (vec![Vec3::ZERO; pixels], vec![Vec3::ZERO; pixels]);
    mean.visibility = vec![0.0; pixels];
    let weight = 1.0 / antialias as f32;
    for (number, &offset) in (0..).zip(offsets) {
        let mut scene = prepared.scene().clone();
        scene.camera = subpixel::shifted(&scene.camera, offset, width, height);
        let shifted = prepared.moved(scene).map_err(PipelineError::from)?;
        let part = of_centres(&shifted, &share, cache_dir, &mut |done, all| {
            progress(number * all + done, antialias * all);
        })?;
        let (seen, others) = (seen(&shifted, [width, height]), other_light(&shifted, &share)?);
        for (pixel, &light) in part.irradiance.iter().enumerate() {
            mean.irradiance[pixel] += light * weight;
            mean.visibility[pixel] += part.visibility[pixel] * weight;
            let diffuse = seen.albedo[pixel] * light * (FRAC_1_PI * weight);
            mean.radiance[pixel] += match &others {
                None => diffuse,
                Some(others) => others[pixel].with(diffuse / weight) * weight,
            };
        }
        mean.samples += part.samples;
        // Errors of the parts are independent.
        mean.noise_nmse2 += part.noise_nmse2 / f64::from(antialias * antialias);
        mean.noise_flicker += part.noise_flicker / f64::from(antialias).powf(1.5);
    }
    Ok(mean)
}

/// Computes a reference of the pixels' centres.
fn of_centres(
    prepared: &PreparedScene,
    config: &ReferenceConfig,
    cache_dir: Option<&Path>,
    progress: &mut dyn FnMut(u32, u32),
) -> Result<Reference, ReferenceError> {
    let &ReferenceConfig { width, height, samples, seed, .. } = config;
    // Whatever a pipeline would refuse, a reference refuses as well.
    every_pixel(width, height).builder(prepared).build()?;
    let (scene, bvh) = (prepared.scene(), prepared.bvh());
    let what = format!("a reference of {width}x{height} pixels under {} lights", scene.lights.len());
    memory::check(what, config.bytes_needed(planes(scene, scene.lights.len()).start))?;
    let seen = seen(prepared, [width, height]);
    let (lights, _) = flush::separate_lights(scene, Some(bvh));
    let scene = &Scene { lights, ..Scene::clone(scene) };

    let key = state::key(scene, config);
    let path = cache_dir.map(|folder| folder.join(format!("reference-{key:016x}.state")));
    let mut state = State::new(key, seen.pixels(), planes(scene, scene.lights.len()).start);
    if let Some(path) = &path {
        state.load(path)?;
    }

    let wanted = samples.div_ceil(2 * PASS) * 2;
    progress(state.passes.min(wanted) * PASS, wanted * PASS);
    if let Some(path) = path.as_ref().filter(|_| state.passes < wanted) {
        State::check_path(path)?;
    }
    let mut tracer = Tracer::new(scene, bvh, &seen, seed);
    while state.passes < wanted {
        tracer.pass(&mut state).map_err(PipelineError::from)?;
        if let Some(path) = &path
            && (state.passes.is_multiple_of(SAVE_EVERY) || state.passes == wanted)
        {
            state.save(path)?;
        }
        progress(state.passes * PASS, wanted * PASS);
    }
    finish(scene, &seen, &state)
}

/// Light of a pixel beside what it reflects diffusely.
#[derive(Clone, Copy)]
struct OtherLight {
    specular: Vec3,
    /// Radiance of a light that is seen before the surface; zero where none is.
    emission: Vec3,
}

impl OtherLight {
    /// Radiance of the pixel.
    fn with(&self, diffuse: Vec3) -> Vec3 {
        if self.emission == Vec3::ZERO { diffuse + self.specular } else { self.emission }
    }
}

/// Renders what pixels' centres receive beside diffuse light, with as many rays a lobe as the reference has samples, 4,096 at most. None of scenes that are
/// matte and whose lights are not seen.
fn other_light(
    prepared: &PreparedScene,
    config: &ReferenceConfig,
) -> Result<Option<Vec<OtherLight>>, ReferenceError> {
    let scene = prepared.scene();
    if !(scene.mesh.is_glossy() || scene.lights.iter().any(|light| light.visible)) {
        return Ok(None);
    }
    let sampling = LightSampling { count: config.samples.clamp(64, 4096), ..LightSampling::default() };
    let pipeline = PipelineConfig { sampling, antialias: 1, ..every_pixel(config.width, config.height) };
    let mut pipeline = pipeline.builder(prepared).seed(config.seed).build()?;
    let image = pipeline.render()?;
    let of = |plane: &[Vec3], pixel: usize| plane.get(pixel).copied().unwrap_or(Vec3::ZERO);
    let pixel =
        |pixel| OtherLight { specular: of(&image.specular, pixel), emission: of(&image.emission, pixel) };
    Ok(Some((0..image.irradiance.len()).map(pixel).collect()))
}

fn every_pixel(width: u32, height: u32) -> PipelineConfig {
    PipelineConfig { width, height, refiner: RefinerConfig::PerPixel, ..PipelineConfig::default() }
}

/// Returns the image of all passes, with the noise that its halves tell of.
fn finish(scene: &Scene, seen: &GBuffer, state: &State) -> Result<Reference, ReferenceError> {
    let image = |halves: &[usize]| -> Vec<Vec3> {
        let pixel = |pixel: usize| {
            let Some(receiver) = seen.receiver(pixel) else { return Vec3::ZERO };
            let light = |(number, light): (usize, &AreaLight)| {
                let fraction = |plane: usize| {
                    let total = |side: usize| -> f64 {
                        halves.iter().map(|&half| state.totals(half, plane)[pixel][side]).sum()
                    };
                    let (visible, all) = (total(0), total(1));
                    if all > 0.0 { (visible / all) as f32 } else { 0.0 }
                };
                let planes = planes(scene, number);
                let fractions = if planes.len() == 3 {
                    Vec3::from_array([0, 1, 2].map(|channel| fraction(planes.start + channel)))
                } else {
                    Vec3::splat(fraction(planes.start))
                };
                light.radiance * (unshadowed(light, receiver.origin, receiver.normal) * fractions)
            };
            scene.lights.iter().enumerate().map(light).sum()
        };
        (0..seen.pixels()).into_par_iter().map(pixel).collect()
    };
    let whole = image(&[0, 1]);
    let mut reference = Reference {
        width: seen.width,
        height: seen.height,
        samples: state.passes * PASS,
        noise_nmse2: 0.0,
        noise_flicker: 0.0,
        noise_grain: None,
        visibility: visible_fractions(scene, seen, &whole),
        irradiance: whole,
        radiance: Vec::new(),
    };
    if is_black(&reference.irradiance) {
        return Ok(reference);
    }
    let mut halves = [image(&[0]), image(&[1])];
    // Of what only one half has met, noise is measured against that half.
    if is_black(&halves[1]) {
        halves.swap(0, 1);
    }
    let mask = receivers(seen);
    let view = |pixels| Image::new(seen.width, seen.height, pixels)?.with_mask(&mask);
    let (half, other, mean) = (view(&halves[0])?, view(&halves[1])?, view(&reference.irradiance)?);
    // The halves differ by twice the error of their mean, frames by √2 of it.
    let noise_flicker = flicker([half, mean], [other, mean])?.mean / 2f64.sqrt();
    let noise_nmse2 = halves_noise(half, other)?;
    // As in the flicker, the difference is twice the error of the mean.
    let noise_grain =
        grain(half, other.with_visible_fractions(&reference.visibility)?)?.map(|grain| 0.5 * grain);
    (reference.noise_flicker, reference.noise_nmse2) = (noise_flicker, noise_nmse2);
    reference.noise_grain = noise_grain;
    Ok(reference)
}

/// Returns the visible fraction of the unshadowed light at each pixel of an image.
fn visible_fractions(scene: &Scene, seen: &GBuffer, irradiance: &[Vec3]) -> Vec<f32> {
    let textures: Vec<Option<SeenTexture>> =
        (0..scene.lights.len()).map(|light| SeenTexture::of(scene, light)).collect();
    let fraction = |(pixel, visible): (usize, &Vec3)| {
        let receiver = seen.receiver(pixel)?;
        let all = |(number, light): (usize, &AreaLight)| {
            let texture = textures[number]
                .as_ref()
                .map_or(Vec3::ONE, |texture| texture.mean_seen(receiver.origin, receiver.normal));
            light.radiance * texture * unshadowed(light, receiver.origin, receiver.normal)
        };
        let all = luminance(scene.lights.iter().enumerate().map(all).sum::<Vec3>().into());
        (all > 0.0).then(|| (luminance((*visible).into()) / all) as f32)
    };
    irradiance.par_iter().enumerate().map(|pixel| fraction(pixel).unwrap_or(0.0)).collect()
}

/// Returns the G-buffer of a scene's camera at a size.
pub fn seen(scene: &PreparedScene, [width, height]: [u32; 2]) -> GBuffer {
    let mut seen = GBuffer::default();
    gbuffer::trace(scene.bvh(), scene.scene(), width, height, &mut seen);
    seen
}

/// Returns which pixels see geometry.
pub fn receivers(seen: &GBuffer) -> Vec<bool> {
    (0..seen.pixels()).map(|pixel| seen.is_receiver(pixel)).collect()
}

fn is_black(pixels: &[Vec3]) -> bool {
    pixels.iter().all(|&pixel| pixel == Vec3::ZERO)
}
