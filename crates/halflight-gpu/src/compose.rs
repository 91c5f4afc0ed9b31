//! Sum of the lights' values: the image.

use halflight_cpu::irradiance::Shading;

use crate::bindings::Slot;
use crate::error::GpuError;
use crate::needs::{Needs, RECORD};
use crate::pass::{Compiler, Pass, shading_flag};
use crate::program::programs;
use crate::recorder::{Groups, Recorder};
use crate::stats::Timed;

programs! {
    COMPOSE: "compose" = compose in "compose", "shared/values";
}

/// Pass that adds a light to the image.
#[derive(Debug)]
pub(crate) struct Compose {
    compose: Pass,
}

impl Compose {
    /// Compiles the pass.
    ///
    /// # Errors
    /// A shader cannot be read or compiled.
    pub(crate) fn new(compiler: &Compiler, shading: Shading) -> Result<Self, GpuError> {
        Ok(Self { compose: compiler.pass(COMPOSE, &[shading_flag(shading)])? })
    }

    /// Declares the image.
    pub(crate) fn declare(needs: &mut Needs) {
        needs.declare(Slot::Image, RECORD * needs.pixels());
    }

    /// Records the addition of the light whose uniforms begin at `first`.
    pub(crate) fn record(&self, recorder: &mut Recorder, first: u32) {
        recorder.run(&self.compose, Timed::Compose, first, Groups::Tiles(0));
    }
}
