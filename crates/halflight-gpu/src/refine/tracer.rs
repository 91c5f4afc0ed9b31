//! Answers to the queries of refiners: masks by the visibility backend, and values of masks.

use halflight_cpu::irradiance::Shading;

use crate::error::GpuError;
use crate::pass::{ByLight, Compiler, Pass, shading_flag};
use crate::program::programs;
use crate::recorder::{Groups, Recorder};
use crate::stats::Timed;
use crate::visibility::Backend;

programs! {
    DISPATCH: "indirect arguments" = dispatch in "indirect_arguments";
    HIDE: "hide" = hide in "visibility/hide";
    IRRADIANCE: "irradiance" = irradiance in "irradiance", "shared/value";
    TEXTURED: "irradiance, textured" = irradiance in "irradiance", "textured/value";
}

/// Passes from queries to masks and values.
#[derive(Debug)]
pub(crate) struct Tracer {
    dispatch: Pass,
    pub(crate) visibility: Box<dyn Backend>,
    /// Pass that takes out what triangles with alpha masks hide, in scenes that have some.
    hide: Option<Pass>,
    irradiance: ByLight,
}

impl Tracer {
    /// Compiles the passes around a backend, for a scene with or without alpha masks.
    ///
    /// # Errors
    /// A shader cannot be read or compiled.
    pub(crate) fn new(
        compiler: &Compiler,
        visibility: Box<dyn Backend>,
        shading: Shading,
        masked: bool,
    ) -> Result<Self, GpuError> {
        Ok(Self {
            dispatch: compiler.pass(DISPATCH, &[])?,
            visibility,
            hide: masked.then(|| compiler.pass(HIDE, &[])).transpose()?,
            irradiance: compiler
                .by_light((IRRADIANCE, &[shading_flag(shading)]), (TEXTURED, &[shading_flag(shading)]))?,
        })
    }

    /// Records the sizes of dispatches over the queries that are new, the next batch.
    pub(super) fn count(&self, recorder: &mut Recorder, frame: u32) {
        recorder.run(&self.dispatch, Timed::Refine, frame, Groups::Count(1));
    }

    /// Records the masks of the batch; `last` says that no cell is split by them.
    pub(super) fn trace(&self, recorder: &mut Recorder, frame: u32, last: bool) {
        self.visibility.record(recorder, frame, last);
        if let Some(hide) = &self.hide {
            recorder.run(hide, Timed::Visibility, frame, Groups::Rays);
        }
    }

    /// Records the values of all queries of a light.
    pub(super) fn evaluate(&self, recorder: &mut Recorder, first: u32) {
        recorder.run_by_light(&self.irradiance, Timed::Irradiance, first, Groups::AllQueries);
    }
}
