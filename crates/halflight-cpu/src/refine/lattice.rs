//! The lattice refiner: masks at the corners of quadtree cells, refined where the visible fraction cannot be predicted.

use halflight_core::fragment::Fragments;
use halflight_core::frame::Frame;
use halflight_core::gbuffer::GBuffer;
use halflight_core::mask::Purpose;
use halflight_core::pyramid::MAX_LEVEL;
use halflight_core::stages::{Refiner, Visibility};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::breaks::Breaks;
use super::place::{cell_rect, faces_away};
use super::{Pending, pixel_sample, trace_pixels};
use crate::corners::Corners;
use crate::irradiance;
use crate::rise::{Rise, RiseLimits};

/// Constants of [`Lattice`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct LatticeConfig {
    /// Level of the coarsest cells, 0 … 7: 4, that is 16 × 16 pixels. Their corners are one pixel in 256; coarser cells
    /// would save next to nothing and pass over more thin shadows.
    pub coarsest_level: u8,
    /// Difference of the visible fraction, 0 … 1, that is interpolated over: 0.05. The masks themselves have noise: in the
    /// middle of a penumbra 64 stratified samples have a standard deviation of 0.02, and less than two of these asks for
    /// pixels that are no better than what they replace.
    pub error: f32,
    /// What parts surfaces.
    pub rise: RiseLimits,
}

impl Default for LatticeConfig {
    fn default() -> Self {
        Self { coarsest_level: 4, error: 0.05, rise: RiseLimits::default() }
    }
}

/// No mask has been asked for here.
const NONE: u32 = u32::MAX;

/// Quadtree cells with full masks at pixel-centred corners, each traced once and shared by all cells and levels.
///
/// The visible fraction `F` is smooth over most of a penumbra and does not know normals. A cell is kept, to be interpolated
/// over, when its corners' `F` differ by no more than [`LatticeConfig::error`], or when the parent's corners had foretold
/// them that well. It is split where its corners turn from the lit to the unlit side of the light, and at steps,
/// silhouettes and concave creases, where contact shadows live (see [`RiseLimits`]). When all is decided, corners of finer
/// cells on or beside the edges of a kept cell are compared with what it would have there, and a cell that is off by more
/// than the error is split after all. So no crack between levels is wider than the error, and a thin shadow
/// that one cell has found is followed through its neighbours. One that passes between all corners is missed.
///
/// A cell's samples are its corners: top left, top right, bottom left, bottom right, those that coincide at the image's
/// border once. A pixel on its own has its own sample. All samples have level 0: they are single pixels.
#[derive(Clone, Debug, Default)]
pub struct Lattice {
    config: LatticeConfig,
    breaks: Breaks,
    /// Sample of every pixel, or [`NONE`].
    corners: Vec<u32>,
    /// Visible fraction of every sample; NaN where the light lies below its horizon.
    fractions: Vec<f32>,
    /// Cells to look at, by level.
    pending: Vec<Vec<Pending>>,
    /// Unbroken cells of the level in work, and the outcome of a test on these or on `kept`.
    judged: Vec<Pending>,
    passed: Vec<bool>,
    /// Pixels whose masks the level in work asks for.
    fresh: Vec<u32>,
    /// Cells above one pixel that have been kept, with their levels.
    kept: Vec<(u8, Pending)>,
    /// Cells of the coarsest level that have got new corners inside, along or beside their edges.
    touched: Vec<bool>,
}

impl Lattice {
    /// A refiner with these constants.
    pub fn new(config: LatticeConfig) -> Self {
        Self { config, ..Self::default() }
    }

    /// The coarsest level of cells.
    fn top(&self) -> u8 {
        self.config.coarsest_level.min(MAX_LEVEL)
    }

    /// Looks at all pending cells of a level: traces the corners that are new and keeps or splits.
    fn descend(
        &mut self,
        frame: &Frame,
        light: u32,
        level: u8,
        visibility: &mut dyn Visibility,
        fragments: &mut Fragments,
    ) {
        let mut cells = std::mem::take(&mut self.pending[usize::from(level)]);
        self.collect(frame, level, &cells, fragments);
        // Handed back for its memory.
        cells.clear();
        self.pending[usize::from(level)] = cells;
        self.trace(frame, light, visibility, fragments);

        let mut passed = std::mem::take(&mut self.passed);
        let holds = |&cell: &Pending| level == 0 || self.holds(frame, light, level, cell);
        self.judged.par_iter().with_min_len(256).map(holds).collect_into_vec(&mut passed);
        for (index, &holds) in passed.iter().enumerate() {
            let cell = self.judged[index];
            if !holds {
                self.split(level, cell);
            } else if level > 0 {
                self.kept.push((level, cell));
            } else {
                let sample = self.corners[frame.gbuffer.index(cell.x, cell.y)];
                fragments.push_cell(0, cell.x, cell.y, &[sample]);
            }
        }
        self.passed = passed;
    }

