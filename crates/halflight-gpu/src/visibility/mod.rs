//! Visibility backends: which passes they are made of.

mod beam;
mod raster4d;

use halflight_core::scene::Scene;
use halflight_cpu::config::{PipelineConfig, VisibilityConfig};

use crate::GpuError;
use crate::buffers::Size;
use crate::programs;
use crate::recorder::{Groups, Recorder};
use crate::stage::{Compiler, Stage};
use crate::stats::Timed;
use beam::Beam;
use raster4d::Raster4d;

/// A backend. Of two stages that answer queries the first does so to refine, the second for irradiance alone.
#[derive(Debug)]
pub(crate) enum Visibility {
    /// Ray by ray.
    Rays([Stage; 2]),
    /// Beams, and rays for what they cannot hold.
    Beam(Box<Beam>),
    /// 4D rasterization, and rays at the light's plane.
    Raster4d(Box<Raster4d>),
}

/// Two stages that differ in what their rays are counted as.
fn for_both(make: impl Fn((&'static str, f64)) -> Result<Stage, GpuError>) -> Result<[Stage; 2], GpuError> {
    Ok([make(("PURPOSE", 0.0))?, make(("PURPOSE", 1.0))?])
}

impl Visibility {
    /// Compiles the passes of a configuration's backend.
    ///
    /// # Errors
    /// It does not exist here, its constants or the light samples are out of range, or a shader cannot be read or compiled.
    pub(crate) fn new(compiler: &Compiler, scene: &Scene, config: &PipelineConfig) -> Result<Self, GpuError> {
        match config.visibility {
            // Exact backends agree, so that the choice between them is free.
            VisibilityConfig::Bvh | VisibilityConfig::Auto => {
                Ok(Self::Rays(for_both(|purpose| compiler.stage(programs::MASKS, &[purpose]))?))
            }
            VisibilityConfig::Beam => Ok(Self::Beam(Box::new(Beam::new(compiler, scene)?))),
            VisibilityConfig::Raster4d(raster) => {
                Ok(Self::Raster4d(Box::new(Raster4d::new(compiler, scene, raster, config.sampling)?)))
            }
            VisibilityConfig::Voxel(_) => {
                let (stage, reason) = ("voxel", "only `bvh`, `beam` and `raster4d` do so far");
                Err(GpuError::Unsupported { stage, reason })
            }
        }
    }

    /// The size that its own buffers take besides those of other stages.
    pub(crate) fn size(&self, size: Size) -> Size {
        match self {
            Self::Rays(_) => size,
            Self::Beam(_) => Size { spilled: size.queries, ..size },
            Self::Raster4d(raster) => raster.size(size),
        }
    }

    /// Records what is done once a light; `frame` is the first of its uniforms.
    pub(crate) fn start(&self, recorder: &mut Recorder, frame: u32) {
        match self {
            Self::Rays(_) | Self::Beam(_) => {}
            Self::Raster4d(raster) => raster.start(recorder, frame),
        }
    }

    /// Records the answers to the queries at hand.
    pub(crate) fn record(&self, recorder: &mut Recorder, frame: u32, last: bool) {
        match self {
            Self::Rays(masks) => {
                recorder.run(&masks[usize::from(last)], Timed::Visibility, frame, Groups::Rays);
            }
            Self::Beam(beam) => beam.record(recorder, frame, last),
            Self::Raster4d(raster) => raster.record(recorder, frame, last),
        }
    }

    /// All stages, to bind.
    pub(crate) fn stages(&mut self) -> Vec<&mut Stage> {
        match self {
            Self::Rays(masks) => masks.iter_mut().collect(),
            Self::Beam(beam) => beam.stages(),
            Self::Raster4d(raster) => raster.stages(),
        }
    }
}

/// Rays for the queries that another backend leaves to them.
#[derive(Debug)]
struct Spill {
    dispatch: Stage,
    masks: [Stage; 2],
}

impl Spill {
    fn new(compiler: &Compiler) -> Result<Self, GpuError> {
        Ok(Self {
            dispatch: compiler.stage(programs::SPILL, &[])?,
            masks: for_both(|purpose| compiler.stage(programs::SPILLED_MASKS, &[purpose]))?,
        })
    }

    /// Forgets what has been left to rays.
    fn clear(recorder: &mut Recorder) {
        recorder.encoder.clear_buffer(&recorder.buffers.spilled, 0, Some(4));
    }

    /// Answers it.
    fn record(&self, recorder: &mut Recorder, frame: u32, last: bool) {
        recorder.run(&self.dispatch, Timed::Visibility, frame, Groups::Count(1));
        recorder.run(&self.masks[usize::from(last)], Timed::Visibility, frame, Groups::Spilled);
    }

    fn stages(&mut self) -> Vec<&mut Stage> {
        let Self { dispatch, masks: [first, second] } = self;
        vec![dispatch, first, second]
    }
}
