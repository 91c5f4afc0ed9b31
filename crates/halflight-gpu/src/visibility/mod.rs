//! Visibility backends: which passes they are made of.

mod beam;
mod raster4d;
mod voxel;

use halflight_core::scene::{Camera, Scene};
use halflight_cpu::config::{PipelineConfig, VisibilityConfig};

use crate::GpuError;
use crate::buffers::Size;
use crate::programs;
use crate::recorder::{Groups, Recorder};
use crate::stage::{Compiler, Stage};
use crate::stats::Timed;
use beam::Beam;
use raster4d::Raster4d;
use voxel::Voxel;

#[cfg(test)]
pub(crate) use voxel::{Space, TurnedLight};

/// A backend. Of two stages that answer queries the first does so to refine, the second for irradiance alone.
#[derive(Debug)]
pub(crate) enum Visibility {
    /// Ray by ray.
    Rays([Stage; 2]),
    /// Beams, and rays for what they cannot hold.
    Beam(Box<Beam>),
    /// 4D rasterization, and rays at the light's plane.
    Raster4d(Box<Raster4d>),
    /// Voxel marching.
    Voxel(Box<Voxel>),
}

/// Two stages that differ in what their rays are counted as.
fn for_both(make: impl Fn((&'static str, f64)) -> Result<Stage, GpuError>) -> Result<[Stage; 2], GpuError> {
    Ok([make(("PURPOSE", 0.0))?, make(("PURPOSE", 1.0))?])
}

impl Visibility {
    /// Compiles the passes of a configuration's backend.
    ///
    /// # Errors
    /// Its constants or the light samples are out of range, or a shader cannot be read or compiled.
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
            VisibilityConfig::Voxel(voxel) => Ok(Self::Voxel(Box::new(Voxel::new(compiler, scene, voxel)?))),
        }
    }

    /// The size that its own buffers take besides those of other stages.
    pub(crate) fn size(&self, size: Size) -> Size {
        match self {
            Self::Rays(_) => size,
            Self::Beam(_) => Size { spilled: size.queries, ..size },
            Self::Raster4d(raster) => raster.size(size),
            Self::Voxel(voxel) => voxel.size(size),
        }
    }

    /// What the buffer `space` is to hold for a camera.
    pub(crate) fn space(&self, camera: &Camera, size: Size) -> Vec<u8> {
        match self {
            Self::Voxel(voxel) => voxel.space(camera, size),
            _ => Vec::new(),
        }
    }

    /// Records what is done once a frame; the uniforms of each light begin `stride` after those of the one before.
    pub(crate) fn prepare(&self, recorder: &mut Recorder, stride: u32) {
        if let Self::Voxel(voxel) = self {
            voxel.prepare(recorder, stride);
        }
    }

    /// Records what is done once a light; `frame` is the first of its uniforms.
    pub(crate) fn start(&self, recorder: &mut Recorder, frame: u32) {
        if let Self::Raster4d(raster) = self {
            raster.start(recorder, frame);
        }
    }

    /// Records the answers to the queries at hand.
    pub(crate) fn record(&self, recorder: &mut Recorder, frame: u32, last: bool) {
        let masks = match self {
            Self::Rays(masks) => masks,
            Self::Beam(beam) => return beam.record(recorder, frame, last),
            Self::Raster4d(raster) => return raster.record(recorder, frame, last),
            Self::Voxel(voxel) => &voxel.masks,
        };
        recorder.run(&masks[usize::from(last)], Timed::Visibility, frame, Groups::Rays);
    }

    /// All stages, to bind.
    pub(crate) fn stages(&mut self) -> Vec<&mut Stage> {
        match self {
            Self::Rays(masks) => masks.iter_mut().collect(),
            Self::Beam(beam) => beam.stages(),
            Self::Raster4d(raster) => raster.stages(),
            Self::Voxel(voxel) => voxel.stages(),
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
