//! Pictures to look at, 8-bit sRGB, rows from the top left: the image itself, its fragments, its error.

use std::f32::consts::FRAC_1_PI;

use glam::Vec3;
use halflight_core::fragment::Fragments;
use halflight_core::gbuffer::GBuffer;
use halflight_metrics::{CompareError, Image, error_map, tone_map};

/// The exposure of all pictures: radiance of 1 W/m²/sr is white.
pub const EXPOSURE: f32 = 1.0;

/// Error that the brightest colour of an error map stands for: a twentieth of the reference's peak.
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

/// The colour of pixels that see nothing.
const NOTHING: [u8; 3] = [24, 24, 28];

/// Diffuse radiance `albedo/π · irradiance` of every pixel, W/m²/sr.
pub fn radiance(irradiance: &[Vec3], albedo: &[Vec3]) -> Vec<Vec3> {
    irradiance.iter().zip(albedo).map(|(&light, &albedo)| light * albedo * FRAC_1_PI).collect()
}

/// The image as the camera sees it: radiance times `exposure`, clamped, in sRGB.
pub fn image(irradiance: &[Vec3], albedo: &[Vec3], exposure: f32) -> Vec<[u8; 3]> {
    tone_map(&radiance(irradiance, albedo), exposure)
}

/// The fragments of one light, a colour a level, the same in every map; cells of 4 × 4 pixels and up have a thin dark
/// edge at their top and left. Pixels that see nothing are nearly black.
pub fn fragment_map(fragments: &Fragments, gbuffer: &GBuffer) -> Vec<[u8; 3]> {
    let (width, height) = (fragments.width(), fragments.height());
    let mut picture = vec![NOTHING; width as usize * height as usize];
    for cell in fragments.cells() {
        let colour = LEVELS[usize::from(cell.level).min(LEVELS.len() - 1)];
        let edge = if cell.level < 2 { colour } else { colour.map(|channel| channel / 2) };
        let (x0, y0, x1, y1) = cell.pixels(width, height);
        for y in y0..y1 {
            for x in x0..x1 {
                let pixel = gbuffer.index(x, y);
                if gbuffer.is_receiver(pixel) {
                    picture[pixel] = if x == x0 || y == y0 { edge } else { colour };
                }
            }
        }
    }
    picture
}

/// The same of levels alone, one a pixel, without edges.
pub fn level_map(levels: &[u8], gbuffer: &GBuffer) -> Vec<[u8; 3]> {
    let colour = |(pixel, &level): (usize, &u8)| {
        if gbuffer.is_receiver(pixel) { LEVELS[usize::from(level).min(LEVELS.len() - 1)] } else { NOTHING }
    };
    levels.iter().enumerate().map(colour).collect()
}

/// Where the error lies: |luminance difference| over the reference's peak, from black to pale yellow at `scale`
/// ([`ERROR_SCALE`] for maps that are to be compared); masked pixels are grey.
///
/// # Errors
/// As [`halflight_metrics::compare`].
pub fn error(image: Image<'_>, reference: Image<'_>, scale: f32) -> Result<Vec<[u8; 3]>, CompareError> {
    Ok(error_map(image, reference)?.picture(scale))
}
