//! The refiner `nichols` (Nichols10): cells are split where masks change in 3 × 3 neighbourhoods.

use halflight_core::pattern::Pattern;
use halflight_core::pyramid::MAX_LEVEL;
use halflight_cpu::irradiance::Shading;
use halflight_cpu::refine::NicholsConfig;

use super::refiner::{Cells, Refiner, all_cells, declare_query_a_cell, level_frames, with_geometry};
use super::tracer::Tracer;
use crate::bindings::Slot;
use crate::error::GpuError;
use crate::frame::Frame;
use crate::needs::{Needs, RECORD, words};
use crate::pass::{Compiler, Pass, flag, shading_flag};
use crate::program::programs;
use crate::recorder::{Groups, Recorder};
use crate::stats::Timed;

programs! {
    CHOOSE: "nichols: choose" = choose in "refine/nichols_choose";
    REUSE: "nichols: reuse" = reuse in "refine/nichols_reuse";
    MERGE: "nichols: merge" = merge in "refine/nichols_merge";
    COMPARE: "nichols: compare" = compare in "refine/nichols_compare";
    COMMIT: "nichols: commit" = commit in "refine/nichols_commit";
}

/// Passes of Nichols10.
#[derive(Debug)]
pub(super) struct Nichols {
    config: NicholsConfig,
    cells: Cells,
    choose: Pass,
    reuse: Pass,
    merge: Pass,
    compare: Pass,
    commit: Pass,
}

impl Nichols {
    pub(super) fn new(
        compiler: &Compiler,
        config: NicholsConfig,
        shading: Shading,
    ) -> Result<Self, GpuError> {
        if config.irradiance_threshold.is_some() {
            return Err(GpuError::Unsupported {
                stage: "nichols with an irradiance threshold",
                reason: "only light samples are compared; leave the threshold out",
            });
        }
        let interleaved = ("INTERLEAVED", flag(config.interleaved));
        Ok(Self {
            config,
            cells: Cells::new(compiler, true, true)?,
            choose: compiler.pass(CHOOSE, &[shading_flag(shading), interleaved])?,
            reuse: compiler.pass(REUSE, &[interleaved])?,
            merge: compiler.pass(MERGE, &[])?,
            compare: compiler.pass(COMPARE, &[interleaved])?,
            commit: compiler.pass(COMMIT, &[("DIAGONAL", flag(config.diagonal))])?,
        })
    }
}

impl Refiner for Nichols {
    fn coarsest(&self) -> u32 {
        self.config.coarsest_level.clamp(1, MAX_LEVEL).into()
    }

    fn declare(&self, needs: &mut Needs, pattern: Pattern) {
        let all = needs.all_cells(self.coarsest());
        declare_query_a_cell(needs, self.coarsest(), pattern);
        needs.declare(Slot::Samples, RECORD * all);
        self.cells.declare(needs, self.coarsest());
        if self.config.incremental {
            needs.declare(Slot::Reused, 8 * all * u64::from(words(pattern)));
        }
    }

    fn frames(&self, general: Frame, pattern: Pattern) -> Vec<Frame> {
        let samples = pattern.len() / if self.config.interleaved { 4 } else { 1 };
        let enough = (self.config.visibility_threshold * samples as f32).max(1.0);
        level_frames(self.coarsest(), general, |frame| {
            with_geometry(Frame { enough, ..frame }, &self.config.geometry)
        })
    }

    fn prepare(&self, recorder: &mut Recorder) {
        self.cells.build_pyramid(recorder, self.coarsest());
    }

    fn record(&self, recorder: &mut Recorder, tracer: &Tracer, first: u32) {
        recorder.clear_queries();
        recorder.clear(Slot::Cells);
        let coarsest = self.coarsest();
        for level in (0..=coarsest).rev() {
            let frame = first + level;
            let cells = all_cells(recorder, level);
            recorder.run(&self.choose, Timed::Refine, frame, cells);
            tracer.count(recorder, frame);
            let incremental = self.config.incremental && level < coarsest;
            if incremental {
                recorder.run(&self.reuse, Timed::Refine, frame, Groups::Queries);
            }
            tracer.trace(recorder, frame, level == 0);
            if incremental {
                recorder.run(&self.merge, Timed::Refine, frame, Groups::Queries);
            }
            if level > 0 {
                recorder.run(&self.compare, Timed::Refine, frame, Groups::Queries);
            }
            recorder.run(&self.commit, Timed::Refine, frame, Groups::Queries);
        }
        self.cells.find_owners(recorder, first);
        tracer.evaluate(recorder, first);
    }
}
