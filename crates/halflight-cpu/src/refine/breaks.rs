//! Where nothing may be interpolated: silhouettes, steps and concave creases between neighbouring pixels.

use halflight_core::frame::Frame;
use rayon::prelude::*;

use crate::rise::{Rise, RiseLimits};

/// The pixel is parted from its right neighbour.
const RIGHT: u8 = 1;
/// The pixel is parted from the one below.
const BELOW: u8 = 2;

/// One level: whether cells of 2^level pixels hold a pixel that is parted from its right or lower neighbour, which may be
/// the first pixel of the next cell.
#[derive(Clone, Debug, Default)]
struct Level {
    width: u32,
    flags: Vec<u8>,
}

/// Breaks of all pixels and cells.
#[derive(Clone, Debug, Default)]
pub(super) struct Breaks {
    width: u32,
    height: u32,
    levels: Vec<Level>,
}

impl Breaks {
    /// Looks for breaks between all neighbours, and gathers them up to level `coarsest`.
    pub(super) fn find(&mut self, frame: &Frame, limits: &RiseLimits, coarsest: u8) {
        let gbuffer = frame.gbuffer;
        (self.width, self.height) = (gbuffer.width, gbuffer.height);
        self.levels.resize_with(usize::from(coarsest) + 1, Level::default);
        let rise = Rise::new(frame, limits);
        let (width, row) = (gbuffer.width, gbuffer.width.max(1) as usize);
        let pixels = &mut self.levels[0];
        pixels.width = width;
        pixels.flags.resize(gbuffer.pixels(), 0);
        pixels.flags.par_chunks_mut(row).enumerate().for_each(|(y, flags)| {
            let first = y * row;
            let last = y + 1 == gbuffer.height as usize;
            for (x, flag) in flags.iter_mut().enumerate() {
                let pixel = first + x;
                let right = x + 1 < row && rise.parts(pixel, pixel + 1, 1);
                let below = !last && rise.parts(pixel, pixel + row, 1);
                *flag = if right { RIGHT } else { 0 } | if below { BELOW } else { 0 };
            }
        });
        for level in 1..=usize::from(coarsest) {
            let (finer, rest) = self.levels.split_at_mut(level);
            gather(&finer[level - 1], self.width, self.height, level as u32, &mut rest[0]);
        }
    }

    /// Whether cell (x, y) cannot be interpolated over: whether any of its pixels, with those of its corners that belong to
    /// the cells right of and below it, is parted from the others; a pixel never is. Without a break they all see geometry or none does.
    pub(super) fn inside(&self, level: u8, x: u32, y: u32) -> bool {
        if level == 0 {
            return false;
        }
        let cells = &self.levels[usize::from(level)];
        if cells.flags[(y * cells.width + x) as usize] != 0 {
            return true;
        }
        // The last corner neighbours none of the cell's own pixels, but the one left of it does.
        let (right, below) = ((x + 1) << level, (y + 1) << level);
        right < self.width
            && below < self.height
            && self.levels[0].flags[(below * self.width + right - 1) as usize] & RIGHT != 0
    }

    /// Bytes held.
    pub(super) fn bytes(&self) -> usize {
        self.levels.iter().map(|level| level.flags.capacity()).sum()
    }
}

/// A level from the next finer one.
fn gather(finer: &Level, width: u32, height: u32, level: u32, out: &mut Level) {
    out.width = width.div_ceil(1 << level);
    let (row, fine_row) = (out.width.max(1) as usize, finer.width.max(1) as usize);
    out.flags.resize(row * height.div_ceil(1 << level) as usize, 0);
    out.flags.par_chunks_mut(row).zip(finer.flags.par_chunks(2 * fine_row)).for_each(|(flags, finer)| {
        flags.fill(0);
        for fine in finer.chunks(fine_row) {
            for (flag, pair) in flags.iter_mut().zip(fine.chunks(2)) {
                *flag |= pair.iter().fold(0, |all, &one| all | one);
            }
        }
    });
}
