//! Construction of the discontinuity pyramid from the G-buffer.
//!
//! Differences are taken between pixels of the same cell only. A max-mipmap of forward differences, as the
//! papers build it, also flags cells whose discontinuity lies just outside, which makes 16 to 19 % more
//! fragments without benefit.

use glam::Vec3;
use halflight_core::gbuffer::GBuffer;
use halflight_core::pyramid::{Pyramid, PyramidLevel};
use rayon::prelude::*;

/// Depth derivative and curvature, both squared.
#[derive(Clone, Copy, Default)]
struct Break {
    depth: f32,
    curvature: f32,
}

impl Break {
    fn max(self, other: Self) -> Self {
        Self { depth: self.depth.max(other.depth), curvature: self.curvature.max(other.curvature) }
    }

    fn plus(self, other: Self) -> Self {
        Self { depth: self.depth + other.depth, curvature: self.curvature + other.curvature }
    }
}

/// Fills levels 1 to `coarsest` of `pyramid` (Koa17 §3.2.1).
pub fn build(gbuffer: &GBuffer, coarsest: u8, pyramid: &mut Pyramid) {
    pyramid.levels.resize_with(usize::from(coarsest), PyramidLevel::default);
    for level in 1..=coarsest {
        let (finer, rest) = pyramid.levels.split_at_mut(usize::from(level) - 1);
        build_level(gbuffer, u32::from(level), finer.last(), &mut rest[0]);
    }
}

/// Builds one level from the next finer one and the pixel pairs across the borders between its four children.
fn build_level(gbuffer: &GBuffer, level: u32, finer: Option<&PyramidLevel>, out: &mut PyramidLevel) {
    out.width = gbuffer.width.div_ceil(1 << level);
    out.height = gbuffer.height.div_ceil(1 << level);
    let cells = (out.width * out.height) as usize;
    out.depth.resize(cells, 0.0);
    out.curvature.resize(cells, 0.0);
    out.receivers.resize(cells, false);
    let row = out.width as usize;
    let rows = out.depth.par_chunks_mut(row).zip(out.curvature.par_chunks_mut(row));
    rows.zip(out.receivers.par_chunks_mut(row)).enumerate().for_each(
        |(y, ((depth, curvature), receivers))| {
            for x in 0..row {
                let (cell_x, cell_y) = (x as u32, y as u32);
                let squared = seams(gbuffer, level, cell_x, cell_y);
                let mut seen = false;
                (depth[x], curvature[x]) = (0.0, 0.0);
                for child in 0..4 {
                    let (child_x, child_y) = (2 * cell_x + (child & 1), 2 * cell_y + (child >> 1));
                    if let Some(finer) = finer {
                        if child_x < finer.width && child_y < finer.height {
                            let index = finer.index(child_x, child_y);
                            depth[x] = depth[x].max(finer.depth[index]);
                            curvature[x] = curvature[x].max(finer.curvature[index]);
                            seen |= finer.receivers[index];
                        }
                    } else if child_x < gbuffer.width && child_y < gbuffer.height {
                        seen |= gbuffer.is_receiver(gbuffer.index(child_x, child_y));
                    }
                }
                depth[x] = depth[x].max(squared.depth.sqrt());
                curvature[x] = curvature[x].max(squared.curvature.sqrt());
                receivers[x] = seen;
            }
        },
    );
}

/// Largest discontinuity between pixels along the two inner borders of a cell. All other pairs lie inside one
/// child and are included in the finer level.
fn seams(gbuffer: &GBuffer, level: u32, cell_x: u32, cell_y: u32) -> Break {
    let size = 1 << level;
    let half = size / 2;
    let (x0, y0) = (cell_x * size, cell_y * size);
    let (x1, y1) = ((x0 + size).min(gbuffer.width), (y0 + size).min(gbuffer.height));
    let at = |x: u32, y: u32| {
        let pixel = gbuffer.index(x, y);
        let right = if x + 1 < x1 { pair(gbuffer, pixel, pixel + 1) } else { Break::default() };
        let below =
            if y + 1 < y1 { pair(gbuffer, pixel, pixel + gbuffer.width as usize) } else { Break::default() };
        right.plus(below)
    };
    let mut worst = Break::default();
    if x0 + half < x1 {
        worst = (y0..y1).fold(worst, |worst, y| worst.max(at(x0 + half - 1, y)));
    }
    if y0 + half < y1 {
        worst = (x0..x1).fold(worst, |worst, x| worst.max(at(x, y0 + half - 1)));
    }
    worst
}

