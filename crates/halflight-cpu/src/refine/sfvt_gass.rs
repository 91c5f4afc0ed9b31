//! SFVT + GASS (Koa17 §3.3–3.4): fragments are tested at sub-fragments and split where the sub-fragments'
//! masks differ.

use halflight_core::fragment::{Fragments, Sample};
use halflight_core::frame::Frame;
use halflight_core::hash;
use halflight_core::mask::{MaskBatch, Purpose};
use halflight_core::pattern::Pattern;
use halflight_core::stages::{RefineOutput, Refiner, Visibility};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::representative::{
    cell_faces_away, cell_rect, faces_away, fragment_point, geometry_breaks, has_receiver,
};
use super::{GeometryThresholds, Pending, quarter, trace_pixels};

/// Options of [`SfvtGass`]. Bit counts are for masks of 16 samples per quadrant and scale with longer ones.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct SfvtGassConfig {
    /// Level of the coarsest fragments: 7, that is 128 × 128 pixels (§3.3.1).
    pub coarsest_level: u8,
    /// Thresholds at which geometry alone splits a fragment.
    pub geometry: GeometryThresholds,
    /// Finest level that a depth discontinuity still splits, to keep glancing angles from refining
    /// everywhere: fragments of this level or below are left to curvature and visibility. 1, that is 2 × 2
    /// pixels (§3.2.1).
    pub depth_finest_level: u8,
    /// Level from which on a fragment is tested at 16 sub-fragments instead of 4 (§3.3.1, N = 5).
    pub sixteen_from_level: u8,
    /// Number of differing bits between quadrants above which a fragment of levels 0–2 is split: 2 (§3.3.1).
    pub fine_threshold: u32,
    /// Number of differing bits between quadrants above which a fragment of levels ≥ 3 is split: 1 (§3.3.1;
    /// Koa16 has 1 everywhere).
    pub coarse_threshold: u32,
    /// True if exactly the threshold splits as well. "Higher than" (§3.3.4) means more, and "8.25 %" fits
    /// neither.
    pub inclusive: bool,
    /// Number of differing bits above which two quadrants are split two levels down: 7 (§3.3.5; Koa16: 4).
    pub gradient_threshold: u32,
    /// True if fragments get the value 0 when no sub-fragment sees any light (§3.3.6).
    pub dark_culling: bool,
    /// True if every stable fragment above level 2 gets three additional level-0 samples (§3.4).
    pub additional_samples: bool,
}

impl Default for SfvtGassConfig {
    fn default() -> Self {
        Self {
            coarsest_level: 7,
            geometry: GeometryThresholds::default(),
            depth_finest_level: 1,
            sixteen_from_level: 5,
            fine_threshold: 2,
            coarse_threshold: 1,
            inclusive: false,
            gradient_threshold: 7,
            dark_culling: true,
            additional_samples: true,
        }
    }
}

impl SfvtGassConfig {
    /// Pattern of one quadrant: a quarter of the samples of a full mask (K = 16 of 64 in the paper), at least
    /// 4.
    pub fn quadrant_pattern(full: Pattern) -> Pattern {
        let quarter = (full.len() / 4).max(4);
        Pattern::with_count(full.kind, quarter).unwrap_or(full)
    }
}

/// Refiner of Koa17.
#[derive(Clone, Debug, Default)]
pub struct SfvtGass {
    config: SfvtGassConfig,
    /// Cells to process, by level.
    pending: Vec<Vec<Pending>>,
    /// Cells of the current level that geometry does not split.
    tested: Vec<Pending>,
    verdicts: Vec<Verdict>,
    /// Pixels of level-0 fragments and additional samples, in the order of their queries.
    finals: Vec<u32>,
}

/// Result of a fragment's masks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Verdict {
    /// All rays were blocked: value 0, and no additional samples.
    Dark,
    /// Kept, with its masks.
    Stable,
    /// Split; bit q is set if quadrant q goes two levels down.
    Split(u8),
}

impl SfvtGass {
    /// Creates a refiner with these options.
    pub fn new(config: SfvtGassConfig) -> Self {
        Self { config, ..Self::default() }
    }

