//! 4D rasterization (Wang17): triangles and receivers are binned by where they are projected to through all of the light, by
//! count, scan and fill, and each cell's receivers are answered by the triangles that lie over it.
//!
//! There is room for all triangles, and as many workgroups are dispatched as there are groups of receivers with runs of triangles
//! over them, so that none takes long and nothing is left out: where that would be more than a dispatch takes, receivers count as lost.
//! Those so near a light's plane that projections do not bound what hides them go to rays. Unlike on the CPU the framebuffer's bounds are those of all receivers, and slopes are
//! squeezed into -1 to 1, so that no outlier stretches it.

use halflight_core::frame::LightSampling;
use halflight_core::scene::Scene;
use halflight_core::stages::Visibility;
use halflight_cpu::pipeline::PipelineError;
use halflight_cpu::raster4d::{self, Raster4dConfig};

use super::{Spill, for_both};
use crate::GpuError;
use crate::buffers::Size;
use crate::programs;
use crate::recorder::{Groups, Recorder};
use crate::stage::{Compiler, Stage};
use crate::stats::Timed;

/// Words before the cells: `TRIANGLE_ENDS` in `shaders/visibility/raster4d.wgsl`.
const HEAD: u64 = 16;

/// Cells that a triangle lies in at most: `shaders/visibility/raster4d_triangles.wgsl`.
const SPAN: u64 = 4;

/// Cells a side of the finest framebuffer at most: `shaders/visibility/raster4d_cells.wgsl`.
const MOST_CELLS: u32 = 1024;

/// Passes of 4D rasterization.
#[derive(Debug)]
pub(crate) struct Raster4d {
    /// Cells of all levels, and of the finest, on all sides that the lights have.
    cells: u64,
    finest: u64,
    sides: u64,
    triangles: u64,
    frame: Stage,
    /// Counts, scans and fills.
    triangle_bins: [Stage; 3],
    lengths: Stage,
    count: [Stage; 2],
    scan: Stage,
    fill: Stage,
    masks: Stage,
    spill: Spill,
}

impl Raster4d {
    /// Compiles them.
    ///
    /// # Errors
    /// The framebuffer is too small or too large, the samples do not lie in rows, a part is switched off that is never off
    /// here, the device binds too few buffers, or a shader cannot be compiled.
    pub(super) fn new(
        compiler: &Compiler,
        scene: &Scene,
        config: Raster4dConfig,
        sampling: LightSampling,
    ) -> Result<Self, GpuError> {
        let twin = raster4d::Raster4d::new(config).map_err(PipelineError::from)?;
        let pattern = sampling.pattern().map_err(PipelineError::from)?;
        // Refiners ask for parts of it, which lie in rows where it does.
        twin.supports(pattern).map_err(PipelineError::from)?;
        let Raster4dConfig { framebuffer, .. } = config;
        if config != (Raster4dConfig { framebuffer, ..Raster4dConfig::default() }) {
            return Err(GpuError::Unsupported {
                stage: "raster4d with parts switched off",
                reason: "only its framebuffer can be chosen",
            });
        }
        if framebuffer > MOST_CELLS {
            return Err(GpuError::TooLarge {
                what: "the framebuffer of raster4d",
                needed: framebuffer.into(),
                unit: "cells a side",
                limit: MOST_CELLS.into(),
                advice: "128 are usual",
            });
        }
        let levels = std::iter::successors(Some(framebuffer), |&side| (side > 1).then(|| side.div_ceil(2)));
        let cells = levels.clone().map(|side| u64::from(side).pow(2)).sum::<u64>();
        let sides = if scene.lights.iter().any(|light| light.two_sided) { 2u32 } else { 1 };
        let triangles = scene.mesh.triangle_count();
        let constants = [
            ("FRAMEBUFFER", framebuffer.into()),
            ("LEVELS", levels.count() as f64),
            ("CELLS", cells as f64),
            ("SIDES", sides.into()),
            ("TRIANGLES", triangles as f64),
        ];
        let stage = |program, own: &[_]| compiler.stage(program, &[&constants, own].concat());
        let [of_triangles, of_receivers] = [0.0, 1.0].map(|value| [("RECEIVERS", value)]);
        let sides = u64::from(sides);
        Ok(Self {
            cells: sides * cells,
            finest: sides * u64::from(framebuffer).pow(2),
            sides,
            triangles: triangles as u64,
            frame: stage(programs::RASTER4D_FRAME, &[])?,
            triangle_bins: [
                stage(programs::RASTER4D_TRIANGLES, &[])?,
                stage(programs::RASTER4D_SCAN, &of_triangles)?,
                stage(programs::RASTER4D_FILL, &of_triangles)?,
            ],
            lengths: stage(programs::RASTER4D_LENGTHS, &[])?,
            count: for_both(|purpose| stage(programs::RASTER4D_RECEIVERS, &[purpose]))?,
            scan: stage(programs::RASTER4D_SCAN, &of_receivers)?,
            fill: stage(programs::RASTER4D_FILL, &of_receivers)?,
            masks: stage(programs::RASTER4D_MASKS, &[])?,
            spill: Spill::new(compiler)?,
        })
    }

    /// What it takes.
    pub(super) fn size(&self, size: Size) -> Size {
        let triangles = self.sides * self.triangles;
        let bins = HEAD + self.cells + 3 * self.finest + 2 * u64::from(size.queries) + (1 + SPAN) * triangles;
        Size { bins, rectangles: triangles, spilled: size.queries, ..size }
    }

    /// Bins the triangles for one light.
    pub(super) fn start(&self, recorder: &mut Recorder, frame: u32) {
        let Size { width, height, .. } = recorder.buffers.size;
        recorder.encoder.clear_buffer(&recorder.buffers.bins, 0, Some(4 * (HEAD + self.cells)));
        let mut run = |stage, count| recorder.run(stage, Timed::Visibility, frame, Groups::Count(count));
        let [count, scan, fill] = &self.triangle_bins;
        run(&self.frame, u64::from(width) * u64::from(height));
        run(count, self.triangles);
        run(scan, 1);
        run(fill, self.triangles);
        run(&self.lengths, self.finest);
    }

    /// Answers the queries at hand.
    pub(super) fn record(&self, recorder: &mut Recorder, frame: u32, last: bool) {
        Spill::clear(recorder);
        let receivers = 4 * (HEAD + self.cells);
        recorder.encoder.clear_buffer(&recorder.buffers.bins, receivers, Some(4 * self.finest));
        let mut run = |stage, groups| recorder.run(stage, Timed::Visibility, frame, groups);
        run(&self.count[usize::from(last)], Groups::Queries);
        run(&self.scan, Groups::Count(1));
        run(&self.fill, Groups::Queries);
        run(&self.masks, Groups::Tasks);
        self.spill.record(recorder, frame, last);
    }

    /// All stages, to bind.
    pub(super) fn stages(&mut self) -> Vec<&mut Stage> {
        let Self { frame, triangle_bins, lengths, count, scan, fill, masks, spill, .. } = self;
        let mut stages = spill.stages();
        stages.extend([frame, lengths, scan, fill, masks]);
        stages.extend(triangle_bins.iter_mut().chain(count));
        stages
    }
}
