//! Access to cells for upsamplers: lookup by pixel, traversal of neighbours, and tiles for threads.

use halflight_core::fragment::{Cell, Fragments, Sample};
use halflight_core::gbuffer::GBuffer;
use rayon::prelude::*;

/// Side of the tiles of the image, in pixels.
pub(super) const TILE: u32 = 8;

/// Number of pixels of a tile.
pub(super) const TILE_PIXELS: usize = (TILE * TILE) as usize;

/// Rectangle of pixels, ends excluded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Rect {
    pub(super) x0: u32,
    pub(super) y0: u32,
    pub(super) x1: u32,
    pub(super) y1: u32,
}

impl Rect {
    /// Columns and rows of the pixels, row by row.
    #[inline]
    pub(super) fn pixels(self) -> impl Iterator<Item = (u32, u32)> {
        (self.y0..self.y1).flat_map(move |y| (self.x0..self.x1).map(move |x| (x, y)))
    }
}

/// Part of a cell that lies in one tile.
#[derive(Clone, Copy, Debug)]
pub(super) struct Piece<'a> {
    pub(super) cell: &'a Cell,
    pub(super) rect: Rect,
}

/// Rows of the image that a thread writes.
#[derive(Debug)]
pub(super) struct Rows<'a> {
    pixels: &'a mut [f32],
    first: usize,
}

impl Rows<'_> {
    /// Current value of a pixel.
    #[inline]
    pub(super) fn get(&self, pixel: usize) -> f32 {
        self.pixels[pixel - self.first]
    }

    /// Writes one pixel, given by its index in the whole image.
    #[inline]
    pub(super) fn set(&mut self, pixel: usize, value: f32) {
        self.pixels[pixel - self.first] = value;
    }
}

/// Fragments with their values, and the cell of every pixel.
#[derive(Clone, Copy, Debug)]
pub(super) struct Field<'a> {
    fragments: &'a Fragments,
    values: &'a [f32],
    owners: &'a [u32],
    pub(super) width: u32,
    pub(super) height: u32,
    /// Any defined value, for single-pixel cells whose value is undefined: they lie below the light's horizon
    /// and their value is multiplied by 0. Interpolation would be wasted there.
    pub(super) anything: f32,
}

impl<'a> Field<'a> {
    /// Finds the cell of every pixel; `None` when the sizes of the arguments disagree.
    pub(super) fn new(
        gbuffer: &GBuffer,
        fragments: &'a Fragments,
        values: &'a [f32],
        owners: &'a mut Vec<u32>,
        out: &[f32],
    ) -> Option<Self> {
        let (width, height) = (fragments.width(), fragments.height());
        let pixels = width as usize * height as usize;
        let fits = (gbuffer.width, gbuffer.height) == (width, height)
            && gbuffer.pixels() == pixels
            && out.len() == pixels
            && values.len() == fragments.samples().len();
        if !fits || pixels == 0 {
            return None;
        }
        fragments.owners(owners);
        let anything = values.iter().copied().find(|v| v.is_finite()).unwrap_or(0.0);
        Some(Self { fragments, values, owners, width, height, anything })
    }