    /// Splits broken cells and drops empty ones; notes the others, and their corners that no cell has had before.
    fn collect(&mut self, frame: &Frame, level: u8, cells: &[Pending], fragments: &mut Fragments) {
        let gbuffer = frame.gbuffer;
        self.judged.clear();
        self.fresh.clear();
        if cells.is_empty() {
            return;
        }
        let purpose = if level == 0 { Purpose::Final } else { Purpose::Refine };
        let batch = fragments.open_batch(frame.pattern, purpose);
        for &cell in cells {
            if cell.x << level >= gbuffer.width || cell.y << level >= gbuffer.height {
                continue;
            }
            if self.breaks.inside(level, cell.x, cell.y) {
                self.split(level, cell);
                continue;
            }
            let pixels = corners_of(gbuffer, level, cell).pixels();
            // Nothing parts the cell's pixels, so what one of them sees, geometry or nothing, all see.
            if !gbuffer.is_receiver(pixels[0]) {
                continue;
            }
            for pixel in pixels {
                if self.corners[pixel] == NONE {
                    let sample = pixel_sample(pixel, gbuffer.width, 0, batch, self.fresh.len());
                    self.corners[pixel] = fragments.push_sample(sample);
                    self.fresh.push(pixel as u32);
                }
            }
            self.judged.push(cell);
        }
    }

    /// Asks for the masks of the new corners and computes how much of the light they see.
    fn trace(
        &mut self,
        frame: &Frame,
        light: u32,
        visibility: &mut dyn Visibility,
        fragments: &mut Fragments,
    ) {
        let Some(&pixel) = self.fresh.first() else { return };
        let sample = fragments.samples()[self.corners[pixel as usize] as usize];
        trace_pixels(frame, light, &self.fresh, visibility, fragments.batch_mut(sample.batch));
        let (batch, known) = (fragments.batch(sample.batch), self.fractions.len());
        self.fractions.resize(known + self.fresh.len(), f32::NAN);
        let light = frame.light(light);
        self.fractions[known..].par_iter_mut().enumerate().with_min_len(256).for_each(|(query, fraction)| {
            *fraction = irradiance::fraction(light, batch, query).unwrap_or(f32::NAN);
        });
        // A corner lies on or just outside the edges of up to four cells.
        let (width, height, shift) = (frame.gbuffer.width, frame.gbuffer.height, self.top());
        let columns = width.div_ceil(1 << shift);
        for &pixel in &self.fresh {
            let (x, y) = (pixel % width, pixel / width);
            let (x0, y0) = (x.saturating_sub(1), y.saturating_sub(1));
            let (x1, y1) = ((x + 1).min(width - 1), (y + 1).min(height - 1));
            for (x, y) in [(x0, y0), (x1, y0), (x0, y1), (x1, y1)] {
                self.touched[((y >> shift) * columns + (x >> shift)) as usize] = true;
            }
        }
    }

    fn split(&mut self, level: u8, cell: Pending) {
        self.pending[usize::from(level) - 1].extend((0..4).map(|child| Pending {
            x: 2 * cell.x + (child & 1),
            y: 2 * cell.y + (child >> 1),
            forced: false,
        }));
    }

    /// The visible fraction at a pixel, NaN where there is none or nobody has asked.
    fn fraction(&self, pixel: usize) -> f32 {
        match self.corners[pixel] {
            NONE => f32::NAN,
            sample => self.fractions[sample as usize],
        }
    }

    /// Whether an unbroken cell can be interpolated over.
    fn holds(&self, frame: &Frame, light: u32, level: u8, cell: Pending) -> bool {
        let gbuffer = frame.gbuffer;
        let corners = corners_of(gbuffer, level, cell);
        let found = corners.pixels().map(|pixel| self.fraction(pixel));
        match found.iter().filter(|fraction| fraction.is_nan()).count() {
            0 => {}
            // On the unlit side, if no bulge turns back to the light.
            4 => {
                let rect = cell_rect(gbuffer, level, cell.x, cell.y);
                let unlit = |x, y| faces_away(gbuffer, frame.light(light), gbuffer.index(x, y));
                return (rect.y0..rect.y1).all(|y| (rect.x0..rect.x1).all(|x| unlit(x, y)));
            }
            _ => return false,
        }
        let low = found.iter().copied().fold(f32::INFINITY, f32::min);
        let high = found.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        if high - low <= self.config.error {
            return true;
        }
        let parent = Pending { x: cell.x / 2, y: cell.y / 2, ..cell };
        if level >= self.top() || self.breaks.inside(level + 1, parent.x, parent.y) {
            return false;
        }
        let parent = corners_of(gbuffer, level + 1, parent);
        let known = parent.pixels().map(|pixel| self.fraction(pixel));
        let rise = Rise::new(frame, &self.config.rise);
        corners.places().into_iter().zip(found).all(|((x, y), fraction)| {
            // Without a fraction at the parent's corners there is no prediction, and the comparison fails.
            (parent.interpolate(&rise, &known, x, y) - fraction).abs() <= self.config.error
        })
    }

