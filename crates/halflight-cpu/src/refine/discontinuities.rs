//! Surface discontinuities between neighbouring pixels: silhouettes, depth discontinuities, concave creases
//! and, for small error targets, sharp convex edges.

use halflight_core::frame::Frame;
use rayon::prelude::*;

use crate::tangent_plane::{Between, DiscontinuityLimits, LightCorners, RUN, Suspects, TangentPlanes};

/// Discontinuity between the pixel and its right neighbour.
const RIGHT: u8 = 1;
/// Discontinuity between the pixel and the one below.
const BELOW: u8 = 2;
/// Shift of these bits for discontinuities where one surface may shadow the other.
const SHADE: u32 = 2;

/// Discontinuities of one level. A cell of 2^level pixels holds those between its pixels and their right and
/// lower neighbours, which may belong to the next cells.
#[derive(Clone, Debug, Default)]
struct Level {
    width: u32,
    flags: Vec<u8>,
}

/// Discontinuities of all pixels and cells, for one light.
#[derive(Clone, Debug, Default)]
pub(crate) struct Discontinuities {
    width: u32,
    height: u32,
    levels: Vec<Level>,
}

impl Discontinuities {
    /// Finds discontinuities between all neighbouring pixels, and gathers them up to level `coarsest`. Convex
    /// edges count as discontinuities if the cosine between the normals of both sides is below `edge`.
    pub(crate) fn find(
        &mut self,
        frame: &Frame,
        light: u32,
        limits: &DiscontinuityLimits,
        edge: f32,
        coarsest: u8,
    ) {
        let gbuffer = frame.gbuffer;
        (self.width, self.height) = (gbuffer.width, gbuffer.height);
        self.levels.resize_with(usize::from(coarsest) + 1, Level::default);
        let (planes, light) = (TangentPlanes::new(frame, limits), LightCorners(frame.light(light).corners()));
        let (width, row) = (gbuffer.width, gbuffer.width.max(1) as usize);
        let flag = |a: usize, b: usize, bit: u8| match planes.between(&light, a, b) {
            Between::Nothing if planes.turns(a, b, edge) => bit,
            Between::Nothing => 0,
            Between::Step => bit,
            Between::Shade => bit | bit << SHADE,
        };
        let pixels = &mut self.levels[0];
        pixels.width = width;
        pixels.flags.resize(gbuffer.pixels(), 0);
        pixels.flags.par_chunks_mut(row).enumerate().for_each(|(y, flags)| {
            let first = y * row;
            let last = y + 1 == gbuffer.height as usize;
            for (start, flags) in (0..row).step_by(RUN).zip(flags.chunks_mut(RUN)) {
                flags.fill(0);
                let (at, count) = (first + start, flags.len());
                let right = planes.suspects(at, at + 1, count.min(row - 1 - start), edge);
                let below =
                    if last { Suspects::default() } else { planes.suspects(at, at + row, count, edge) };
                for (Suspects { steps, mut others }, apart, bit) in [(right, 1, RIGHT), (below, row, BELOW)] {
                    for (lane, flag) in flags.iter_mut().enumerate() {
                        *flag |= (steps >> lane & 1) as u8 * bit;
                    }
                    while others != 0 {
                        let lane = others.trailing_zeros() as usize;
                        others &= others - 1;
                        flags[lane] |= flag(at + lane, at + lane + apart, bit);
                    }
                }
            }
        });
        for level in 1..=usize::from(coarsest) {
            let (finer, rest) = self.levels.split_at_mut(level);
            gather(&finer[level - 1], self.width, self.height, level as u32, &mut rest[0]);
        }
    }

    /// Strongest discontinuity among the pixels of cell (x, y) and those of its corners that belong to the
    /// cells right of and below it; nothing inside a pixel.
    pub(crate) fn inside(&self, level: u8, x: u32, y: u32) -> Between {
        if level == 0 {
            return Between::Nothing;
        }
        let cells = &self.levels[usize::from(level)];
        let mut flags = cells.flags[(y * cells.width + x) as usize];
        // The last corner has no neighbour among the cell's own pixels, but the corner's left neighbour is
        // next to one.
        let (right, below) = ((x + 1) << level, (y + 1) << level);
        if right < self.width && below < self.height {
            let corner = self.levels[0].flags[(below * self.width + right - 1) as usize];
            flags |= corner & (RIGHT | RIGHT << SHADE);
        }
        match (flags, flags >> SHADE) {
            (0, _) => Between::Nothing,
            (_, 0) => Between::Step,
            _ => Between::Shade,
        }
    }

    /// Memory held, bytes.
    pub(crate) fn bytes(&self) -> usize {
        self.levels.iter().map(|level| level.flags.capacity()).sum()
    }
}

/// Computes a level from the next finer one.
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
