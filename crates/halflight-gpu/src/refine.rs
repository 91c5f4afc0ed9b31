//! Refiners: which passes they are made of.

mod target;

use halflight_core::pattern::Pattern;
use halflight_core::pyramid::MAX_LEVEL;
use halflight_cpu::config::{PipelineConfig, RefinerConfig};
use halflight_cpu::irradiance::Shading;
use halflight_cpu::refine::{GeometryThresholds, LatticeConfig, NicholsConfig, SfvtGassConfig, Steps};

use crate::GpuError;
use crate::buffers::Size;
use crate::frame::{self, Frame, GpuPattern};
use crate::programs;
use crate::recorder::{Groups, Recorder};
use crate::stage::{Compiler, Stage};
use crate::stats::Timed;
use crate::visibility::Visibility;
pub(crate) use target::Choice;
use target::Target;

/// Turns queries into masks and values.
#[derive(Debug)]
pub(crate) struct Tracer {
    pub(crate) dispatch: Stage,
    pub(crate) visibility: Visibility,
    pub(crate) irradiance: Stage,
}

impl Tracer {
    /// Sizes the dispatches of the queries that are new.
    fn count(&self, recorder: &mut Recorder, frame: u32) {
        recorder.run(&self.dispatch, Timed::Refine, frame, Groups::Count(1));
    }

    /// Traces these.
    fn trace(&self, recorder: &mut Recorder, frame: u32, last: bool) {
        self.visibility.record(recorder, frame, last);
    }
}

/// A refiner.
#[derive(Debug)]
pub(crate) enum Refine {
    /// Every pixel its own samples.
    Full(Stage),
    /// 3 × 3 neighbourhoods.
    Nichols(Box<Nichols>),
    /// Sub-fragment tests.
    SfvtGass(Box<SfvtGass>),
    /// Masks at the corners of cells.
    Lattice(Box<Lattice>),
}

/// Passes of Nichols10.
#[derive(Debug)]
pub(crate) struct Nichols {
    config: NicholsConfig,
    pyramid: Stage,
    choose: Stage,
    reuse: Stage,
    merge: Stage,
    compare: Stage,
    settle: Stage,
    owners: Stage,
}

/// Passes of Koa17.
#[derive(Debug)]
pub(crate) struct SfvtGass {
    config: SfvtGassConfig,
    pyramid: Stage,
    classify: Stage,
    judge: Stage,
    value: Stage,
    finals: Stage,
    owners: Stage,
}

/// Passes of the lattice.
#[derive(Debug)]
pub(crate) struct Lattice {
    config: LatticeConfig,
    discontinuities: Stage,
    gather: Stage,
    look: Stage,
    ask: Stage,
    value: Stage,
    judge: Stage,
    mend: Stage,
    owners: Stage,
    target: Option<Target>,
}

/// How often kept cells are compared with their neighbours. The CPU goes on until none is contradicted, which took up to four
/// rounds in a hall, among toys and in foliage; cracks that are left after more than these stay.
const ROUNDS: usize = 6;

/// An override constant that is true or false.
fn flag(value: bool) -> f64 {
    if value { 1.0 } else { 0.0 }
}

