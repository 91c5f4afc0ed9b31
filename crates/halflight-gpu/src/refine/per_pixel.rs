//! Per-pixel refiner: every pixel has its own samples.

use halflight_core::pattern::Pattern;

use super::refiner::{Refiner, declare_query_a_cell, level_frames};
use super::tracer::Tracer;
use crate::bindings::Slot;
use crate::error::GpuError;
use crate::frame::Frame;
use crate::needs::{Needs, RECORD};
use crate::pass::{Compiler, Pass};
use crate::program::programs;
use crate::recorder::{Groups, Recorder};
use crate::stats::Timed;

programs! {
    PER_PIXEL: "per-pixel" = request in "refine/per_pixel";
}

/// Pass that makes a query a pixel.
#[derive(Debug)]
pub(super) struct PerPixel {
    request: Pass,
}

impl PerPixel {
    pub(super) fn new(compiler: &Compiler) -> Result<Self, GpuError> {
        Ok(Self { request: compiler.pass(PER_PIXEL, &[])? })
    }
}

impl Refiner for PerPixel {
    fn coarsest(&self) -> u32 {
        0
    }

    fn declare(&self, needs: &mut Needs, pattern: Pattern) {
        declare_query_a_cell(needs, 0, pattern);
        needs.declare(Slot::Samples, RECORD * needs.pixels());
        needs.declare(Slot::Owners, 4 * needs.pixels());
    }

    fn frames(&self, general: Frame, _pattern: Pattern) -> Vec<Frame> {
        level_frames(0, general, |frame| frame)
    }

    fn record(&self, recorder: &mut Recorder, tracer: &Tracer, first: u32) {
        recorder.clear_queries();
        recorder.run(&self.request, Timed::Refine, first, Groups::Tiles(0));
        tracer.count(recorder, first);
        tracer.trace(recorder, first, true);
        tracer.evaluate(recorder, first);
    }
}
