//! Pictures to look at: 8-bit sRGB pixels, row by row from the top left.
//!
//! Functions take one value a pixel and return one `[red, green, blue]` a pixel.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;
use halflight_core::fragment::Fragments;
use halflight_core::gbuffer::GBuffer;
use halflight_metrics::{CompareError, Image, error_map, tone_map};

/// Exposure of all pictures of Halflight: a radiance of 1 W/m²/sr is white.
pub const EXPOSURE: f32 = 1.0;

/// Error that the brightest colour of an error map stands for, as a share of the reference's peak: a twentieth.
pub const ERROR_SCALE: f32 = 0.05;

/// Colours of levels 0 … 7 in a fragment map: cyan for single pixels as in Koa17, white for the coarsest.
const LEVELS: [[u8; 3]; 8] = [
    [0, 200, 220],
    [30, 110, 220],
    [100, 60, 190],
    [190, 50, 140],
    [230, 90, 60],
    [245, 160, 50],
    [250, 220, 130],
    [255, 255, 255],
];

/// Colour of pixels that see nothing.
const NOTHING: [u8; 3] = [24, 24, 28];

/// Returns the diffuse radiance `albedo/π · irradiance` of every pixel, W/m²/sr, from irradiance in W/m² and albedo in 0 … 1.
pub fn radiance(irradiance: &[Vec3], albedo: &[Vec3]) -> Vec<Vec3> {
    irradiance.iter().zip(albedo).map(|(&light, &albedo)| light * albedo * FRAC_1_PI).collect()
}

/// Returns the image as the camera sees it: radiance times `exposure`, clamped to 0 … 1, in sRGB. [`EXPOSURE`] is the usual one.
pub fn image(irradiance: &[Vec3], albedo: &[Vec3], exposure: f32) -> Vec<[u8; 3]> {
    tone_map(&radiance(irradiance, albedo), exposure)
}

/// Returns a map of the fragments of one light: one colour a level, equal in all maps.
///
/// Cells of 4 × 4 pixels and more have a thin dark edge at their top and left. Pixels that see nothing, and those that
/// `gbuffer` lacks where it has another size, are nearly black.
pub fn fragment_map(fragments: &Fragments, gbuffer: &GBuffer) -> Vec<[u8; 3]> {
    let (width, height) = (fragments.width(), fragments.height());
    let mut picture = vec![NOTHING; width as usize * height as usize];
    for cell in fragments.cells() {
        let colour = LEVELS[usize::from(cell.level).min(LEVELS.len() - 1)];
        let edge = if cell.level < 2 { colour } else { colour.map(|channel| channel / 2) };
        let (x0, y0, x1, y1) = cell.pixels(width, height);
        for y in y0..y1 {
            for x in x0..x1 {
                let pixel = y as usize * width as usize + x as usize;
                if pixel < gbuffer.pixels() && gbuffer.is_receiver(pixel) {
                    picture[pixel] = if x == x0 || y == y0 { edge } else { colour };
                }
            }
        }
    }
    picture
}

/// Returns a map of levels, one a pixel, in the colours of [`fragment_map`] and without edges.
pub fn level_map(levels: &[u8], gbuffer: &GBuffer) -> Vec<[u8; 3]> {
    let colour = |(pixel, &level): (usize, &u8)| {
        let seen = pixel < gbuffer.pixels() && gbuffer.is_receiver(pixel);
        if seen { LEVELS[usize::from(level).min(LEVELS.len() - 1)] } else { NOTHING }
    };
    levels.iter().enumerate().map(colour).collect()
}

/// Returns a map of the error: |luminance difference| over the reference's peak, from black to pale yellow at `scale` and
/// above. Masked pixels are grey. Maps that are to be compared have one scale, such as [`ERROR_SCALE`].
///
/// # Errors
/// [`CompareError`] where sizes or masks differ, no pixel takes part, a pixel is not finite, or the reference is black.
pub fn error(image: Image<'_>, reference: Image<'_>, scale: f32) -> Result<Vec<[u8; 3]>, CompareError> {
    Ok(error_map(image, reference)?.picture(scale))
}
