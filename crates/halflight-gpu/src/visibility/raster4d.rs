//! 4D rasterization (Wang17): triangles and receivers are binned by where they are projected to through all of the light, by
//! count, scan and fill, and each cell's receivers are answered by the triangles that lie over it.
//!
//! Buffers have room for all triangles, and as many workgroups are dispatched as there are groups of receivers with runs of triangles
//! over them, so that none takes long and nothing is left out: where that would be more than a dispatch takes, receivers count as lost.
//! Receivers so near a light's plane that projections do not bound what hides them go to rays. Unlike on the CPU the framebuffer's bounds are those of all receivers, and slopes are
//! squeezed into -1 to 1, so that no outlier stretches it.

use halflight_core::frame::LightSampling;
use halflight_core::light::AreaLight;
use halflight_core::stages::Visibility;
use halflight_cpu::pipeline::PipelineError;
use halflight_cpu::raster4d::{self, Raster4dConfig};

use super::backend::{Backend, Both, Spill};
use crate::bindings::Slot;
use crate::error::GpuError;
use crate::light::sides;
use crate::needs::Needs;
use crate::pass::{Compiler, Pass};
use crate::program::programs;
use crate::recorder::{Groups, Recorder};
use crate::stats::Timed;

programs! {
    FRAME: "raster4d: frame" = lay_out in "visibility/raster4d_frame";
    TRIANGLES: "raster4d: triangles" = count_triangles in "visibility/raster4d_triangles";
    RECEIVERS: "raster4d: receivers" = count_receivers in "visibility/raster4d_receivers";
    SCAN: "raster4d: scan" = scan in "visibility/raster4d_scan";
    FILL: "raster4d: fill" = fill in "visibility/raster4d_fill";
    LENGTHS: "raster4d: lengths" = measure in "visibility/raster4d_lengths";
    MASKS: "raster4d: masks" = take_hidden in "visibility/raster4d_masks";
}

/// Words before the cells: `TRIANGLE_ENDS` in `shaders/visibility/raster4d.wgsl`.
const HEAD: u64 = 16;

/// Cells that a triangle lies in at most: `shaders/visibility/raster4d_triangles.wgsl`.
const SPAN: u64 = 4;

/// Cells a side of the finest framebuffer at most: `shaders/visibility/raster4d_cells.wgsl`.
const MOST_CELLS: u32 = 1024;

/// Passes of 4D rasterization.
#[derive(Debug)]
pub(super) struct Raster4d {
    /// Cells of all levels on one side of a light.
    cells: u64,
    /// Cells of the finest level on one side of a light.
    finest: u64,
    triangles: u64,
    frame: Pass,
    /// Passes that count, scan and fill.
    triangle_bins: [Pass; 3],
    lengths: Pass,
    count: Both,
    scan: Pass,
    fill: Pass,
    masks: Pass,
    spill: Spill,
}

impl Raster4d {
    /// Compiles the passes for a scene of so many triangles.
    ///
    /// # Errors
    /// The framebuffer is too small or too large, the samples do not lie in rows, a part is switched off that is never off
    /// here, the device binds too few buffers, or a shader cannot be compiled.
    pub(super) fn new(
        compiler: &Compiler,
        triangles: usize,
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
        let constants = [
            ("FRAMEBUFFER", framebuffer.into()),
            ("LEVELS", levels.count() as f64),
            ("CELLS", cells as f64),
            ("TRIANGLES", triangles as f64),
        ];
        let pass = |program, own: &[_]| compiler.pass(program, &[&constants, own].concat());
        let [of_triangles, of_receivers] = [0.0, 1.0].map(|value| [("RECEIVERS", value)]);
        Ok(Self {
            cells,
            finest: u64::from(framebuffer).pow(2),
            triangles: triangles as u64,
            frame: pass(FRAME, &[])?,
            triangle_bins: [pass(TRIANGLES, &[])?, pass(SCAN, &of_triangles)?, pass(FILL, &of_triangles)?],
            lengths: pass(LENGTHS, &[])?,
            count: Both::new(|purpose| pass(RECEIVERS, &[purpose]))?,
            scan: pass(SCAN, &of_receivers)?,
            fill: pass(FILL, &of_receivers)?,
            masks: pass(MASKS, &[])?,
            spill: Spill::new(compiler)?,
        })
    }
}

impl Backend for Raster4d {
    fn declare(&self, needs: &mut Needs, lights: &[AreaLight]) {
        let sides = u64::from(sides(lights));
        let triangles = sides * self.triangles;
        let cells = HEAD + sides * (self.cells + 3 * self.finest);
        let words = cells + 2 * needs.records(Slot::Queries) + (1 + SPAN) * triangles;
        needs.declare(Slot::Bins, 4 * words);
        needs.declare(Slot::Rectangles, 16 * triangles);
        Spill::declare(needs);
    }

    /// Records the bins of triangles.
    fn start(&self, recorder: &mut Recorder, frame: u32) {
        let pixels = recorder.buffers.needs.pixels();
        let sides = u64::from(sides(recorder.lights));
        recorder.clear_words(Slot::Bins, 0, HEAD + sides * self.cells);
        let mut run = |pass, count| recorder.run(pass, Timed::Visibility, frame, Groups::Count(count));
        let [count, scan, fill] = &self.triangle_bins;
        run(&self.frame, pixels);
        run(count, self.triangles);
        run(scan, 1);
        run(fill, self.triangles);
        run(&self.lengths, sides * self.finest);
    }

    fn record(&self, recorder: &mut Recorder, frame: u32, last: bool) {
        Spill::clear(recorder);
        let sides = u64::from(sides(recorder.lights));
        recorder.clear_words(Slot::Bins, HEAD + sides * self.cells, sides * self.finest);
        self.count.run(recorder, frame, last, Groups::Queries);
        let mut run = |pass, groups| recorder.run(pass, Timed::Visibility, frame, groups);
        run(&self.scan, Groups::Count(1));
        run(&self.fill, Groups::Queries);
        run(&self.masks, Groups::Tasks);
        self.spill.record(recorder, frame, last);
    }
}
