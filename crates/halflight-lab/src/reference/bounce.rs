//! Converged indirect light of exactly one diffuse reflection.
//!
//! A pass sends one ray from each pixel's receiver, distributed as the cosine to the shading normal, and finds the direct irradiance `E` of the
//! surface that it hits: for every light `U · Σ g V / Σ g` over [`LIGHT_SAMPLES`] jittered samples with exact masks and the analytic unshadowed
//! irradiance `U`. The surface reflects `albedo/π · E` to everywhere, so that the pass estimates the indirect irradiance as `π · albedo/π · E`.
//! The ratio has a bias, which falls with the number of light samples and is confined to hits in a penumbra.
//!
//! | part | rule |
//! | --- | --- |
//! | directions | R2 sequence (Roberts 2018), shifted by a hash of pixel, half and seed |
//! | directions below the geometric horizon of a smooth surface | no light |
//! | hits | nearest surface, by exact arithmetic as for primary rays; glossy surfaces reflect their diffuse part alone |
//! | lights | never hit, since they are no geometry; flush ones are moved as in a frame |
//! | halves | even and odd passes, with shifts of their own: their difference tells the noise |
//!
//! The state is saved as that of a [`reference`](super::reference()) is.

use std::f64::consts::TAU;
use std::hash::Hasher as _;
use std::path::Path;
use std::sync::Arc;

use fnv::FnvHasher;
use glam::Vec3;
use halflight_core::frame::{Frame, LightSampling, Sharing};
use halflight_core::gbuffer::GBuffer;
use halflight_core::hash;
use halflight_core::pattern::{PatternError, PatternKind};
use halflight_core::pyramid::Pyramid;
use halflight_core::scene::Scene;
use halflight_cpu::bvh::Bvh;
use halflight_cpu::flush;
use halflight_cpu::gbuffer;
use halflight_cpu::pipeline::PipelineError;
use halflight_cpu::prepared::PreparedScene;
use halflight_cpu::unshadowed::unshadowed_many;
use halflight_image::memory;
use halflight_metrics::{Image, flicker, halves_noise, luminance};
use rayon::prelude::*;

use super::state::{self, State};
use super::tracer::LightTracer;
use super::{MAX_SAMPLES, ReferenceConfig, ReferenceError, every_pixel, is_black, receivers, seen};

/// Light samples of a hit and light.
pub const LIGHT_SAMPLES: u32 = 16;

/// Passes after which the state is saved.
const SAVE_EVERY: u32 = 64;

/// Distinguishes the random numbers of directions from those of light samples.
const DIRECTIONS: u32 = 0x51f1_5eed;

/// Steps of the R2 sequence: 1/g and 1/g² of the root g of g³ = g + 1.
const STEPS: [f64; 2] = [0.754_877_666_246_692_7, 0.569_840_290_998_053_2];

/// Planes of sums a half: red and green, and blue.
const PLANES: usize = 2;

/// Hits whose unshadowed irradiance is one task.
const CHUNK: usize = 1024;

/// Bytes a pixel beside those of a frame: sums of both halves and their copy on the way to the disk, the G-buffer of the hits, directions and light.
const BYTES: u64 = 2 * 2 * 16 * PLANES as u64 + 160;

/// Indirect irradiance of exactly one diffuse reflection, with an estimate of its noise.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OneBounce {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Irradiance per channel, W/m², at pixels' centres; zero where nothing is seen.
    pub irradiance: Vec<Vec3>,
    /// Rays over the hemisphere of each pixel; more than asked for where the cache had more.
    pub rays: u32,
    /// Estimated NMSE₂ against the true image, from two independent halves; 0 where no light arrives at all.
    pub noise_nmse2: f64,
    /// Estimated NMSE₂ of the luminance.
    pub noise_luminance: f64,
    /// Estimated mean [`flicker`](flicker()) that its noise makes from frame to frame, where frames have rays of their own.
    pub noise_flicker: f64,
}

/// Returns an image of the luminance of each pixel, in all channels.
pub fn luminances(pixels: &[Vec3]) -> Vec<Vec3> {
    pixels.iter().map(|&pixel| Vec3::splat(luminance(pixel.into()) as f32)).collect()
}

