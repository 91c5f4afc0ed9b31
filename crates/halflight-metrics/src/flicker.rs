//! Temporal flicker: changes from frame to frame that the reference does not have.

use serde::{Deserialize, Serialize};

use crate::color::luminance;
use crate::pair::{CompareError, Pair};
use crate::percentile::p99;
use crate::view::{Image, ShapeMismatch};

/// Flicker: `|Δ image − Δ reference|` between two frames, in luminance, over the pixels unmasked in both
/// frames, relative to the mean luminance of the later reference there. 0 where an image changes exactly as
/// its reference does, whatever its error otherwise.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Flicker {
    /// Mean over the pixels.
    pub mean: f64,
    /// 99th percentile over the pixels, by nearest rank.
    pub p99: f64,
}

/// Measures the flicker between two frames, each an image with its reference.
///
/// Masks are as in [`compare`](crate::compare()), and may differ from frame to frame.
///
/// # Errors
/// See [`compare`](crate::compare()) for each of the frames; also frames of different sizes, and masks
/// without a common pixel, or with a black reference there.
pub fn flicker(before: [Image<'_>; 2], after: [Image<'_>; 2]) -> Result<Flicker, CompareError> {
    let sizes = [before[0], after[0]].map(|image| (image.width(), image.height()));
    if sizes[0] != sizes[1] {
        return Err(ShapeMismatch::Size { a: sizes[0], b: sizes[1] }.into());
    }
    let [before, after] = [Pair::new(before[0], before[1])?, Pair::new(after[0], after[1])?];
    let mut changes = Vec::with_capacity(after.count);
    let mut light = 0.0;
    for index in after.indices().filter(|&index| before.takes_part(index)) {
        let [(old, old_reference), (new, reference)] =
            [&before, &after].map(|pair| pair.at(index)).map(|(a, b)| (luminance(a), luminance(b)));
        changes.push(((new - old) - (reference - old_reference)).abs());
        light += reference;
    }
    if changes.is_empty() {
        return Err(CompareError::NoPixels);
    }
    if light <= 0.0 {
        return Err(CompareError::ZeroReference);
    }
    let count = changes.len();
    let brightness = light / count as f64;
    let mean = changes.iter().sum::<f64>() / count as f64;
    let p99 = p99(&mut changes).ok_or(CompareError::NoPixels)?;
    Ok(Flicker { mean: mean / brightness, p99: p99 / brightness })
}
