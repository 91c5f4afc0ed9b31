//! Queries at the corners of a level's pending cells, and their masks.

use super::tracer::Tracer;
use crate::error::GpuError;
use crate::pass::{Compiler, Pass, flag};
use crate::program::programs;
use crate::recorder::{Groups, Recorder};
use crate::stats::Timed;

programs! {
    CLASSIFY: "lattice: classify" = classify in "refine/lattice_classify";
    REQUEST: "lattice: request" = request in "refine/lattice_request";
}

/// Passes that find pending cells and ask at their corners.
#[derive(Debug)]
pub(super) struct Request {
    classify: Pass,
    request: Pass,
}

impl Request {
    /// Compiles the passes; `counted` says that their queries count as samples.
    pub(super) fn new(compiler: &Compiler, counted: bool) -> Result<Self, GpuError> {
        let constants: &[_] = if counted { &[] } else { &[("COUNTED", flag(false))] };
        Ok(Self { classify: compiler.pass(CLASSIFY, &[])?, request: compiler.pass(REQUEST, constants)? })
    }

    /// Records the masks at the corners of a level.
    pub(super) fn record(
        &self,
        recorder: &mut Recorder,
        tracer: &Tracer,
        frame: u32,
        level: u32,
        last: bool,
    ) {
        recorder.run(&self.classify, Timed::Refine, frame, Groups::Tiles(level));
        recorder.run(&self.request, Timed::Refine, frame, Groups::Corners(level));
        tracer.count(recorder, frame);
        tracer.trace(recorder, frame, last);
    }
}
