//! Discontinuity pyramid: max-mipmaps of depth derivative and normal curvature over the G-buffer.

/// The coarsest level anything uses: fragments of 128 × 128 pixels (Koa17 §3.3.1).
pub const MAX_LEVEL: u8 = 7;

/// One level: cells of 2^m × 2^m pixels, row by row; those at the right and bottom border may be clipped.
#[derive(Clone, Debug, Default)]
pub struct PyramidLevel {
    /// Cells across.
    pub width: u32,
    /// Cells down.
    pub height: u32,
    /// Largest depth derivative in the cell, relative to depth, per pixel; infinite where a receiver borders on nothing.
    pub depth: Vec<f32>,
    /// Largest curvature `sqrt(κx² + κy²)` in the cell (Koa17 §3.2.1), 0 … 2√2.
    pub curvature: Vec<f32>,
    /// True if any pixel of the cell is a receiver.
    pub receivers: Vec<bool>,
}

/// Levels from 1 (2 × 2 pixels) to the coarsest that the refiner looks at; a single pixel has no break inside.
#[derive(Clone, Debug, Default)]
pub struct Pyramid {
    /// The levels, level 1 first.
    pub levels: Vec<PyramidLevel>,
}

impl PyramidLevel {
    /// Index of cell (x, y).
    #[inline]
    pub fn index(&self, x: u32, y: u32) -> usize {
        y as usize * self.width as usize + x as usize
    }
}

impl Pyramid {
    /// Level `level` ≥ 1, or `None` where it was not built.
    pub fn level(&self, level: u8) -> Option<&PyramidLevel> {
        self.levels.get(usize::from(level).checked_sub(1)?)
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.levels
            .iter()
            .map(|l| (l.depth.capacity() + l.curvature.capacity()) * 4 + l.receivers.capacity())
            .sum()
    }
}
