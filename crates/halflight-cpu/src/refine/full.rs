//! Every pixel its own samples: the Monte Carlo rival and, with many samples, the reference.

use halflight_core::fragment::Fragments;
use halflight_core::frame::Frame;
use halflight_core::mask::Purpose;
use halflight_core::stages::{Refiner, Visibility};

use super::{pixel_sample, trace_pixels};

/// Gives every receiver pixel a fragment of its own with a full mask.
#[derive(Clone, Debug, Default)]
pub struct Full {
    pixels: Vec<u32>,
}

impl Refiner for Full {
    fn refine(
        &mut self,
        frame: &Frame,
        light: u32,
        visibility: &mut dyn Visibility,
        fragments: &mut Fragments,
    ) {
        let gbuffer = frame.gbuffer;
        order_by_tiles(gbuffer.width, gbuffer.height, &mut self.pixels);
        self.pixels.retain(|&pixel| gbuffer.is_receiver(pixel as usize));
        let batch = fragments.open_batch(frame.pattern, Purpose::Final);
        trace_pixels(frame, light, &self.pixels, visibility, fragments.batch_mut(batch));
        for (query, &pixel) in self.pixels.iter().enumerate() {
            let sample = pixel_sample(pixel as usize, gbuffer.width, 0, batch, query);
            let index = fragments.push_sample(sample);
            fragments.push_cell(0, pixel % gbuffer.width, pixel / gbuffer.width, &[index]);
        }
    }

    fn coarsest_level(&self) -> u8 {
        0
    }

    fn bytes(&self) -> usize {
        self.pixels.capacity() * 4
    }
}

/// All pixels, in tiles of 8 × 8: neighbours in the batch are neighbours in the image, both ways.
fn order_by_tiles(width: u32, height: u32, pixels: &mut Vec<u32>) {
    const TILE: u32 = 8;
    pixels.clear();
    for top in (0..height).step_by(TILE as usize) {
        for left in (0..width).step_by(TILE as usize) {
            for y in top..(top + TILE).min(height) {
                for x in left..(left + TILE).min(width) {
                    pixels.push(y * width + x);
                }
            }
        }
    }
}
