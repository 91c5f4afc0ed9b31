//! Output of refiners: samples with their masks, and the cells of the image that they stand for.

use crate::gbuffer::{GBuffer, NO_PRIMITIVE};
use crate::mask::{MaskBatch, Purpose};
use crate::pattern::Pattern;

/// Levels that are counted apart: 0 … 15.
pub const LEVELS: usize = 16;

/// A fragment's value at a point of the image, known through the masks of one or more receivers.
///
/// Its receivers are `probes` consecutive queries of one batch. A sample without probes was found to receive nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Position of the value, in pixels: pixel (i, j) has its centre at (i + 0.5, j + 0.5).
    pub x: f32,
    /// Down, like `x`.
    pub y: f32,
    /// Index of the pixel whose depth, normal and plane stand for the sample.
    pub pixel: u32,
    /// Size of the fragment that it belongs to: 2^level pixels; 0 for single pixels and additional samples.
    pub level: u8,
    /// Number of queries that the value is made of.
    pub probes: u8,
    /// Index of the batch that holds them.
    pub batch: u16,
    /// The first of them.
    pub first: u32,
}

impl Sample {
    /// The sample of a single pixel in an image of this width, made of one query.
    #[inline]
    pub fn of_pixel(pixel: u32, width: u32, level: u8, batch: u16, query: u32) -> Self {
        let (x, y) = (pixel % width.max(1), pixel / width.max(1));
        Self { x: x as f32 + 0.5, y: y as f32 + 0.5, pixel, level, probes: 1, batch, first: query }
    }
}

/// A square of 2^level pixels that takes its values from samples, its own or shared with other cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cell {
    /// Column, in cells of this level.
    pub x: u16,
    /// Row, in cells of this level.
    pub y: u16,
    /// Size: 2^level pixels, clipped at the image's border.
    pub level: u8,
    count: u8,
    first: u32,
}

impl Cell {
    /// The pixels that the cell covers in an image of this size: `(x0, y0, x1, y1)`, ends excluded.
    #[inline]
    pub fn pixels(&self, width: u32, height: u32) -> (u32, u32, u32, u32) {
        let size = 1u32 << self.level;
        let (x, y) = (u32::from(self.x) << self.level, u32::from(self.y) << self.level);
        (x.min(width), y.min(height), (x + size).min(width), (y + size).min(height))
    }
}

/// Faults of a refiner's fragments.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum FragmentError {
    /// A sample's pixel or place lies outside the image.
    #[error("the refiner's sample {sample} lies outside the image")]
    Pixel {
        /// Index of the sample.
        sample: usize,
    },
    /// A sample refers to queries that were not asked.
    #[error("the refiner's sample {sample} refers to queries that do not exist")]
    Query {
        /// Index of the sample.
        sample: usize,
    },
    /// A cell is too large or refers to samples that do not exist.
    #[error("the refiner's cell {cell} has no such level or refers to samples that do not exist")]
    Cell {
        /// Index of the cell.
        cell: usize,
    },
    /// A cell has more samples, or lies farther right or down, than can be.
    #[error("the refiner's cell {cell} has more than {MAX_CELL_SAMPLES} samples or lies at more than 65535")]
    Limits {
        /// Index of the cell.
        cell: usize,
    },
    /// More batches than can be numbered.
    #[error("the refiner opened more than {MAX_BATCHES} batches")]
    Batches,
    /// Two cells hold the same pixel.
    #[error("pixel {pixel} lies in more than one of the refiner's cells")]
    Twice {
        /// Index of the pixel.
        pixel: usize,
    },
    /// No cell holds a pixel that sees geometry.
    #[error("pixel {pixel} sees geometry and lies in none of the refiner's cells")]
    Uncovered {
        /// Index of the pixel.
        pixel: usize,
    },
}

/// Most samples of a cell.
pub const MAX_CELL_SAMPLES: usize = u8::MAX as usize;

