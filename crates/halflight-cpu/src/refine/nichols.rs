//! The 3 × 3 refiner of Nichols10: fragments are compared with their neighbours, one level at a time,
//! coarsest first.

use std::time::Instant;

use halflight_core::fragment::{Fragments, Sample};
use halflight_core::frame::Frame;
use halflight_core::mask::{MaskBatch, Purpose};
use halflight_core::pattern::Pattern;
use halflight_core::stages::{RefineOutput, Refiner, Visibility};
use halflight_core::stats::LevelWork;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::representative::{cell_faces_away, fragment_point, geometry_breaks, has_receiver};
use super::{GeometryThresholds, Pending, quarter};
use crate::irradiance;

/// Options of [`Nichols`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct NicholsConfig {
    /// Level of the coarsest fragments: 4, a 64² grid for a 1024² image (§3.3.2).
    pub coarsest_level: u8,
    /// Thresholds at which geometry alone splits a fragment (§3.2).
    pub geometry: GeometryThresholds,
    /// Fraction of the light samples that must change inside a 3 × 3 neighbourhood to refine it. The paper
    /// says half of 256 (§3.3.2); on scenes with narrow penumbrae that misses most of them.
    pub visibility_threshold: f32,
    /// Change of irradiance between neighbours above which fragments are refined, relative to the brightest
    /// fragment of the coarsest level. Off by default: the comparisons of Koa17 count bits alone. Fig. 10
    /// varies it from 0.005 up.
    pub irradiance_threshold: Option<f32>,
    /// True if a light sample is traced again only where the coarser neighbourhood disagrees about it
    /// (§3.3.2).
    pub incremental: bool,
    /// True if every 2 × 2 block shares the samples, a quarter each; only fragments of the same phase are
    /// compared (§3.3.2).
    pub interleaved: bool,
    /// True if the neighbours of refined fragments are refined too, diagonal ones included: fewer gaps at
    /// shadow edges for many more fragments.
    pub diagonal: bool,
}

impl Default for NicholsConfig {
    fn default() -> Self {
        Self {
            coarsest_level: 4,
            geometry: GeometryThresholds::default(),
            visibility_threshold: 0.5,
            irradiance_threshold: None,
            incremental: true,
            interleaved: false,
            diagonal: false,
        }
    }
}

/// Cell that was not rendered at its level.
const NONE: u32 = u32::MAX;

/// Rendered fragments of one level: their cells, and the queries that hold their masks.
#[derive(Clone, Debug, Default)]
struct Level {
    width: u32,
    height: u32,
    batch: u16,
    /// Query of every cell, or [`NONE`].
    queries: Vec<u32>,
}

impl Level {
    fn reset(&mut self, frame: &Frame, level: u8) {
        self.width = frame.gbuffer.width.div_ceil(1 << level);
        self.height = frame.gbuffer.height.div_ceil(1 << level);
        self.queries.clear();
        self.queries.resize(self.width as usize * self.height as usize, NONE);
    }

    /// True if cell (x, y) was rendered.
    fn has(&self, x: u32, y: u32) -> bool {
        self.queries[(y * self.width + x) as usize] != NONE
    }

    /// Queries of the rendered fragments among cell (x, y) and its neighbours up to `radius` cells away.
    fn around(&self, x: u32, y: u32, radius: u32) -> impl Iterator<Item = usize> + '_ {
        let columns = x.saturating_sub(radius)..(x + radius + 1).min(self.width);
        (y.saturating_sub(radius)..(y + radius + 1).min(self.height)).flat_map(move |y| {
            columns.clone().filter_map(move |x| {
                let query = self.queries[(y * self.width + x) as usize];
                (query != NONE).then_some(query as usize)
            })
        })
    }
}

