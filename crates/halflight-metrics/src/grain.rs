//! Grain: visible noise of a penumbra.

use crate::{
    color::luminance,
    filter::{Border, correlate, gaussian},
    pair::{CompareError, Pair},
    percentile::p99,
    view::Image,
};

/// Standard deviation in pixels of the Gaussian whose result is taken away. Of a sinusoidal error, 94 % are left at a
/// period of 16 pixels (blotches of 8), half at 32, 7 % at 100.
const SIGMA: f64 = 6.0;
const RADIUS: usize = 18;

/// Luminance, as a share of the peak, that is added to the local one: less light than that is lost in what a screen
/// reflects.
const FLOOR: f64 = 0.02;

/// Computes [`Comparison::grain`](crate::Comparison::grain) alone, which takes less time than all measures.
///
/// # Errors
/// See [`compare`](crate::compare()).
pub fn grain(image: Image<'_>, reference: Image<'_>) -> Result<Option<f64>, CompareError> {
    Ok(grain_of(&Pair::new(image, reference)?))
}

/// Returns the grain; `None` where no pixel lies in the penumbra.
///
/// Pixels outside the penumbra have zero weight in the Gaussian, whose weights are rescaled to a sum of 1: errors of the
/// lit floor and of other surfaces beyond the penumbra's edge do not leak in.
pub(crate) fn grain_of(pair: &Pair<'_>) -> Option<f64> {
    let penumbra = pair.penumbra();
    if penumbra.is_empty() {
        return None;
    }
    let mut moments = vec![[0.0; 3]; pair.len()];
    for &i in &penumbra {
        let (image, reference) = pair.at(i);
        let (error, light) = (luminance(image - reference), luminance(reference).abs());
        moments[i] = [1.0, error / pair.peak, light / pair.peak];
    }
    let taps = gaussian(RADIUS, SIGMA);
    let [weight, error, light]: [Vec<f64>; 3] = std::array::from_fn(|m| {
        let plane: Vec<f64> = moments.iter().map(|moment| moment[m]).collect();
        correlate(&plane, pair.width, &taps, &taps, Border::Zero)
    });
    let contrast = |&i: &usize| (moments[i][1] - error[i] / weight[i]).abs() / (light[i] / weight[i] + FLOOR);
    p99(&mut penumbra.iter().map(contrast).collect::<Vec<_>>())
}
