//! Options of the lattice refiner.

use serde::{Deserialize, Serialize};

use crate::tangent_plane::DiscontinuityLimits;

/// Options of [`Lattice`](super::Lattice).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LatticeConfig {
    /// Level of the coarsest cells, 0 … 7: 3, that is 8 × 8 pixels. Their corners are one pixel in 64;
    /// coarser cells save 3 % of the receivers and miss wider shadows.
    pub coarsest_level: u8,
    /// Interpolation tolerance, as a difference of the visible fraction, 0 … 1: 0.05. The masks themselves
    /// have noise: in the middle of a penumbra, 64 stratified samples have a standard deviation of 0.02. A
    /// tolerance of less than two of these makes pixels that are no better than the interpolated ones they
    /// replace.
    pub error: f32,
    /// Error target as NMSE₂, or 0 to use `error` and the frame's samples as they are: 0. With a target, both
    /// are chosen from the masks of the coarsest corners with 64 samples. If more than 400 samples are
    /// needed, only receivers that see part of the light get more than 64. If most pixels would be traced
    /// anyway, all are.
    pub target: f32,
    /// True if a cell is kept only with a certificate that it hides no thin shadow: false. Requires a backend
    /// with certificates, `bvh` or `beam`; with others, and in foliage, every pixel is traced.
    pub certify: bool,
    /// True if some pixels of the cells that an error target keeps are traced and compared with the
    /// interpolated values, and cells are split by the result: true. Without, the interpolation error is
    /// assumed to be that of the bundled scenes, and the interpolation tolerance does not depend on the
    /// strength of the light. The GPU never validates, whatever the value.
    pub validate: bool,
    /// Bound on visible errors, relative to the irradiance around them, or 0 for none: 0. With an error target only. Receivers whose noise would
    /// exceed it get more samples, cells are split where interpolation may, and the visible fractions are smoothed as far as their noise explains
    /// the differences.
    pub visible_error: f32,
    /// Limits of the tangent-plane test.
    #[serde(alias = "rise")]
    pub discontinuity: DiscontinuityLimits,
}

impl Default for LatticeConfig {
    fn default() -> Self {
        let discontinuity = DiscontinuityLimits::default();
        Self {
            coarsest_level: 3,
            error: 0.05,
            target: 0.0,
            certify: false,
            validate: true,
            visible_error: 0.0,
            discontinuity,
        }
    }
}
