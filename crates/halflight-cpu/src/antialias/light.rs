//! Light of sub-samples: the visible fraction of each one's source times its own unshadowed irradiance and albedo.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;
use halflight_core::gbuffer::GBuffer;
use halflight_core::light::AreaLight;
use halflight_core::values::Values;

use super::sources::Source;
use super::surfaces::Seen;
use crate::irradiance::Shading;
use crate::textured::SeenTexture;
use crate::unshadowed::unshadowed_many;

/// Sub-samples that are lit together.
const BLOCK: usize = 64;

/// Largest factor by which an irradiance that was sampled elsewhere is scaled: at grazing incidence it may be much smaller there.
const MOST_SCALE: f32 = 2.0;

/// Values of one light that sub-samples take.
pub(super) struct Lit<'a> {
    pub(super) light: &'a AreaLight,
    pub(super) shading: Shading,
    /// Surfaces and values of the pixels.
    pub(super) gbuffer: &'a GBuffer,
    pub(super) planes: &'a Values,
    /// Surfaces of the sub-samples, and values of those that have masks of their own.
    pub(super) samples: &'a GBuffer,
    pub(super) own: &'a [Vec3],
    /// Texture of the light, if it has one.
    pub(super) texture: Option<&'a SeenTexture>,
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

impl Block {
    const EMPTY: Self = Self {
        count: 0,
        pixel: [0; BLOCK],
        origins: [Vec3::ZERO; BLOCK],
        normals: [Vec3::ZERO; BLOCK],
        albedo: [Vec3::ZERO; BLOCK],
        values: [Vec3::ZERO; BLOCK],
        source_origins: [Vec3::ZERO; BLOCK],
        source_normals: [Vec3::ZERO; BLOCK],
    };
}

impl Lit<'_> {
    /// Adds the radiance that the light causes to the sums of some pixels; the sub-samples of the `i`-th are `starts[i]..starts[i + 1]`.
    pub(super) fn add(&self, starts: &[usize], sources: &[Source], sums: &mut [Vec3]) {
        let mut block = Block::EMPTY;
        for (pixel, range) in starts.windows(2).enumerate() {
            for (entry, &source) in (range[0]..range[1]).zip(&sources[range[0]..range[1]]) {
                let sample = Seen { gbuffer: self.samples, entry };
                let (values, source) = match source {
                    Source::Whole => break,
                    Source::Background => continue,
                    Source::Pixel(entry) => {
                        let entry = entry as usize;
                        (self.pixel_value(entry), Seen { gbuffer: self.gbuffer, entry })
                    }
                    Source::Own(place) => {
                        let entry = range[0] + usize::from(place);
                        (self.own[entry], Seen { gbuffer: self.samples, entry })
                    }
                };
                // In the umbra it does not matter how much light there would be.
                if values == Vec3::ZERO {
                    continue;
                }
                let lane = block.count;
                (block.pixel[lane], block.values[lane], block.albedo[lane]) =
                    (pixel, values, sample.albedo());
                (block.origins[lane], block.normals[lane]) = sample.receiver();
                if self.shading == Shading::Sampled {
                    (block.source_origins[lane], block.source_normals[lane]) = source.receiver();
                }
                block.count += 1;
                if block.count == BLOCK {
                    self.flush(&mut block, sums);
                }
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
    fn flush(&self, block: &mut Block, sums: &mut [Vec3]) {
        let count = std::mem::take(&mut block.count);
        let (mut unshadowed, mut at_source) = ([0.0f32; BLOCK], [0.0f32; BLOCK]);
        let light = self.light;
        unshadowed_many(light, &block.origins[..count], &block.normals[..count], &mut unshadowed[..count]);
        if self.shading == Shading::Sampled {
            let (origins, normals) = (&block.source_origins[..count], &block.source_normals[..count]);
            unshadowed_many(light, origins, normals, &mut at_source[..count]);
        }
        let mut textures = [Vec3::ONE; BLOCK];
        if let Some(texture) = self.texture.filter(|_| self.shading == Shading::Ratio) {
            texture.seen(&block.origins[..count], &block.normals[..count], &mut textures);
        }
        for lane in 0..count {
            let factor = match self.shading {
                Shading::Ratio => unshadowed[lane],
                Shading::Sampled if at_source[lane] > 0.0 => {
                    (unshadowed[lane] / at_source[lane]).min(MOST_SCALE)
                }
                Shading::Sampled => 1.0,
            };
            let irradiance = light.radiance * textures[lane] * block.values[lane] * factor;
            sums[block.pixel[lane]] += block.albedo[lane] * irradiance * FRAC_1_PI;
        }
    }
}