/// Most batches in one frame.
pub const MAX_BATCHES: usize = u16::MAX as usize + 1;

/// Fragments of one light in one frame. Reused from frame to frame: nothing is freed.
///
/// Every receiver pixel lies in exactly one cell. Cells refer to samples by index, so that centre samples, additional
/// samples and corners shared between cells all fit; a cell's first sample is the one that stands for it as a whole.
#[derive(Debug, Default)]
pub struct Fragments {
    width: u32,
    height: u32,
    light: u32,
    samples: Vec<Sample>,
    cells: Vec<Cell>,
    cell_samples: Vec<u32>,
    batches: Vec<MaskBatch>,
    used: usize,
    /// The first thing that was refused.
    fault: Option<FragmentError>,
    /// One bit a pixel that lies in a cell.
    covered: Vec<u64>,
}

impl Fragments {
    /// Forgets everything but the memory.
    pub fn reset(&mut self, width: u32, height: u32, light: u32) {
        (self.width, self.height, self.light) = (width, height, light);
        self.samples.clear();
        self.cells.clear();
        self.cell_samples.clear();
        self.used = 0;
        self.fault = None;
    }

    /// Opens an empty batch and returns its index. Queries that samples refer to stay in it until the next frame. From
    /// [`MAX_BATCHES`] on the last one is opened again, and [`Fragments::validate`] fails.
    pub fn open_batch(&mut self, pattern: Pattern, purpose: Purpose) -> u16 {
        if self.used == MAX_BATCHES {
            self.fault.get_or_insert(FragmentError::Batches);
            self.used -= 1;
        }
        if self.used == self.batches.len() {
            self.batches.push(MaskBatch::default());
        }
        self.batches[self.used].reset(self.light, pattern, purpose);
        self.used += 1;
        (self.used - 1) as u16
    }

    /// All batches opened this frame.
    pub fn batches(&self) -> &[MaskBatch] {
        &self.batches[..self.used]
    }

    /// A batch opened this frame.
    pub fn batch(&self, index: u16) -> &MaskBatch {
        &self.batches[usize::from(index)]
    }

    /// A batch opened this frame, to fill or to have answered.
    pub fn batch_mut(&mut self, index: u16) -> &mut MaskBatch {
        &mut self.batches[usize::from(index)]
    }

    /// Adds a sample and returns its index.
    pub fn push_sample(&mut self, sample: Sample) -> u32 {
        self.samples.push(sample);
        (self.samples.len() - 1) as u32
    }

    /// A sample added before, to change.
    pub fn sample_mut(&mut self, index: u32) -> &mut Sample {
        &mut self.samples[index as usize]
    }

    /// Adds a cell with the samples that it takes its values from, at most [`MAX_CELL_SAMPLES`]. One with more, or that lies at
    /// more than 65535, is left out, and [`Fragments::validate`] fails.
    pub fn push_cell(&mut self, level: u8, x: u32, y: u32, samples: &[u32]) {
        let first = self.cell_samples.len() as u32;
        let (Ok(x), Ok(y), Ok(count)) = (x.try_into(), y.try_into(), samples.len().try_into()) else {
            self.fault.get_or_insert(FragmentError::Limits { cell: self.cells.len() });
            return;
        };
        self.cell_samples.extend_from_slice(samples);
        self.cells.push(Cell { x, y, level, count, first });
    }

    /// Makes pixels cells with a sample each; their masks are the queries of `batch`, one a pixel in their order.
    pub fn push_pixels(&mut self, batch: u16, pixels: &[u32]) {
        let (width, sample, first) =
            (self.width.max(1), self.samples.len() as u32, self.cell_samples.len() as u32);
        let own = |(&pixel, query)| Sample::of_pixel(pixel, width, 0, batch, query);
        self.samples.extend(pixels.iter().zip(0..).map(own));
        self.cell_samples.extend((sample..).take(pixels.len()));
        let cell = |(&pixel, first)| Cell {
            x: (pixel % width) as u16,
            y: (pixel / width) as u16,
            level: 0,
            count: 1,
            first,
        };
        self.cells.extend(pixels.iter().zip(first..).map(cell));
    }

