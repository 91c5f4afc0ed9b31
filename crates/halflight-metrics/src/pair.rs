//! Image and its reference, validated once so that the measures themselves cannot fail.

use std::fmt;
use std::ops::RangeInclusive;

use glam::{DVec3, Vec3};
use thiserror::Error;

use crate::view::{Image, ShapeMismatch};

/// Role of the image to which an error refers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Image under test.
    Image,
    /// Reference for the image under test.
    Reference,
}

impl fmt::Display for Role {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Image => "image",
            Self::Reference => "reference",
        })
    }
}

/// Error of comparing two images.
#[derive(Clone, Debug, Error, PartialEq)]
#[non_exhaustive]
pub enum CompareError {
    /// Sizes or masks differ.
    #[error(transparent)]
    Shape(#[from] ShapeMismatch),
    /// Unmasked pixel that is NaN or infinite.
    #[error("pixel ({x}, {y}) of the {role} is not finite: [{}, {}, {}]", value.x, value.y, value.z)]
    NotFinite {
        /// Role of the pixel's image.
        role: Role,
        /// Column.
        x: u32,
        /// Row.
        y: u32,
        /// Linear RGB value of the pixel.
        value: Vec3,
    },
    /// Mask that is false everywhere.
    #[error("no pixel takes part in the comparison: the mask is false everywhere")]
    NoPixels,
    /// Black reference, for which relative errors are undefined.
    #[error("the reference is zero at every pixel that takes part, so relative errors are undefined")]
    ZeroReference,
}

/// Visible fractions of pixels in a penumbra: 0 and 1 with a margin for the noise of a reference.
pub const PENUMBRA: RangeInclusive<f32> = 0.002..=0.998;

/// Two images of one size whose unmasked pixels are finite, with a reference that is not all zero.
pub(crate) struct Pair<'a> {
    pub(crate) width: usize,
    image: &'a [Vec3],
    reference: &'a [Vec3],
    mask: Option<&'a [bool]>,
    /// Visible fractions of the reference.
    fractions: Option<&'a [f32]>,
    /// Number of unmasked pixels.
    pub(crate) count: usize,
    /// Largest absolute channel value of the reference, by which both images are divided.
    pub(crate) peak: f64,
}

impl<'a> Pair<'a> {
    pub(crate) fn new(image: Image<'a>, reference: Image<'a>) -> Result<Self, CompareError> {
        let mask = image.common_mask(&reference)?;
        let mut pair = Self {
            width: image.width() as usize,
            image: image.pixels(),
            reference: reference.pixels(),
            mask,
            fractions: reference.visible_fractions(),
            count: 0,
            peak: 0.0,
        };
        let (mut count, mut peak) = (0, 0.0_f32);
        for i in pair.indices() {
            for (role, value) in [(Role::Image, pair.image[i]), (Role::Reference, pair.reference[i])] {
                if !value.is_finite() {
                    let (x, y) = image.position(i);
                    return Err(CompareError::NotFinite { role, x, y, value });
                }
            }
            count += 1;
            peak = peak.max(pair.reference[i].abs().max_element());
        }
        if count == 0 {
            return Err(CompareError::NoPixels);
        }
        if peak == 0.0 {
            return Err(CompareError::ZeroReference);
        }
        (pair.count, pair.peak) = (count, f64::from(peak));
        Ok(pair)
    }

    /// Number of pixels in the image, masked ones included.
    pub(crate) fn len(&self) -> usize {
        self.reference.len()
    }

    pub(crate) fn takes_part(&self, index: usize) -> bool {
        self.mask.is_none_or(|mask| mask[index])
    }

    /// Indices of the unmasked pixels, in order.
    pub(crate) fn indices(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.len()).filter(|&i| self.takes_part(i))
    }

    /// Indices of the unmasked pixels in the penumbra, in order; none where the reference has no visible fractions.
    pub(crate) fn penumbra(&self) -> Vec<usize> {
        let Some(fractions) = self.fractions else { return Vec::new() };
        self.indices().filter(|&i| PENUMBRA.contains(&fractions[i])).collect()
    }

    /// Image and reference values of the unmasked pixels, in order.
    pub(crate) fn values(&self) -> impl Iterator<Item = (DVec3, DVec3)> + '_ {
        self.indices().map(|i| self.at(i))
    }

    /// Image and reference values of an unmasked pixel.
    pub(crate) fn at(&self, index: usize) -> (DVec3, DVec3) {
        (self.image[index].as_dvec3(), self.reference[index].as_dvec3())
    }

    /// Values for each pixel from image and reference divided by the peak; `masked` elsewhere.
    pub(crate) fn map_relative<T: Clone>(&self, masked: T, value: impl Fn(DVec3, DVec3) -> T) -> Vec<T> {
        let mut out = vec![masked; self.len()];
        for i in self.indices() {
            out[i] = value(self.image[i].as_dvec3() / self.peak, self.reference[i].as_dvec3() / self.peak);
        }
        out
    }
}
