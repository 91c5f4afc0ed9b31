//! Beams: 64 neighbouring receivers gather the triangles in the shaft between them and the light, in workgroup memory. An empty
//! shaft proves light; where there are more triangles than fit, the receivers go to rays, which the device counts.

use halflight_core::light::AreaLight;

use super::backend::{Backend, Both, Spill};
use crate::error::GpuError;
use crate::needs::Needs;
use crate::pass::Compiler;
use crate::program::programs;
use crate::recorder::{Groups, Recorder};

programs! {
    BEAM: "beam" = beam in "visibility/beam", "shared/query_batch";
}

/// Passes of beams.
#[derive(Debug)]
pub(super) struct Beam {
    masks: Both,
    spill: Spill,
}

impl Beam {
    pub(super) fn new(compiler: &Compiler) -> Result<Self, GpuError> {
        Ok(Self {
            masks: Both::new(|purpose| compiler.pass(BEAM, &[purpose]))?,
            spill: Spill::new(compiler)?,
        })
    }
}

impl Backend for Beam {
    fn declare(&self, needs: &mut Needs, _lights: &[AreaLight]) {
        Spill::declare(needs);
    }

    fn record(&self, recorder: &mut Recorder, frame: u32, last: bool) {
        Spill::clear(recorder);
        self.masks.run(recorder, frame, last, Groups::Queries);
        self.spill.record(recorder, frame, last);
    }
}
