//! Error targets: light samples and threshold are chosen on the device, by pilot samples at the coarsest corners.

use std::mem::offset_of;

use bytemuck::{Pod, Zeroable};
use halflight_core::pattern::Pattern;
use halflight_cpu::refine::Budget;

use super::request::Request;
use super::tracer::Tracer;
use crate::bindings::Slot;
use crate::error::GpuError;
use crate::frame::{Frame, GpuPattern};
use crate::needs::Needs;
use crate::pass::{ByLight, Compiler, Pass, flag};
use crate::program::programs;
use crate::recorder::{Groups, Recorder};
use crate::stats::{ENERGY, EXPECTED, Timed};

programs! {
    EVALUATE: "error target: evaluate" = evaluate in "refine/target_evaluate", "shared/noise", "shared/sums";
    EVALUATE_TEXTURED: "error target: evaluate, textured" = evaluate in "refine/target_evaluate", "textured/noise", "textured/sums";
    CHOOSE: "error target: choose" = choose in "refine/target_choose";
    COUNT: "error target: count" = count in "refine/target_count";
    DECIDE: "error target: decide" = decide in "refine/target_decide";
    PREDICT: "error target: predict" = predict in "refine/target_predict";
    MEASURE: "error target: measure" = measure in "refine/target_energy";
    SUM: "error target: sum" = sum in "refine/target_sum";
}

/// Twin of `Choice` in `shaders/shared/choice.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Choice {
    pub(crate) pattern: GpuPattern,
    pub(crate) error: f32,
    pub(crate) coarsest: u32,
    pub(crate) every: GpuPattern,
}

/// Passes that choose a sampling plan, and that predict the error.
#[derive(Debug)]
pub(super) struct Target {
    request: Request,
    evaluate: ByLight,
    choose: Pass,
    count: Pass,
    decide: Pass,
    predict: Pass,
    sum_predicted: Pass,
    measure: Pass,
    sum_energy: Pass,
}

impl Target {
    /// Words of the longest masks: every receiver is asked once, for at most so many samples. The CPU asks those that see part
    /// of the light a second time where that is not enough.
    pub(super) const WORDS: u32 = (Budget::ONCE as u32 * Budget::ONCE as u32).div_ceil(32);

    pub(super) fn new(
        compiler: &Compiler,
        target: f32,
        visible_error: f32,
        smooths: bool,
    ) -> Result<Self, GpuError> {
        let Budget { noise, interpolation } = Budget::new(target);
        let constants = [
            ("WHOLE_TARGET", target.into()),
            ("NOISE_TARGET", noise),
            ("INTERPOLATION", interpolation),
            ("LEAST_SIDE", f64::from(Budget::least_side(visible_error, Budget::ONLY))),
        ];
        let [_, one, two] = Budget::DENSE.map(|share| f64::from(share.unwrap_or(f32::MAX)));
        let sum = |counter: usize| compiler.pass(SUM, &[("COUNTER", counter as f64)]);
        Ok(Self {
            request: Request::new(compiler, false)?,
            evaluate: compiler.by_light((EVALUATE, &[]), (EVALUATE_TEXTURED, &[]))?,
            choose: compiler.pass(CHOOSE, &constants)?,
            count: compiler.pass(COUNT, &[])?,
            decide: compiler.pass(DECIDE, &[("SHARE_1", one), ("SHARE_2", two)])?,
            predict: compiler.pass(PREDICT, &[("SMOOTHED", flag(smooths))])?,
            sum_predicted: sum(EXPECTED)?,
            measure: compiler.pass(MEASURE, &[])?,
            sum_energy: sum(ENERGY)?,
        })
    }

    /// Declares the buffers of an error target besides those of the lattice.
    pub(super) fn declare(needs: &mut Needs) {
        needs.declare(Slot::Chosen, size_of::<Choice>() as u64);
        let tiles = u64::from(needs.width.div_ceil(8)) * u64::from(needs.height.div_ceil(8));
        needs.declare(Slot::Sums, 4 * tiles);
    }

    /// Returns the pattern of pilot samples.
    pub(super) fn pilot_pattern(pattern: Pattern) -> GpuPattern {
        GpuPattern::new(Pattern { columns: Budget::PILOT, rows: Budget::PILOT, ..pattern })
    }

    /// Records pilot samples at the coarsest corners and the choice of a sampling plan, and writes the plan into the uniforms
    /// of the levels, which begin at `first`. The uniform of the pilot samples follows them.
    pub(super) fn take_pilot_samples(
        &self,
        recorder: &mut Recorder,
        tracer: &Tracer,
        first: u32,
        coarsest: u32,
    ) {
        let pilot = first + coarsest + 1;
        self.request.record(recorder, tracer, pilot, coarsest, false);
        recorder.run_by_light(&self.evaluate, Timed::Refine, pilot, Groups::Queries);
        recorder.run(&self.choose, Timed::Refine, pilot, Groups::Count(1));
        Self::adopt(recorder, first, coarsest);
    }

    /// Records the change to every pixel where so many cells of a level are left that levels do not pay.
    pub(super) fn decide(&self, recorder: &mut Recorder, first: u32, level: u32, coarsest: u32) {
        if Budget::DENSE.get(level as usize).copied().flatten().is_none() {
            return;
        }
        recorder.run(&self.count, Timed::Refine, first + level, Groups::Tiles(level));
        recorder.run(&self.decide, Timed::Refine, first + level, Groups::Count(1));
        Self::adopt(recorder, first, coarsest);
    }

    /// Records the sum of the errors that are predicted for a light.
    pub(super) fn predict(&self, recorder: &mut Recorder, first: u32) {
        recorder.run(&self.predict, Timed::Refine, first, Groups::Tiles(0));
        recorder.run(&self.sum_predicted, Timed::Refine, first, Groups::Count(1));
    }

    /// Records the image's square, which errors are relative to.
    pub(super) fn measure(&self, recorder: &mut Recorder) {
        recorder.run(&self.measure, Timed::Compose, 0, Groups::Tiles(0));
        recorder.run(&self.sum_energy, Timed::Compose, 0, Groups::Count(1));
    }

    /// Records copies of the plan into the uniforms of the levels.
    fn adopt(recorder: &mut Recorder, first: u32, coarsest: u32) {
        let buffers = recorder.buffers;
        for (from, to, bytes) in [
            (offset_of!(Choice, pattern), offset_of!(Frame, pattern), size_of::<GpuPattern>()),
            (offset_of!(Choice, error), offset_of!(Frame, error), 4),
            (offset_of!(Choice, coarsest), offset_of!(Frame, coarsest), 4),
        ] {
            for level in first..=first + coarsest {
                let slot = u64::from(level * buffers.frame_stride);
                recorder.encoder.copy_buffer_to_buffer(
                    &buffers[Slot::Chosen],
                    from as u64,
                    &buffers.frames,
                    slot + to as u64,
                    bytes as u64,
                );
            }
        }
    }
}
