//! Representative pixels of fragments, and culling of cells that light cannot reach.

use halflight_core::frame::Frame;
use halflight_core::gbuffer::GBuffer;
use halflight_core::light::AreaLight;

use super::GeometryThresholds;

/// Rectangle of pixels inside the image, ends excluded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Rect {
    pub x0: u32,
    pub y0: u32,
    pub x1: u32,
    pub y1: u32,
}

/// Pixels of cell (x, y) of a level, clipped to the image.
pub(super) fn cell_rect(gbuffer: &GBuffer, level: u8, x: u32, y: u32) -> Rect {
    let (x0, y0) = (x << level, y << level);
    Rect { x0, y0, x1: (x0 + (1 << level)).min(gbuffer.width), y1: (y0 + (1 << level)).min(gbuffer.height) }
}

/// Representative pixel of a square of `size` pixels with its corner at (x, y): the pixel just right of and
/// below the square's centre, clamped into the image. If that is no receiver, it is the nearest receiver of
/// the square.
///
/// `None` when the square holds no receiver or lies outside the image.
pub(super) fn fragment_point(gbuffer: &GBuffer, x: u32, y: u32, size: u32) -> Option<usize> {
    if x >= gbuffer.width || y >= gbuffer.height {
        return None;
    }
    let centre_x = (x + size / 2).min(gbuffer.width - 1);
    let centre_y = (y + size / 2).min(gbuffer.height - 1);
    let centre = gbuffer.index(centre_x, centre_y);
    if gbuffer.is_receiver(centre) {
        return Some(centre);
    }
    let (x1, y1) = ((x + size).min(gbuffer.width), (y + size).min(gbuffer.height));
    let mut best = None;
    for row in y..y1 {
        for column in x..x1 {
            let pixel = gbuffer.index(column, row);
            if gbuffer.is_receiver(pixel) {
                let distance = column.abs_diff(centre_x).pow(2) + row.abs_diff(centre_y).pow(2);
                if best.is_none_or(|(nearest, _)| distance < nearest) {
                    best = Some((distance, pixel));
                }
            }
        }
    }
    best.map(|(_, pixel)| pixel)
}

/// True if the cell holds any receiver. `level` 0 is a pixel.
pub(super) fn has_receiver(frame: &Frame, level: u8, x: u32, y: u32) -> bool {
    let gbuffer = frame.gbuffer;
    if level == 0 {
        return x < gbuffer.width && y < gbuffer.height && gbuffer.is_receiver(gbuffer.index(x, y));
    }
    let Some(cells) = frame.pyramid.level(level) else { return true };
    x < cells.width && y < cells.height && cells.receivers[cells.index(x, y)]
}

/// Depth and curvature discontinuities of a cell by the thresholds: (depth, curvature). Pixels have none.
pub(super) fn geometry_breaks(
    frame: &Frame,
    thresholds: &GeometryThresholds,
    level: u8,
    x: u32,
    y: u32,
) -> (bool, bool) {
    let Some(cells) = frame.pyramid.level(level) else { return (false, false) };
    let index = cells.index(x, y);
    (cells.depth[index] > thresholds.depth, cells.curvature[index] > thresholds.curvature)
}

/// True if the receiver at `pixel` faces away from all of the light, or the light from it (Koa17 §3.2.2,
/// Nichols10 §3.2).
pub(super) fn faces_away(gbuffer: &GBuffer, light: &AreaLight, pixel: usize) -> bool {
    let Some(receiver) = gbuffer.receiver(pixel) else { return true };
    !light.emits_towards(receiver.origin)
        || light.corners().iter().all(|&corner| receiver.normal.dot(corner - receiver.origin) <= 0.0)
}

/// True if a whole cell faces away from the light: tested at its centre and its corners, since the centre
/// alone is wrong for large fragments on curved surfaces.
pub(super) fn cell_faces_away(frame: &Frame, light: &AreaLight, level: u8, x: u32, y: u32) -> bool {
    let gbuffer = frame.gbuffer;
    let rect = cell_rect(gbuffer, level, x, y);
    let centre = fragment_point(gbuffer, rect.x0, rect.y0, 1 << level);
    if !centre.is_some_and(|pixel| faces_away(gbuffer, light, pixel)) {
        return false;
    }
    let corners =
        [(rect.x0, rect.y0), (rect.x1 - 1, rect.y0), (rect.x0, rect.y1 - 1), (rect.x1 - 1, rect.y1 - 1)];
    corners.iter().all(|&(x, y)| faces_away(gbuffer, light, gbuffer.index(x, y)))
}