    /// Whether no corner of finer cells where they meet a kept one contradicts what it would have there.
    fn meets_neighbours(&self, frame: &Frame, level: u8, cell: Pending) -> bool {
        let corners = corners_of(frame.gbuffer, level, cell);
        let known = corners.pixels().map(|pixel| self.fraction(pixel));
        let rise = Rise::new(frame, &self.config.rise);
        corners.edges().all(|(x, y)| {
            let found = self.fraction(frame.gbuffer.index(x, y));
            if found.is_nan() {
                return true;
            }
            let expected = corners.interpolate(&rise, &known, x, y);
            // Without corners on the pixel's surface there is nothing to compare with.
            expected.is_nan() || (found - expected).abs() <= self.config.error
        })
    }

    /// Splits kept cells that their neighbours contradict; whether there were any.
    fn mend(&mut self, frame: &Frame) -> bool {
        let (top, columns) = (self.top(), frame.gbuffer.width.div_ceil(1 << self.top()));
        let mut passed = std::mem::take(&mut self.passed);
        let meets = |&(level, cell): &(u8, Pending)| {
            let up = top - level;
            !self.touched[((cell.y >> up) * columns + (cell.x >> up)) as usize]
                || self.meets_neighbours(frame, level, cell)
        };
        self.kept.par_iter().with_min_len(256).map(meets).collect_into_vec(&mut passed);
        self.touched.fill(false);
        let mut left = 0;
        for (index, &meets) in passed.iter().enumerate() {
            let (level, cell) = self.kept[index];
            if meets {
                self.kept[left] = (level, cell);
                left += 1;
            } else {
                self.split(level, cell);
            }
        }
        self.kept.truncate(left);
        let any = left < passed.len();
        self.passed = passed;
        any
    }
}

impl Refiner for Lattice {
    fn refine(
        &mut self,
        frame: &Frame,
        light: u32,
        visibility: &mut dyn Visibility,
        fragments: &mut Fragments,
    ) {
        let gbuffer = frame.gbuffer;
        let top = self.top();
        self.breaks.find(frame, &self.config.rise, top);
        self.corners.clear();
        self.corners.resize(gbuffer.pixels(), NONE);
        self.fractions.clear();
        self.kept.clear();
        let (columns, rows) = (gbuffer.width.div_ceil(1 << top), gbuffer.height.div_ceil(1 << top));
        self.touched.clear();
        self.touched.resize(columns as usize * rows as usize, false);
        self.pending.resize_with(usize::from(top) + 1, Vec::new);
        self.pending[usize::from(top)]
            .extend((0..rows).flat_map(|y| (0..columns).map(move |x| Pending { x, y, forced: false })));
        loop {
            for level in (0..=top).rev() {
                self.descend(frame, light, level, visibility, fragments);
            }
            if !self.mend(frame) {
                break;
            }
        }
        for &(level, cell) in &self.kept {
            let mut own = [NONE; 4];
            let mut count = 0;
            for sample in corners_of(gbuffer, level, cell).pixels().map(|pixel| self.corners[pixel]) {
                if !own[..count].contains(&sample) {
                    own[count] = sample;
                    count += 1;
                }
            }
            fragments.push_cell(level, cell.x, cell.y, &own[..count]);
        }
    }

    /// None: it looks for breaks of another kind.
    fn coarsest_level(&self) -> u8 {
        0
    }

    fn bytes(&self) -> usize {
        let pending: usize = self.pending.iter().map(Vec::capacity).sum();
        self.breaks.bytes()
            + (self.corners.capacity() + self.fractions.capacity() + self.fresh.capacity()) * 4
            + (pending + self.judged.capacity()) * size_of::<Pending>()
            + self.kept.capacity() * size_of::<(u8, Pending)>()
            + self.passed.capacity()
            + self.touched.capacity()
    }
}

fn corners_of(gbuffer: &GBuffer, level: u8, cell: Pending) -> Corners {
    Corners::new(gbuffer.width, gbuffer.height, level, cell.x, cell.y)
}
