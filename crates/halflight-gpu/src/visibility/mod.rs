//! Visibility backends: which passes they are made of.

mod beam;

use halflight_core::scene::Scene;
use halflight_cpu::config::{PipelineConfig, VisibilityConfig};

use crate::GpuError;
use crate::buffers::Size;
use crate::programs::visibility as programs;
use crate::recorder::{Groups, Recorder};
use crate::stage::Stage;
use crate::stats::Timed;
use beam::Beam;

/// A backend. Of two stages that answer queries the first does so to refine, the second for irradiance alone.
#[derive(Debug)]
pub(crate) enum Visibility {
    /// Ray by ray.
    Rays([Stage; 2]),
    /// Beams, and rays for what they cannot hold.
    Beam(Box<Beam>),
}

/// Two stages that differ in what their rays are counted as.
fn for_both(make: impl Fn((&'static str, f64)) -> Result<Stage, GpuError>) -> Result<[Stage; 2], GpuError> {
    Ok([make(("PURPOSE", 0.0))?, make(("PURPOSE", 1.0))?])
}

impl Visibility {
    /// Compiles the passes of a configuration's backend, or of one from outside.
    ///
    /// # Errors
    /// It does not exist here, its constants are out of range, or a shader cannot be read or compiled.
    pub(crate) fn new(
        device: &wgpu::Device,
        scene: &Scene,
        config: &PipelineConfig,
        module: Option<&str>,
    ) -> Result<Self, GpuError> {
        let rays =
            || for_both(|purpose| Stage::with_visibility(device, programs::BVH_MASKS, &[purpose], module));
        match config.visibility {
            _ if module.is_some() => Ok(Self::Rays(rays()?)),
            // Exact backends agree, so that the choice between them is free.
            VisibilityConfig::Bvh | VisibilityConfig::Auto => Ok(Self::Rays(rays()?)),
            VisibilityConfig::Beam => Ok(Self::Beam(Box::new(Beam::new(device, scene)?))),
            _ => {
                let (stage, reason) = ("this visibility backend", "only `bvh` and `beam` do so far");
                Err(GpuError::Unsupported { stage, reason })
            }
        }
    }

    /// The size that its own buffers take besides those of other stages.
    pub(crate) fn size(&self, size: Size) -> Size {
        match self {
            Self::Rays(_) => size,
            Self::Beam(_) => Size { spilled: size.queries, ..size },
        }
    }

    /// Records the answers to the queries at hand.
    pub(crate) fn record(&self, recorder: &mut Recorder, frame: u32, last: bool) {
        match self {
            Self::Rays(masks) => {
                recorder.run(&masks[usize::from(last)], Timed::Visibility, frame, Groups::Rays);
            }
            Self::Beam(beam) => beam.record(recorder, frame, last),
        }
    }

    /// All stages, to bind.
    pub(crate) fn stages(&mut self) -> Vec<&mut Stage> {
        match self {
            Self::Rays(masks) => masks.iter_mut().collect(),
            Self::Beam(beam) => beam.stages(),
        }
    }
}

/// Checks that a stage may bind as many storage buffers as a backend needs.
///
/// # Errors
/// The device allows fewer.
fn check_bindings(device: &wgpu::Device, what: &'static str, needed: usize) -> Result<(), GpuError> {
    let limit = device.limits().max_storage_buffers_per_shader_stage;
    if needed as u64 > u64::from(limit) {
        return Err(GpuError::TooLarge {
            what,
            needed: needed as u64,
            unit: "storage buffers a stage",
            limit: limit.into(),
            advice: "ask the device for more, or choose `bvh`",
        });
    }
    Ok(())
}

/// Rays for the queries that beams have no room for.
#[derive(Debug)]
struct Spill {
    dispatch: Stage,
    masks: [Stage; 2],
}

impl Spill {
    fn new(device: &wgpu::Device) -> Result<Self, GpuError> {
        Ok(Self {
            dispatch: Stage::new(device, programs::SPILL, &[])?,
            masks: for_both(|purpose| Stage::new(device, programs::SPILLED_MASKS, &[purpose]))?,
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