/// Squared discontinuity between two neighbouring pixels: depth difference relative to the nearer one, and
/// the chord between the unit normals, which is `2 sin(acos(N·N')/2)`.
#[inline]
fn pair(gbuffer: &GBuffer, a: usize, b: usize) -> Break {
    let (near, far) = {
        let (za, zb) = (gbuffer.depth[a], gbuffer.depth[b]);
        if za < zb { (za, zb) } else { (zb, za) }
    };
    if near == f32::INFINITY {
        return Break::default();
    }
    if far == f32::INFINITY {
        return Break { depth: f32::INFINITY, curvature: 0.0 };
    }
    let step = (far - near) / near;
    let turn: Vec3 = gbuffer.normal[a] - gbuffer.normal[b];
    Break { depth: step * step, curvature: turn.length_squared() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn flat(width: u32, height: u32) -> GBuffer {
        let mut gbuffer = GBuffer::default();
        gbuffer.reset(width, height);
        gbuffer.depth.fill(1.0);
        gbuffer.normal.fill(Vec3::Y);
        gbuffer.primitive.fill(0);
        gbuffer
    }

    /// Largest discontinuity of all pairs inside a cell, by brute force.
    fn direct(gbuffer: &GBuffer, level: u32, x: u32, y: u32) -> Break {
        let size = 1 << level;
        let (x0, y0) = (x * size, y * size);
        let (x1, y1) = ((x0 + size).min(gbuffer.width), (y0 + size).min(gbuffer.height));
        let mut worst = Break::default();
        for y in y0..y1 {
            for x in x0..x1 {
                let pixel = gbuffer.index(x, y);
                let mut here = Break::default();
                if x + 1 < x1 {
                    here = here.plus(pair(gbuffer, pixel, pixel + 1));
                }
                if y + 1 < y1 {
                    here = here.plus(pair(gbuffer, pixel, pixel + gbuffer.width as usize));
                }
                worst = worst.max(here);
            }
        }
        worst
    }

    #[test]
    fn seams_and_children_see_every_pair_inside() {
        let mut gbuffer = flat(37, 21);
        for pixel in 0..gbuffer.pixels() {
            let bits = halflight_core::hash::mix(pixel as u32);
            gbuffer.depth[pixel] = 1.0 + (bits & 0xff) as f32 / 64.0;
            let tilt = (bits >> 8 & 0xff) as f32 / 256.0;
            gbuffer.normal[pixel] = Vec3::new(tilt, 1.0, 0.0).normalize();
        }
        let mut pyramid = Pyramid::default();
        build(&gbuffer, 6, &mut pyramid);
        for level in 1..=6u8 {
            let cells = pyramid.level(level).unwrap();
            for y in 0..cells.height {
                for x in 0..cells.width {
                    let expected = direct(&gbuffer, u32::from(level), x, y);
                    let index = cells.index(x, y);
                    assert_eq!(cells.depth[index], expected.depth.sqrt(), "level {level} cell {x},{y}");
                    assert_eq!(cells.curvature[index], expected.curvature.sqrt());
                    assert!(cells.receivers[index]);
                }
            }
        }
    }

    #[test]
    fn a_break_between_two_cells_flags_neither() {
        let mut gbuffer = flat(8, 4);
        for y in 0..4 {
            for x in 4..8 {
                let pixel = gbuffer.index(x, y);
                gbuffer.depth[pixel] = 2.0;
            }
        }
        let mut pyramid = Pyramid::default();
        build(&gbuffer, 3, &mut pyramid);
        assert_eq!(pyramid.level(2).unwrap().depth, [0.0, 0.0]);
        assert_eq!(pyramid.level(3).unwrap().depth, [1.0]);
        assert!(pyramid.level(0).is_none() && pyramid.level(4).is_none());
    }

    #[test]
    fn receivers_against_nothing_are_a_break_and_empty_cells_are_known() {
        let mut gbuffer = flat(4, 2);
        for pixel in [2, 3, 6, 7, 1] {
            gbuffer.depth[pixel] = f32::INFINITY;
            gbuffer.primitive[pixel] = halflight_core::gbuffer::NO_PRIMITIVE;
        }
        let mut pyramid = Pyramid::default();
        build(&gbuffer, 2, &mut pyramid);
        assert_eq!(pyramid.level(1).unwrap().depth, [f32::INFINITY, 0.0]);
        assert_eq!(pyramid.level(1).unwrap().receivers, [true, false]);
    }
}
