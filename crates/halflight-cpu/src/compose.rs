//! The last stage: interpolated values to irradiance, summed over the lights.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;
use halflight_core::frame::Frame;
use halflight_core::gbuffer::GBuffer;
use halflight_core::light::AreaLight;
use halflight_core::values::Values;
use rayon::prelude::*;

use crate::irradiance::Shading;
use crate::textured::SeenTexture;
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

/// Adds one light's share to `image`: `planes` holds irradiance per unit radiance, or the visible fraction that the
/// analytic irradiance is multiplied with, and the mean of the light's texture where it has one. Three channels are factors of red, green and
/// blue; otherwise the first is a factor of the whole radiance. `totals`, where wanted, has been sized to the image.
pub(crate) fn add_light(
    frame: &Frame,
    number: u32,
    shading: Shading,
    texture: Option<&SeenTexture>,
    planes: &Values,
    image: &mut [Vec3],
    totals: Option<&mut Totals>,
) {
    let channel = |channel| planes.channel(channel);
    let lit = Lit { gbuffer: frame.gbuffer, light: frame.light(number), shading, texture };
    match planes.channels() {
        3 => lit.add_planes([channel(0), channel(1), channel(2)], image, totals),
        _ => lit.add_planes([channel(0)], image, totals),
    }
}

/// Writes the radiance that leaves the surfaces: albedo/π · irradiance, and `indirect` light and `specular` reflection where there are any.
pub(crate) fn reflect(
    gbuffer: &GBuffer,
    irradiance: &[Vec3],
    indirect: &[Vec3],
    specular: &[Vec3],
    radiance: &mut Vec<Vec3>,
) {
    radiance.resize(irradiance.len(), Vec3::ZERO);
    let pixels = radiance.par_iter_mut().zip(irradiance).zip(&gbuffer.albedo).with_min_len(4096);
    pixels.for_each(|((radiance, &light), &albedo)| *radiance = light * albedo * FRAC_1_PI);
    let again = radiance.par_iter_mut().zip(indirect).zip(&gbuffer.albedo).with_min_len(4096);
    again.for_each(|((radiance, &light), &albedo)| *radiance += light * albedo * FRAC_1_PI);
    let glossy = radiance.par_iter_mut().zip(specular).with_min_len(4096);
    glossy.for_each(|(radiance, &specular)| *radiance += specular);
}

/// Surfaces and the light that they receive.
struct Lit<'a> {
    gbuffer: &'a GBuffer,
    light: &'a AreaLight,
    shading: Shading,
    texture: Option<&'a SeenTexture>,
}

/// Radiance times one factor, or one for each of its channels, and the luminance of that.
#[inline(always)]
fn scaled<const N: usize>(radiance: Vec3, luminance_of_radiance: f32, factors: [f32; N]) -> (Vec3, f32) {
    match factors[..] {
        [red, green, blue] => {
            let light = radiance * Vec3::new(red, green, blue);
            (light, luminance(light))
        }
        _ => (radiance * factors[0], luminance_of_radiance * factors[0]),
    }
}

