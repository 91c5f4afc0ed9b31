//! The borrowed image every function of this crate takes.

use glam::Vec3;
use thiserror::Error;

/// A borrowed linear RGB image, rows from the top left, with an optional mask of the pixels that take part.
///
/// Pixels outside the mask may hold anything, NaN included: they are never read as values.
#[derive(Clone, Copy, Debug)]
pub struct Image<'a> {
    width: u32,
    height: u32,
    pixels: &'a [Vec3],
    mask: Option<&'a [bool]>,
}

impl<'a> Image<'a> {
    /// Borrows `width × height` pixels, all of which take part.
    ///
    /// # Errors
    /// [`ImageError`] where a side is zero or the number of pixels is not `width × height`.
    pub fn new(width: u32, height: u32, pixels: &'a [Vec3]) -> Result<Self, ImageError> {
        let expected = u64::from(width) * u64::from(height);
        if expected == 0 {
            return Err(ImageError::Empty { width, height });
        }
        if pixels.len() as u64 != expected {
            return Err(ImageError::PixelCount { width, height, expected, found: pixels.len() });
        }
        Ok(Self { width, height, pixels, mask: None })
    }

    /// Lets only the pixels take part whose entry in `mask` is true.
    ///
    /// # Errors
    /// [`ImageError::MaskCount`] where the mask does not have one entry a pixel.
    pub fn with_mask(self, mask: &'a [bool]) -> Result<Self, ImageError> {
        if mask.len() != self.pixels.len() {
            return Err(ImageError::MaskCount { expected: self.pixels.len(), found: mask.len() });
        }
        Ok(Self { mask: Some(mask), ..self })
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

    /// The pixels, masked ones included.
    #[must_use]
    pub fn pixels(&self) -> &'a [Vec3] {
        self.pixels
    }

    /// The mask, true for a pixel that takes part; `None` where all do.
    #[must_use]
    pub fn mask(&self) -> Option<&'a [bool]> {
        self.mask
    }

    /// Column and row of a pixel index.
    pub(crate) fn position(&self, index: usize) -> (u32, u32) {
        let width = self.width as usize;
        ((index % width) as u32, (index / width) as u32)
    }

    /// The mask two images share.
    ///
    /// A mask given by only one image holds for both. Two masks must agree: taking their intersection would let an
    /// image hide its worst pixels by calling them invalid.
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

/// Pixels or mask that do not fit the size of an [`Image`].
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum ImageError {
    /// A side is zero.
    #[error("an image of {width}×{height} has no pixels; both sides must be at least 1")]
    Empty {
        /// Width in pixels.
        width: u32,
        /// Height in pixels.
        height: u32,
    },
    /// Not one value a pixel.
    #[error("an image of {width}×{height} needs {expected} pixels, found {found}")]
    PixelCount {
        /// Width in pixels.
        width: u32,
        /// Height in pixels.
        height: u32,
        /// `width × height`.
        expected: u64,
        /// The number of pixels given.
        found: usize,
    },
    /// Not one mask entry a pixel.
    #[error("the mask needs one entry for each of the {expected} pixels, found {found}")]
    MaskCount {
        /// The number of pixels.
        expected: usize,
        /// The number of mask entries given.
        found: usize,
    },
}

/// Two images that cannot be set against each other pixel by pixel.
#[derive(Clone, Debug, Error, PartialEq, Eq)]
#[non_exhaustive]
pub enum ShapeMismatch {
    /// Their sizes differ.
    #[error("the images differ in size: {}×{} against {}×{}", a.0, a.1, b.0, b.1)]
    Size {
        /// Width and height of the first image.
        a: (u32, u32),
        /// Width and height of the second image.
        b: (u32, u32),
    },
    /// Both have a mask and the masks disagree.
    #[error(
        "the images' masks disagree at {pixels} pixels, the first at ({x}, {y}); give both the same mask"
    )]
    Mask {
        /// How many pixels are in one mask only.
        pixels: usize,
        /// Column of the first.
        x: u32,
        /// Row of the first.
        y: u32,
    },
}