    /// Checks that samples and cells refer to pixels, queries and samples that exist and that every pixel of the G-buffer that
    /// sees geometry lies in exactly one cell, so that the stages that follow a refiner from outside need not.
    ///
    /// # Errors
    /// The first fault found.
    pub fn validate(&mut self, gbuffer: &GBuffer) -> Result<(), FragmentError> {
        if let Some(fault) = self.fault {
            return Err(fault);
        }
        self.check_references()?;
        self.check_cover(gbuffer)
    }

    /// Checks that every pixel that sees geometry lies in exactly one cell.
    fn check_cover(&mut self, gbuffer: &GBuffer) -> Result<(), FragmentError> {
        let Self { covered, cells, width, height, .. } = self;
        let row = width.div_ceil(64) as usize;
        covered.clear();
        covered.resize(row * *height as usize, 0);
        for cell in &*cells {
            let (x0, y0, x1, y1) = cell.pixels(*width, *height);
            if cell.level == 0 && x0 < x1 && y0 < y1 {
                let (word, bit) = (&mut covered[y0 as usize * row + (x0 / 64) as usize], 1 << (x0 % 64));
                if *word & bit != 0 {
                    return Err(FragmentError::Twice { pixel: (y0 * *width + x0) as usize });
                }
                *word |= bit;
                continue;
            }
            for y in y0..y1 {
                let mut x = x0;
                while x < x1 {
                    let end = x1.min((x / 64 + 1) * 64);
                    let bits = (!0u64 >> (64 - (end - x))) << (x % 64);
                    let word = &mut covered[y as usize * row + (x / 64) as usize];
                    if *word & bits != 0 {
                        let column = x / 64 * 64 + (*word & bits).trailing_zeros();
                        return Err(FragmentError::Twice { pixel: (y * *width + column) as usize });
                    }
                    *word |= bits;
                    x = end;
                }
            }
        }
        for (y, words) in covered.chunks(row.max(1)).enumerate() {
            for (number, &word) in words.iter().enumerate() {
                let first = 64 * number;
                let count = 64.min(*width as usize - first);
                let mut missing = !word & (!0u64 >> (64 - count));
                while missing != 0 {
                    let pixel = y * *width as usize + first + missing.trailing_zeros() as usize;
                    if gbuffer.primitive.get(pixel).is_some_and(|&triangle| triangle != NO_PRIMITIVE) {
                        return Err(FragmentError::Uncovered { pixel });
                    }
                    missing &= missing - 1;
                }
            }
        }
        Ok(())
    }

    /// Checks that samples and cells refer to what exists.
    fn check_references(&self) -> Result<(), FragmentError> {
        let pixels = self.width as usize * self.height as usize;
        for (index, sample) in self.samples.iter().enumerate() {
            let queries =
                || self.batches[..self.used].get(usize::from(sample.batch)).map_or(0, MaskBatch::len);
            let last = sample.first as usize + usize::from(sample.probes);
            if sample.pixel as usize >= pixels || !(sample.x.is_finite() && sample.y.is_finite()) {
                return Err(FragmentError::Pixel { sample: index });
            }
            if sample.probes > 0 && last > queries() {
                return Err(FragmentError::Query { sample: index });
            }
        }
        for (index, cell) in self.cells.iter().enumerate() {
            let known = |&sample: &u32| (sample as usize) < self.samples.len();
            if usize::from(cell.level) >= LEVELS || !self.cell_samples(cell).iter().all(known) {
                return Err(FragmentError::Cell { cell: index });
            }
        }
        Ok(())
    }

    /// Image width in pixels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Image height in pixels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Index of the light in the scene.
    pub fn light(&self) -> u32 {
        self.light
    }