impl Lit<'_> {
    fn add_planes<const N: usize>(
        &self,
        planes: [&[f32]; N],
        image: &mut [Vec3],
        totals: Option<&mut Totals>,
    ) {
        let block = |first: usize, image: &mut [Vec3], totals: Option<(&mut [f32], &mut [f32])>| {
            self.add_block(first, planes, image, totals);
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

    /// Adds the light of up to [`BLOCK`] pixels from `first` on.
    fn add_block<const N: usize>(
        &self,
        first: usize,
        planes: [&[f32]; N],
        image: &mut [Vec3],
        totals: Option<(&mut [f32], &mut [f32])>,
    ) {
        let Self { gbuffer, light, shading, texture } = *self;
        let pixels = first..first + image.len();
        let planes = planes.map(|plane| &plane[pixels.clone()]);
        // In the umbra it does not matter how much light there would be.
        let dark = totals.is_none() && planes.iter().all(|plane| plane.iter().all(|&value| value == 0.0));
        if dark {
            return;
        }
        let mut irradiance = [0.0f32; BLOCK];
        let (origins, normals) = (&gbuffer.position[pixels.clone()], &gbuffer.shading_normals()[pixels]);
        if shading == Shading::Ratio || totals.is_some() {
            // Pixels that see nothing have a zero normal and no irradiance.
            unshadowed_many(light, origins, normals, &mut irradiance[..image.len()]);
        }
        let uniform = (light.radiance, luminance(light.radiance));
        let mut textures = [Vec3::ONE; BLOCK];
        if let Some(texture) = texture {
            texture.seen(origins, normals, &mut textures[..image.len()]);
        }
        // Radiance without occluders, and its luminance.
        let seen = |lane: usize| match texture {
            None => uniform,
            Some(_) => {
                let radiance = light.radiance * textures[lane];
                (radiance, luminance(radiance))
            }
        };
        let share = |lane: usize| match shading {
            // Sampled irradiance has the texels in it.
            Shading::Sampled => scaled(uniform.0, uniform.1, planes.map(|plane| plane[lane])),
            Shading::Ratio => {
                let (radiance, luminance) = seen(lane);
                scaled(radiance, luminance, planes.map(|plane| irradiance[lane] * plane[lane]))
            }
        };
        if let Some((unshadowed, visible)) = totals {
            for lane in 0..image.len() {
                unshadowed[lane] += seen(lane).1 * irradiance[lane];
                visible[lane] += share(lane).1;
            }
        }
        for (lane, pixel) in image.iter_mut().enumerate() {
            *pixel += share(lane).0;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const WIDTH: u32 = 40;
    const HEIGHT: u32 = 3;
    const PIXELS: usize = (WIDTH * HEIGHT) as usize;

    fn light() -> AreaLight {
        let corner = Vec3::new(-1.0, 2.0, -1.0);
        AreaLight::parallelogram(corner, Vec3::X, Vec3::Z, Vec3::new(5.0, 3.0, 2.0)).two_sided()
    }

    fn floor() -> GBuffer {
        let mut gbuffer = GBuffer::default();
        gbuffer.reset(WIDTH, HEIGHT);
        for pixel in 0..PIXELS {
            gbuffer.position[pixel] = Vec3::new(0.05 * pixel as f32 - 2.0, 0.0, 0.0);
            gbuffer.normal[pixel] = Vec3::Y;
            gbuffer.primitive[pixel] = 0;
        }
        gbuffer
    }

    /// Planes of which `value` gives a channel's value at a pixel.
    fn planes(channels: usize, value: impl Fn(usize, usize) -> f32) -> Values {
        let mut planes = Values::default();
        planes.reset(channels, PIXELS);
        for channel in 0..channels {
            for (pixel, place) in planes.channel_mut(channel).iter_mut().enumerate() {
                *place = value(channel, pixel);
            }
        }
        planes
    }

    fn composed(shading: Shading, planes: &Values) -> (Vec<Vec3>, Totals) {
        let mut image = vec![Vec3::splat(0.25); PIXELS];
        let mut totals = Totals { unshadowed: vec![0.0; PIXELS], visible: vec![0.0; PIXELS] };
        let (gbuffer, light) = (floor(), light());
        let lit = Lit { gbuffer: &gbuffer, light: &light, shading, texture: None };
        let mut plain = vec![Vec3::splat(0.25); PIXELS];
        let channel = |channel| planes.channel(channel);
        match planes.channels() {
            3 => {
                let planes = [0, 1, 2].map(channel);
                lit.add_planes(planes, &mut image, Some(&mut totals));
                lit.add_planes(planes, &mut plain, None);
            }
            _ => {
                lit.add_planes([channel(0)], &mut image, Some(&mut totals));
                lit.add_planes([channel(0)], &mut plain, None);
            }
        }
        assert_eq!(image, plain);
        (image, totals)
    }

    /// Value of a pixel; the first block of pixels is dark.
    fn ramp(pixel: usize) -> f32 {
        if pixel < BLOCK { 0.0 } else { 0.005 * pixel as f32 }
    }

    #[test]
    fn three_channels_are_factors_of_red_green_and_blue() {
        for shading in [Shading::Sampled, Shading::Ratio] {
            let (image, totals) =
                composed(shading, &planes(3, |channel, pixel| channel as f32 * ramp(pixel)));
            let (single, plain) = composed(shading, &planes(1, |_, pixel| ramp(pixel)));
            assert_eq!(totals.unshadowed, plain.unshadowed);
            for pixel in 0..PIXELS {
                let light = single[pixel] - Vec3::splat(0.25);
                assert!(pixel < BLOCK || light.min_element() > 0.0);
                let expected = light * Vec3::new(0.0, 1.0, 2.0);
                assert!(
                    (image[pixel] - Vec3::splat(0.25)).abs_diff_eq(expected, 1e-5),
                    "{shading:?} {pixel}"
                );
                assert!((totals.visible[pixel] - luminance(expected)).abs() < 1e-5, "{shading:?} {pixel}");
            }
        }
    }

    #[test]
    fn one_channel_is_a_factor_of_the_radiance() {
        for shading in [Shading::Sampled, Shading::Ratio] {
            let (image, _) = composed(shading, &planes(1, |_, pixel| ramp(pixel)));
            let gbuffer = floor();
            let mut irradiance = [1.0; PIXELS];
            if shading == Shading::Ratio {
                unshadowed_many(&light(), &gbuffer.position, &gbuffer.normal, &mut irradiance);
            }
            for pixel in 0..PIXELS {
                let expected = Vec3::splat(0.25) + light().radiance * (irradiance[pixel] * ramp(pixel));
                assert_eq!(image[pixel], expected, "{shading:?} {pixel}");
            }
        }
    }
}
