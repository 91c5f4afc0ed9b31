//! The refiner `sfvt-gass` (Koa17): cells are split by tests of their quadrants.

use halflight_core::pattern::Pattern;
use halflight_core::pyramid::MAX_LEVEL;
use halflight_cpu::irradiance::Shading;
use halflight_cpu::refine::SfvtGassConfig;

use super::refiner::{Cells, Refiner, all_cells, declare_queries, level_frames, with_geometry};
use super::tracer::Tracer;
use crate::bindings::Slot;
use crate::error::GpuError;
use crate::frame::{Frame, GpuPattern};
use crate::needs::{Needs, RECORD, words};
use crate::pass::{ByLight, Compiler, Pass, flag, shading_flag};
use crate::program::programs;
use crate::recorder::{Groups, Recorder};
use crate::stats::Timed;
use crate::textured::Patterns;

programs! {
    CLASSIFY: "sfvt-gass: classify" = classify in "refine/sfvt_classify";
    SPLIT_TEST: "sfvt-gass: split test" = split_test in "refine/sfvt_split_test";
    VALUE: "sfvt-gass: value" = irradiance in "irradiance", "shared/value";
    TEXTURED: "sfvt-gass: value, textured" = irradiance in "irradiance", "textured/value";
    FINALS: "sfvt-gass: finals" = finals in "refine/sfvt_finals";
}

/// Passes of Koa17.
#[derive(Debug)]
pub(super) struct SfvtGass {
    config: SfvtGassConfig,
    cells: Cells,
    classify: Pass,
    split_test: Pass,
    value: ByLight,
    finals: Pass,
}

impl SfvtGass {
    pub(super) fn new(
        compiler: &Compiler,
        config: SfvtGassConfig,
        shading: Shading,
    ) -> Result<Self, GpuError> {
        let shading = shading_flag(shading);
        let dark = ("DARK_CULLING", flag(config.dark_culling));
        let additional = ("ADDITIONAL_SAMPLES", flag(config.additional_samples));
        Ok(Self {
            config,
            cells: Cells::new(compiler, true, true)?,
            classify: compiler.pass(CLASSIFY, &[shading])?,
            split_test: compiler.pass(SPLIT_TEST, &[dark, additional])?,
            value: compiler.by_light((VALUE, &[shading]), (TEXTURED, &[shading]))?,
            finals: compiler.pass(FINALS, &[shading])?,
        })
    }

    /// Queries of a tested cell.
    fn slots(&self, level: u32) -> u32 {
        if level >= u32::from(self.config.sixteen_from_level) { 16 } else { 4 }
    }
}

impl Refiner for SfvtGass {
    fn coarsest(&self) -> u32 {
        self.config.coarsest_level.clamp(1, MAX_LEVEL).into()
    }

    fn declare(&self, needs: &mut Needs, pattern: Pattern) {
        let coarsest = self.coarsest();
        let tests = (1..=coarsest).map(|level| needs.cells(level) * u64::from(self.slots(level)));
        let tests = tests.max().unwrap_or(0);
        let quadrant = u64::from(words(SfvtGassConfig::quadrant_pattern(pattern)));
        let mask_words = (needs.pixels() * u64::from(words(pattern))).max(tests * quadrant);
        declare_queries(needs, needs.pixels().max(tests), mask_words);
        needs.declare(Slot::Samples, RECORD * needs.all_cells(coarsest));
        self.cells.declare(needs, coarsest);
    }

    fn frames(&self, general: Frame, pattern: Pattern) -> Vec<Frame> {
        let config = &self.config;
        let quadrant = SfvtGassConfig::quadrant_pattern(pattern);
        let scaled = |bits: u32| bits * quadrant.len() as u32 / 16;
        level_frames(self.coarsest(), general, |frame| {
            let depth_finest = config.depth_finest_level.into();
            let frame = Frame { depth_finest, ..with_geometry(frame, &config.geometry) };
            if frame.level == 0 {
                return frame;
            }
            let threshold =
                scaled(if frame.level <= 2 { config.fine_threshold } else { config.coarse_threshold });
            Frame {
                pattern: GpuPattern::new(quadrant),
                slots: self.slots(frame.level),
                split_above: if config.inclusive { threshold.max(1) - 1 } else { threshold },
                gradient_above: scaled(config.gradient_threshold),
                ..frame
            }
        })
    }

    fn patterns(&self, pattern: Pattern) -> Patterns {
        Patterns::Given(vec![pattern, SfvtGassConfig::quadrant_pattern(pattern)])
    }

    fn prepare(&self, recorder: &mut Recorder) {
        self.cells.build_pyramid(recorder, self.coarsest());
    }

    fn record(&self, recorder: &mut Recorder, tracer: &Tracer, first: u32) {
        recorder.clear_queries();
        recorder.clear(Slot::Cells);
        for level in (1..=self.coarsest()).rev() {
            let frame = first + level;
            let cells = all_cells(recorder, level);
            recorder.run(&self.classify, Timed::Refine, frame, cells);
            tracer.count(recorder, frame);
            tracer.trace(recorder, frame, false);
            recorder.run(&self.split_test, Timed::Refine, frame, Groups::Cells);
            recorder.run_by_light(&self.value, Timed::Irradiance, frame, Groups::Cells);
            recorder.clear_queries();
        }
        recorder.run(&self.finals, Timed::Refine, first, Groups::Tiles(0));
        tracer.count(recorder, first);
        tracer.trace(recorder, first, true);
        self.cells.find_owners(recorder, first);
        tracer.evaluate(recorder, first);
    }
}