    /// Splits cells by geometry, drops empty ones and writes culled ones; `tested` holds the remaining ones.
    fn classify(&mut self, frame: &Frame, light: u32, level: u8, fragments: &mut Fragments) {
        self.tested.clear();
        let cells = std::mem::take(&mut self.pending[usize::from(level)]);
        for &cell in &cells {
            let Pending { x, y, .. } = cell;
            if !has_receiver(frame, level, x, y) {
                continue;
            }
            let (depth, curvature) = geometry_breaks(frame, &self.config.geometry, level, x, y);
            if curvature || (depth && level > self.config.depth_finest_level) {
                self.split(level, x, y);
            } else if cell_faces_away(frame, frame.light(light), level, x, y) {
                write_unlit(frame, fragments, level, x, y);
            } else {
                self.tested.push(cell);
            }
        }
        // Returned to keep its memory.
        self.pending[usize::from(level)] = cells;
        self.pending[usize::from(level)].clear();
    }

    fn split(&mut self, level: u8, x: u32, y: u32) {
        for child in 0..4 {
            let (x, y) = (2 * x + (child & 1), 2 * y + (child >> 1));
            self.pending[usize::from(level) - 1].push(Pending { x, y, forced: false });
        }
    }

    /// Traces the masks of all tested fragments of a level and returns the batch, with `slots` queries per
    /// fragment.
    fn test(
        &self,
        frame: &Frame,
        light: u32,
        level: u8,
        visibility: &mut dyn Visibility,
        fragments: &mut Fragments,
    ) -> (u16, usize) {
        let pattern = SfvtGassConfig::quadrant_pattern(frame.pattern);
        let words = pattern.words();
        let sixteen = level >= self.config.sixteen_from_level;
        let slots = if sixteen { 16 } else { 4 };
        let batch = fragments.open_batch(pattern, Purpose::Refine);
        fragments.batch_mut(batch).fill(self.tested.len() * slots);
        let (queries, wanted, _) = fragments.batch_mut(batch).slots_mut();
        queries
            .par_chunks_mut(slots)
            .zip(wanted.par_chunks_mut(slots * words))
            .zip(&self.tested)
            .with_min_len(64)
            .for_each(|((queries, wanted), cell)| {
                let size = 1u32 << level;
                let fragment = hash::fold(u32::from(level) << 16 | cell.y, cell.x);
                for (slot, (query, wanted)) in queries.iter_mut().zip(wanted.chunks_mut(words)).enumerate() {
                    // Slots are ordered by quadrant; of sixteen, four belong to a quadrant.
                    let (quadrant, part) = if sixteen { (slot / 4, slot % 4) } else { (slot, 0) };
                    let (mut x, mut y) = corner(cell.x * size, cell.y * size, size / 2, quadrant);
                    let mut square = size / 2;
                    if sixteen {
                        square /= 2;
                        (x, y) = corner(x, y, square, part);
                        keep_share(pattern, part, wanted);
                    }
                    let Some(pixel) = fragment_point(frame.gbuffer, x, y, square) else {
                        wanted.fill(0);
                        query.asked = 0;
                        continue;
                    };
                    let Some(receiver) = frame.gbuffer.receiver(pixel) else { continue };
                    (query.origin, query.normal) = (receiver.origin, receiver.normal);
                    query.pixel = pixel as u32;
                    query.key = frame.key(light, fragment, pixel as u32);
                    query.asked = wanted.iter().map(|word| word.count_ones()).sum();
                }
            });
        visibility.masks(frame, fragments.batch_mut(batch));
        (batch, slots)
    }

    /// Computes the verdicts of all tested fragments from their masks.
    fn split_test(&mut self, fragments: &Fragments, batch: u16, slots: usize, level: u8) {
        let mut verdicts = std::mem::take(&mut self.verdicts);
        let verdict = |fragment| self.verdict(fragments.batch(batch), fragment, slots, level);
        (0..self.tested.len()).into_par_iter().with_min_len(256).map(verdict).collect_into_vec(&mut verdicts);
        self.verdicts = verdicts;
    }

