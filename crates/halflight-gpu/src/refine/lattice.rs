//! The refiner `lattice`: masks at corners that cells share, refined where the visible fraction cannot be interpolated.

use halflight_core::pattern::Pattern;
use halflight_core::pyramid::MAX_LEVEL;
use halflight_cpu::irradiance::Shading;
use halflight_cpu::refine::{Budget, LatticeConfig, Steps};

use super::refiner::{Cells, Refiner, declare_queries, level_frames};
use super::request::Request;
use super::target::Target;
use super::tracer::Tracer;
use crate::bindings::Slot;
use crate::error::GpuError;
use crate::frame::Frame;
use crate::needs::{Needs, RECORD, words};
use crate::pass::{ByLight, Compiler, Pass, flag, shading_flag};
use crate::program::programs;
use crate::recorder::{Groups, Recorder};
use crate::stats::Timed;
use crate::textured::Patterns;

programs! {
    DISCONTINUITIES: "discontinuities" = find in "refine/discontinuities";
    GATHER: "discontinuities: gather" = gather in "refine/discontinuities_gather";
    SMOOTH: "lattice: smooth" = smooth_fractions in "refine/lattice_smooth";
    SMOOTH_TEXTURED: "lattice: smooth, textured" = smooth_fractions in "textured/lattice_smooth";
    VALUE_TEXTURED: "lattice: value, textured" = value in "refine/lattice_value", "textured/noise", "textured/value";
    VALUE: "lattice: value" = value in "refine/lattice_value", "shared/noise", "shared/value";
    SPLIT_TEST: "lattice: split test" = split_test in "refine/lattice_split_test";
    CLOSE_CRACKS: "lattice: close cracks" = close_cracks in "refine/lattice_close_cracks";
}

/// Rounds of comparisons of kept cells with their neighbours. The CPU goes on until none is contradicted, which took up to four
/// rounds in a hall, among toys and in foliage; cracks that are left after more than these stay.
const ROUNDS: usize = 6;

/// Passes of the lattice.
#[derive(Debug)]
pub(super) struct Lattice {
    config: LatticeConfig,
    cells: Cells,
    discontinuities: Pass,
    gather: Pass,
    request: Request,
    value: ByLight,
    split_test: Pass,
    close_cracks: Pass,
    /// Smoothing of visible fractions, where visible errors are bounded.
    smooth: Option<ByLight>,
    target: Option<Target>,
}

impl Lattice {
    pub(super) fn new(
        compiler: &Compiler,
        config: LatticeConfig,
        shading: Shading,
    ) -> Result<Self, GpuError> {
        if config.certify {
            return Err(GpuError::Unsupported {
                stage: "lattice with certificates",
                reason: "no backend certifies anything here; leave `certify` out",
            });
        }
        let visible_error = if config.target > 0.0 { config.visible_error } else { 0.0 };
        // Irradiance itself is computed from masks.
        let smooths = visible_error > 0.0 && shading == Shading::Ratio;
        let target = (config.target > 0.0)
            .then(|| Target::new(compiler, config.target, visible_error, smooths))
            .transpose()?;
        let visible_error = ("VISIBLE_ERROR", f64::from(visible_error));
        let edge = Steps::new(config.target).edge;
        let noisy = ("NOISY", flag(target.is_some()));
        Ok(Self {
            config,
            cells: Cells::new(compiler, false, false)?,
            discontinuities: compiler.pass(DISCONTINUITIES, &[("EDGE", edge.into())])?,
            gather: compiler.pass(GATHER, &[])?,
            request: Request::new(compiler, true)?,
            value: compiler.by_light(
                (VALUE, &[shading_flag(shading), noisy]),
                (VALUE_TEXTURED, &[shading_flag(shading), noisy]),
            )?,
            split_test: compiler.pass(SPLIT_TEST, &[visible_error])?,
            close_cracks: compiler.pass(CLOSE_CRACKS, &[visible_error])?,
            smooth: smooths.then(|| compiler.by_light((SMOOTH, &[]), (SMOOTH_TEXTURED, &[]))).transpose()?,
            target,
        })
    }

