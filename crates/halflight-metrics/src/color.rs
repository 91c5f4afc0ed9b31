//! Colour conversions of the measures. Linear RGB has sRGB (Rec. 709) primaries and white point D65.

use glam::{DMat3, DVec3};

/// Linear sRGB to CIE XYZ, derived from the chromaticities of IEC 61966-2-1 (as in CSS Color 4, §10). By
/// columns.
const XYZ_FROM_RGB: DMat3 = DMat3::from_cols(
    DVec3::new(0.412_390_799_265_96, 0.212_639_005_871_51, 0.019_330_818_715_59),
    DVec3::new(0.357_584_339_383_88, 0.715_168_678_767_76, 0.119_194_779_794_63),
    DVec3::new(0.180_480_788_401_83, 0.072_192_315_360_73, 0.950_532_152_249_66),
);

/// Returns the luminance of linear RGB, of which white (1, 1, 1) has 1.
#[must_use]
pub fn luminance(rgb: DVec3) -> f64 {
    XYZ_FROM_RGB.row(1).dot(rgb)
}

/// sRGB transfer function (IEC 61966-2-1) of a linear value in 0..1.
pub(crate) fn srgb_encode(linear: f32) -> f32 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// Conversions between linear RGB and the two spaces of ꟻLIP; holds the inverse matrix and the white point.
pub(crate) struct Spaces {
    rgb_from_xyz: DMat3,
    white: DVec3,
}

impl Spaces {
    pub(crate) fn new() -> Self {
        Self { rgb_from_xyz: XYZ_FROM_RGB.inverse(), white: XYZ_FROM_RGB * DVec3::ONE }
    }

    /// YCxCz: the linearised L*a*b* in which contrast sensitivity filters are defined. Y is −16..100.
    pub(crate) fn ycxcz_from_rgb(&self, rgb: DVec3) -> DVec3 {
        let t = XYZ_FROM_RGB * rgb / self.white;
        DVec3::new(116.0 * t.y - 16.0, 500.0 * (t.x - t.y), 200.0 * (t.y - t.z))
    }

    pub(crate) fn rgb_from_ycxcz(&self, c: DVec3) -> DVec3 {
        let y = (c.x + 16.0) / 116.0;
        self.rgb_from_xyz * (DVec3::new(y + c.y / 500.0, y, y - c.z / 200.0) * self.white)
    }

    /// CIE 1976 L*a*b*. L is 0..100.
    pub(crate) fn lab_from_rgb(&self, rgb: DVec3) -> DVec3 {
        const DELTA: f64 = 6.0 / 29.0;
        let f = (XYZ_FROM_RGB * rgb / self.white).to_array().map(|t| {
            if t > DELTA * DELTA * DELTA { t.cbrt() } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 }
        });
        DVec3::new(116.0 * f[1] - 16.0, 500.0 * (f[0] - f[1]), 200.0 * (f[1] - f[2]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ycxcz_round_trips() {
        let spaces = Spaces::new();
        let rgb = DVec3::new(0.9, 0.2, 0.05);
        let back = spaces.rgb_from_ycxcz(spaces.ycxcz_from_rgb(rgb));
        // Two 3×3 products in f64: a few ulp of values near 1.
        assert!((back - rgb).abs().max_element() < 1e-13, "{back}");
    }

    #[test]
    fn white_and_black_are_neutral() {
        let spaces = Spaces::new();
        // The white point is the matrix' own, so only rounding is left.
        assert!((spaces.lab_from_rgb(DVec3::ONE) - DVec3::new(100.0, 0.0, 0.0)).length() < 1e-10);
        assert!(spaces.lab_from_rgb(DVec3::ZERO).length() < 1e-10);
        assert!((luminance(DVec3::ONE) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn srgb_green_has_its_known_lab_value() {
        let lab = Spaces::new().lab_from_rgb(DVec3::new(0.0, 1.0, 0.0));
        // Published value of the sRGB green primary under D65, which tables give to two decimals.
        assert!((lab - DVec3::new(87.73, -86.18, 83.18)).abs().max_element() < 0.01, "{lab}");
    }
}
