//! Error targets: light samples and threshold are chosen on the device, by a trial at the coarsest corners.

use std::mem::offset_of;

use bytemuck::{Pod, Zeroable};
use halflight_core::pattern::Pattern;
use halflight_cpu::refine::Budget;

use super::Tracer;
use crate::GpuError;
use crate::buffers::{ENERGY, EXPECTED};
use crate::frame::{Frame, GpuPattern};
use crate::programs;
use crate::recorder::{Groups, Recorder};
use crate::stage::{Compiler, Stage};
use crate::stats::Timed;

/// Twin of `Choice` in `shaders/shared/choice.wgsl`.
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Choice {
    pub(crate) pattern: GpuPattern,
    pub(crate) error: f32,
    pub(crate) coarsest: u32,
    pub(crate) every: GpuPattern,
}

/// Passes that choose, and that say what is to be expected.
#[derive(Debug)]
pub(super) struct Target {
    ask: Stage,
    show: Stage,
    choose: Stage,
    count: Stage,
    decide: Stage,
    expect: Stage,
    sum_expected: Stage,
    measure: Stage,
    sum_energy: Stage,
}

impl Target {
    /// Words of the longest masks: every receiver is asked once, for at most so many samples. The CPU asks those that see part
    /// of the light a second time where that is not enough.
    pub(super) const WORDS: u32 = (Budget::ONCE as u32 * Budget::ONCE as u32).div_ceil(32);

    pub(super) fn new(compiler: &Compiler, target: f32) -> Result<Self, GpuError> {
        let Budget { noise, interpolation } = Budget::new(target);
        let constants =
            [("WHOLE_TARGET", target.into()), ("NOISE_TARGET", noise), ("INTERPOLATION", interpolation)];
        let [_, one, two] = Budget::DENSE.map(|share| f64::from(share.unwrap_or(f32::MAX)));
        let sum = |counter: usize| compiler.stage(programs::TARGET_SUM, &[("COUNTER", counter as f64)]);
        Ok(Self {
            ask: compiler.stage(programs::LATTICE_REQUEST, &[("COUNTED", 0.0)])?,
            show: compiler.stage(programs::TARGET_SHOW, &[])?,
            choose: compiler.stage(programs::TARGET_CHOOSE, &constants)?,
            count: compiler.stage(programs::TARGET_COUNT, &[])?,
            decide: compiler.stage(programs::TARGET_DECIDE, &[("SHARE_1", one), ("SHARE_2", two)])?,
            expect: compiler.stage(programs::TARGET_PREDICT, &[])?,
            sum_expected: sum(EXPECTED)?,
            measure: compiler.stage(programs::TARGET_ENERGY, &[])?,
            sum_energy: sum(ENERGY)?,
        })
    }

    /// The pattern of a trial.
    pub(super) fn trial(pattern: Pattern) -> GpuPattern {
        GpuPattern::new(Pattern { columns: Budget::TRIAL, rows: Budget::TRIAL, ..pattern })
    }

    /// Tries, chooses, and writes what is chosen into the uniforms of the levels, which begin at `first`; the trial's is behind
    /// them.
    pub(super) fn try_out(
        &self,
        recorder: &mut Recorder,
        tracer: &Tracer,
        look: &Stage,
        first: u32,
        coarsest: u32,
    ) {
        let trial = first + coarsest + 1;
        recorder.run(look, Timed::Refine, trial, Groups::Tiles(coarsest));
        recorder.run(&self.ask, Timed::Refine, trial, Groups::Corners(coarsest));
        tracer.count(recorder, trial);
        tracer.trace(recorder, trial, false);
        recorder.run(&self.show, Timed::Refine, trial, Groups::Queries);
        recorder.run(&self.choose, Timed::Refine, trial, Groups::Count(1));
        Self::adopt(recorder, first, coarsest);
    }

    /// Goes over to every pixel where so many cells of a level are left that it does not pay to look at them.
    pub(super) fn decide(&self, recorder: &mut Recorder, first: u32, level: u32, coarsest: u32) {
        if Budget::DENSE.get(level as usize).copied().flatten().is_none() {
            return;
        }
        recorder.run(&self.count, Timed::Refine, first + level, Groups::Tiles(level));
        recorder.run(&self.decide, Timed::Refine, first + level, Groups::Count(1));
        Self::adopt(recorder, first, coarsest);
    }

    /// Adds up what is to be expected of a light.
    pub(super) fn expect(&self, recorder: &mut Recorder, first: u32) {
        recorder.run(&self.expect, Timed::Refine, first, Groups::Tiles(0));
        recorder.run(&self.sum_expected, Timed::Refine, first, Groups::Count(1));
    }

    /// And what that is held against, once the image is there.
    pub(super) fn measure(&self, recorder: &mut Recorder) {
        recorder.run(&self.measure, Timed::Compose, 0, Groups::Tiles(0));
        recorder.run(&self.sum_energy, Timed::Compose, 0, Groups::Count(1));
    }

    /// Writes what is chosen into the uniforms of the levels.
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
                    &buffers.chosen,
                    from as u64,
                    &buffers.frames,
                    slot + to as u64,
                    bytes as u64,
                );
            }
        }
    }

    pub(super) fn stages(&mut self) -> [&mut Stage; 9] {
        let Self { ask, show, choose, count, decide, expect, sum_expected, measure, sum_energy } = self;
        [ask, show, choose, count, decide, expect, sum_expected, measure, sum_energy]
    }
}
