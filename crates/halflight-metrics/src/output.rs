//! Pictures on disk.

use std::{
    ffi::OsString,
    fs::{self, File},
    io::{self, BufWriter, Write},
    path::{Path, PathBuf},
    process,
    sync::atomic::{AtomicU32, Ordering},
};

use glam::Vec3;
use image::{ExtendedColorType, ImageEncoder, codecs::png::PngEncoder};
use thiserror::Error;

use crate::color::srgb_encode;

/// A file that could not be written. No part of it is left behind.
#[derive(Debug, Error)]
#[error("cannot write {}", path.display())]
pub struct WriteError {
    /// The file.
    pub path: PathBuf,
    /// What went wrong.
    pub source: io::Error,
}

/// Linear RGB as 8-bit sRGB: times `exposure`, clamped to 0..1, sRGB transfer function, rounded. NaN becomes 0.
#[must_use]
pub fn tone_map(linear: &[Vec3], exposure: f32) -> Vec<[u8; 3]> {
    let encode = |c: f32| (255.0 * srgb_encode((c * exposure).clamp(0.0, 1.0))).round() as u8;
    linear.iter().map(|pixel| pixel.to_array().map(encode)).collect()
}

/// Writes 8-bit sRGB pixels, rows from the top left, as a PNG file, whole or not at all.
///
/// # Errors
/// [`WriteError`] where `rgb` does not hold `width × height` pixels, a side is zero, or the file cannot be written.
pub fn write_png(path: &Path, width: u32, height: u32, rgb: &[[u8; 3]]) -> Result<(), WriteError> {
    write_atomically(path, |file| {
        let pixels = u64::from(width) * u64::from(height);
        if pixels == 0 || pixels != rgb.len() as u64 {
            let found = rgb.len();
            return Err(io::Error::new(
                io::ErrorKind::InvalidInput,
                format!("a picture of {width}×{height} cannot be made of {found} pixels"),
            ));
        }
        PngEncoder::new(file)
            .write_image(rgb.as_flattened(), width, height, ExtendedColorType::Rgb8)
            .map_err(io::Error::other)
    })
}

/// Writes a file whole or not at all: `write` fills a temporary file in the same folder, which then takes the name
/// `path`, replacing what was there. On failure the temporary file is removed and `path` is as it was.
///
/// # Errors
/// [`WriteError`] where the temporary file cannot be made, `write` fails, or the renaming does.
pub fn write_atomically(
    path: &Path,
    write: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> Result<(), WriteError> {
    let outcome = temporary_name(path).and_then(|temporary| {
        let mut file = BufWriter::new(File::create_new(&temporary)?);
        let written = write(&mut file).and_then(|()| file.flush());
        // Closed before it is renamed, which some systems insist on.
        drop(file);
        written.and_then(|()| fs::rename(&temporary, path)).inspect_err(|_| {
            // The first error is the one to report.
            let _ = fs::remove_file(&temporary);
        })
    });
    outcome.map_err(|source| WriteError { path: path.to_owned(), source })
}

/// A name in the folder of `path` that no other thread or running process uses.
fn temporary_name(path: &Path) -> io::Result<PathBuf> {
    static COUNTER: AtomicU32 = AtomicU32::new(0);
    let name = path
        .file_name()
        .ok_or_else(|| io::Error::new(io::ErrorKind::InvalidInput, "the path names no file"))?;
    let mut temporary = OsString::from(".");
    temporary.push(name);
    temporary.push(format!(".{}.{}.tmp", process::id(), COUNTER.fetch_add(1, Ordering::Relaxed)));
    Ok(path.with_file_name(temporary))
}
