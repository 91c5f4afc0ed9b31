//! Visible part of a grid's samples by the variance of occluder distances (Nichols10, §3.3.3; Donnelly and Lauritzen 2006).

use super::gather::Grid;

/// Returns the part of a sample that is visible where parts of segments before the nearest occluder have this mean and mean square; 1 is the light itself.
///
/// Chebyshev's inequality (Donnelly and Lauritzen 2006, equation 5) bounds the share of distances that reach the light.
pub(super) fn visible(mean: f32, square: f32, least: f32) -> f32 {
    let missing = 1.0 - mean;
    if missing <= 0.0 {
        return 1.0;
    }
    let variance = (square - mean * mean).max(least);
    variance / (variance + missing * missing)
}

/// Returns the visible part of each sample of a grid by the grids around it, its own among them. A sample that none of them has traced takes the mean of the
/// others.
pub(super) fn blurred<'a>(around: impl Iterator<Item = &'a Grid>, count: usize, least: f32) -> Vec<f32> {
    let mut sums = vec![[0.0f32; 3]; count];
    for grid in around {
        for (sum, &part) in sums.iter_mut().zip(&grid.parts) {
            if part >= 0.0 {
                *sum = [sum[0] + part, sum[1] + part * part, sum[2] + 1.0];
            }
        }
    }
    let of = |[sum, square, number]: [f32; 3]| {
        (number > 0.0).then(|| visible(sum / number, square / number, least))
    };
    let known: Vec<Option<f32>> = sums.into_iter().map(of).collect();
    let (sum, number) =
        known.iter().flatten().fold((0.0, 0u32), |(sum, number), part| (sum + part, number + 1));
    let rest = if number > 0 { sum / number as f32 } else { 1.0 };
    known.into_iter().map(|part| part.unwrap_or(rest)).collect()
}