    /// Verdict of one fragment, from the `slots` queries from `fragment * slots` on.
    pub(super) fn verdict(&self, batch: &MaskBatch, fragment: usize, slots: usize, level: u8) -> Verdict {
        let config = &self.config;
        let samples = batch.pattern().len() as u32;
        let scaled = |bits: u32| bits * samples / 16;
        let threshold = scaled(if level <= 2 { config.fine_threshold } else { config.coarse_threshold });
        let (mut differing, mut any_visible) = (0, false);
        let mut gradient = [0u32; 4];
        for word in 0..batch.words() {
            // Reduced to one (known, visible) pair per quadrant.
            let mut quadrants = [(0u64, 0u64); 4];
            for slot in 0..slots {
                let query = fragment * slots + slot;
                let known = batch.wanted(query)[word];
                let quadrant = &mut quadrants[slot * 4 / slots];
                quadrant.0 |= known;
                quadrant.1 |= batch.visible(query)[word] & known;
            }
            let lit = quadrants.iter().fold(0, |lit, &(_, visible)| lit | visible);
            let unlit = quadrants.iter().fold(0, |unlit, &(known, visible)| unlit | (known & !visible));
            any_visible |= lit != 0;
            // The OR of all six pairwise XORs (Eq. 1, which as printed leaves A⊕C out), over bits that both
            // sides know.
            differing += (lit & unlit).count_ones();
            for (edge, gradient) in gradient.iter_mut().enumerate() {
                let (a, b) = (quadrants[RING[edge]], quadrants[RING[(edge + 1) % 4]]);
                *gradient += ((a.1 ^ b.1) & a.0 & b.0).count_ones();
            }
        }
        if !any_visible && config.dark_culling {
            return Verdict::Dark;
        }
        let split = if config.inclusive { differing >= threshold.max(1) } else { differing > threshold };
        if !split {
            return Verdict::Stable;
        }
        let mut deep = 0;
        for (edge, &gradient) in gradient.iter().enumerate() {
            if gradient > scaled(config.gradient_threshold) {
                deep |= 1 << RING[edge] | 1 << RING[(edge + 1) % 4];
            }
        }
        Verdict::Split(deep)
    }

    /// Applies the verdicts: keeps, blackens or splits.
    fn commit(
        &mut self,
        frame: &Frame,
        fragments: &mut Fragments,
        batch: u16,
        slots: usize,
        finals: u16,
        level: u8,
    ) {
        for index in 0..self.tested.len() {
            let Pending { x, y, .. } = self.tested[index];
            match self.verdicts[index] {
                verdict @ (Verdict::Dark | Verdict::Stable) => {
                    let centre = centre_sample(frame, fragments, level, (batch, index * slots, slots));
                    let mut samples = [fragments.push_sample(centre); 4];
                    let mut count = 1;
                    if verdict == Verdict::Stable && self.config.additional_samples && level > 2 {
                        let rect = cell_rect(frame.gbuffer, level, x, y);
                        let half = 1 << (level - 1);
                        for (px, py) in
                            [(rect.x0, rect.y0), (rect.x0 + half, rect.y0), (rect.x0, rect.y0 + half)]
                        {
                            if px < rect.x1
                                && py < rect.y1
                                && let Some(sample) =
                                    self.final_sample(frame, finals, frame.gbuffer.index(px, py))
                            {
                                samples[count] = fragments.push_sample(sample);
                                count += 1;
                            }
                        }
                    }
                    fragments.push_cell(level, x, y, &samples[..count]);
                }
                Verdict::Split(deep) => {
                    for quadrant in 0..4u32 {
                        let (cx, cy) = (2 * x + (quadrant & 1), 2 * y + (quadrant >> 1));
                        if deep & (1 << quadrant) != 0 && level >= 2 {
                            self.split(level - 1, cx, cy);
                        } else {
                            self.pending[usize::from(level) - 1].push(Pending {
                                x: cx,
                                y: cy,
                                forced: false,
                            });
                        }
                    }
                }
            }
        }
    }

    /// Queues a level-0 sample at a pixel.
    fn final_sample(&mut self, frame: &Frame, finals: u16, pixel: usize) -> Option<Sample> {
        if !frame.gbuffer.is_receiver(pixel) {
            return None;
        }
        let query = self.finals.len() as u32;
        self.finals.push(pixel as u32);
        Some(Sample::of_pixel(pixel as u32, frame.gbuffer.width, 0, finals, query))
    }
}

