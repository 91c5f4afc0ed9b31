//! Errors and work of a row along an animation, frame by frame.

use halflight_core::stats::LevelWork;
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

/// Work of a row in one frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct FrameWork {
    /// Time in the animation, seconds.
    pub time_s: f64,
    /// Work of each level, 0 first; times are medians. Empty where the refiner does not tell it.
    pub levels: Vec<LevelWork>,
    /// Time of the whole frame, the median, ms.
    pub total_ms: f64,
}

/// Measurements of a row along an animation; empty where the experiment does not ask for them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Along {
    /// Errors of each frame.
    pub errors: Vec<FrameError>,
    /// Work of each frame.
    pub work: Vec<FrameWork>,
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
