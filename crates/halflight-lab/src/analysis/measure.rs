//! Errors that rows are compared by.

use crate::results::Finished;

/// Error of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measure {
    /// NMSE₂.
    Nmse2,
    /// NMSE of Koa17.
    Nmse,
    /// 99th percentile of ꟻLIP.
    FlipP99,
    /// Grain of the penumbra.
    Grain,
}

impl Measure {
    /// Returns the error of a row, if it was measured.
    pub fn of(self, row: &Finished) -> Option<f64> {
        match self {
            Self::Nmse2 => Some(row.record.nmse2),
            Self::Nmse => Some(row.record.nmse),
            Self::FlipP99 => row.record.flip_p99,
            Self::Grain => row.record.grain,
        }
    }

    /// Returns the error of the reference itself, where it is known.
    pub fn noise(self, row: &Finished) -> Option<f64> {
        match self {
            Self::Nmse2 => Some(row.record.reference_noise),
            Self::Grain => row.record.reference_grain,
            Self::Nmse | Self::FlipP99 => None,
        }
    }

    /// Returns the name on the axis of a chart.
    pub fn label(self) -> &'static str {
        match self {
            Self::Nmse2 => "NMSE₂ = SSE / Σ reference²",
            Self::Nmse => "NMSE (Koa17)",
            Self::FlipP99 => "FLIP, 99th percentile over the pixels",
            Self::Grain => "grain of the penumbra, as a contrast",
        }
    }

    /// Returns the name in sentences.
    pub fn words(self) -> &'static str {
        match self {
            Self::Nmse2 => "NMSE₂",
            Self::Nmse => "NMSE",
            Self::FlipP99 => "ꟻLIP",
            Self::Grain => "grain",
        }
    }
}
