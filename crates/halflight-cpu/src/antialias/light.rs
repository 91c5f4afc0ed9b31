//! Light of sub-samples: the visible fraction of each one's source times its own unshadowed irradiance and albedo.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;
use halflight_core::gbuffer::GBuffer;
use halflight_core::light::AreaLight;
use halflight_core::values::Values;

use super::sources::Source;
use crate::irradiance::Shading;
use crate::unshadowed::unshadowed_many;

/// Sub-samples that are lit together.
const BLOCK: usize = 64;

/// Largest factor by which an irradiance that was sampled elsewhere is scaled: at grazing incidence it may be much smaller there.
const MOST_SCALE: f32 = 2.0;

/// Sums over the sub-samples of a pixel.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sums {
    /// Irradiance, W/m².
    pub(super) irradiance: Vec3,
    /// Albedo/π times irradiance, W/m²/sr.
    pub(super) radiance: Vec3,
}

/// Values of one light that sub-samples take.
pub(super) struct Lit<'a> {
    pub(super) light: &'a AreaLight,
    pub(super) shading: Shading,
    /// Surfaces and values of the pixels.
    pub(super) gbuffer: &'a GBuffer,
    pub(super) planes: &'a Values,
    /// Surfaces of the sub-samples, and values of those that have masks of their own.
    pub(super) samples: &'a GBuffer,
    pub(super) own: &'a [f32],
}

/// Sub-samples that wait for their unshadowed irradiance.
struct Block {
    count: usize,
    pixel: [usize; BLOCK],
    origins: [Vec3; BLOCK],
    normals: [Vec3; BLOCK],
    albedo: [Vec3; BLOCK],
    /// Values of the sources, by channel.
    values: [Vec3; BLOCK],
    source_origins: [Vec3; BLOCK],
    source_normals: [Vec3; BLOCK],
}

impl Lit<'_> {
    /// Adds the light to the sums of some pixels, whose first sub-sample is `first`; `sources` has as many for each pixel.
    pub(super) fn add(&self, first: usize, sources: &[Source], sums: &mut [Sums]) {
        let count = sources.len() / sums.len().max(1);
        let (samples, normals) = (self.samples, self.samples.shading_normals());
        let mut block = Block {
            count: 0,
            pixel: [0; BLOCK],
            origins: [Vec3::ZERO; BLOCK],
            normals: [Vec3::ZERO; BLOCK],
            albedo: [Vec3::ZERO; BLOCK],
            values: [Vec3::ZERO; BLOCK],
            source_origins: [Vec3::ZERO; BLOCK],
            source_normals: [Vec3::ZERO; BLOCK],
        };
        for (at, &source) in sources.iter().enumerate() {
            let (values, source_surfaces, entry) = match source {
                Source::Whole | Source::Background => continue,
                Source::Pixel(pixel) => (self.pixel_value(pixel as usize), self.gbuffer, pixel as usize),
                Source::Own(other) => {
                    let entry = first + at / count * count + usize::from(other);
                    (Vec3::splat(self.own[entry]), samples, entry)
                }
            };
            // In the umbra it does not matter how much light there would be.
            if values == Vec3::ZERO {
                continue;
            }
            let lane = block.count;
            block.pixel[lane] = at / count;
            block.origins[lane] = samples.position[first + at];
            block.normals[lane] = normals[first + at];
            block.albedo[lane] = samples.albedo[first + at];
            block.values[lane] = values;
            if self.shading == Shading::Sampled {
                block.source_origins[lane] = source_surfaces.position[entry];
                block.source_normals[lane] = source_surfaces.shading_normals()[entry];
            }
            block.count += 1;
            if block.count == BLOCK {
                self.flush(&mut block, sums);
            }
        }
        self.flush(&mut block, sums);
    }

    /// Value of a pixel, by channel.
    fn pixel_value(&self, pixel: usize) -> Vec3 {
        let channel = |channel| self.planes.channel(channel)[pixel];
        match self.planes.channels() {
            3 => Vec3::new(channel(0), channel(1), channel(2)),
            _ => Vec3::splat(channel(0)),
        }
    }

    /// Adds the light of the sub-samples of a block, and empties it.
    fn flush(&self, block: &mut Block, sums: &mut [Sums]) {
        let count = std::mem::take(&mut block.count);
        let (mut unshadowed, mut at_source) = ([0.0f32; BLOCK], [0.0f32; BLOCK]);
        let light = self.light;
        unshadowed_many(light, &block.origins[..count], &block.normals[..count], &mut unshadowed[..count]);
        if self.shading == Shading::Sampled {
            let (origins, normals) = (&block.source_origins[..count], &block.source_normals[..count]);
            unshadowed_many(light, origins, normals, &mut at_source[..count]);
        }
        for lane in 0..count {
            let factor = match self.shading {
                Shading::Ratio => unshadowed[lane],
                Shading::Sampled if at_source[lane] > 0.0 => {
                    (unshadowed[lane] / at_source[lane]).min(MOST_SCALE)
                }
                Shading::Sampled => 1.0,
            };
            let irradiance = light.radiance * block.values[lane] * factor;
            let sum = &mut sums[block.pixel[lane]];
            sum.irradiance += irradiance;
            sum.radiance += block.albedo[lane] * irradiance * FRAC_1_PI;
        }
    }
}
