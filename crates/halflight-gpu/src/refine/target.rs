//! Error targets: light samples and threshold are chosen on the device, by a trial at the coarsest corners.

use std::mem::offset_of;

use bytemuck::{Pod, Zeroable};
use halflight_core::pattern::Pattern;
use halflight_cpu::refine::Budget;

use super::Tracer;
use crate::GpuError;
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
    pub(crate) step_level: u32,
}

/// Passes of a trial.
#[derive(Debug)]
pub(super) struct Target {
    ask: Stage,
    show: Stage,
    choose: Stage,
}

impl Target {
    /// Words of the longest masks: every receiver is asked once, for at most so many samples. The CPU asks those that see part
    /// of the light a second time where that is not enough.
    pub(super) const WORDS: u32 = (Budget::ONCE as u32 * Budget::ONCE as u32).div_ceil(32);

    pub(super) fn new(compiler: &Compiler, target: f32) -> Result<Self, GpuError> {
        let Budget { noise, interpolation, step_level, .. } = Budget::new(target);
        let constants =
            [("NOISE_TARGET", noise), ("INTERPOLATION", interpolation), ("STEP_LEVEL", step_level.into())];
        Ok(Self {
            ask: compiler.stage(programs::LATTICE_ASK, &[("COUNTED", 0.0)])?,
            show: compiler.stage(programs::TARGET_SHOW, &[])?,
            choose: compiler.stage(programs::TARGET_CHOOSE, &constants)?,
        })
    }

    /// The pattern of a trial.
    pub(super) fn trial(pattern: Pattern) -> GpuPattern {
        GpuPattern::new(Pattern { columns: Budget::TRIAL, rows: Budget::TRIAL, ..pattern })
    }

    /// Tries, chooses, and writes what is chosen into the uniforms of the levels, which begin at `first`; the trial's is behind
    /// them.
    pub(super) fn record(
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
        let buffers = recorder.buffers;
        // Error and level of steps are neighbours in both.
        const { assert!(offset_of!(Choice, step_level) == offset_of!(Choice, error) + 4) };
        const { assert!(offset_of!(Frame, step_level) == offset_of!(Frame, error) + 4) };
        for (from, to, bytes) in [
            (offset_of!(Choice, pattern), offset_of!(Frame, pattern), size_of::<GpuPattern>()),
            (offset_of!(Choice, error), offset_of!(Frame, error), 8),
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

    pub(super) fn stages(&mut self) -> [&mut Stage; 3] {
        [&mut self.ask, &mut self.show, &mut self.choose]
    }
}
