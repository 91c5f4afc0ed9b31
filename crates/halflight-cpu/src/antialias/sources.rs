//! Sources of sub-samples: which pixel, or which sub-sample with a mask of its own, each takes its visible fraction from.

use glam::{IVec2, Vec2};
use halflight_core::gbuffer::{GBuffer, NO_PRIMITIVE};

use super::surfaces::{Seen, Surfaces};

/// Largest number of sub-samples of a pixel.
const MOST: usize = 16;

/// Pixels of a 3 × 3 neighbourhood.
const NEAR: usize = 9;

/// Source of a sub-sample's visible fraction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Source {
    /// All sub-samples of the pixel see what its centre sees: the pixel is left as it is.
    #[default]
    Whole,
    /// The sub-sample sees nothing.
    Background,
    /// A pixel's centre.
    Pixel(u32),
    /// A mask that a sub-sample of the same pixel asks for, by its place among the pixel's.
    Own(u8),
}

/// Pixels around the one that a sub-sample lies in, nearest first.
fn nearest(offset: Vec2) -> [IVec2; NEAR] {
    let mut near: [IVec2; NEAR] = std::array::from_fn(|at| IVec2::new(at as i32 % 3 - 1, at as i32 / 3 - 1));
    // Stable: of two that are equally near, the upper left one comes first.
    near.sort_by(|a, b| {
        a.as_vec2().distance_squared(offset).total_cmp(&b.as_vec2().distance_squared(offset))
    });
    near
}

/// Search for sources in one frame.
pub(super) struct Search<'a> {
    surfaces: &'a Surfaces<'a>,
    /// Surfaces of the pixels.
    gbuffer: &'a GBuffer,
    /// Pixels around each offset.
    near: [[IVec2; NEAR]; MOST],
}

impl<'a> Search<'a> {
    pub(super) fn new(surfaces: &'a Surfaces, gbuffer: &'a GBuffer, offsets: &[Vec2]) -> Self {
        let mut near = [[IVec2::ZERO; NEAR]; MOST];
        near.iter_mut().zip(offsets).for_each(|(near, &offset)| *near = nearest(offset));
        Self { surfaces, gbuffer, near }
    }

    /// Finds the sources of the sub-samples of `pixel`, which have these offsets and are entries from `first` on of `samples`.
    pub(super) fn find(
        &self,
        pixel: u32,
        offsets: impl Iterator<Item = u8>,
        samples: &GBuffer,
        first: usize,
        out: &mut [Source],
    ) {
        let seen = |place: usize| Seen { gbuffer: samples, entry: first + place };
        let centre = Seen { gbuffer: self.gbuffer, entry: pixel as usize };
        if (0..out.len()).all(|place| self.surfaces.look_alike(centre, seen(place))) {
            out.fill(Source::Whole);
            return;
        }
        for (place, offset) in offsets.enumerate().take(out.len()) {
            let sample = seen(place);
            out[place] = if sample.triangle() == NO_PRIMITIVE {
                Source::Background
            } else if let Some(found) = self.pixel_of(pixel, offset, sample) {
                Source::Pixel(found)
            } else {
                let own = |&other: &usize| {
                    out[other] == Source::Own(other as u8) && self.surfaces.are_one(seen(other), sample)
                };
                Source::Own((0..place).find(own).unwrap_or(place) as u8)
            };
        }
    }

    /// Nearest pixel that sees the surface of a sub-sample of `pixel`.
    fn pixel_of(&self, pixel: u32, offset: u8, sample: Seen) -> Option<u32> {
        let GBuffer { width, height, .. } = *self.gbuffer;
        let (x, y) = (pixel % width, pixel / width);
        let mut near = self.near[usize::from(offset)].iter().filter_map(|step| {
            let (x, y) = (x.wrapping_add_signed(step.x), y.wrapping_add_signed(step.y));
            (x < width && y < height).then(|| y * width + x)
        });
        near.find(|&index| {
            self.surfaces.are_one(Seen { gbuffer: self.gbuffer, entry: index as usize }, sample)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_own_pixel_comes_first_and_the_opposite_corner_last() {
        let near = nearest(Vec2::new(0.4375, -0.375));
        assert_eq!(near[..2], [IVec2::ZERO, IVec2::new(1, 0)]);
        assert_eq!(near[8], IVec2::new(-1, 1));
    }
}
