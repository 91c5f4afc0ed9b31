//! Contract of visibility backends, and the rays that several of them share.

use std::fmt::Debug;

use halflight_core::light::AreaLight;
use halflight_core::scene::Camera;

use crate::bindings::Slot;
use crate::error::GpuError;
use crate::needs::Needs;
use crate::pass::{Compiler, Pass};
use crate::program::programs;
use crate::recorder::{Groups, Recorder};
use crate::stats::Timed;

programs! {
    MASKS: "masks" = masks in "visibility/masks", "visibility/ray", "shared/query_batch";
    SPILL: "spill" = spill in "visibility/spill";
    SPILLED_MASKS: "spilled masks" = masks in "visibility/masks", "visibility/ray", "visibility/spilled";
}

/// A backend: answers the batch of queries by masks.
pub(crate) trait Backend: Debug + Send + Sync {
    /// Declares the backend's own buffers for some lights; the refiner's are declared already.
    fn declare(&self, _needs: &mut Needs, _lights: &[AreaLight]) {}

    /// Returns the contents of [`Slot::Space`] for a camera; none where the backend does not declare it.
    fn space(&self, _camera: &Camera, _needs: &Needs, _lights: &[AreaLight]) -> Vec<u8> {
        Vec::new()
    }

    /// Records the work of once a frame; the uniforms of each light begin `stride` after those of the one before.
    fn prepare(&self, _recorder: &mut Recorder, _stride: u32) {}

    /// Records the work of once a light; `frame` is the first of its uniforms.
    fn start(&self, _recorder: &mut Recorder, _frame: u32) {}

    /// Records the masks of the batch; `last` says that no cell is split by them.
    fn record(&self, recorder: &mut Recorder, frame: u32, last: bool);
}

/// Two passes that differ in what their rays are counted as: the first for those that refine, the second for irradiance alone.
#[derive(Debug)]
pub(super) struct Both([Pass; 2]);

impl Both {
    /// Compiles both passes; `make` is given their override constant.
    pub(super) fn new(
        make: impl Fn((&'static str, f64)) -> Result<Pass, GpuError>,
    ) -> Result<Self, GpuError> {
        Ok(Self([make(("PURPOSE", 0.0))?, make(("PURPOSE", 1.0))?]))
    }

    /// Records one of the passes.
    pub(super) fn run(&self, recorder: &mut Recorder, frame: u32, last: bool, groups: Groups) {
        recorder.run(&self.0[usize::from(last)], Timed::Visibility, frame, groups);
    }
}

/// The backend `bvh`: ray by ray.
#[derive(Debug)]
pub(super) struct Rays {
    masks: Both,
}

impl Rays {
    pub(super) fn new(compiler: &Compiler) -> Result<Self, GpuError> {
        Ok(Self { masks: Both::new(|purpose| compiler.pass(MASKS, &[purpose]))? })
    }
}

impl Backend for Rays {
    fn record(&self, recorder: &mut Recorder, frame: u32, last: bool) {
        self.masks.run(recorder, frame, last, Groups::Rays);
    }
}

/// Rays for the queries that another backend leaves to them.
#[derive(Debug)]
pub(super) struct Spill {
    dispatch: Pass,
    masks: Both,
}

impl Spill {
    pub(super) fn new(compiler: &Compiler) -> Result<Self, GpuError> {
        Ok(Self {
            dispatch: compiler.pass(SPILL, &[])?,
            masks: Both::new(|purpose| compiler.pass(SPILLED_MASKS, &[purpose]))?,
        })
    }

    /// Declares room for all queries.
    pub(super) fn declare(needs: &mut Needs) {
        needs.declare(Slot::Spilled, 4 * (1 + needs.records(Slot::Queries)));
    }

    /// Removes all queries that have been left to rays.
    pub(super) fn clear(recorder: &mut Recorder) {
        recorder.clear_words(Slot::Spilled, 0, 1);
    }

    /// Records the masks of these queries.
    pub(super) fn record(&self, recorder: &mut Recorder, frame: u32, last: bool) {
        recorder.run(&self.dispatch, Timed::Visibility, frame, Groups::Count(1));
        self.masks.run(recorder, frame, last, Groups::Spilled);
    }
}
