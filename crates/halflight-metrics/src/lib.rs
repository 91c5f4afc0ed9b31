//! Error measures for rendered images.
//!
//! * [`compare`] compares an image with a reference and returns every error measure the project reports, as
//!   one serialisable [`Comparison`]. Error targets are stated in its `nmse2`.
//! * Two of them follow the eye where sums over the image do not: [`Comparison::flip_p99`] and
//!   [`Comparison::grain`]; see the table below.
//! * [`halves_noise`] estimates the remaining error of a reference, from two independent halves of it.
//! * [`flicker`] measures changes between two frames that the reference does not have.
//! * [`error_map`] and [`squared_error_picture`] show the error at each pixel, at a scale fixed by the
//!   caller.
//! * [`check_close`] is the project's only approximate comparison for tests.
//! * [`tone_map`], [`write_png`] and [`write_file`] write pictures to files, pipes and standard output.
//!
//! Errors that are seen, from a ball above a floor (640 × 480, penumbrae 20 to 90 pixels wide) against 4096 samples a
//! pixel, in fourfold zoom at the exposure of `halflight render --png`:
//!
//! | `grain` | seen in a penumbra | example |
//! | --- | --- | --- |
//! | to 0.03 | smooth | 1024 samples a pixel: 0.026 |
//! | to 0.06 | traces along the umbra's edge: stairs, dots | `--error 1e-5`: 0.038 |
//! | to 0.15 | blotches or noise in zoom | `--error 1e-4`: 0.083; 256 samples a pixel: 0.063 |
//! | above | noise at normal size | 64 samples a pixel: 0.17; 16: 0.48 |
//!
//! | `flip_p99` | seen anywhere in the image | example |
//! | --- | --- | --- |
//! | to 0.03 | nothing | 256 samples a pixel: 0.025; 1024: 0.013 |
//! | to 0.06 | traces in zoom | `--error 1e-5`: 0.047; 64 samples a pixel: 0.052 |
//! | to 0.15 | blotches or noise | `--error 1e-4`: 0.095; 16 samples a pixel: 0.11 |
//! | above | wrong shapes or brightness | |
//!
//! A reference has grain of its own, 0.013 here: what is to be judged by grain needs 4096 samples a pixel or more.
//!
//! Images are borrowed: linear RGB in rows from the top left, with an optional mask of the pixels to compare
//! (for rendered images the receivers: no background, no emitters) and, for references, the visible fraction of the light at
//! each pixel, which tells the penumbra. The crate is independent of scenes and
//! renderers. Sums are computed in `f64` and in pixel order, so that a result does not depend on the number
//! of threads.
//!
//! ```
//! use glam::Vec3;
//! use halflight_metrics::{Image, compare};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let reference = [Vec3::splat(1.0), Vec3::splat(2.0)];
//! let rendered = [Vec3::splat(1.0), Vec3::splat(2.5)];
//! let errors = compare(Image::new(2, 1, &rendered)?, Image::new(2, 1, &reference)?)?;
//! assert_eq!(errors.sse, 0.75); // 3 channels × 0.5²
//! assert_eq!(errors.nmse2, 0.05); // over 3 × (1² + 2²)
//! # Ok(())
//! # }
//! ```

mod close;
mod color;
mod compare;
mod file;
mod filter;
mod flicker;
mod flip;
mod grain;
mod map;
mod output;
mod pair;
mod percentile;
mod ssim;
mod view;

pub use close::{Mismatch, Tolerance, check_close};
pub use color::luminance;
pub use compare::{Comparison, compare, halves_noise, nmse2};
pub use file::{WriteError, check_output, is_same_file, is_standard_output, is_stream, write_file};
pub use flicker::{Flicker, flicker};
pub use grain::grain;
pub use map::{ErrorMap, error_map, squared_error_picture};
pub use output::{tone_map, write_png};
pub use pair::{CompareError, PENUMBRA, Role};
pub use view::{Image, ImageError, ShapeMismatch};
