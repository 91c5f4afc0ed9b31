//! The last stage: interpolated values to irradiance, summed over the lights.

use glam::Vec3;
use halflight_core::gbuffer::GBuffer;
use halflight_core::light::AreaLight;
use rayon::prelude::*;

use crate::irradiance::Shading;
use crate::unshadowed::unshadowed_many;

/// Pixels that are composed together.
const BLOCK: usize = 64;

/// Unshadowed and visible light of every pixel, for the `visibility` layer.
#[derive(Clone, Debug, Default)]
pub(crate) struct Totals {
    /// Luminance-weighted ΣU.
    pub unshadowed: Vec<f32>,
    /// Luminance-weighted ΣUF.
    pub visible: Vec<f32>,
}

/// Luminance of linear Rec. 709 light.
pub(crate) fn luminance(rgb: Vec3) -> f32 {
    rgb.dot(Vec3::new(0.2126, 0.7152, 0.0722))
}

/// Adds one light's share to `image`: `plane` holds irradiance per unit radiance, or the visible fraction that the
/// analytic irradiance is multiplied with. `totals`, where wanted, has been sized to the image.
pub(crate) fn add_light(
    gbuffer: &GBuffer,
    light: &AreaLight,
    shading: Shading,
    plane: &[f32],
    image: &mut [Vec3],
    totals: Option<&mut Totals>,
) {
    let radiance = light.radiance;
    let luminance = luminance(radiance);
    let needs_unshadowed = shading == Shading::Ratio || totals.is_some();
    let block = |first: usize, image: &mut [Vec3], totals: Option<(&mut [f32], &mut [f32])>| {
        let mut irradiance = [0.0f32; BLOCK];
        // In the umbra it does not matter how much light there would be.
        let dark = totals.is_none() && plane[first..first + image.len()].iter().all(|&value| value == 0.0);
        if dark {
            return;
        }
        if needs_unshadowed {
            // Where nothing is seen the normal is zero, and so is the irradiance.
            let pixels = first..first + image.len();
            let (origins, normals) = (&gbuffer.position[pixels.clone()], &gbuffer.normal[pixels]);
            unshadowed_many(light, origins, normals, &mut irradiance[..image.len()]);
        }
        if let Some((unshadowed, visible)) = totals {
            for lane in 0..image.len() {
                let lit = match shading {
                    Shading::Sampled => plane[first + lane],
                    Shading::Ratio => irradiance[lane] * plane[first + lane],
                };
                unshadowed[lane] += luminance * irradiance[lane];
                visible[lane] += luminance * lit;
            }
        }
        for (lane, pixel) in image.iter_mut().enumerate() {
            let value = plane[first + lane];
            *pixel += radiance * if shading == Shading::Ratio { irradiance[lane] * value } else { value };
        }
    };
    let image = image.par_chunks_mut(BLOCK).enumerate();
    match totals {
        None => image.for_each(|(index, image)| block(index * BLOCK, image, None)),
        Some(totals) => image
            .zip(totals.unshadowed.par_chunks_mut(BLOCK).zip(totals.visible.par_chunks_mut(BLOCK)))
            .for_each(|((index, image), (unshadowed, visible))| {
                block(index * BLOCK, image, Some((unshadowed, visible)));
            }),
    }
}