    /// Cell that contains the pixel.
    #[inline]
    pub(super) fn owner(&self, x: u32, y: u32) -> Option<&'a Cell> {
        self.fragments.cells().get(self.owners[self.pixel(x, y)] as usize)
    }

    /// Index of a pixel.
    #[inline]
    pub(super) fn pixel(&self, x: u32, y: u32) -> usize {
        y as usize * self.width as usize + x as usize
    }

    /// All cells.
    pub(super) fn cells(&self) -> &'a [Cell] {
        self.fragments.cells()
    }

    /// Number of samples.
    pub(super) fn sample_count(&self) -> usize {
        self.values.len()
    }

    /// Pixels of a cell.
    #[inline]
    pub(super) fn rect(&self, cell: &Cell) -> Rect {
        let (x0, y0, x1, y1) = cell.pixels(self.width, self.height);
        Rect { x0, y0, x1, y1 }
    }

    /// Sample, if it is valid: its pixel is in the image and its position is finite.
    #[inline]
    pub(super) fn sample(&self, index: u32) -> Option<&'a Sample> {
        let sample = self.fragments.samples().get(index as usize)?;
        let usable = (sample.pixel as usize) < self.owners.len() && (sample.x + sample.y).is_finite();
        usable.then_some(sample)
    }

    /// Indices of a cell's samples.
    #[inline]
    pub(super) fn samples_of(&self, cell: &Cell) -> &'a [u32] {
        self.fragments.cell_samples(cell)
    }

    /// Value of a sample, if defined.
    #[inline]
    pub(super) fn value(&self, index: u32) -> Option<f32> {
        self.values.get(index as usize).copied().filter(|v| v.is_finite())
    }

    /// Calls `visit` with every cell that touches the frame of pixels `margin` outside `rect`, in a fixed
    /// order. A cell that touches two sides is visited twice.
    #[inline]
    pub(super) fn walk_around(&self, rect: Rect, margin: u32, mut visit: impl FnMut(&'a Cell)) {
        let left = rect.x0.saturating_sub(margin);
        let top = rect.y0.saturating_sub(margin);
        let right = (rect.x1 - 1).saturating_add(margin).min(self.width - 1);
        let bottom = (rect.y1 - 1).saturating_add(margin).min(self.height - 1);
        if rect.y0 >= margin {
            self.walk_row(rect.y0 - margin, left, right + 1, &mut visit);
        }
        if rect.x0 >= margin {
            self.walk_column(rect.x0 - margin, top, bottom + 1, &mut visit);
        }
        if right == rect.x1 - 1 + margin {
            self.walk_column(right, top, bottom + 1, &mut visit);
        }
        if bottom == rect.y1 - 1 + margin {
            self.walk_row(bottom, left, right + 1, &mut visit);
        }
    }

    /// Calls `visit` with the cells of row `y` between two columns, each once.
    #[inline]
    pub(super) fn walk_row(&self, y: u32, x0: u32, x1: u32, mut visit: impl FnMut(&'a Cell)) {
        let mut x = x0;
        while x < x1 {
            let owner = self.owner(x, y);
            x = owner.map_or(x + 1, |cell| self.rect(cell).x1);
            if let Some(cell) = owner {
                visit(cell);
            }
        }
    }

    /// Calls `visit` with the cells of column `x` between two rows, each once.
    #[inline]
    pub(super) fn walk_column(&self, x: u32, y0: u32, y1: u32, mut visit: impl FnMut(&'a Cell)) {
        let mut y = y0;
        while y < y1 {
            let owner = self.owner(x, y);
            y = owner.map_or(y + 1, |cell| self.rect(cell).y1);
            if let Some(cell) = owner {
                visit(cell);
            }
        }
    }

    /// Writes the values of single-pixel samples to their receiver pixels.
    pub(super) fn write_exact(&self, gbuffer: &GBuffer, out: &mut [f32]) {
        for index in 0..self.sample_count() as u32 {
            if let Some(sample) = self.sample(index)
                && sample.level == 0
                && let Some(value) = self.value(index)
            {
                let pixel = sample.pixel as usize;
                if self.owners[pixel] != u32::MAX && gbuffer.is_receiver(pixel) {
                    out[pixel] = value;
                }
            }
        }
    }

    /// Divides the image into the parts that cells have in tiles, and calls `fill` for each on all threads,
    /// with scratch memory that is created once per row of tiles. Pixels in no cell become 0.
    pub(super) fn for_each_piece<S: Default>(
        &self,
        out: &mut [f32],
        fill: impl Fn(&Piece, &mut Rows, &mut S) + Sync,
    ) {
        let band = self.width as usize * TILE as usize;
        out.par_chunks_mut(band).enumerate().for_each(|(index, pixels)| {
            let mut scratch = S::default();
            let top = index as u32 * TILE;
            let bottom = (top + TILE).min(self.height);
            let mut rows = Rows { pixels, first: index * band };
            for left in (0..self.width).step_by(TILE as usize) {
                let right = (left + TILE).min(self.width);
                for y in top..bottom {
                    let mut x = left;
                    while x < right {
                        let Some(cell) = self.owner(x, y) else {
                            rows.set(self.pixel(x, y), 0.0);
                            x += 1;
                            continue;
                        };
                        let whole = self.rect(cell);
                        let x1 = whole.x1.min(right);
                        if y == whole.y0.max(top) {
                            let rect = Rect { x0: x, y0: y, x1, y1: whole.y1.min(bottom) };
                            fill(&Piece { cell, rect }, &mut rows, &mut scratch);
                        }
                        x = x1;
                    }
                }
            }
        });
    }
}
