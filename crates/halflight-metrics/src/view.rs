//! Borrowed image, the argument of every function of this crate.

use glam::Vec3;
use thiserror::Error;

/// Borrowed linear RGB image, rows from the top left, with an optional mask of the pixels to compare
/// and, for references, the visible fraction of the light at each pixel.
///
/// Pixels outside the mask may have any value, NaN included: they are never read as values.
#[derive(Clone, Copy, Debug)]
pub struct Image<'a> {
    width: u32,
    height: u32,
    pixels: &'a [Vec3],
    mask: Option<&'a [bool]>,
    fractions: Option<&'a [f32]>,
}

impl<'a> Image<'a> {
    /// Borrows `width × height` pixels, none of them masked.
    ///
    /// # Errors
    /// [`ImageError`] if a side is zero or the number of pixels is not `width × height`.
    pub fn new(width: u32, height: u32, pixels: &'a [Vec3]) -> Result<Self, ImageError> {
        let expected = u64::from(width) * u64::from(height);
        if expected == 0 {
            return Err(ImageError::Empty { width, height });
        }
        if pixels.len() as u64 != expected {
            return Err(ImageError::PixelCount { width, height, expected, found: pixels.len() });
        }
        Ok(Self { width, height, pixels, mask: None, fractions: None })
    }

    /// Masks all pixels whose entry in `mask` is false.
    ///
    /// # Errors
    /// [`ImageError::MaskCount`] if the mask does not have one entry per pixel.
    pub fn with_mask(self, mask: &'a [bool]) -> Result<Self, ImageError> {
        if mask.len() != self.pixels.len() {
            return Err(ImageError::MaskCount { expected: self.pixels.len(), found: mask.len() });
        }
        Ok(Self { mask: Some(mask), ..self })
    }

    /// Tells the visible fraction of the light at each pixel, 0 to 1; a NaN where there is none. The fractions of a
    /// reference say which of its pixels lie in a penumbra, where [`Comparison::grain`](crate::Comparison::grain) is
    /// measured; those of an image under test are not used.
    ///
    /// # Errors
    /// [`ImageError::FractionCount`] if there is not one fraction per pixel.
    pub fn with_visible_fractions(self, fractions: &'a [f32]) -> Result<Self, ImageError> {
        if fractions.len() != self.pixels.len() {
            return Err(ImageError::FractionCount { expected: self.pixels.len(), found: fractions.len() });
        }
        Ok(Self { fractions: Some(fractions), ..self })
    }

    /// Width in pixels, at least 1.
    #[must_use]
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Height in pixels, at least 1.
    #[must_use]
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Pixels of the image, masked ones included.
    #[must_use]
    pub fn pixels(&self) -> &'a [Vec3] {
        self.pixels
    }

    /// Mask of the image, true for a pixel to compare; `None` if no pixel is masked.
    #[must_use]
    pub fn mask(&self) -> Option<&'a [bool]> {
        self.mask
    }

    /// Visible fractions of the light, one a pixel; `None` if they are not known.
    #[must_use]
    pub fn visible_fractions(&self) -> Option<&'a [f32]> {
        self.fractions
    }

    /// Column and row of a pixel index.
    pub(crate) fn position(&self, index: usize) -> (u32, u32) {
        let width = self.width as usize;
        ((index % width) as u32, (index / width) as u32)
    }

    /// Common mask of two images.
    ///
    /// A mask of only one image holds for both. Two masks must be equal: with their intersection, an image
    /// could hide its worst pixels by masking them.
    pub(crate) fn common_mask(&self, other: &Self) -> Result<Option<&'a [bool]>, ShapeMismatch> {
        if (self.width, self.height) != (other.width, other.height) {
            return Err(ShapeMismatch::Size { a: (self.width, self.height), b: (other.width, other.height) });
        }
        if let (Some(a), Some(b)) = (self.mask, other.mask) {
            let mut differing = (0..a.len()).filter(|&i| a[i] != b[i]);
            if let Some(first) = differing.next() {
                let (x, y) = self.position(first);
                return Err(ShapeMismatch::Mask { pixels: 1 + differing.count(), x, y });
            }
        }
        Ok(self.mask.or(other.mask))
    }
}

/// Pixels, mask or visible fractions that do not fit the size of an [`Image`].
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum ImageError {
    /// Side of length zero.
    #[error("an image of {width}×{height} has no pixels; both sides must be at least 1")]
    Empty {
        /// Width in pixels.
        width: u32,
        /// Height in pixels.
        height: u32,
    },
    /// Number of pixels that is not `width × height`.
    #[error("an image of {width}×{height} needs {expected} pixels, found {found}")]
    PixelCount {
        /// Width in pixels.
        width: u32,
        /// Height in pixels.
        height: u32,
        /// `width × height`.
        expected: u64,
        /// Number of pixels given.
        found: usize,
    },
    /// Number of mask entries that is not the number of pixels.
    #[error("the mask needs one entry for each of the {expected} pixels, found {found}")]
    MaskCount {
        /// Number of pixels.
        expected: usize,
        /// Number of mask entries given.
        found: usize,
    },
    /// Number of visible fractions that is not the number of pixels.
    #[error("there must be one visible fraction for each of the {expected} pixels, found {found}")]
    FractionCount {
        /// Number of pixels.
        expected: usize,
        /// Number of fractions given.
        found: usize,
    },
}

/// Error of comparing two images pixel by pixel.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum ShapeMismatch {
    /// Different sizes.
    #[error("the images differ in size: {}×{} against {}×{}", a.0, a.1, b.0, b.1)]
    Size {
        /// Width and height of the first image.
        a: (u32, u32),
        /// Width and height of the second image.
        b: (u32, u32),
    },
    /// Different masks.
    #[error(
        "the images' masks disagree at {pixels} pixels, the first at ({x}, {y}); give both the same mask"
    )]
    Mask {
        /// Number of pixels that are in one mask only.
        pixels: usize,
        /// Column of the first.
        x: u32,
        /// Row of the first.
        y: u32,
    },
}
