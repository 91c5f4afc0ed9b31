//! Means of a texture over squares of 2, 4, 8 … texels a side, one level after another.

use glam::{Vec2, Vec3};

/// Coarser levels of a texture: each halves the columns and rows of the one before, rounded up. A value is the mean over the texels of its square
/// that the texture has.
#[derive(Debug)]
pub(super) struct Levels {
    /// Level 0, the texels themselves, is not among them.
    means: Vec<Vec3>,
    /// Levels from 0 on.
    levels: Vec<Level>,
}

/// Size of a level, and where it begins in [`Levels::means`].
#[derive(Clone, Copy, Debug)]
struct Level {
    first: usize,
    columns: u32,
    rows: u32,
}

impl Levels {
    pub(super) fn new(width: u32, height: u32, texels: &[Vec3]) -> Self {
        let mut levels = vec![Level { first: 0, columns: width, rows: height }];
        let mut means: Vec<Vec3> = Vec::new();
        while let Some(&below) = levels.last().filter(|level| level.columns > 1 || level.rows > 1) {
            let level = Level {
                first: means.len(),
                columns: below.columns.div_ceil(2),
                rows: below.rows.div_ceil(2),
            };
            let side = 1 << (levels.len() - 1);
            // Texels along one side of a square of the level below.
            let part = |at: u32, size: u32| (size - at * side).min(side) as f32;
            for y in 0..level.rows {
                for x in 0..level.columns {
                    let (mut sum, mut area) = (Vec3::ZERO, 0.0);
                    for row in 2 * y..(2 * y + 2).min(below.rows) {
                        for column in 2 * x..(2 * x + 2).min(below.columns) {
                            let at = below.first + (row * below.columns + column) as usize;
                            let mean = if levels.len() == 1 { texels[at] } else { means[at] };
                            let weight = part(column, width) * part(row, height);
                            sum += mean * weight;
                            area += weight;
                        }
                    }
                    means.push(sum / area);
                }
            }
            levels.push(level);
        }
        Self { means, levels }
    }

    /// Means of all levels but the first, rows from the top.
    pub(super) fn means(&self) -> &[Vec3] {
        &self.means
    }

    /// Places of the first values of all levels from the first one's: the texels', then those of the means, which follow.
    pub(super) fn places(&self, texels: usize) -> impl Iterator<Item = u32> + '_ {
        let place = move |at: usize| if at == 0 { 0 } else { texels + self.levels[at].first };
        (0..self.levels.len()).map(move |at| place(at) as u32)
    }

    /// Mean over a rectangle in texels from the top left, on the finest level of which `longest` texels are at most two squares: squares that lie in
    /// it partly count with their part.
    pub(super) fn mean(&self, texels: &[Vec3], low: Vec2, high: Vec2, longest: f32) -> Vec3 {
        let mut level = 0;
        while level + 1 < self.levels.len() && ((2u32 << level) as f32) < longest {
            level += 1;
        }
        let Level { first, columns, rows } = self.levels[level];
        let means = if level == 0 { texels } else { &self.means };
        let square = (1u32 << level) as f32;
        let place = |at: f32, count: u32| ((at / square) as u32).min(count - 1);
        let (left, right) = (place(low.x, columns), place(high.x, columns));
        let (top, bottom) = (place(low.y, rows), place(high.y, rows));
        let mean_at = |x: u32, y: u32| means[first + (y * columns + x) as usize];
        if left == right && top == bottom {
            return mean_at(left, top);
        }
        let (mut sum, mut area) = (Vec3::ZERO, 0.0);
        for y in top..=bottom {
            let height = high.y.min((y + 1) as f32 * square) - low.y.max(y as f32 * square);
            for x in left..=right {
                let width = high.x.min((x + 1) as f32 * square) - low.x.max(x as f32 * square);
                let weight = width.max(0.0) * height.max(0.0);
                sum += mean_at(x, y) * weight;
                area += weight;
            }
        }
        if area > 0.0 { sum / area } else { mean_at(left, top) }
    }

    /// Memory held, bytes.
    pub(super) fn bytes(&self) -> usize {
        self.means.capacity() * size_of::<Vec3>()
    }
}