impl Refine {
    /// Compiles the passes of a configuration's refiner.
    ///
    /// # Errors
    /// It does not exist here, or a shader cannot be compiled.
    pub(crate) fn new(compiler: &Compiler, config: &PipelineConfig) -> Result<Self, GpuError> {
        let shading = ("SHADING", flag(config.shading == Shading::Ratio));
        let stage = |program, constants: &[(&str, f64)]| compiler.stage(program, constants);
        match config.refiner {
            RefinerConfig::Full => Ok(Self::Full(stage(programs::FULL, &[])?)),
            RefinerConfig::Nichols(config) => {
                if config.irradiance_threshold.is_some() {
                    return Err(GpuError::Unsupported {
                        stage: "nichols with an irradiance threshold",
                        reason: "only light samples are compared; leave the threshold out",
                    });
                }
                let interleaved = ("INTERLEAVED", flag(config.interleaved));
                Ok(Self::Nichols(Box::new(Nichols {
                    config,
                    pyramid: stage(programs::PYRAMID, &[])?,
                    choose: stage(programs::NICHOLS_CHOOSE, &[shading, interleaved])?,
                    reuse: stage(programs::NICHOLS_REUSE, &[interleaved])?,
                    merge: stage(programs::NICHOLS_MERGE, &[])?,
                    compare: stage(programs::NICHOLS_COMPARE, &[interleaved])?,
                    settle: stage(programs::NICHOLS_COMMIT, &[("DIAGONAL", flag(config.diagonal))])?,
                    owners: stage(programs::OWNERS, &[])?,
                })))
            }
            RefinerConfig::SfvtGass(config) => {
                let dark = ("DARK_CULLING", flag(config.dark_culling));
                let additional = ("FURTHER_SAMPLES", flag(config.additional_samples));
                Ok(Self::SfvtGass(Box::new(SfvtGass {
                    config,
                    pyramid: stage(programs::PYRAMID, &[])?,
                    classify: stage(programs::SFVT_CLASSIFY, &[shading])?,
                    judge: stage(programs::SFVT_SPLIT_TEST, &[dark, additional])?,
                    value: stage(programs::SFVT_VALUE, &[shading])?,
                    finals: stage(programs::SFVT_FINALS, &[shading])?,
                    owners: stage(programs::OWNERS, &[])?,
                })))
            }
            RefinerConfig::Lattice(config) => {
                if config.certify {
                    return Err(GpuError::Unsupported {
                        stage: "lattice with proofs",
                        reason: "no backend proves anything here; leave `certify` out",
                    });
                }
                let target =
                    (config.target > 0.0).then(|| Target::new(compiler, config.target)).transpose()?;
                let edge = Steps::new(config.target).edge;
                Ok(Self::Lattice(Box::new(Lattice {
                    config,
                    discontinuities: stage(programs::DISCONTINUITIES, &[("EDGE", edge.into())])?,
                    gather: stage(programs::DISCONTINUITIES_GATHER, &[])?,
                    look: stage(programs::LATTICE_CLASSIFY, &[])?,
                    ask: stage(programs::LATTICE_REQUEST, &[])?,
                    value: stage(programs::LATTICE_VALUE, &[shading, ("NOISY", flag(target.is_some()))])?,
                    judge: stage(programs::LATTICE_SPLIT_TEST, &[])?,
                    mend: stage(programs::LATTICE_CLOSE_CRACKS, &[])?,
                    owners: stage(programs::OWNERS, &[("COUNTED", 0.0)])?,
                    target,
                })))
            }
        }
    }

    /// The coarsest level of cells.
    pub(crate) fn coarsest(&self) -> u32 {
        let level = |level: u8| u32::from(level.clamp(1, MAX_LEVEL));
        match self {
            Self::Full(_) => 0,
            Self::Nichols(nichols) => level(nichols.config.coarsest_level),
            Self::SfvtGass(sfvt) => level(sfvt.config.coarsest_level),
            Self::Lattice(lattice) => lattice.config.coarsest_level.min(MAX_LEVEL).into(),
        }
    }

    /// Uniforms of a light: one a level, and one of a trial.
    pub(crate) fn uniforms(&self) -> u32 {
        self.coarsest() + 1 + u32::from(self.expects())
    }

    /// What its buffers take for an image of this size.
    pub(crate) fn size(&self, width: u32, height: u32, pattern: Pattern) -> Size {
        let words = u64::from(frame::words(pattern));
        let cells = |level| frame::cells(width, height, level);
        let all = (0..=self.coarsest()).map(cells).sum::<u32>();
        let size = Size { width, height, samples: all, cells: all, pyramid: all, ..Size::default() };
        match self {
            Self::Full(_) => Size {
                queries: all,
                words: u64::from(all) * words,
                samples: all,
                cells: 0,
                pyramid: 0,
                ..size
            },
            Self::Nichols(nichols) => {
                let words = u64::from(all) * words;
                Size {
                    queries: all,
                    words,
                    reused: if nichols.config.incremental { words } else { 0 },
                    ..size
                }
            }
            Self::SfvtGass(sfvt) => {
                // What does not fit into 32 bits does not fit into a buffer either.
                let tests = (1..=self.coarsest()).map(|level| cells(level).saturating_mul(sfvt.slots(level)));
                let tests = tests.max().unwrap_or(0);
                let quadrant = u64::from(frame::words(SfvtGassConfig::quadrant_pattern(pattern)));
                Size {
                    queries: cells(0).max(tests),
                    words: (u64::from(cells(0)) * words).max(u64::from(tests) * quadrant),
                    ..size
                }
            }
            Self::Lattice(lattice) => Size {
                queries: cells(0),
                words: u64::from(cells(0))
                    * if lattice.target.is_some() { Target::WORDS.into() } else { words },
                choices: lattice.target.is_some().into(),
                tiles: if lattice.target.is_some() { width.div_ceil(8) * height.div_ceil(8) } else { 0 },
                samples: cells(0),
                pyramid: 0,
                discontinuities: all,
                fractions: cells(0),
                ..size
            },
        }
    }