impl Refiner for SfvtGass {
    fn refine(
        &mut self,
        frame: &Frame,
        light: u32,
        visibility: &mut dyn Visibility,
        fragments: &mut Fragments,
    ) -> RefineOutput<'_> {
        let gbuffer = frame.gbuffer;
        let coarsest = self.coarsest_level();
        self.pending.resize_with(usize::from(coarsest) + 1, Vec::new);
        self.pending.iter_mut().for_each(Vec::clear);
        self.finals.clear();
        let finals = fragments.open_batch(frame.pattern, Purpose::Final);
        for y in 0..gbuffer.height.div_ceil(1 << coarsest) {
            for x in 0..gbuffer.width.div_ceil(1 << coarsest) {
                self.pending[usize::from(coarsest)].push(Pending { x, y, forced: false });
            }
        }
        for level in (1..=coarsest).rev() {
            self.classify(frame, light, level, fragments);
            let (batch, slots) = self.test(frame, light, level, visibility, fragments);
            self.split_test(fragments, batch, slots, level);
            self.commit(frame, fragments, batch, slots, finals, level);
        }
        for index in 0..self.pending[0].len() {
            let Pending { x, y, .. } = self.pending[0][index];
            if !has_receiver(frame, 0, x, y) {
                continue;
            }
            let pixel = gbuffer.index(x, y);
            if faces_away(gbuffer, frame.light(light), pixel) {
                write_unlit(frame, fragments, 0, x, y);
            } else if let Some(sample) = self.final_sample(frame, finals, pixel) {
                let sample = fragments.push_sample(sample);
                fragments.push_cell(0, x, y, &[sample]);
            }
        }
        trace_pixels(frame, light, &self.finals, visibility, fragments.batch_mut(finals));
        RefineOutput::default()
    }

    fn patterns(&self, full: Pattern) -> Vec<Pattern> {
        vec![SfvtGassConfig::quadrant_pattern(full), full]
    }

    fn coarsest_level(&self) -> u8 {
        self.config.coarsest_level.clamp(1, halflight_core::pyramid::MAX_LEVEL)
    }

    fn bytes(&self) -> usize {
        let pending: usize = self.pending.iter().map(Vec::capacity).sum();
        (pending + self.tested.capacity()) * size_of::<Pending>()
            + self.verdicts.capacity() * size_of::<Verdict>()
            + self.finals.capacity() * 4
    }
}

/// Quadrants around the ring A-B-C-D, as indices of rows of two: top left, top right, bottom right, bottom
/// left.
const RING: [usize; 4] = [0, 1, 3, 2];

/// Corner of quadrant `index` of a square at (x, y) whose quadrants are `half` wide.
fn corner(x: u32, y: u32, half: u32, index: usize) -> (u32, u32) {
    (x + half * (index as u32 & 1), y + half * (index as u32 >> 1))
}

/// Keeps only the samples that part `part` of a quadrant's four traces: sample k belongs to the same part in
/// all quadrants.
fn keep_share(pattern: Pattern, part: usize, wanted: &mut [u64]) {
    for sample in (0..pattern.len()).filter(|&sample| quarter(pattern, sample) != part) {
        wanted[sample / 64] &= !(1 << (sample % 64));
    }
}

/// Sample of a whole fragment: at the mean of the pixels from which its rays started.
fn centre_sample(frame: &Frame, fragments: &Fragments, level: u8, probes: (u16, usize, usize)) -> Sample {
    let (batch, first, count) = probes;
    let queries = &fragments.batch(batch).queries()[first..first + count];
    let width = frame.gbuffer.width;
    let (mut x, mut y, mut found) = (0.0, 0.0, 0.0);
    for query in queries.iter().filter(|query| query.asked > 0) {
        x += (query.pixel % width) as f32 + 0.5;
        y += (query.pixel / width) as f32 + 0.5;
        found += 1.0;
    }
    let (x, y) = if found > 0.0 { (x / found, y / found) } else { (0.5, 0.5) };
    // The sample's representative pixel is the traced one nearest to that mean.
    let nearest = queries.iter().filter(|query| query.asked > 0).min_by(|a, b| {
        let distance = |pixel: u32| {
            ((pixel % width) as f32 + 0.5 - x).powi(2) + ((pixel / width) as f32 + 0.5 - y).powi(2)
        };
        distance(a.pixel).total_cmp(&distance(b.pixel))
    });
    let pixel = nearest.map_or(0, |query| query.pixel);
    Sample { x, y, pixel, level, probes: count as u8, batch, first: first as u32 }
}

/// Writes a cell that no light can reach: one sample without probes.
fn write_unlit(frame: &Frame, fragments: &mut Fragments, level: u8, x: u32, y: u32) {
    let gbuffer = frame.gbuffer;
    if let Some(pixel) = fragment_point(gbuffer, x << level, y << level, 1 << level) {
        let sample = Sample { probes: 0, ..Sample::of_pixel(pixel as u32, gbuffer.width, level, 0, 0) };
        let sample = fragments.push_sample(sample);
        fragments.push_cell(level, x, y, &[sample]);
    }
}
