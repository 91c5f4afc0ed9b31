//! Pictures as files.

use std::{io, path::Path};

use glam::Vec3;
use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};

use crate::color::srgb_encode;
use crate::file::{WriteError, write_file};

/// Converts linear RGB to 8-bit sRGB: times `exposure`, clamped to 0..1, sRGB transfer function, rounded. NaN
/// becomes 0.
#[must_use]
pub fn tone_map(linear: &[Vec3], exposure: f32) -> Vec<[u8; 3]> {
    let encode = |c: f32| (255.0 * srgb_encode((c * exposure).clamp(0.0, 1.0))).round() as u8;
    linear.iter().map(|pixel| pixel.to_array().map(encode)).collect()
}

/// Writes 8-bit sRGB pixels, rows from the top left, as a PNG file; see [`write_file`] for possible targets
/// of `path`.
///
/// # Errors
/// [`WriteError`] if `rgb` does not hold `width × height` pixels, a side is zero, or the file cannot be
/// written.
pub fn write_png(path: &Path, width: u32, height: u32, rgb: &[[u8; 3]]) -> Result<(), WriteError> {
    let content = png(width, height, rgb).map_err(|source| WriteError { path: path.to_owned(), source })?;
    write_file(path, &content)
}

/// Encodes a PNG file in memory.
fn png(width: u32, height: u32, rgb: &[[u8; 3]]) -> io::Result<Vec<u8>> {
    let pixels = u64::from(width) * u64::from(height);
    if pixels == 0 || pixels != rgb.len() as u64 {
        let found = rgb.len();
        return Err(io::Error::new(
            io::ErrorKind::InvalidInput,
            format!("a picture of {width}×{height} cannot be made of {found} pixels"),
        ));
    }
    let mut content = Vec::new();
    PngEncoder::new(&mut content)
        .write_image(rgb.as_flattened(), width, height, ExtendedColorType::Rgb8)
        .map_err(io::Error::other)?;
    Ok(content)
}
