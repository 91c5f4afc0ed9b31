//! The one approximate comparison of the project's tests.

use std::fmt;

use glam::Vec3;
use thiserror::Error;

use crate::view::{Image, ShapeMismatch};

/// How far apart two values may be: `absolute + relative · max(|a|, |b|)`.
///
/// Say next to every tolerance why it is what it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance {
    /// In the unit of the values.
    pub absolute: f64,
    /// A share of the larger of the two values.
    pub relative: f64,
}

impl Tolerance {
    /// Allows a fixed distance.
    #[must_use]
    pub fn absolute(absolute: f64) -> Self {
        Self { absolute, relative: 0.0 }
    }

    /// Allows a share of the larger value.
    #[must_use]
    pub fn relative(relative: f64) -> Self {
        Self { absolute: 0.0, relative }
    }

    /// Whether two values are close. NaN is close to nothing, an infinity to nothing either.
    #[must_use]
    pub fn accepts(&self, a: f64, b: f64) -> bool {
        self.excess(a, b) <= 0.0
    }

    /// By how much two values are too far apart; infinite where their distance or the tolerance is no number.
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
    /// Some pixels are too far apart.
    #[error(
        "{exceeding} of {pixels} pixels differ by more than {tolerance}; the worst is ({x}, {y}): \
         [{}, {}, {}] against [{}, {}, {}]",
        a.x, a.y, a.z, b.x, b.y, b.z
    )]
    Pixels {
        /// How many pixels are too far apart in some channel.
        exceeding: usize,
        /// How many pixels were checked.
        pixels: usize,
        /// What was allowed.
        tolerance: Tolerance,
        /// Column of the pixel that exceeds the tolerance by most.
        x: u32,
        /// Row of that pixel.
        y: u32,
        /// Its value in the first image.
        a: Vec3,
        /// Its value in the second image.
        b: Vec3,
    },
}

/// Checks that two images are equal up to a tolerance at every pixel that takes part, channel by channel.
///
/// A mask given by one of the images holds for both; two masks must be equal. A pixel that is not finite is close to
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
