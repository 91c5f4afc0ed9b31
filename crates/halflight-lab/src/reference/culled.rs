//! Visibility backends without rays below a horizon, for use outside a pipeline.

use halflight_core::frame::Frame;
use halflight_core::light::AreaLight;
use halflight_core::mask::MaskBatch;
use halflight_core::pattern::Pattern;
use halflight_core::stages::{Unsupported, Visibility};
use halflight_cpu::horizon;

/// Backend that is not asked about rays below a horizon, which count as nothing in all sums.
pub(super) struct Culled<'a> {
    pub(super) inner: &'a mut dyn Visibility,
    pub(super) light: &'a AreaLight,
}

impl Visibility for Culled<'_> {
    fn masks(&mut self, frame: &Frame, batch: &mut MaskBatch) {
        horizon::cull(self.light, batch);
        self.inner.masks(frame, batch);
    }

    fn supports(&self, pattern: Pattern) -> Result<(), Unsupported> {
        self.inner.supports(pattern)
    }
}