/// Computes the indirect irradiance of one diffuse reflection, or takes it from `cache_dir` (created if it is missing), under the rules of
/// [`reference`](super::reference()). `config.samples` are the rays of each pixel, rounded up to whole pairs; its sub-samples are not used, since irradiance is that of
/// pixels' centres. `progress` is told how many rays a pixel are done, and of how many.
///
/// # Errors
/// The scene or size cannot be rendered, memory does not suffice, or the state cannot be read or saved.
pub fn one_bounce(
    prepared: &PreparedScene,
    config: &ReferenceConfig,
    cache_dir: Option<&Path>,
    progress: &mut dyn FnMut(u32, u32),
) -> Result<OneBounce, ReferenceError> {
    let &ReferenceConfig { width, height, samples, seed, .. } = config;
    if samples == 0 || samples > MAX_SAMPLES {
        return Err(ReferenceError::Samples(samples));
    }
    // Sizes and scenes that a pipeline would refuse are refused here as well.
    every_pixel(width, height).builder(prepared).build()?;
    let own = BYTES.saturating_mul(u64::from(width) * u64::from(height));
    memory::check(
        format!("a reference of indirect light of {width}x{height} pixels"),
        every_pixel(width, height).bytes_needed().saturating_add(own),
    )?;
    let (scene, bvh) = (prepared.scene(), prepared.bvh());
    let seen = seen(prepared, [width, height]);
    let (lights, _) = flush::separate_lights(scene, Some(bvh));
    let scene = &Scene { lights, ..Scene::clone(scene) };

    let key = key(scene, config);
    let path = cache_dir.map(|folder| folder.join(format!("indirect-{key:016x}.state")));
    let mut state = State::new(key, seen.pixels(), PLANES);
    if let Some(path) = &path {
        state.load(path)?;
    }
    let wanted = samples.div_ceil(2) * 2;
    progress(state.passes.min(wanted), wanted);
    if let Some(path) = path.as_ref().filter(|_| state.passes < wanted) {
        State::check_path(path)?;
    }
    let mut tracer = BounceTracer::new(scene, bvh, &seen, seed);
    while state.passes < wanted {
        tracer.pass(&mut state).map_err(PipelineError::from)?;
        if let Some(path) = &path
            && (state.passes.is_multiple_of(SAVE_EVERY) || state.passes == wanted)
        {
            state.save(path)?;
        }
        progress(state.passes, wanted);
    }
    finish(&seen, &state)
}

/// Stages and buffers that are kept between passes.
struct BounceTracer<'a> {
    scene: &'a Scene,
    bvh: &'a Bvh,
    seen: &'a GBuffer,
    seed: u32,
    lights: LightTracer,
    pyramid: Pyramid,
    /// Directions of the pixels' rays; zero where there is none.
    directions: Vec<Vec3>,
    hits: GBuffer,
    /// Unshadowed irradiance of a light at the hits, per unit radiance.
    unshadowed: Vec<f32>,
    /// Direct irradiance at the hits, W/m².
    irradiance: Vec<Vec3>,
}

impl<'a> BounceTracer<'a> {
    fn new(scene: &'a Scene, bvh: &'a Arc<Bvh>, seen: &'a GBuffer, seed: u32) -> Self {
        let pixels = seen.pixels();
        Self {
            scene,
            bvh,
            seen,
            seed,
            lights: LightTracer::new(bvh),
            pyramid: Pyramid::default(),
            directions: vec![Vec3::ZERO; pixels],
            hits: GBuffer::default(),
            unshadowed: vec![0.0; pixels],
            irradiance: vec![Vec3::ZERO; pixels],
        }
    }

    /// Adds one ray a pixel to its half.
    fn pass(&mut self, state: &mut State) -> Result<(), PatternError> {
        let (seen, pass, seed) = (self.seen, state.passes, self.seed);
        let directions = self.directions.par_iter_mut().enumerate().with_min_len(256);
        directions.for_each(|(pixel, out)| *out = direction(seen, pixel, pass, seed));
        gbuffer::trace_rays(self.bvh, self.scene, &seen.position, &self.directions, &mut self.hits);
        // One entry a ray; refiners keep columns and rows in 16 bits.
        (self.hits.width, self.hits.height) = (seen.width, seen.height);
        self.light_hits(pass)?;
        let half = (pass % 2) as usize;
        let reflected = |pixel: usize| (self.irradiance[pixel] * self.hits.albedo[pixel]).as_dvec3();
        for (pixel, total) in state.totals_mut(half, 0).iter_mut().enumerate() {
            let light = reflected(pixel);
            (total[0], total[1]) = (total[0] + light.x, total[1] + light.y);
        }
        for (pixel, total) in state.totals_mut(half, 1).iter_mut().enumerate() {
            total[0] += reflected(pixel).z;
        }
        state.passes += 1;
        Ok(())
    }

    /// Computes the direct irradiance at the hits.
    fn light_hits(&mut self, pass: u32) -> Result<(), PatternError> {
        let sampling =
            LightSampling { count: LIGHT_SAMPLES, kind: PatternKind::Jittered, sharing: Sharing::Receiver };
        let frame = Frame {
            scene: self.scene,
            gbuffer: &self.hits,
            pyramid: &self.pyramid,
            pattern: sampling.pattern()?,
            sharing: sampling.sharing,
            index: pass,
            seed: self.seed,
        };
        self.irradiance.fill(Vec3::ZERO);
        for (number, light) in self.scene.lights.iter().enumerate() {
            let normals = self.hits.shading_normals().par_chunks(CHUNK);
            let receivers = self.hits.position.par_chunks(CHUNK).zip(normals);
            let chunks = self.unshadowed.par_chunks_mut(CHUNK).zip(receivers);
            chunks.for_each(|(out, (origins, normals))| unshadowed_many(light, origins, normals, out));
            for &(pixel, sums, visible) in self.lights.trace(&frame, number) {
                let pixel = pixel as usize;
                if sums.all > 0.0 {
                    self.irradiance[pixel] += light.radiance * visible * (self.unshadowed[pixel] / sums.all);
                }
            }
        }
        Ok(())
    }
}

