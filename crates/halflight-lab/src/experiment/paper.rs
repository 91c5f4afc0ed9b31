//! Figures of a paper in an experiment file.

use serde::{Deserialize, Serialize};

/// Figures of a paper.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Paper {
    /// Name of the paper, table or figure.
    pub source: String,
    /// Differences between the paper's figures and ours.
    pub differs: String,
    /// Samples a pixel of a second reference, of the kind that the paper measures against.
    pub reference_samples: Option<u32>,
    /// Rows of its table; may be empty.
    #[serde(default, rename = "row")]
    pub rows: Vec<PaperRow>,
}

/// Row of a paper's table, and the choice of our rows that stand beside it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PaperRow {
    /// Name in the paper.
    pub label: String,
    /// Our scene.
    pub scene: String,
    /// Our refiner.
    #[serde(deserialize_with = "super::refiner_name")]
    pub refiner: String,
    /// Our visibility backend, if only one is meant.
    pub visibility: Option<String>,
    /// Our constants, as in the column `parameters`, if only one set is meant.
    pub parameters: Option<String>,
    /// Our light samples, if only one number is meant.
    pub samples: Option<u32>,
    /// Our upsampler, if only one is meant.
    pub upsampler: Option<String>,
    /// Our shading, if only one is meant.
    pub shading: Option<String>,
    /// Our light scale, if only one is meant.
    pub light_scale: Option<f32>,
    /// Triangles.
    pub triangles: Option<u64>,
    /// Fragments.
    pub fragments: Option<u64>,
    /// Visibility rays.
    pub rays: Option<u64>,
    /// Time of visibility tests, ms.
    pub visibility_ms: Option<f64>,
    /// Time of irradiance, ms.
    pub irradiance_ms: Option<f64>,
    /// Time of upsampling, ms.
    pub upsample_ms: Option<f64>,
    /// Time of the frame, ms.
    pub total_ms: Option<f64>,
    /// Time to prepare the backend, once a frame, ms: STEP 4 of Wang17.
    pub prepare_ms: Option<f64>,
    /// Time of visibility without preparation, ms: STEP 5 of Wang17.
    pub masks_ms: Option<f64>,
    /// Share of relevant pairs among all pairs of a receiver and a triangle that are looked at, percent.
    pub relevant_before: Option<f64>,
    /// Share of relevant pairs after rejection, percent.
    pub relevant_after: Option<f64>,
    /// Light samples that ray tracing has time for in the same time.
    pub equal_time_samples: Option<u32>,
    /// Sum of squared errors of an image in 0 … 1.
    pub sse: Option<f64>,
    /// SSE over the sum of the reference.
    pub nmse: Option<f64>,
}