    /// Uniforms of one light: one a level, pixels first, and the trial's.
    pub(crate) fn frames(&self, general: Frame, pattern: Pattern) -> Vec<Frame> {
        let coarsest = self.coarsest();
        let level = |level: u32| {
            let frame = Frame { level, coarsest, ..general };
            match self {
                Self::Full(_) => frame,
                Self::Nichols(nichols) => nichols.frame(frame, pattern),
                Self::SfvtGass(sfvt) => sfvt.frame(frame, pattern),
                Self::Lattice(lattice) => lattice.frame(frame),
            }
        };
        let trial = match self {
            Self::Lattice(lattice) if lattice.target.is_some() => {
                Some(Frame { pattern: Target::trial(pattern), ..level(coarsest) })
            }
            _ => None,
        };
        (0..=coarsest).map(level).chain(trial).collect()
    }

    /// Records what is done once a frame.
    pub(crate) fn prepare(&self, recorder: &mut Recorder) {
        let pyramid = match self {
            Self::Full(_) | Self::Lattice(_) => return,
            Self::Nichols(nichols) => &nichols.pyramid,
            Self::SfvtGass(sfvt) => &sfvt.pyramid,
        };
        recorder.encoder.clear_buffer(&recorder.buffers.pyramid, 0, None);
        for level in 1..=self.coarsest() {
            let Size { width, height, .. } = recorder.buffers.size;
            let seams = u64::from(frame::cells(width, height, level)) * (2 << level);
            recorder.run(pyramid, Timed::Pyramid, level, Groups::Count(seams));
        }
    }

    /// Records what is done for one light, whose uniforms begin at `first`.
    pub(crate) fn record(&self, recorder: &mut Recorder, tracer: &Tracer, first: u32) {
        recorder.clear_queries();
        match self {
            Self::Full(stage) => {
                recorder.run(stage, Timed::Refine, first, Groups::Tiles(0));
                tracer.count(recorder, first);
                tracer.trace(recorder, first, true);
            }
            Self::Nichols(nichols) => nichols.record(recorder, tracer, first, self.coarsest()),
            Self::SfvtGass(sfvt) => sfvt.record(recorder, tracer, first, self.coarsest()),
            // Its values are known as it goes.
            Self::Lattice(lattice) => return lattice.record(recorder, tracer, first, self.coarsest()),
        }
        recorder.run(&tracer.irradiance, Timed::Irradiance, first, Groups::AllQueries);
    }

    /// Records what is done once the image is there.
    pub(crate) fn finish(&self, recorder: &mut Recorder) {
        if let Self::Lattice(lattice) = self
            && let Some(target) = &lattice.target
        {
            target.measure(recorder);
        }
    }

    /// Whether it says what error is to be expected.
    pub(crate) fn expects(&self) -> bool {
        matches!(self, Self::Lattice(lattice) if lattice.target.is_some())
    }

    /// All stages, to bind.
    pub(crate) fn stages(&mut self) -> Vec<&mut Stage> {
        match self {
            Self::Full(stage) => vec![stage],
            Self::Nichols(nichols) => {
                let Nichols { config: _, pyramid, choose, reuse, merge, compare, settle, owners } =
                    &mut **nichols;
                vec![pyramid, choose, reuse, merge, compare, settle, owners]
            }
            Self::SfvtGass(sfvt) => {
                let SfvtGass { config: _, pyramid, classify, judge, value, finals, owners } = &mut **sfvt;
                vec![pyramid, classify, judge, value, finals, owners]
            }
            Self::Lattice(lattice) => {
                let Lattice {
                    config: _,
                    discontinuities,
                    gather,
                    look,
                    ask,
                    value,
                    judge,
                    mend,
                    owners,
                    target,
                } = &mut **lattice;
                let stages = [discontinuities, gather, look, ask, value, judge, mend, owners];
                stages.into_iter().chain(target.iter_mut().flat_map(Target::stages)).collect()
            }
        }
    }
}

fn with_geometry(frame: Frame, thresholds: &GeometryThresholds) -> Frame {
    Frame { depth_break: thresholds.depth, curvature_break: thresholds.curvature, ..frame }
}

/// Invocations for all cells of a level.
fn all_cells(recorder: &Recorder, level: u32) -> Groups {
    let Size { width, height, .. } = recorder.buffers.size;
    Groups::Count(frame::cells(width, height, level).into())
}

impl Nichols {
    fn frame(&self, frame: Frame, pattern: Pattern) -> Frame {
        let samples = pattern.len() / if self.config.interleaved { 4 } else { 1 };
        let enough = (self.config.visibility_threshold * samples as f32).max(1.0);
        with_geometry(Frame { enough, ..frame }, &self.config.geometry)
    }

    fn record(&self, recorder: &mut Recorder, tracer: &Tracer, first: u32, coarsest: u32) {
        recorder.encoder.clear_buffer(&recorder.buffers.cells, 0, None);
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
            recorder.run(&self.settle, Timed::Refine, frame, Groups::Queries);
        }
        recorder.run(&self.owners, Timed::Refine, first, Groups::Tiles(0));
    }
}

