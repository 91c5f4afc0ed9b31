//! Properties of cells that depend on geometry alone.

use glam::Vec3;
use halflight_core::certificate::Region;
use halflight_core::frame::Frame;
use halflight_core::gbuffer::GBuffer;

use super::Square;
use crate::corners::Corners;
use crate::refine::representative::cell_rect;
use crate::tangent_plane::{LightCorners, Side, TangentPlanes};

/// Frame and light for which cells are classified.
pub(super) struct View<'a> {
    pub(super) frame: &'a Frame<'a>,
    pub(super) gbuffer: &'a GBuffer,
    pub(super) light: u32,
    pub(super) planes: TangentPlanes<'a>,
}

impl View<'_> {
    /// Bounds on the origins of shadow rays of a cell's receivers, its corners included, without those that
    /// face away from the light. Unbounded if some have only part of the light above their horizon: they get
    /// little light, and a small occluder can hide a large fraction of it.
    pub(super) fn region(&self, cell: Square) -> Region {
        let (gbuffer, rect) = (self.gbuffer, cell_rect(self.gbuffer, cell.level, cell.x, cell.y));
        let light = LightCorners(self.frame.light(self.light).corners());
        let own = (rect.y0..rect.y1).flat_map(|y| (rect.x0..rect.x1).map(move |x| gbuffer.index(x, y)));
        let mut region = Region::EMPTY;
        for pixel in own.chain(cell.corners(gbuffer).pixels()) {
            let Some(receiver) = gbuffer.receiver(pixel) else { continue };
            match self.planes.side(&light, pixel) {
                Side::Lit => region = region.with(receiver.origin),
                Side::Unlit => {}
                Side::Both => return Region { low: Vec3::NEG_INFINITY, high: Vec3::INFINITY },
            }
        }
        region
    }

    /// Number of receivers among a cell's pixels.
    pub(super) fn receivers(&self, cell: Square) -> u64 {
        let rect = cell_rect(self.gbuffer, cell.level, cell.x, cell.y);
        let row =
            |y| (rect.x0..rect.x1).filter(|&x| self.gbuffer.is_receiver(self.gbuffer.index(x, y))).count();
        (rect.y0..rect.y1).map(row).sum::<usize>() as u64
    }

    /// True if every pixel of a cell that sees geometry has a corner on its surface.
    pub(super) fn serves(&self, corners: &Corners, cell: Square) -> bool {
        let (gbuffer, pixels, positions) = (self.gbuffer, corners.pixels(), corners.positions());
        let rect = cell_rect(gbuffer, cell.level, cell.x, cell.y);
        (rect.y0..rect.y1).all(|y| {
            (rect.x0..rect.x1).all(|x| {
                let pixel = gbuffer.index(x, y);
                !gbuffer.is_receiver(pixel)
                    || positions.into_iter().zip(pixels).any(|((cx, cy), corner)| {
                        self.planes.is_level(pixel, corner, cx.abs_diff(x).max(cy.abs_diff(y)))
                    })
            })
        })
    }
}