    /// All samples.
    pub fn samples(&self) -> &[Sample] {
        &self.samples
    }

    /// All cells.
    pub fn cells(&self) -> &[Cell] {
        &self.cells
    }

    /// Indices of the samples of a cell.
    #[inline]
    pub fn cell_samples(&self, cell: &Cell) -> &[u32] {
        &self.cell_samples[cell.first as usize..cell.first as usize + usize::from(cell.count)]
    }

    /// Number of samples of each level: what is reported as fragments.
    pub fn per_level(&self) -> [u64; LEVELS] {
        let mut counts = [0; LEVELS];
        for sample in &self.samples {
            counts[usize::from(sample.level).min(LEVELS - 1)] += 1;
        }
        counts
    }

    /// Number of cells of each level.
    pub fn cells_per_level(&self) -> [u64; LEVELS] {
        let mut counts = [0; LEVELS];
        for cell in &self.cells {
            counts[usize::from(cell.level).min(LEVELS - 1)] += 1;
        }
        counts
    }

    /// Writes, for every pixel, the index of the cell that it lies in (`u32::MAX`: none).
    pub fn owners(&self, owners: &mut Vec<u32>) {
        owners.clear();
        owners.resize(self.width as usize * self.height as usize, u32::MAX);
        for (index, cell) in self.cells.iter().enumerate() {
            let (x0, y0, x1, y1) = cell.pixels(self.width, self.height);
            for y in y0..y1 {
                let row = y as usize * self.width as usize;
                owners[row + x0 as usize..row + x1 as usize].fill(index as u32);
            }
        }
    }

