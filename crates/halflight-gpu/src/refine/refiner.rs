//! Contract of refiners, and what several of them share.

use std::fmt::Debug;

use halflight_core::pattern::Pattern;
use halflight_cpu::refine::GeometryThresholds;

use super::tracer::Tracer;
use crate::bindings::Slot;
use crate::error::GpuError;
use crate::frame::Frame;
use crate::needs::{Needs, RECORD, words};
use crate::pass::{Compiler, Pass};
use crate::program::programs;
use crate::recorder::{Groups, Recorder};
use crate::stats::Timed;
use crate::textured::Patterns;

programs! {
    PYRAMID: "pyramid" = level in "pyramid";
    OWNERS: "owners" = own in "owners";
}

/// A refiner: asks for visibility, coarse to fine, until every pixel has a sample or a cell.
pub(crate) trait Refiner: Debug + Send + Sync {
    /// Returns the coarsest level of cells.
    fn coarsest(&self) -> u32;

    /// Declares the buffers for light samples of a pattern.
    fn declare(&self, needs: &mut Needs, pattern: Pattern);

    /// Returns the uniforms of one light: one a level, pixels first, and any further ones that the refiner reads.
    fn frames(&self, general: Frame, pattern: Pattern) -> Vec<Frame>;

    /// Number of uniforms of one light.
    fn uniforms(&self) -> u32 {
        self.coarsest() + 1 + u32::from(self.expects())
    }

    /// Light samples that are taken where the configuration has a pattern.
    fn patterns(&self, pattern: Pattern) -> Patterns {
        Patterns::Given(vec![pattern])
    }

    /// Returns whether values are smoothed.
    fn smooths(&self) -> bool {
        false
    }

    /// Returns whether the refiner predicts the error of the image.
    fn expects(&self) -> bool {
        false
    }

    /// Records the work of once a frame.
    fn prepare(&self, _recorder: &mut Recorder) {}

    /// Records the work of one light, whose uniforms begin at `first`.
    fn record(&self, recorder: &mut Recorder, tracer: &Tracer, first: u32);

    /// Records what follows the image.
    fn finish(&self, _recorder: &mut Recorder) {}
}

/// Returns the uniforms of the levels of one light.
pub(super) fn level_frames(coarsest: u32, general: Frame, frame: impl Fn(Frame) -> Frame) -> Vec<Frame> {
    (0..=coarsest).map(|level| frame(Frame { level, coarsest, ..general })).collect()
}

/// Returns a uniform with thresholds of the geometry.
pub(super) fn with_geometry(frame: Frame, thresholds: &GeometryThresholds) -> Frame {
    Frame { depth_break: thresholds.depth, curvature_break: thresholds.curvature, ..frame }
}

/// Returns a dispatch of one invocation a cell of a level.
pub(super) fn all_cells(recorder: &Recorder, level: u32) -> Groups {
    Groups::Count(recorder.buffers.needs.cells(level))
}

/// Declares queries with masks of so many words altogether.
pub(super) fn declare_queries(needs: &mut Needs, queries: u64, mask_words: u64) {
    needs.declare(Slot::Queries, RECORD * queries);
    needs.declare(Slot::Wanted, 4 * mask_words);
    needs.declare(Slot::Visible, 4 * mask_words);
}

/// Declares one query a cell of all levels.
pub(super) fn declare_query_a_cell(needs: &mut Needs, coarsest: u32, pattern: Pattern) {
    let queries = needs.all_cells(coarsest);
    declare_queries(needs, queries, queries * u64::from(words(pattern)));
}

/// Passes that all refiners with cells have but the lattice, and the buffers of cells.
#[derive(Debug)]
pub(super) struct Cells {
    pyramid: Option<Pass>,
    owners: Pass,
}

impl Cells {
    /// Compiles the passes; with `pyramid` those of the discontinuity pyramid, too. Samples are counted by level only where
    /// `counted` says so.
    pub(super) fn new(compiler: &Compiler, pyramid: bool, counted: bool) -> Result<Self, GpuError> {
        let constants: &[_] = if counted { &[] } else { &[("COUNTED", 0.0)] };
        Ok(Self {
            pyramid: pyramid.then(|| compiler.pass(PYRAMID, &[])).transpose()?,
            owners: compiler.pass(OWNERS, constants)?,
        })
    }

    /// Declares the buffers of cells of all levels up to `coarsest`.
    pub(super) fn declare(&self, needs: &mut Needs, coarsest: u32) {
        let all = needs.all_cells(coarsest);
        needs.declare(Slot::Cells, RECORD * all);
        needs.declare(Slot::Owners, 4 * needs.pixels());
        if self.pyramid.is_some() {
            needs.declare(Slot::Pyramid, 8 * all);
        }
    }

    /// Records the discontinuity pyramid.
    pub(super) fn build_pyramid(&self, recorder: &mut Recorder, coarsest: u32) {
        let Some(pyramid) = &self.pyramid else { return };
        recorder.clear(Slot::Pyramid);
        for level in 1..=coarsest {
            let seams = recorder.buffers.needs.cells(level) * (2 << level);
            recorder.run(pyramid, Timed::Pyramid, level, Groups::Count(seams));
        }
    }

    /// Records the level of each pixel's cell.
    pub(super) fn find_owners(&self, recorder: &mut Recorder, first: u32) {
        recorder.run(&self.owners, Timed::Refine, first, Groups::Tiles(0));
    }
}
