//! Inputs of frames, and the buffers between stages that callers may look into.

use halflight_core::scene::Camera;

use crate::bindings::Slot;
use crate::gbuffer::Surfaces;

/// Inputs of a frame.
#[derive(Clone, Copy, Debug, Default)]
pub struct Inputs<'a> {
    /// Camera of the frame; the scene's own by default.
    pub camera: Option<Camera>,
    /// Number of the frame: frames differ in their light samples.
    pub frame: u32,
    /// Source of the G-buffer.
    pub surfaces: Surfaces<'a>,
}

/// Buffer between stages; all numbers have 32 bits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Inside {
    /// Queries: pixel, key, samples asked for, place among the samples.
    Queries,
    /// Masks of the samples that were traced, 32 to a word, each query's after the last one's.
    Wanted,
    /// Masks of the samples that were seen, likewise.
    Visible,
    /// Samples: place in pixels (two floats), value (a float, below 0 for none), pixel. One a cell, level by level.
    Samples,
    /// One number a pixel: the level of the cell that it lies in, `u32::MAX` for none.
    Owners,
    /// One float a pixel: irradiance per radiance, or the visible fraction.
    Plane,
    /// Number of queries that `beam` or `raster4d` has left to rays last, then these.
    Spilled,
    /// Sampling plan of an error target: kind, columns and rows of the light samples come first.
    Chosen,
    /// Voxels, behind four numbers and one more a light: texels row by row, slices in words of 64 bits.
    Voxels,
}

impl Inside {
    /// Slot of the buffer.
    pub(crate) fn slot(self) -> Slot {
        match self {
            Self::Queries => Slot::Queries,
            Self::Wanted => Slot::Wanted,
            Self::Visible => Slot::Visible,
            Self::Samples => Slot::Samples,
            Self::Owners => Slot::Owners,
            Self::Plane => Slot::Plane,
            Self::Spilled => Slot::Spilled,
            Self::Chosen => Slot::Chosen,
            Self::Voxels => Slot::Voxels,
        }
    }
}
