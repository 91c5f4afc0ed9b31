//! Figures of a paper in an experiment file.

use serde::{Deserialize, Serialize};

/// Figures that a paper gives.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Paper {
    /// Paper, table or figure.
    pub source: String,
    /// In what its figures and ours differ.
    pub differs: String,
    /// Also measure against a reference of so many samples a pixel, as the paper does.
    #[serde(default)]
    pub reference_samples: Option<u32>,
    /// Its figures; there may be none to print.
    #[serde(default, rename = "row")]
    pub rows: Vec<PaperRow>,
}

/// One row of a paper's table, and which of our rows stand beside it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PaperRow {
    /// What the paper calls it.
    pub label: String,
    /// Our scene.
    pub scene: String,
    /// Our refiner.
    pub refiner: String,
    /// Our visibility backend, if only one is meant.
    #[serde(default)]
    pub visibility: Option<String>,
    /// Our constants, as in the column `parameters`, if only one set is meant.
    #[serde(default)]
    pub parameters: Option<String>,
    /// Our light samples, if only one number is meant.
    #[serde(default)]
    pub samples: Option<u32>,
    /// Our upsampler, if only one is meant.
    #[serde(default)]
    pub upsampler: Option<String>,
    /// Our shading, if only one is meant.
    #[serde(default)]
    pub shading: Option<String>,
    /// Our light scale, if only one is meant.
    #[serde(default)]
    pub light_scale: Option<f32>,
    /// Triangles.
    #[serde(default)]
    pub triangles: Option<u64>,
    /// Fragments.
    #[serde(default)]
    pub fragments: Option<u64>,
    /// Visibility rays.
    #[serde(default)]
    pub rays: Option<u64>,
    /// Visibility tests, ms.
    #[serde(default)]
    pub visibility_ms: Option<f64>,
    /// Upsampling, ms.
    #[serde(default)]
    pub upsample_ms: Option<f64>,
    /// All, ms.
    #[serde(default)]
    pub total_ms: Option<f64>,
    /// Preparation of the backend, once a frame, ms: STEP 4 of Wang17.
    #[serde(default)]
    pub prepare_ms: Option<f64>,
    /// Visibility without that, ms: STEP 5 of Wang17.
    #[serde(default)]
    pub masks_ms: Option<f64>,
    /// Share of relevant pairs among all pairs of a receiver and a triangle that are looked at, percent.
    #[serde(default)]
    pub relevant_before: Option<f64>,
    /// The same after rejection.
    #[serde(default)]
    pub relevant_after: Option<f64>,
    /// Light samples that ray tracing has time for in the same time.
    #[serde(default)]
    pub equal_time_samples: Option<u32>,
    /// Sum of squared errors of an image in 0 … 1.
    #[serde(default)]
    pub sse: Option<f64>,
    /// SSE over the sum of the reference.
    #[serde(default)]
    pub nmse: Option<f64>,
}