/// Refiner of Nichols10. All receivers share one light-sample pattern, since masks of neighbours are compared
/// bit by bit.
#[derive(Clone, Debug, Default)]
pub struct Nichols {
    config: NicholsConfig,
    levels: Vec<Level>,
    pending: Vec<Pending>,
    next: Vec<Pending>,
    /// Cells rendered at the current level with their pixels, and a flag for those with an illumination
    /// discontinuity.
    rendered: Vec<(Pending, u32)>,
    flagged: Vec<bool>,
    spread: Vec<bool>,
    values: Vec<f32>,
    brightest: f32,
    /// Samples whose visibility is reused from the coarser level, and their visibility bits.
    reused_known: Vec<u64>,
    reused_visible: Vec<u64>,
    /// The four phases of interleaved sampling, as masks.
    phases: [Vec<u64>; 4],
    /// Work of each level, 0 first.
    work: Vec<LevelWork>,
}

impl Nichols {
    /// Creates a refiner with these options.
    pub fn new(config: NicholsConfig) -> Self {
        Self { config, ..Self::default() }
    }

    /// Selects the pending cells that are rendered at this level (§3.4). Of the others, some go on to the
    /// next level, some are written as unlit, and some are empty.
    fn select(&mut self, frame: &Frame, light: u32, level: u8, fragments: &mut Fragments) {
        self.rendered.clear();
        for index in 0..self.pending.len() {
            let cell = self.pending[index];
            let Pending { x, y, forced } = cell;
            if !has_receiver(frame, level, x, y) {
                continue;
            }
            let broken = self.broken(frame, level, x, y);
            if broken && !forced {
                split(&mut self.next, cell, false);
                continue;
            }
            let Some(pixel) = fragment_point(frame.gbuffer, x << level, y << level, 1 << level) else {
                continue;
            };
            if !broken && cell_faces_away(frame, frame.light(light), level, x, y) {
                let sample =
                    Sample { probes: 0, ..Sample::of_pixel(pixel as u32, frame.gbuffer.width, level, 0, 0) };
                let sample = fragments.push_sample(sample);
                fragments.push_cell(level, x, y, &[sample]);
                continue;
            }
            self.rendered.push((cell, pixel as u32));
        }
    }

    /// Radius of a neighbourhood in cells: 1, that is 3 × 3. Of interleaved fragments only every other one
    /// has traced the same samples, so their neighbourhood is 5 × 5.
    fn radius(&self) -> u32 {
        if self.config.interleaved { 2 } else { 1 }
    }

    fn broken(&self, frame: &Frame, level: u8, x: u32, y: u32) -> bool {
        let (depth, curvature) = geometry_breaks(frame, &self.config.geometry, level, x, y);
        depth || curvature
    }

    /// Traces the masks of the rendered fragments, reusing bits on which the coarser neighbourhood agrees
    /// (§3.3.2).
    fn trace(
        &mut self,
        frame: &Frame,
        light: u32,
        level: u8,
        visibility: &mut dyn Visibility,
        out: &mut Fragments,
    ) {
        let purpose = if level == 0 { Purpose::Final } else { Purpose::Refine };
        let index = out.open_batch(frame.pattern, purpose);
        // Temporarily moved out, so that the coarser batch can be read while this one is written.
        let mut batch = std::mem::take(out.batch_mut(index));
        batch.fill(self.rendered.len());
        let words = batch.words();
        self.reused_known.clear();
        self.reused_known.resize(self.rendered.len() * words, 0);
        self.reused_visible.clear();
        self.reused_visible.resize(self.rendered.len() * words, 0);
        let coarser = (self.config.incremental && level < self.coarsest_level()).then(|| {
            let cells = &self.levels[usize::from(level) + 1];
            (cells, out.batch(cells.batch))
        });
        let (interleaved, phases, radius) = (self.config.interleaved, &self.phases, self.radius());
        let (queries, wanted, _) = batch.slots_mut();
        queries
            .par_iter_mut()
            .zip(wanted.par_chunks_mut(words))
            .zip(self.reused_known.par_chunks_mut(words).zip(self.reused_visible.par_chunks_mut(words)))
            .zip(&self.rendered)
            .with_min_len(256)
            .for_each(|(((query, wanted), (known, visible)), &(cell, pixel))| {
                let Some(receiver) = frame.gbuffer.receiver(pixel as usize) else { return };
                (query.origin, query.normal) = (receiver.origin, receiver.normal);
                query.pixel = pixel;
                query.key = frame.shared_key(light);
                if interleaved {
                    wanted.copy_from_slice(&phases[phase(cell)]);
                }
                query.asked = wanted.iter().map(|word| word.count_ones()).sum();
                // A cell whose parent was not rendered has masks of its parent's neighbours only, which may
                // lie on other surfaces.
                let Some((cells, batch)) = coarser.filter(|(cells, _)| cells.has(cell.x / 2, cell.y / 2))
                else {
                    return;
                };
                for word in 0..words {
                    let votes = Votes::count(batch, cells.around(cell.x / 2, cell.y / 2, radius), word);
                    known[word] = (votes.lit ^ votes.unlit) & wanted[word];
                    visible[word] = votes.lit & known[word];
                    wanted[word] &= !known[word];
                }
            });
        visibility.masks(frame, &mut batch);
        let (_, wanted, visible) = batch.slots_mut();
        let reused = self.reused_known.iter().zip(&self.reused_visible);
        for ((wanted, visible), (known, seen)) in wanted.iter_mut().zip(visible).zip(reused) {
            *visible = (*visible & *wanted) | seen;
            *wanted |= known;
        }
        *out.batch_mut(index) = batch;
        let cells = &mut self.levels[usize::from(level)];
        cells.batch = index;
        for (query, (cell, _)) in self.rendered.iter().enumerate() {
            cells.queries[(cell.y * cells.width + cell.x) as usize] = query as u32;
        }
    }

