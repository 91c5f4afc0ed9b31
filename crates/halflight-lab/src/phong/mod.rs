//! Phong pass of Nichols10 (§3.2.1, §3.3.3): a second multiresolution gather, for what glossy surfaces reflect of the lights.
//!
//! 1. Fragments are discarded where the mirrored direction misses the light and the lobe is weak towards all of its corners (`refine`).
//! 2. They are split by depth and normals, and where their distance is not below the lobe's width at the light.
//! 3. A fragment gathers from the light samples; where too few of them lie in the lobe, from a grid of directions inside the lobe, with means of the light's texture
//!    (`gather`).
//! 4. Light samples are seen or not. In the grid, distances of the nearest occluders are blurred over the fragments around, and Chebyshev's inequality
//!    bounds the visible part, as in variance shadow maps (`variance`).
//!
//! The exponent is that of equal width, n = 2 / α² − 2 with α = roughness², which is how `Ns` of material libraries is read. The lobe is normalised (Lafortune and
//! Willems 1994). Shadow rays are exact instead of marched through voxels. [`truth`] is what the pass comes to with more and more fragments and samples.

mod config;
mod gather;
mod lobe;
mod refine;
#[cfg(test)]
mod tests;
mod truth;
mod variance;

use std::time::Instant;

use glam::Vec3;
use halflight_core::fragment::LEVELS;
use halflight_core::frame::{Frame, Sharing};
use halflight_core::gbuffer::GBuffer;
use halflight_core::pattern::{Pattern, PatternError, PatternKind};
use halflight_core::pyramid::Pyramid;
use halflight_core::specular::SurfaceSpecular;
use halflight_core::values::Values;
use halflight_cpu::prepared::PreparedScene;
use halflight_cpu::upsample::{Bilinear, BilinearConfig};
use halflight_cpu::{gbuffer, pyramid};

pub use config::{LobeVisibility, PhongConfig, SpecularPass};
pub use truth::truth;

/// Level of pixels that no fragment was rendered for: discarded, or matte.
pub const NOT_RENDERED: u8 = u8::MAX;

/// Level of pixels whose fragment was discarded since the lobe misses the light.
pub const DISCARDED: u8 = u8::MAX - 1;

/// Result of the pass.
#[derive(Clone, Debug, Default)]
pub struct PhongFrame {
    /// Specularly reflected radiance of each pixel, W/m²/sr, row by row from the top left.
    pub radiance: Vec<Vec3>,
    /// Level of the fragment of each pixel, that of the last light; [`DISCARDED`] or [`NOT_RENDERED`] where there is none.
    pub levels: Vec<u8>,
    /// Fragments gathered at each level, all lights together, 0 first.
    pub rendered: [u64; LEVELS],
    /// Of these, fragments whose lobe was sampled by a grid.
    pub sampled: u64,
    /// Pixels of glossy surfaces, and those of them in discarded fragments, all lights together.
    pub glossy: u64,
    /// See [`PhongFrame::glossy`].
    pub discarded: u64,
    /// Shadow rays.
    pub rays: u64,
    /// Time of the pass without the G-buffer, ms.
    pub ms: f64,
}

/// Surfaces of a scene and what the pass needs of them.
pub struct Surfaces<'a> {
    scene: &'a PreparedScene,
    gbuffer: GBuffer,
    pyramid: Pyramid,
    seed: u32,
}

impl<'a> Surfaces<'a> {
    /// Traces what the camera of a scene sees.
    pub fn new(scene: &'a PreparedScene, [width, height]: [u32; 2], seed: u32) -> Self {
        let mut seen = GBuffer::default();
        gbuffer::trace(scene.bvh(), scene.scene(), width, height, &mut seen);
        Self { scene, gbuffer: seen, pyramid: Pyramid::default(), seed }
    }

    /// Surfaces that the pixels see.
    pub fn gbuffer(&self) -> &GBuffer {
        &self.gbuffer
    }

    /// Specular reflection of a pixel.
    fn specular(&self, pixel: usize) -> SurfaceSpecular {
        self.gbuffer.specular.get(pixel).copied().unwrap_or(SurfaceSpecular::MATTE)
    }

    fn frame(&self, pattern: Pattern) -> Frame<'_> {
        Frame {
            scene: self.scene.scene(),
            gbuffer: &self.gbuffer,
            pyramid: &self.pyramid,
            pattern,
            sharing: Sharing::Frame,
            index: 0,
            seed: self.seed,
        }
    }

    /// Runs the pass for all lights.
    ///
    /// # Errors
    /// The number of light samples is 0 or more than 4096.
    pub fn render(&mut self, config: &PhongConfig) -> Result<PhongFrame, PatternError> {
        let pattern = Pattern::with_count(PatternKind::Jittered, config.samples as usize)?;
        let start = Instant::now();
        pyramid::build(&self.gbuffer, config.coarsest_level, &mut self.pyramid);
        let pixels = self.gbuffer.pixels();
        let mut out = PhongFrame {
            radiance: vec![Vec3::ZERO; pixels],
            levels: vec![NOT_RENDERED; pixels],
            ..PhongFrame::default()
        };
        out.glossy = (0..pixels).filter(|&pixel| self.is_glossy(pixel)).count() as u64;
        let frame = self.frame(pattern);
        let mut upsampler = Bilinear::new(BilinearConfig::default());
        for number in 0..frame.scene.lights.len() as u32 {
            let light = gather::Light::new(self, &frame, number, config);
            let found = refine::refine(self, &light, config);
            let mut values = Values::default();
            values.reset(3, found.values.len());
            for channel in 0..3 {
                let of = found.values.iter().map(|value| value[channel]);
                values.channel_mut(channel).iter_mut().zip(of).for_each(|(to, value)| *to = value);
            }
            let mut planes = vec![0.0; 3 * pixels];
            halflight_core::stages::Upsampler::upsample_channels(
                &mut upsampler,
                &frame,
                &found.fragments,
                &values,
                &mut planes,
            );
            let radiance = frame.light(number).radiance;
            for (pixel, out) in out.radiance.iter_mut().enumerate() {
                let value = Vec3::new(planes[pixel], planes[pixels + pixel], planes[2 * pixels + pixel]);
                *out += radiance * self.specular(pixel).f0 * value;
            }
            for (sum, count) in out.rendered.iter_mut().zip(found.rendered) {
                *sum += count;
            }
            out.levels = found.levels;
            let lost = |pixel: &usize| out.levels[*pixel] == DISCARDED && self.is_glossy(*pixel);
            out.discarded += (0..pixels).filter(lost).count() as u64;
            out.sampled += found.sampled;
            out.rays += found.rays;
        }
        out.ms = start.elapsed().as_secs_f64() * 1e3;
        Ok(out)
    }

    /// Returns whether a pixel sees a glossy surface.
    fn is_glossy(&self, pixel: usize) -> bool {
        self.gbuffer.is_receiver(pixel) && !self.specular(pixel).is_matte()
    }
}
