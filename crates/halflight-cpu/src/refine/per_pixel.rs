//! Per-pixel refiner: a mask for every pixel. Monte Carlo baseline and, with many samples, the reference.

use halflight_core::fragment::Fragments;
use halflight_core::frame::Frame;
use halflight_core::mask::Purpose;
use halflight_core::stages::{RefineOutput, Refiner, Visibility};

use super::pixel_set::PixelSet;
use super::trace_pixels;

/// Refiner that gives every receiver pixel a fragment of its own with a complete mask.
#[derive(Debug, Default)]
pub struct PerPixel {
    receivers: PixelSet,
    pixels: Vec<u32>,
}

impl Refiner for PerPixel {
    fn refine(
        &mut self,
        frame: &Frame,
        light: u32,
        visibility: &mut dyn Visibility,
        fragments: &mut Fragments,
    ) -> RefineOutput<'_> {
        let gbuffer = frame.gbuffer;
        self.receivers.reset(gbuffer.width, gbuffer.height);
        self.receivers.insert_where(|pixel| gbuffer.is_receiver(pixel));
        self.receivers.drain(&mut self.pixels);
        let batch = fragments.open_batch(frame.pattern, Purpose::Final);
        trace_pixels(frame, light, &self.pixels, visibility, fragments.batch_mut(batch));
        fragments.push_pixels(batch, &self.pixels);
        RefineOutput::default()
    }

    fn coarsest_level(&self) -> u8 {
        0
    }

    fn bytes(&self) -> usize {
        self.pixels.capacity() * 4 + self.receivers.bytes()
    }
}
