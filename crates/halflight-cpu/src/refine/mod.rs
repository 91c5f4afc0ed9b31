//! Refiners: they choose the fragments of an image.

pub(crate) mod discontinuities;
mod lattice;
mod nichols;
mod per_pixel;
pub(crate) mod pixel_set;
mod quality;
mod representative;
mod sfvt_gass;
mod target;
#[cfg(test)]
mod tests;

pub use lattice::{Lattice, LatticeConfig};
pub use nichols::{Nichols, NicholsConfig};
pub use per_pixel::PerPixel;
pub use quality::{Quality, UnknownQuality};
pub use sfvt_gass::{SfvtGass, SfvtGassConfig};
pub use target::{Budget, Steps};

pub use crate::tangent_plane::DiscontinuityLimits;

use halflight_core::frame::Frame;
use halflight_core::mask::MaskBatch;
use halflight_core::pattern::Pattern;
use halflight_core::stages::Visibility;
use rayon::prelude::*;

/// Thresholds at which geometry alone splits a fragment. None of the papers gives values.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct GeometryThresholds {
    /// Depth difference between neighbouring pixels, relative to depth, above which a fragment is split. A
    /// floor seen at a glancing angle has differences of (pixel angle) × distance ÷ eye height, about 0.01
    /// across a hall.
    pub depth: f32,
    /// Curvature (chord between neighbouring unit normals) above which a fragment is split; 0.2 is 11°.
    pub curvature: f32,
}

impl Default for GeometryThresholds {
    fn default() -> Self {
        Self { depth: 0.05, curvature: 0.2 }
    }
}

/// Cell to be processed, in units of cells of its level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Pending {
    x: u32,
    y: u32,
    /// True if the cell must be rendered, whatever its geometry (Nichols10: the coarser result showed an
    /// illumination discontinuity).
    forced: bool,
}

/// Traces complete masks at receiver pixels, one query per pixel in their order.
fn trace_pixels(
    frame: &Frame,
    light: u32,
    pixels: &[u32],
    visibility: &mut dyn Visibility,
    batch: &mut MaskBatch,
) {
    batch.fill(pixels.len()).par_iter_mut().zip(pixels).with_min_len(1024).for_each(|(query, &pixel)| {
        if let Some(receiver) = frame.gbuffer.receiver(pixel as usize) {
            (query.origin, query.normal) = (receiver.origin, receiver.normal);
            query.pixel = pixel;
            query.key = frame.key(light, pixel, pixel);
        }
    });
    visibility.masks(frame, batch);
}

/// Index of the receiver, of four that share a pattern, that traces a sample. Each traces every other column
/// of every other row, so that its rays spread over the whole light. The samples of a single row or column
/// are assigned in turn.
fn quarter(pattern: Pattern, sample: usize) -> usize {
    let columns = usize::from(pattern.columns);
    let (column, row) = (sample % columns, sample / columns);
    if columns > 1 && pattern.rows > 1 { (column & 1) | (row & 1) << 1 } else { sample & 3 }
}