    /// Bytes held.
    pub fn bytes(&self) -> usize {
        self.samples.capacity() * size_of::<Sample>()
            + self.cells.capacity() * size_of::<Cell>()
            + self.cell_samples.capacity() * 4
            + self.covered.capacity() * 8
            + self.batches.iter().map(MaskBatch::bytes).sum::<usize>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_clipped_at_the_border_and_share_samples() {
        let mut fragments = Fragments::default();
        fragments.reset(5, 3, 0);
        let sample = Sample { x: 2.0, y: 2.0, pixel: 0, level: 2, probes: 0, batch: 0, first: 0 };
        let shared = fragments.push_sample(sample);
        fragments.push_cell(2, 0, 0, &[shared]);
        fragments.push_cell(2, 1, 0, &[shared]);
        fragments.push_cell(2, 9, 9, &[shared]);
        let mut owners = Vec::new();
        fragments.owners(&mut owners);
        assert_eq!(owners, [0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);
        assert_eq!(fragments.cell_samples(&fragments.cells()[1]), [shared]);
        assert_eq!((fragments.per_level()[2], fragments.cells_per_level()[2]), (1, 3));
    }

    #[test]
    fn pixels_are_cells_of_their_own() {
        let pixels = [0, 7, 14];
        let mut one_by_one = Fragments::default();
        let mut at_once = Fragments::default();
        for fragments in [&mut one_by_one, &mut at_once] {
            fragments.reset(5, 3, 0);
            let before = fragments.push_sample(Sample::of_pixel(3, 5, 1, 0, 0));
            fragments.push_cell(1, 1, 0, &[before, before]);
        }
        for (query, pixel) in (0..).zip(pixels) {
            let sample = one_by_one.push_sample(Sample::of_pixel(pixel, 5, 0, 2, query));
            one_by_one.push_cell(0, pixel % 5, pixel / 5, &[sample]);
        }
        at_once.push_pixels(2, &pixels);
        assert_eq!(at_once.samples(), one_by_one.samples());
        assert_eq!(at_once.cells(), one_by_one.cells());
        assert_eq!(at_once.cell_samples, one_by_one.cell_samples);
        assert_eq!(
            at_once.samples()[2],
            Sample { x: 2.5, y: 1.5, pixel: 7, level: 0, probes: 1, batch: 2, first: 1 }
        );
    }

    #[test]
    fn faults_of_a_refiner_are_found() {
        let sample = Sample { x: 2.0, y: 2.0, pixel: 0, level: 2, probes: 0, batch: 0, first: 0 };
        let check = |sample: Sample, cell: &[u32]| {
            let mut fragments = Fragments::default();
            fragments.reset(5, 3, 0);
            fragments.push_sample(sample);
            fragments.push_cell(2, 0, 0, cell);
            fragments.validate(&empty(5, 3))
        };
        assert_eq!(check(sample, &[0]), Ok(()));
        assert_eq!(check(Sample { pixel: 15, ..sample }, &[0]), Err(FragmentError::Pixel { sample: 0 }));
        assert_eq!(check(Sample { x: f32::NAN, ..sample }, &[0]), Err(FragmentError::Pixel { sample: 0 }));
        assert_eq!(check(Sample { probes: 1, ..sample }, &[0]), Err(FragmentError::Query { sample: 0 }));
        assert_eq!(check(sample, &[1]), Err(FragmentError::Cell { cell: 0 }));
        assert_eq!(check(sample, &[0; 255]), Ok(()));
        assert_eq!(check(sample, &[0; 256]), Err(FragmentError::Limits { cell: 0 }));
    }

    fn empty(width: u32, height: u32) -> GBuffer {
        let mut gbuffer = GBuffer::default();
        gbuffer.reset(width, height);
        gbuffer
    }

    #[test]
    fn receivers_lie_in_exactly_one_cell() {
        let mut gbuffer = empty(150, 9);
        gbuffer.primitive[3 * 150 + 140] = 7;
        let check = |cells: &[(u8, u32, u32)]| {
            let mut fragments = Fragments::default();
            fragments.reset(150, 9, 0);
            for &(level, x, y) in cells {
                fragments.push_cell(level, x, y, &[]);
            }
            fragments.validate(&gbuffer)
        };
        assert_eq!(check(&[(0, 140, 3)]), Ok(()));
        assert_eq!(check(&[(7, 1, 0), (6, 0, 0), (6, 1, 0)]), Ok(()));
        assert_eq!(check(&[(0, 140, 4), (7, 0, 0)]), Err(FragmentError::Uncovered { pixel: 3 * 150 + 140 }));
        assert_eq!(check(&[]), Err(FragmentError::Uncovered { pixel: 3 * 150 + 140 }));
        // Pixels that see nothing as well, since one of them would be lost.
        let twice = |pixel: usize| Err(FragmentError::Twice { pixel });
        assert_eq!(check(&[(0, 140, 3), (0, 140, 3)]), twice(3 * 150 + 140));
        assert_eq!(check(&[(7, 0, 0), (7, 1, 0), (0, 127, 8)]), twice(8 * 150 + 127));
        assert_eq!(check(&[(0, 63, 0), (6, 0, 0)]), twice(63));
        assert_eq!(check(&[(0, 149, 8), (1, 74, 4)]), twice(8 * 150 + 149));
        let far = check(&[(0, 140, 3), (0, 70_000, 0)]);
        assert_eq!(far, Err(FragmentError::Limits { cell: 1 }));
    }

    #[test]
    fn too_many_batches_are_noticed() {
        let mut fragments = Fragments::default();
        fragments.reset(1, 1, 0);
        let pattern = Pattern { kind: crate::pattern::PatternKind::Grid, columns: 1, rows: 1 };
        for _ in 0..MAX_BATCHES {
            fragments.open_batch(pattern, Purpose::Final);
        }
        assert_eq!(fragments.validate(&empty(1, 1)), Ok(()));
        assert_eq!(fragments.open_batch(pattern, Purpose::Final), u16::MAX);
        assert_eq!(fragments.validate(&empty(1, 1)), Err(FragmentError::Batches));
    }
}