    /// Flags the rendered fragments whose neighbourhood shows an illumination discontinuity.
    fn compare(&mut self, frame: &Frame, light: u32, level: u8, fragments: &Fragments) {
        let cells = &self.levels[usize::from(level)];
        let batch = fragments.batch(cells.batch);
        let (words, radius) = (batch.words(), self.radius());
        let samples = frame.pattern.len() / if self.config.interleaved { 4 } else { 1 };
        let enough = (self.config.visibility_threshold * samples as f32).max(1.0);
        if self.config.irradiance_threshold.is_some() {
            let (light, area) = (frame.light(light), frame.light(light).frame_area());
            let value = |query: usize| irradiance::query_sums(light, batch, query, 1).sampled(area);
            (0..batch.len()).into_par_iter().with_min_len(256).map(value).collect_into_vec(&mut self.values);
            if level == self.coarsest_level() {
                self.brightest = self.values.iter().copied().fold(0.0, f32::max);
            }
        }
        let (values, brightest) = (&self.values, self.brightest);
        let threshold = self.config.irradiance_threshold;
        let flag = |&(cell, _): &(Pending, u32)| {
            let own = cells.queries[(cell.y * cells.width + cell.x) as usize] as usize;
            let changed: u32 = (0..words)
                .map(|word| {
                    let votes = Votes::count(batch, cells.around(cell.x, cell.y, radius), word);
                    (votes.lit & votes.unlit & batch.wanted(own)[word]).count_ones()
                })
                .sum();
            changed as f32 >= enough
                || threshold.is_some_and(|threshold| {
                    let (low, high) =
                        cells.around(cell.x, cell.y, 1).fold((f32::INFINITY, 0.0f32), |(low, high), q| {
                            (low.min(values[q]), high.max(values[q]))
                        });
                    high - low > threshold * brightest
                })
        };
        self.rendered.par_iter().with_min_len(256).map(flag).collect_into_vec(&mut self.flagged);
        if self.config.diagonal {
            let narrow = std::mem::take(&mut self.flagged);
            let spread =
                |&(cell, _): &(Pending, u32)| cells.around(cell.x, cell.y, 1).any(|query| narrow[query]);
            self.rendered.par_iter().with_min_len(256).map(spread).collect_into_vec(&mut self.spread);
            self.flagged = std::mem::replace(&mut self.spread, narrow);
        }
    }

