//! Approximate comparison for the project's tests.

use std::fmt;

use glam::Vec3;
use thiserror::Error;

use crate::view::{Image, ShapeMismatch};

/// Largest difference of two values: `absolute + relative · max(|a|, |b|)`.
///
/// Every use should state the reason for its tolerance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// Absolute part, in the unit of the values.
    pub absolute: f64,
    /// Relative part, as a fraction of the larger of the two values.
    pub relative: f64,
}

impl Tolerance {
    /// Allows a fixed difference.
    #[must_use]
    pub fn absolute(absolute: f64) -> Self {
        Self { absolute, relative: 0.0 }
    }

    /// Allows a fraction of the larger value.
    #[must_use]
    pub fn relative(relative: f64) -> Self {
        Self { absolute: 0.0, relative }
    }

    /// True if two values are close. NaN and infinities are close to nothing.
    #[must_use]
    pub fn accepts(&self, a: f64, b: f64) -> bool {
        self.excess(a, b) <= 0.0
    }

    /// Excess of the difference over the tolerance; infinite if it is NaN.
    fn excess(&self, a: f64, b: f64) -> f64 {
        let excess = (a - b).abs() - (self.absolute + self.relative * a.abs().max(b.abs()));
        if a.is_finite() && b.is_finite() && !excess.is_nan() { excess } else { f64::INFINITY }
    }
}

impl fmt::Display for Tolerance {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:e} + {:e} of the larger value", self.absolute, self.relative)
    }
}

/// Two images that are not close.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum Mismatch {
    /// Sizes or masks differ.
    #[error(transparent)]
    Shape(#[from] ShapeMismatch),
    /// The mask leaves no pixel, so that the check would hold for any two images.
    #[error("no pixel to check: the mask is false everywhere")]
    NoPixels,
    /// Pixels that differ by more than the tolerance.
    #[error(
        "{exceeding} of {pixels} pixels differ by more than {tolerance}; the worst is ({x}, {y}): \
         [{}, {}, {}] against [{}, {}, {}]",
        a.x, a.y, a.z, b.x, b.y, b.z
    )]
    Pixels {
        /// Number of pixels that differ too much in some channel.
        exceeding: usize,
        /// Number of pixels that were checked.
        pixels: usize,
        /// Tolerance of the check.
        tolerance: Tolerance,
        /// Column of the pixel that exceeds the tolerance by most.
        x: u32,
        /// Row of that pixel.
        y: u32,
        /// Value of that pixel in the first image.
        a: Vec3,
        /// Value of that pixel in the second image.
        b: Vec3,
    },
}

/// Checks that two images are equal up to a tolerance at every unmasked pixel, channel by channel.
///
/// A mask of only one image holds for both; two masks must be equal. A pixel that is not finite is close to
/// nothing, itself included.
///
/// # Errors
/// [`Mismatch`], whose message names the worst pixel, its values, and how many pixels exceed the tolerance.
pub fn check_close(a: Image<'_>, b: Image<'_>, tolerance: Tolerance) -> Result<(), Mismatch> {
    let mask = a.common_mask(&b)?;
    let (mut pixels, mut exceeding) = (0, 0);
    let mut worst = (0.0, 0);
    for (i, (p, q)) in a.pixels().iter().zip(b.pixels()).enumerate() {
        if mask.is_some_and(|mask| !mask[i]) {
            continue;
        }
        pixels += 1;
        let excess = (0..3)
            .map(|c| tolerance.excess(f64::from(p[c]), f64::from(q[c])))
            .fold(f64::NEG_INFINITY, f64::max);
        if excess > 0.0 {
            exceeding += 1;
        }
        if excess > worst.0 {
            worst = (excess, i);
        }
    }
    match (pixels, exceeding) {
        (0, _) => Err(Mismatch::NoPixels),
        (_, 0) => Ok(()),
        _ => {
            let (x, y) = a.position(worst.1);
            let (a, b) = (a.pixels()[worst.1], b.pixels()[worst.1]);
            Err(Mismatch::Pixels { exceeding, pixels, tolerance, x, y, a, b })
        }
    }
}
