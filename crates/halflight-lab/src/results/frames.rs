//! Errors of a row along an animation, frame by frame.

use halflight_metrics::Flicker;
use serde::{Deserialize, Serialize};

/// Errors of a row in one frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct FrameError {
    /// Time in the animation, seconds.
    pub time_s: f64,
    /// NMSE₂ against this frame's reference.
    pub nmse2: f64,
    /// Flicker from the frame before to this one; `None` for the first.
    pub flicker: Option<Flicker>,
    /// Mean flicker that the noise of the reference makes, at most: its samples are the same in all frames.
    pub noise: f64,
}

/// Means over all frames of a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Means {
    /// Mean flicker.
    pub mean: f64,
    /// 99th percentile over the pixels.
    pub p99: f64,
    /// NMSE₂ against the frames' references.
    pub nmse2: f64,
    /// Flicker that the noise of the references makes.
    pub noise: f64,
}

impl Means {
    /// Returns the means; `None` where no two frames follow each other.
    pub fn of(frames: &[FrameError]) -> Option<Self> {
        let mean = |values: &mut dyn Iterator<Item = f64>| {
            let (sum, count) = values.fold((0.0, 0u32), |(sum, count), value| (sum + value, count + 1));
            (count > 0).then(|| sum / f64::from(count))
        };
        Some(Self {
            mean: mean(&mut frames.iter().filter_map(|frame| Some(frame.flicker?.mean)))?,
            p99: mean(&mut frames.iter().filter_map(|frame| Some(frame.flicker?.p99)))?,
            nmse2: mean(&mut frames.iter().map(|frame| frame.nmse2))?,
            noise: mean(&mut frames.iter().map(|frame| frame.noise))?,
        })
    }
}