    /// Keeps or splits all pending cells of a level.
    fn commit(&self, recorder: &mut Recorder, tracer: &Tracer, first: u32, level: u32) {
        let frame = first + level;
        self.request.record(recorder, tracer, frame, level, level == 0);
        recorder.run_by_light(&self.value, Timed::Irradiance, frame, Groups::Queries);
        recorder.run(&self.split_test, Timed::Refine, frame, Groups::Tiles(level));
    }
}

impl Refiner for Lattice {
    fn coarsest(&self) -> u32 {
        self.config.coarsest_level.min(MAX_LEVEL).into()
    }

    fn declare(&self, needs: &mut Needs, pattern: Pattern) {
        let pixels = needs.pixels();
        let mask_words = if self.target.is_some() { Target::WORDS } else { words(pattern) };
        declare_queries(needs, pixels, pixels * u64::from(mask_words));
        needs.declare(Slot::Samples, RECORD * pixels);
        needs.declare(Slot::Discontinuities, 4 * needs.all_cells(self.coarsest()));
        needs.declare(Slot::Fractions, 8 * pixels);
        self.cells.declare(needs, self.coarsest());
        if self.target.is_some() {
            Target::declare(needs);
        }
    }

    fn frames(&self, general: Frame, pattern: Pattern) -> Vec<Frame> {
        let LatticeConfig { error, target, discontinuity, .. } = self.config;
        let mut frames = level_frames(self.coarsest(), general, |frame| Frame {
            error,
            step_level: Steps::new(target).level.into(),
            crease_sine: discontinuity.crease_deg.to_radians().sin(),
            pixel_footprint: discontinuity.step_px * frame.pixel_footprint,
            ..frame
        });
        let coarsest = frames.last().copied().filter(|_| self.target.is_some());
        frames.extend(coarsest.map(|frame| Frame { pattern: Target::pilot_pattern(pattern), ..frame }));
        frames
    }

    fn patterns(&self, pattern: Pattern) -> Patterns {
        match self.target {
            Some(_) => Patterns::Squares { most: Budget::ONCE },
            None => Patterns::Given(vec![pattern]),
        }
    }

    fn smooths(&self) -> bool {
        self.smooth.is_some()
    }

    fn expects(&self) -> bool {
        self.target.is_some()
    }

    fn record(&self, recorder: &mut Recorder, tracer: &Tracer, first: u32) {
        let coarsest = self.coarsest();
        recorder.clear_queries();
        recorder.clear(Slot::Cells);
        recorder.clear(Slot::Fractions);
        recorder.run(&self.discontinuities, Timed::Refine, first, Groups::Tiles(0));
        for level in 1..=coarsest {
            recorder.run(&self.gather, Timed::Refine, first + level, Groups::Tiles(level));
        }
        if let Some(target) = &self.target {
            target.take_pilot_samples(recorder, tracer, first, coarsest);
            recorder.clear(Slot::Cells);
            recorder.clear_queries();
        }
        for level in (0..=coarsest).rev() {
            self.commit(recorder, tracer, first, level);
            if let Some(target) = self.target.as_ref().filter(|_| level > 0) {
                target.decide(recorder, first, level - 1, coarsest);
            }
        }
        for _ in 0..ROUNDS {
            for level in 1..=coarsest {
                recorder.run(&self.close_cracks, Timed::Refine, first + level, Groups::Tiles(level));
            }
            // Children of cells that were split; the coarsest cells have no parents.
            for level in (0..coarsest.max(1)).rev() {
                self.commit(recorder, tracer, first, level);
            }
        }
        if let Some(smooth) = &self.smooth {
            recorder.run_by_light(smooth, Timed::Refine, first, Groups::Tiles(0));
        }
        self.cells.find_owners(recorder, first);
        if let Some(target) = &self.target {
            target.predict(recorder, first);
        }
    }

    fn finish(&self, recorder: &mut Recorder) {
        if let Some(target) = &self.target {
            target.measure(recorder);
        }
    }
}