    /// Keeps the fragments without a discontinuity and passes the children of the others on.
    fn commit(&mut self, frame: &Frame, level: u8, fragments: &mut Fragments) {
        let batch = self.levels[usize::from(level)].batch;
        for (query, &(cell, pixel)) in (0..).zip(&self.rendered) {
            let flagged = level > 0 && self.flagged[query as usize];
            if flagged || (level > 0 && self.broken(frame, level, cell.x, cell.y)) {
                split(&mut self.next, cell, flagged);
                continue;
            }
            let sample =
                fragments.push_sample(Sample::of_pixel(pixel, frame.gbuffer.width, level, batch, query));
            fragments.push_cell(level, cell.x, cell.y, &[sample]);
        }
    }
}

impl Refiner for Nichols {
    fn refine(
        &mut self,
        frame: &Frame,
        light: u32,
        visibility: &mut dyn Visibility,
        fragments: &mut Fragments,
    ) -> RefineOutput<'_> {
        let coarsest = self.coarsest_level();
        self.levels.resize_with(usize::from(coarsest) + 1, Level::default);
        for (level, cells) in self.levels.iter_mut().enumerate() {
            cells.reset(frame, level as u8);
        }
        for (phase, mask) in self.phases.iter_mut().enumerate() {
            phase_mask(frame.pattern, phase, mask);
        }
        // Above the coarsest level everything counts as discontinuous, or refinement would never start.
        self.pending.clear();
        let (width, height) =
            (self.levels[usize::from(coarsest)].width, self.levels[usize::from(coarsest)].height);
        self.pending
            .extend((0..height).flat_map(|y| (0..width).map(move |x| Pending { x, y, forced: false })));
        self.work.clear();
        self.work.resize(self.levels.len(), LevelWork::default());
        for level in (0..=coarsest).rev() {
            let start = Instant::now();
            self.next.clear();
            self.select(frame, light, level, fragments);
            self.trace(frame, light, level, visibility, fragments);
            if level > 0 {
                self.compare(frame, light, level, fragments);
            }
            self.commit(frame, level, fragments);
            std::mem::swap(&mut self.pending, &mut self.next);
            let ms = start.elapsed().as_secs_f64() * 1e3;
            self.work[usize::from(level)] = LevelWork { rendered: self.rendered.len() as u64, ms };
        }
        RefineOutput { levels: &self.work, ..RefineOutput::default() }
    }

    fn coarsest_level(&self) -> u8 {
        self.config.coarsest_level.clamp(1, halflight_core::pyramid::MAX_LEVEL)
    }

    fn bytes(&self) -> usize {
        self.levels.iter().map(|level| level.queries.capacity() * 4).sum::<usize>()
            + (self.pending.capacity() + self.next.capacity()) * size_of::<Pending>()
            + self.rendered.capacity() * size_of::<(Pending, u32)>()
            + (self.reused_known.capacity() + self.reused_visible.capacity()) * 8
            + self.values.capacity() * 4
            + self.flagged.capacity()
            + self.spread.capacity()
    }
}

/// Visibility of 64 light samples in a neighbourhood: visible from some fragment, hidden from some fragment.
#[derive(Clone, Copy, Default)]
struct Votes {
    lit: u64,
    unlit: u64,
}

impl Votes {
    fn count(batch: &MaskBatch, queries: impl Iterator<Item = usize>, word: usize) -> Self {
        queries.fold(Self::default(), |votes, query| {
            let (known, visible) = (batch.wanted(query)[word], batch.visible(query)[word]);
            Self { lit: votes.lit | (known & visible), unlit: votes.unlit | (known & !visible) }
        })
    }
}

fn split(next: &mut Vec<Pending>, cell: Pending, forced: bool) {
    next.extend((0..4).map(|child| Pending {
        x: 2 * cell.x + (child & 1),
        y: 2 * cell.y + (child >> 1),
        forced,
    }));
}

/// Index of a cell in its 2 × 2 block.
fn phase(cell: Pending) -> usize {
    ((cell.x & 1) | (cell.y & 1) << 1) as usize
}

/// Mask of the samples that fragments of a phase trace.
fn phase_mask(pattern: Pattern, phase: usize, mask: &mut Vec<u64>) {
    mask.clear();
    mask.resize(pattern.words(), 0);
    for sample in (0..pattern.len()).filter(|&sample| quarter(pattern, sample) == phase) {
        mask[sample / 64] |= 1 << (sample % 64);
    }
}
