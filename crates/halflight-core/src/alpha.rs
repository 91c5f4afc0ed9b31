//! Alpha masks: the solid texels and the holes of a surface, one bit a texel.

use glam::DVec2;

/// Alpha from which on texels are solid where nothing else is asked for.
pub const DEFAULT_CUTOFF: f32 = 0.5;

/// Solid texels of an image, of a material that has holes: leaves, chains, fences.
///
/// Light passes through the holes and the camera sees what lies behind them. A point of a surface takes the texel that it lies in, without
/// interpolation; the image repeats beyond the unit square.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AlphaMask {
    width: u32,
    height: u32,
    /// Texels row by row from the top, 64 a word.
    solid: Vec<u64>,
}

/// Reasons why an alpha mask cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum AlphaMaskError {
    /// The number of texels is not the product of the sides, or there are none.
    #[error("an alpha mask of {width} x {height} texels has {found}, expected their product, at least 1")]
    Size {
        /// Width in texels.
        width: u32,
        /// Height in texels.
        height: u32,
        /// Number of texels that were given.
        found: usize,
    },
    /// The cutoff is no alpha.
    #[error("the cutoff of an alpha mask is {cutoff}, expected a number from 0 to 1")]
    Cutoff {
        /// The cutoff that was given.
        cutoff: f32,
    },
}

impl AlphaMask {
    /// Makes the mask of an image, given its alpha row by row from the top. A texel is solid if its alpha, divided by 255, is `cutoff`
    /// (0 … 1) or more.
    ///
    /// # Errors
    /// The image has no texels or another number than its sides say, or the cutoff is outside 0 … 1.
    pub fn new(
        width: u32,
        height: u32,
        alpha: impl ExactSizeIterator<Item = u8>,
        cutoff: f32,
    ) -> Result<Self, AlphaMaskError> {
        if !(0.0..=1.0).contains(&cutoff) {
            return Err(AlphaMaskError::Cutoff { cutoff });
        }
        let found = alpha.len();
        if found == 0 || found as u64 != u64::from(width) * u64::from(height) {
            return Err(AlphaMaskError::Size { width, height, found });
        }
        let mut solid = vec![0; found.div_ceil(64)];
        for (texel, alpha) in alpha.enumerate() {
            solid[texel / 64] |= u64::from(f32::from(alpha) / 255.0 >= cutoff) << (texel % 64);
        }
        Ok(Self { width, height, solid })
    }

    /// Returns true if the texel at texture coordinates `uv` is solid; (0, 0) is the lower left of the image. Infinite coordinates and NaN
    /// take the first column or row.
    #[inline]
    pub fn is_solid(&self, uv: DVec2) -> bool {
        // The part after the point can round up to 1, and is NaN for an infinite coordinate.
        let place = |unit: f64, size: u32| {
            (((unit - unit.floor()) * f64::from(size)) as usize).min(size as usize - 1)
        };
        let (column, row_from_below) = (place(uv.x, self.width), place(uv.y, self.height));
        let texel = (self.height as usize - 1 - row_from_below) * self.width as usize + column;
        self.solid[texel / 64] >> (texel % 64) & 1 == 1
    }

    /// Width in texels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Height in texels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Returns true if there is no hole.
    pub fn is_opaque(&self) -> bool {
        self.solid.iter().map(|word| word.count_ones() as usize).sum::<usize>()
            == self.width as usize * self.height as usize
    }

    /// The bits, row by row from the top, 64 texels a word: 1 is solid.
    pub fn words(&self) -> &[u64] {
        &self.solid
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texels_at_the_cutoff_are_solid() {
        let solid = |alpha: [u8; 2], cutoff| {
            let mask = AlphaMask::new(2, 1, alpha.into_iter(), cutoff).unwrap();
            [0.25, 0.75].map(|u| mask.is_solid(DVec2::new(u, 0.5)))
        };
        assert_eq!(solid([127, 128], 0.5), [false, true]);
        assert_eq!(solid([50, 51], 0.2), [false, true]);
        assert_eq!(solid([254, 255], 1.0), [false, true]);
        assert_eq!(solid([0, 255], 0.0), [true, true]);
    }

    #[test]
    fn masks_repeat_and_have_their_origin_below() {
        // Solid: the upper left and the lower right of 3 x 2 texels.
        let mask = AlphaMask::new(3, 2, [255, 0, 0, 0, 0, 255].into_iter(), 0.5).unwrap();
        let expected = [[false, false, true], [true, false, false]];
        for (row, expected) in expected.into_iter().enumerate() {
            for (column, expected) in expected.into_iter().enumerate() {
                let uv = DVec2::new((column as f64 + 0.5) / 3.0, (row as f64 + 0.5) / 2.0);
                for shift in [0.0, 1.0, -1.0, 7.0, -12.0] {
                    assert_eq!(mask.is_solid(uv + shift), expected, "{uv} {shift}");
                }
            }
        }
        // Just below 0, where the part after the point rounds up to 1, and what is no number.
        assert!(!mask.is_solid(DVec2::new(-1e-300, 0.75)) && mask.is_solid(DVec2::new(-1e-300, 0.25)));
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert!(!mask.is_solid(DVec2::splat(bad)));
        }
        assert!(!mask.is_opaque() && AlphaMask::new(9, 9, [1; 81].into_iter(), 0.0).unwrap().is_opaque());
    }

    #[test]
    fn bad_masks_are_refused() {
        let mask = |width, height, cutoff| AlphaMask::new(width, height, [0; 4].into_iter(), cutoff);
        assert!(mask(2, 2, 0.5).is_ok());
        for (width, height) in [(2, 1), (0, 4), (65_536, 65_537)] {
            assert!(matches!(mask(width, height, 0.5), Err(AlphaMaskError::Size { .. })));
        }
        for cutoff in [-0.1, 1.1, f32::NAN] {
            assert!(matches!(mask(2, 2, cutoff), Err(AlphaMaskError::Cutoff { .. })));
        }
        assert!(AlphaMask::new(0, 0, [].into_iter(), 0.5).is_err());
    }
}