impl SfvtGass {
    /// Queries of a tested cell.
    fn slots(&self, level: u32) -> u32 {
        if level >= u32::from(self.config.sixteen_from_level) { 16 } else { 4 }
    }

    fn frame(&self, frame: Frame, pattern: Pattern) -> Frame {
        let config = &self.config;
        let frame = Frame {
            depth_finest: config.depth_finest_level.into(),
            ..with_geometry(frame, &config.geometry)
        };
        if frame.level == 0 {
            return frame;
        }
        let quadrant = SfvtGassConfig::quadrant_pattern(pattern);
        let scaled = |bits: u32| bits * quadrant.len() as u32 / 16;
        let threshold =
            scaled(if frame.level <= 2 { config.fine_threshold } else { config.coarse_threshold });
        Frame {
            pattern: GpuPattern::new(quadrant),
            slots: self.slots(frame.level),
            split_above: if config.inclusive { threshold.max(1) - 1 } else { threshold },
            gradient_above: scaled(config.gradient_threshold),
            ..frame
        }
    }

    fn record(&self, recorder: &mut Recorder, tracer: &Tracer, first: u32, coarsest: u32) {
        recorder.encoder.clear_buffer(&recorder.buffers.cells, 0, None);
        for level in (1..=coarsest).rev() {
            let frame = first + level;
            let cells = all_cells(recorder, level);
            recorder.run(&self.classify, Timed::Refine, frame, cells);
            tracer.count(recorder, frame);
            tracer.trace(recorder, frame, false);
            recorder.run(&self.judge, Timed::Refine, frame, Groups::Cells);
            recorder.run(&self.value, Timed::Irradiance, frame, Groups::Cells);
            recorder.clear_queries();
        }
        recorder.run(&self.finals, Timed::Refine, first, Groups::Tiles(0));
        tracer.count(recorder, first);
        tracer.trace(recorder, first, true);
        recorder.run(&self.owners, Timed::Refine, first, Groups::Tiles(0));
    }
}

impl Lattice {
    fn frame(&self, frame: Frame) -> Frame {
        let LatticeConfig { error, target, discontinuity, .. } = self.config;
        Frame {
            error,
            step_level: Steps::new(target).level.into(),
            crease_sine: discontinuity.crease_deg.to_radians().sin(),
            pixel_footprint: discontinuity.step_px * frame.pixel_footprint,
            ..frame
        }
    }

    fn record(&self, recorder: &mut Recorder, tracer: &Tracer, first: u32, coarsest: u32) {
        recorder.encoder.clear_buffer(&recorder.buffers.cells, 0, None);
        recorder.encoder.clear_buffer(&recorder.buffers.fractions, 0, None);
        recorder.run(&self.discontinuities, Timed::Refine, first, Groups::Tiles(0));
        for level in 1..=coarsest {
            recorder.run(&self.gather, Timed::Refine, first + level, Groups::Tiles(level));
        }
        if let Some(target) = &self.target {
            target.try_out(recorder, tracer, &self.look, first, coarsest);
            recorder.encoder.clear_buffer(&recorder.buffers.cells, 0, None);
            recorder.clear_queries();
        }
        for level in (0..=coarsest).rev() {
            self.settle(recorder, tracer, first, level);
            if let Some(target) = self.target.as_ref().filter(|_| level > 0) {
                target.decide(recorder, first, level - 1, coarsest);
            }
        }
        for _ in 0..ROUNDS {
            for level in 1..=coarsest {
                recorder.run(&self.mend, Timed::Refine, first + level, Groups::Tiles(level));
            }
            // Children of what was split; the coarsest cells have no parents.
            for level in (0..coarsest.max(1)).rev() {
                self.settle(recorder, tracer, first, level);
            }
        }
        recorder.run(&self.owners, Timed::Refine, first, Groups::Tiles(0));
        if let Some(target) = &self.target {
            target.expect(recorder, first);
        }
    }

    /// Keeps or splits all pending cells of a level.
    fn settle(&self, recorder: &mut Recorder, tracer: &Tracer, first: u32, level: u32) {
        let frame = first + level;
        recorder.run(&self.look, Timed::Refine, frame, Groups::Tiles(level));
        recorder.run(&self.ask, Timed::Refine, frame, Groups::Corners(level));
        tracer.count(recorder, frame);
        tracer.trace(recorder, frame, level == 0);
        recorder.run(&self.value, Timed::Irradiance, frame, Groups::Queries);
        recorder.run(&self.judge, Timed::Refine, frame, Groups::Tiles(level));
    }
}
