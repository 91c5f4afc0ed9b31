//! Medians of repeated frames.

use halflight_core::stats::{FrameStats, StageTimes};

/// Returns the median: the mean of the middle two of an even number, 0 of none.
pub(crate) fn median(values: impl IntoIterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.into_iter().collect();
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    match values.len() {
        0 => 0.0,
        length if length % 2 == 1 => values[middle],
        _ => 0.5 * (values[middle - 1] + values[middle]),
    }
}

/// Medians over repeated frames, each stage on its own, in ms rounded to 0.1 µs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Medians {
    pub(crate) stages: StageTimes,
    /// Preparation of the backend, a part of the visibility stage.
    pub(crate) prepare: f64,
    pub(crate) total: f64,
}

/// Returns the medians of every stage and of the total.
pub(crate) fn medians(frames: &[FrameStats]) -> Medians {
    let of = |time: fn(&FrameStats) -> f64| (median(frames.iter().map(time)) * 1e4).round() / 1e4;
    let mut stages = StageTimes::default();
    stages.gbuffer = of(|frame| frame.stages_ms.gbuffer);
    stages.pyramid = of(|frame| frame.stages_ms.pyramid);
    stages.refine = of(|frame| frame.stages_ms.refine);
    stages.visibility = of(|frame| frame.stages_ms.visibility);
    stages.certify = of(|frame| frame.stages_ms.certify);
    stages.irradiance = of(|frame| frame.stages_ms.irradiance);
    stages.upsample = of(|frame| frame.stages_ms.upsample);
    stages.compose = of(|frame| frame.stages_ms.compose);
    Medians { stages, prepare: of(|frame| frame.visibility.prepare_ms), total: of(|frame| frame.total_ms) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn medians_of_odd_even_and_no_numbers() {
        assert_eq!(median([3.0, 1.0, 100.0]), 3.0);
        assert_eq!(median([4.0, 1.0, 2.0, 100.0]), 3.0);
        assert_eq!(median([]), 0.0);
    }

    #[test]
    fn stages_and_total_are_taken_apart() {
        let frame = |refine: f64, total_ms: f64| {
            let mut frame = FrameStats::default();
            frame.stages_ms.refine = refine;
            frame.visibility.prepare_ms = total_ms / 2.0 - 1.0;
            frame.total_ms = total_ms;
            frame
        };
        let medians = medians(&[frame(1.0, 9.0), frame(5.0, 7.0), frame(2.0, 30.0)]);
        assert_eq!((medians.stages.refine, medians.prepare, medians.total), (2.0, 3.5, 9.0));
    }
}
