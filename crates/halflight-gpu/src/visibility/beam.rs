//! Beams: 64 neighbouring receivers gather the triangles in the shaft between them and the light, in workgroup memory. An empty
//! shaft proves light; where there are more triangles than fit, the receivers go to rays, which the device counts.

use halflight_core::scene::Scene;

use super::{Spill, for_both};
use crate::GpuError;
use crate::programs;
use crate::recorder::{Groups, Recorder};
use crate::stage::{Compiler, Stage};
use crate::stats::Timed;

/// Passes of beams.
#[derive(Debug)]
pub(crate) struct Beam {
    masks: [Stage; 2],
    spill: Spill,
}

impl Beam {
    /// Compiles them.
    ///
    /// # Errors
    /// The device binds too few buffers, or a shader cannot be compiled.
    pub(super) fn new(compiler: &Compiler, scene: &Scene) -> Result<Self, GpuError> {
        let (low, high) = scene.mesh.bounds().unwrap_or_default();
        let largest = ("LARGEST", low.abs().max(high.abs()).max_element().into());
        Ok(Self {
            masks: for_both(|purpose| compiler.stage(programs::BEAM, &[largest, purpose]))?,
            spill: Spill::new(compiler)?,
        })
    }

    /// Answers the queries at hand.
    pub(super) fn record(&self, recorder: &mut Recorder, frame: u32, last: bool) {
        Spill::clear(recorder);
        recorder.run(&self.masks[usize::from(last)], Timed::Visibility, frame, Groups::Queries);
        self.spill.record(recorder, frame, last);
    }

    /// All stages, to bind.
    pub(super) fn stages(&mut self) -> Vec<&mut Stage> {
        let Self { masks: [first, second], spill } = self;
        let mut stages = spill.stages();
        stages.extend([first, second]);
        stages
    }
}
