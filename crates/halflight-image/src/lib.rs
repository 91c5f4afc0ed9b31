//! Images of Halflight: OpenEXR files with all layers of a frame, and pictures of it to look at.
//!
//! * [`ExrFile`] holds named channels of one size. [`ExrFile::read`] reads OpenEXR files of any program, [`ExrFile::write`]
//!   writes 32-bit floats without loss.
//! * [`picture`] makes 8-bit sRGB pixels: the tone-mapped image, and false-colour maps of fragments and errors.
//!   [`halflight_metrics::write_png`] puts them into files.
//! * [`memory`] tells how many bytes can be had, so that images that do not fit are refused by an error.
//!
//! Pixels are stored row by row from the top left; pixel (x, y) has index y · width + x. Irradiance is in W/m², radiance in
//! W/m²/sr, both linear RGB.
//!
//! ```
//! use halflight_image::{ExrFile, RGB};
//! use halflight_image::glam::Vec3;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! # let folder = tempfile::tempdir()?;
//! # let path = folder.path().join("image.exr");
//! let radiance = [Vec3::new(0.5, 0.25, 0.0), Vec3::ONE];
//! let mut file = ExrFile::new(2, 1, Default::default());
//! file.add_vectors("radiance", RGB, &radiance);
//! file.write(&path)?;
//! assert_eq!(ExrFile::read(&path)?.layer("radiance")?, radiance);
//! # Ok(())
//! # }
//! ```

mod exr_file;
pub mod memory;
pub mod picture;

pub use exr_file::{
    DEFAULT_LAYER, ExrFile, INDIRECT, INDIRECT_IRRADIANCE, METADATA, RGB, ReadError, VISIBILITY, Window, XYZ,
    layer_in_words,
};
pub use glam;
