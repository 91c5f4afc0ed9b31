//! Corners of a cell: the pixels between which its values are interpolated.

use crate::tangent_plane::TangentPlanes;

/// Corner pixels of a square cell: its own first pixel and the first pixels of the cells right of and below
/// it, clamped to the image's last column and row. All four corners of a single-pixel cell are the pixel
/// itself. The order is top left, top right, bottom left, bottom right; at the border they may coincide.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Corners {
    width: usize,
    x0: u32,
    y0: u32,
    x1: u32,
    y1: u32,
    across: f32,
    down: f32,
}

impl Corners {
    /// Corners of cell (x, y) of a level in an image of this size, which contains the cell's first pixel.
    #[inline]
    pub(crate) fn new(width: u32, height: u32, level: u8, x: u32, y: u32) -> Self {
        let (x0, y0) = (x << level, y << level);
        let size = if level > 0 { 1 << level } else { 0 };
        let (x1, y1) = ((x0 + size).min(width - 1), (y0 + size).min(height - 1));
        let inverse = |length: u32| 1.0 / length.max(1) as f32;
        Self { width: width as usize, x0, y0, x1, y1, across: inverse(x1 - x0), down: inverse(y1 - y0) }
    }

    /// Columns and rows of the corners.
    #[inline]
    pub(crate) fn positions(&self) -> [(u32, u32); 4] {
        [(self.x0, self.y0), (self.x1, self.y0), (self.x0, self.y1), (self.x1, self.y1)]
    }

    /// Indices of the corners in the image.
    #[inline]
    pub(crate) fn pixels(&self) -> [usize; 4] {
        self.positions().map(|(x, y)| y as usize * self.width + x as usize)
    }

    /// Bilinear weights of the corners at pixel (x, y); extrapolated where the pixel does not lie between
    /// them.
    #[inline]
    pub(crate) fn weights(&self, x: u32, y: u32) -> [f32; 4] {
        let u = (x as f32 - self.x0 as f32) * self.across;
        let v = (y as f32 - self.y0 as f32) * self.down;
        [(1.0 - u) * (1.0 - v), u * (1.0 - v), (1.0 - u) * v, u * v]
    }

    /// Value at pixel (x, y): bilinear between the corners that no surface discontinuity separates from it
    /// and whose value exists (is not NaN), with renormalised weights. NaN if there are none.
    #[inline]
    pub(crate) fn interpolate(&self, planes: &TangentPlanes, values: &[f32; 4], x: u32, y: u32) -> f32 {
        let pixel = y as usize * self.width + x as usize;
        let (weights, pixels) = (self.weights(x, y), self.pixels());
        let (mut sum, mut total) = (0.0, 0.0);
        let (mut plain, mut count) = (0.0, 0.0);
        for (corner, (cx, cy)) in self.positions().into_iter().enumerate() {
            let (weight, value) = (weights[corner], values[corner]);
            if value.is_nan()
                || planes.is_discontinuity(pixel, pixels[corner], cx.abs_diff(x).max(cy.abs_diff(y)))
            {
                continue;
            }
            sum += weight * value;
            total += weight;
            plain += value;
            count += 1.0;
        }
        // The remaining corners may have a weight of almost zero.
        if total > 1e-3 { sum / total } else { plain / count }
    }

    /// True if a predicate holds wherever pixels of finer cells border on this one: along its four edges, and
    /// just outside the left and the top one. Pixels just outside the right and the bottom edge lie on these
    /// edges, which belong to the next cells.
    #[inline]
    pub(crate) fn all_edges(&self, mut holds: impl FnMut(u32, u32) -> bool) -> bool {
        let Self { x0, y0, x1, y1, .. } = *self;
        (x0 + 1..x1).all(|x| holds(x, y0) && holds(x, y1))
            && (y0 + 1..y1).all(|y| holds(x0, y) && holds(x1, y))
            && (y0 == 0 || (x0..x1 + 1).all(|x| holds(x, y0 - 1)))
            && (x0 == 0 || (y0..y1 + 1).all(|y| holds(x0 - 1, y)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Number of positions on and beside a cell's edges.
    fn edges(corners: &Corners) -> usize {
        let mut count = 0;
        corners.all_edges(|_, _| {
            count += 1;
            true
        });
        count
    }

    #[test]
    fn corners_are_clamped_at_the_last_row_and_column() {
        let inner = Corners::new(10, 7, 2, 1, 0);
        assert_eq!(inner.positions(), [(4, 0), (8, 0), (4, 4), (8, 4)]);
        assert_eq!(inner.pixels(), [4, 8, 44, 48]);
        // Three per side, and five outside the left one; the row above is outside the image.
        assert_eq!(edges(&inner), 4 * 3 + 5);
        assert!(inner.all_edges(|x, y| (3..=8).contains(&x) && y <= 4));
        assert!(!inner.all_edges(|x, y| (x, y) != (3, 4)));
        let border = Corners::new(10, 7, 2, 2, 1);
        assert_eq!(border.positions(), [(8, 4), (9, 4), (8, 6), (9, 6)]);
        assert_eq!(Corners::new(10, 7, 0, 3, 2).positions(), [(3, 2); 4]);
        let last = Corners::new(9, 5, 2, 2, 1);
        assert_eq!((last.positions(), edges(&last)), ([(8, 4); 4], 2));
        assert_eq!(last.weights(8, 4), [1.0, 0.0, 0.0, 0.0]);
    }

    #[test]
    fn interpolation_follows_a_ramp() {
        let corners = Corners::new(100, 100, 3, 2, 3);
        let ramp = |x: u32, y: u32| 0.25 * x as f32 - 0.5 * y as f32;
        let values = corners.positions().map(|(x, y)| ramp(x, y));
        for (x, y) in [(16, 24), (19, 30), (24, 32), (16, 27), (15, 25)] {
            // All numbers are short binary fractions.
            let weights = corners.weights(x, y);
            let sum: f32 = weights.iter().zip(values).map(|(weight, value)| weight * value).sum();
            assert_eq!(sum, ramp(x, y));
        }
    }
}
