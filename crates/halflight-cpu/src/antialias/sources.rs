//! Sources of sub-samples: which pixel, or which sub-sample with a mask of its own, each takes its visible fraction from.

use glam::{IVec2, Vec2};
use halflight_core::frame::Frame;
use halflight_core::gbuffer::{GBuffer, NO_PRIMITIVE};
use rayon::prelude::*;

use super::surfaces::{Seen, Surfaces};

/// Largest number of sub-samples of a pixel.
pub(super) const MOST: usize = 16;

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
    /// A mask that a sub-sample of the same pixel asks for, by its number in the pixel.
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

/// Finds the sources of all sub-samples: `samples` has a row for each of `pixels`, with a column for each of `offsets`.
pub(super) fn find(
    frame: &Frame,
    surfaces: &Surfaces,
    pixels: &[u32],
    offsets: &[Vec2],
    samples: &GBuffer,
    out: &mut Vec<Source>,
) {
    let mut near = [[IVec2::ZERO; NEAR]; MOST];
    for (near, &offset) in near.iter_mut().zip(offsets) {
        *near = nearest(offset);
    }
    let count = offsets.len();
    out.resize(samples.pixels(), Source::Whole);
    let rows = out.par_chunks_mut(count).zip(pixels).enumerate().with_min_len(64);
    rows.for_each(|(row, (out, &pixel))| {
        let seen = |column: usize| Seen::new(samples, row * count + column);
        let centre = Seen::new(frame.gbuffer, pixel as usize);
        if (0..count).all(|column| surfaces.look_alike(&centre, &seen(column))) {
            out.fill(Source::Whole);
            return;
        }
        for column in 0..count {
            let sample = seen(column);
            out[column] = if sample.triangle == NO_PRIMITIVE {
                Source::Background
            } else if let Some(found) = pixel_of(frame.gbuffer, surfaces, pixel, &near[column], &sample) {
                Source::Pixel(found)
            } else {
                let own = |&other: &usize| {
                    out[other] == Source::Own(other as u8) && surfaces.are_one(&seen(other), &sample)
                };
                Source::Own((0..column).find(own).unwrap_or(column) as u8)
            };
        }
    });
}

/// Nearest pixel that sees the surface of a sub-sample of `pixel`.
fn pixel_of(
    gbuffer: &GBuffer,
    surfaces: &Surfaces,
    pixel: u32,
    near: &[IVec2; NEAR],
    sample: &Seen,
) -> Option<u32> {
    let (width, height) = (gbuffer.width as i32, gbuffer.height as i32);
    let place = IVec2::new(pixel as i32 % width, pixel as i32 / width);
    let pixels = near.iter().map(|&step| place + step);
    let inside = pixels.filter(|at| (0..width).contains(&at.x) && (0..height).contains(&at.y));
    let mut indices = inside.map(|at| (at.y * width + at.x) as u32);
    indices.find(|&index| surfaces.are_one(&Seen::new(gbuffer, index as usize), sample))
}
