//! What comes back with every frame besides the image.

use serde::{Deserialize, Serialize};

use crate::fragment::LEVELS;

/// Shadow rays, in the three columns that papers mix up.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct RayCounts {
    /// Traced to decide on refinement.
    pub refine: u64,
    /// Traced for irradiance alone: level-0 fragments and additional samples.
    #[serde(rename = "final")]
    pub last: u64,
    /// Not traced, because the sample lies below the receiver's or the light's horizon.
    pub skipped: u64,
    /// All traced rays.
    pub total: u64,
}

/// Wall-clock milliseconds of each stage.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StageTimes {
    /// Primary visibility and surface attributes.
    pub gbuffer: f64,
    /// Discontinuity mipmaps.
    pub pyramid: f64,
    /// Refinement without the visibility it asks for.
    pub refine: f64,
    /// Masks, with per-frame preparation of the backend and horizon culling.
    pub visibility: f64,
    /// Values of the samples from their masks.
    pub irradiance: f64,
    /// One value a pixel from the samples.
    pub upsample: f64,
    /// Unshadowed irradiance, product and sum over the lights.
    pub compose: f64,
}

/// Fragments of a frame, all lights together.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct FragmentCounts {
    /// All samples.
    pub total: u64,
    /// Samples of each level, 0 first.
    pub per_level: [u64; LEVELS],
}

/// Statistics of one frame.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FrameStats {
    /// Fragments by level.
    pub fragments: FragmentCounts,
    /// Shadow rays by purpose.
    pub rays: RayCounts,
    /// Time by stage.
    pub stages_ms: StageTimes,
    /// Time of the whole frame.
    pub total_ms: f64,
    /// Most bytes held by the pipeline and its stages at the end of any frame so far.
    pub peak_bytes: u64,
}