/// Returns the direction of a pixel's ray in a pass, unit length, distributed as the cosine to the shading normal; zero where nothing is seen and below the geometric horizon.
fn direction(seen: &GBuffer, pixel: usize, pass: u32, seed: u32) -> Vec3 {
    let Some(receiver) = seen.receiver(pixel) else { return Vec3::ZERO };
    let key = hash::fold(hash::pattern_key(pixel as u32, pass % 2, 0, seed), DIRECTIONS);
    let number = f64::from(pass / 2);
    let [along, around] = [0, 1].map(|axis| {
        let shift = f64::from(hash::sample_bits(key, axis as u32)) / 4_294_967_296.0;
        (shift + number * STEPS[axis]).fract()
    });
    let normal = receiver.normal.as_dvec3();
    let (right, up) = normal.any_orthonormal_pair();
    let (sine, cosine) = (around * TAU).sin_cos();
    let direction = (right * cosine + up * sine) * along.sqrt() + normal * (1.0 - along).sqrt();
    let direction = direction.as_vec3();
    if direction.dot(seen.normal[pixel]) > 0.0 { direction } else { Vec3::ZERO }
}

/// Returns the image of all passes, with the noise that its halves tell of.
fn finish(seen: &GBuffer, state: &State) -> Result<OneBounce, ReferenceError> {
    let image = |halves: &[usize]| -> Vec<Vec3> {
        let rays = f64::from(state.passes / 2) * halves.len() as f64;
        let pixel = |pixel: usize| {
            let total = |plane: usize, side: usize| -> f32 {
                let sums = halves.iter().map(|&half| state.totals(half, plane)[pixel][side]);
                (sums.sum::<f64>() / rays) as f32
            };
            Vec3::new(total(0, 0), total(0, 1), total(1, 0))
        };
        (0..seen.pixels()).into_par_iter().map(pixel).collect()
    };
    let irradiance = image(&[0, 1]);
    let found = OneBounce {
        width: seen.width,
        height: seen.height,
        irradiance,
        rays: state.passes,
        noise_nmse2: 0.0,
        noise_luminance: 0.0,
        noise_flicker: 0.0,
    };
    if is_black(&found.irradiance) {
        return Ok(found);
    }
    let mut halves = [image(&[0]), image(&[1])];
    // Of what only one half has met, noise is measured against that half.
    if is_black(&halves[1]) {
        halves.swap(0, 1);
    }
    let mask = receivers(seen);
    let view = |pixels| Image::new(seen.width, seen.height, pixels)?.with_mask(&mask);
    let (half, other, mean) = (view(&halves[0])?, view(&halves[1])?, view(&found.irradiance)?);
    // The halves differ by twice the error of their mean, frames by √2 of it.
    let noise_flicker = flicker([half, mean], [other, mean])?.mean / 2f64.sqrt();
    let noise_nmse2 = halves_noise(half, other)?;
    let grey = [luminances(&halves[0]), luminances(&halves[1])];
    let noise_luminance = halves_noise(view(&grey[0])?, view(&grey[1])?)?;
    Ok(OneBounce { noise_nmse2, noise_luminance, noise_flicker, ..found })
}

/// Returns a hash of all that the samples depend on: what a reference depends on, and what surfaces reflect.
fn key(scene: &Scene, config: &ReferenceConfig) -> u64 {
    let mesh = &scene.mesh;
    let mut hash = FnvHasher::default();
    hash.write(b"one bounce 1");
    hash.write(&state::key(scene, config).to_le_bytes());
    write_words(&mut hash, &[LIGHT_SAMPLES, mesh.normals.len() as u32, mesh.textures.len() as u32]);
    write_words(&mut hash, &mesh.material_ids);
    for normal in &mesh.normals {
        write_words(&mut hash, &normal.to_array().map(f32::to_bits));
    }
    if !mesh.textures.is_empty() {
        for uv in &mesh.uvs {
            write_words(&mut hash, &uv.to_array().map(f32::to_bits));
        }
    }
    for texture in &mesh.textures {
        write_words(&mut hash, &[texture.width, texture.height]);
        hash.write(texture.texels.as_flattened());
    }
    hash.write(format!("{:?}", mesh.materials).as_bytes());
    hash.finish()
}

fn write_words(hash: &mut FnvHasher, values: &[u32]) {
    values.iter().for_each(|value| hash.write(&value.to_le_bytes()));
}
