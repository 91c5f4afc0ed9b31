//! Error maps and their pictures.

use glam::{DVec3, Vec3};

use crate::{
    color::luminance,
    pair::{CompareError, Pair},
    view::Image,
};

/// Colour of masked pixels in an [`ErrorMap::picture`]: a grey, which the colour ramp never contains.
const MASKED: [u8; 3] = [96, 96, 96];

/// Stops of the colour ramp at equal steps, sRGB: black through violet, red and orange to a pale yellow.
/// Lightness increases monotonically, so that the ramp is readable in print too.
const RAMP: [Vec3; 7] = [
    Vec3::ZERO,
    Vec3::new(48.0, 12.0, 92.0),
    Vec3::new(118.0, 24.0, 108.0),
    Vec3::new(190.0, 48.0, 76.0),
    Vec3::new(236.0, 104.0, 36.0),
    Vec3::new(250.0, 182.0, 40.0),
    Vec3::new(252.0, 252.0, 190.0),
];

/// Error of each pixel.
#[derive(Clone, Debug, PartialEq)]
pub struct ErrorMap {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Absolute luminance difference divided by the peak of the reference, rows from the top left; `None`
    /// where masked.
    pub values: Vec<Option<f32>>,
}

/// Absolute difference in Rec. 709 luminance at each pixel, divided by the reference's largest channel value.
///
/// # Errors
/// See [`compare`](crate::compare).
pub fn error_map(image: Image<'_>, reference: Image<'_>) -> Result<ErrorMap, CompareError> {
    let pair = Pair::new(image, reference)?;
    let values = pair.map_relative(None, |a, b| Some(luminance(a - b).abs() as f32));
    Ok(ErrorMap { width: image.width(), height: image.height(), values })
}

impl ErrorMap {
    /// Map in false colours, sRGB, rows from the top left: errors from 0 to `full_scale` run through a ramp
    /// from black over violet, red and orange to pale yellow; larger ones stay at its end; masked pixels are
    /// grey.
    ///
    /// Maps are comparable if they have the same `full_scale` and the same reference.
    #[must_use]
    pub fn picture(&self, full_scale: f32) -> Vec<[u8; 3]> {
        self.values.iter().map(|value| value.map_or(MASKED, |v| ramp(v / full_scale))).collect()
    }
}

/// Colour of the ramp at `t`, clamped to 0..1.
fn ramp(t: f32) -> [u8; 3] {
    let last = RAMP.len() - 1;
    // A NaN (0 over a scale of 0) stays one and is cast to 0, black, which is the ramp's first stop.
    let position = t.clamp(0.0, 1.0) * last as f32;
    let stop = (position as usize).min(last - 1);
    RAMP[stop].lerp(RAMP[stop + 1], position - stop as f32).to_array().map(|c| c.round() as u8)
}

/// Error map of Koa17 (Figs. 12 to 16): the squared difference of each pixel, times `factor`, as the red
/// channel.
///
/// Both images are divided by the reference's largest channel value; the squares of the three channels are
/// summed; the product is clamped to 0..1 and stored without a transfer function. The paper leaves these
/// three open and uses factors of 1, 9 and 20. Masked pixels are black.
///
/// # Errors
/// See [`compare`](crate::compare).
pub fn squared_error_picture(
    image: Image<'_>,
    reference: Image<'_>,
    factor: f32,
) -> Result<Vec<[u8; 3]>, CompareError> {
    let pair = Pair::new(image, reference)?;
    let red = |a: DVec3, b: DVec3| {
        let error = f64::from(factor) * (a - b).length_squared();
        [(255.0 * error.clamp(0.0, 1.0)).round() as u8, 0, 0]
    };
    Ok(pair.map_relative([0; 3], red))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ramp_grows_lighter_from_end_to_end() {
        let lightness: Vec<f32> = (0..=1000)
            .map(|i| {
                let [r, g, b] = ramp(i as f32 / 1000.0).map(f32::from);
                0.2126 * r + 0.7152 * g + 0.0722 * b
            })
            .collect();
        // Rounding each channel to 8 bits may lower the sum by at most half a step a channel.
        assert!(lightness.windows(2).all(|w| w[1] >= w[0] - 0.5));
        assert!(lightness[0] < 1.0 && lightness[1000] > 240.0);
        assert!((0..=1000).all(|i| ramp(i as f32 / 1000.0) != MASKED));
    }

    #[test]
    fn the_ramp_is_clamped() {
        assert_eq!(ramp(-1.0), ramp(0.0));
        assert_eq!(ramp(f32::NAN), ramp(0.0));
        assert_eq!(ramp(f32::INFINITY), ramp(1.0));
        assert_eq!(ramp(1.0), [252, 252, 190]);
    }
}
