//! Edge pixels: pixels that see another surface than one of their four neighbours.
//!
//! Every straight edge that crosses a pixel passes between its centre and that of such a neighbour, so that no other pixels need be looked at. Things
//! thinner than a pixel may pass between all centres; pixels that miss them are not found.

use halflight_core::frame::Frame;
use halflight_core::gbuffer::GBuffer;
use rayon::prelude::*;

use super::surfaces::{Seen, Surfaces};

/// Pixels along the side of a tile: edge pixels are listed tile by tile, since those of one tile are traced together.
const TILE: usize = 8;

/// Edge between the pixel and its right neighbour.
const RIGHT: u8 = 1;

/// Edge between the pixel and the one below.
const BELOW: u8 = 2;

/// Edge pixels of a frame.
#[derive(Default)]
pub(super) struct Edges {
    flags: Vec<u8>,
    /// Pixels of each row of tiles.
    bands: Vec<Vec<u32>>,
    pixels: Vec<u32>,
}

impl Edges {
    /// Finds the edge pixels of a frame.
    pub(super) fn find(&mut self, frame: &Frame, surfaces: &Surfaces) {
        let gbuffer = frame.gbuffer;
        let (width, pixels) = (gbuffer.width.max(1) as usize, gbuffer.pixels());
        self.flags.resize(pixels, 0);
        let rows = self.flags.par_chunks_mut(width).enumerate();
        rows.for_each(|(y, flags)| flag_row(gbuffer, surfaces, y * width, flags));
        let flags = &self.flags[..];
        self.bands.resize_with(pixels.div_ceil(width * TILE), Vec::new);
        let bands = self.bands.par_iter_mut().enumerate();
        bands.for_each(|(band, found)| list_band(flags, width, band * TILE, found));
        self.pixels.clear();
        self.bands.iter().for_each(|found| self.pixels.extend_from_slice(found));
    }

    /// Edge pixels, tile by tile.
    pub(super) fn pixels(&self) -> &[u32] {
        &self.pixels
    }

    /// Memory held, bytes.
    pub(super) fn bytes(&self) -> usize {
        let bands: usize = self.bands.iter().map(Vec::capacity).sum();
        self.flags.capacity() + (bands + self.pixels.capacity()) * size_of::<u32>()
    }
}

/// Writes the flags of the row that begins with pixel `first`.
fn flag_row(gbuffer: &GBuffer, surfaces: &Surfaces, first: usize, flags: &mut [u8]) {
    let (width, primitive) = (flags.len(), &gbuffer.primitive[..]);
    let differ = |a: usize, b: usize| {
        primitive[a] != primitive[b] && !surfaces.look_alike(&Seen::new(gbuffer, a), &Seen::new(gbuffer, b))
    };
    for (x, flag) in flags.iter_mut().enumerate() {
        let pixel = first + x;
        let right = x + 1 < width && differ(pixel, pixel + 1);
        let below = pixel + width < primitive.len() && differ(pixel, pixel + width);
        *flag = u8::from(right) * RIGHT | u8::from(below) * BELOW;
    }
}

/// Lists the edge pixels of the tiles whose first row is `top`.
fn list_band(flags: &[u8], width: usize, top: usize, found: &mut Vec<u32>) {
    found.clear();
    let rows = top..(top + TILE).min(flags.len() / width);
    for left in (0..width).step_by(TILE) {
        for y in rows.clone() {
            for x in left..(left + TILE).min(width) {
                let pixel = y * width + x;
                let mut edge = flags[pixel];
                if x > 0 {
                    edge |= flags[pixel - 1] & RIGHT;
                }
                if y > 0 {
                    edge |= flags[pixel - width] & BELOW;
                }
                if edge != 0 {
                    found.push(pixel as u32);
                }
            }
        }
    }
}
