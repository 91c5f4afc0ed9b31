//! Structural similarity: Wang, Bovik, Sheikh, Simoncelli, "Image Quality Assessment: From Error Visibility
//! to Structural Similarity", IEEE TIP 13(4), 2004, Eq. 13 with the constants of §III-C.

use crate::{
    color::luminance,
    filter::{Border, correlate, gaussian},
    pair::Pair,
};

/// Standard deviation in pixels of the 11×11 window.
const SIGMA: f64 = 1.5;
const RADIUS: usize = 5;
/// (K₁L)² and (K₂L)² with a dynamic range L of 1.
const C1: f64 = 0.01 * 0.01;
const C2: f64 = 0.03 * 0.03;

/// Mean SSIM of the luminance over the unmasked pixels, both images divided by the reference's peak.
///
/// At the image's edge and beside masked pixels the window keeps its valid pixels and its weights are
/// rescaled to a sum of 1, so that every pixel counts and no padding is used.
pub(crate) fn ssim(pair: &Pair<'_>) -> f64 {
    let taps = gaussian(RADIUS, SIGMA);
    // Masked pixels have zero weight: all their moments, the zeroth included, are zero.
    let moments = pair.map_relative([0.0; 6], |image, reference| {
        let (x, y) = (luminance(image), luminance(reference));
        [1.0, x, y, x * x, y * y, x * y]
    });
    let blurred: [Vec<f64>; 6] = std::array::from_fn(|m| {
        let plane: Vec<f64> = moments.iter().map(|moment| moment[m]).collect();
        correlate(&plane, pair.width, &taps, &taps, Border::Zero)
    });
    let sum: f64 = pair.indices().map(|i| local_ssim(std::array::from_fn(|m| blurred[m][i]))).sum();
    sum / pair.count as f64
}

/// SSIM of one window from its weighted sums of 1, x, y, x², y², xy.
fn local_ssim([weight, x, y, xx, yy, xy]: [f64; 6]) -> f64 {
    let (x, y) = (x / weight, y / weight);
    // Rounding may leave a variance just below zero and a covariance just above its bound.
    let (var_x, var_y) = ((xx / weight - x * x).max(0.0), (yy / weight - y * y).max(0.0));
    let bound = var_x.sqrt() * var_y.sqrt();
    let covariance = (xy / weight - x * y).clamp(-bound, bound);
    let mean_term = (2.0 * x * y + C1) / (x * x + y * y + C1);
    let variance_term = (2.0 * covariance + C2) / (var_x + var_y + C2);
    mean_term * variance_term
}
