//! The `raster4d` visibility backend (Wang17): receivers and triangles are projected through all of the light at once,
//! and those whose projections overlap are paired.
//!
//! Per light and frame, all triangles are binned into a framebuffer beyond the scene (`project`, `cells`; STEPs 2 and
//! 4). A receiver looks into the one cell that it is projected to through the light's corner (STEP 3, §3.2), keeps the
//! triangles whose rectangle covers all of its own (§3.2), and takes whole rows of its mask from each (STEP 5, §3.3).
//! Receivers may come from anywhere, in any number: the whole image or a refiner's sub-fragments.

mod cells;
mod project;
#[cfg(test)]
mod tests;

use std::ops::Range;

use halflight_core::frame::Frame;
use halflight_core::light::AreaLight;
use halflight_core::mask::{MaskBatch, Query};
use halflight_core::pattern::{Pattern, PatternKind};
use halflight_core::scene::Mesh;
use halflight_core::stages::{Unsupported, Visibility};
use halflight_core::stats::VisibilityStats;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use crate::occluder::{Block, Points, Rows, Samples, Triangle};
use crate::pool::Pool;
use crate::shaft::{GROUP, Hull, List, Share, bounds, quarter};
use crate::simd::{Isa, Kernel, Lanes, Simd};
use cells::{Cells, Entries};
use project::Rectangle;

/// Triangles that receivers share without a look at where each of them is projected to.
const SHORT: usize = 64;

/// Triangles that are worth a test against a shaft: more are first left out by the rectangles of fewer receivers.
const MANY: usize = 1024;

/// Cells a side that a triangle covers at most before it goes to a coarser framebuffer: fewer make lists longer than
/// what they are for, more make more entries.
const SPAN: u16 = 4;

/// Constants of 4D rasterization. The switches are there to measure what each of the paper's optimisations gains.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Raster4dConfig {
    /// Cells a side of the framebuffer (Wang17 §4.2, Table 6: 128 is best of 32, 64, 128 and 256).
    pub framebuffer: u32,
    /// A receiver looks into one cell instead of all that its projection covers (Wang17 §3.2, Algorithm 2).
    pub one_cell: bool,
    /// Pairs whose projections do not cover each other are dropped (Wang17 §3.2, Algorithm 3).
    pub rejection: bool,
    /// Masks are computed by rows instead of sample by sample (Wang17 §3.3).
    pub rows: bool,
    /// Triangles that cover many cells are kept in coarser framebuffers, one a power of two. Not in the paper, whose
    /// lists grow with the square of the light's projected size.
    pub coarser: bool,
    /// Neighbouring receivers look into their cells together, and test what they find there against the shaft to the
    /// light. Not in the paper. Goes with `one_cell` and `rejection`; without either it does nothing.
    pub shafts: bool,
    /// Pairs in which the triangle hides a sample are counted, one by one, which costs much time. Only without `shafts`.
    pub count_relevant: bool,
}

impl Default for Raster4dConfig {
    fn default() -> Self {
        Self {
            framebuffer: 128,
            one_cell: true,
            rejection: true,
            rows: true,
            coarser: true,
            shafts: true,
            count_relevant: false,
        }
    }
}

/// Why 4D rasterization cannot be set up.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Raster4dError {
    /// The framebuffer is too small or too large.
    #[error("a framebuffer of {0} cells a side was asked for; {min} to {max} are possible", min = Raster4d::FRAMEBUFFERS.0, max = Raster4d::FRAMEBUFFERS.1)]
    Framebuffer(u32),
    /// Shafts leave pairs out before they can be counted.
    #[error("count_relevant needs shafts = false: shafts leave pairs out before they are counted")]
    Relevant,
}

/// Exact visibility by 4D rasterization, for grids and grids with shifted rows.
#[derive(Debug)]
pub struct Raster4d {
    config: Raster4dConfig,
    isa: Isa,
    triangles: Vec<Triangle>,
    /// The largest coordinate of the mesh.
    largest: f32,
    /// For each light its front, then its back where it has one.
    sides: Vec<[Option<Cells>; 2]>,
    stats: VisibilityStats,
    rows: Pool<Worker<Rows>>,
    points: Pool<Worker<Points>>,
}

impl Raster4d {
    /// Smallest and largest framebuffer.
    pub const FRAMEBUFFERS: (u32, u32) = (1, 4096);

    /// Nothing is built before the first frame.
    ///
    /// # Errors
    /// The framebuffer is too small or too large.
    pub fn new(config: Raster4dConfig) -> Result<Self, Raster4dError> {
        let (least, most) = Self::FRAMEBUFFERS;
        if !(least..=most).contains(&config.framebuffer) {
            return Err(Raster4dError::Framebuffer(config.framebuffer));
        }
        if config.count_relevant && config.shafts {
            return Err(Raster4dError::Relevant);
        }
        Ok(Self {
            config,
            isa: Isa::best(),
            triangles: Vec::new(),
            largest: 0.0,
            sides: Vec::new(),
            stats: VisibilityStats::default(),
            rows: Pool::default(),
            points: Pool::default(),
        })
    }

    /// The same backend with another instruction set: the same answers, for comparison.
    #[must_use]
    pub fn with_isa(self, isa: Isa) -> Self {
        Self { isa, ..self }
    }
}

impl Visibility for Raster4d {
    fn supports(&self, pattern: Pattern) -> Result<(), Unsupported> {
        if Rows::fit(pattern) {
            return Ok(());
        }
        let reason = if pattern.kind == PatternKind::Jittered {
            "samples must lie in rows: use grid or shifted-rows"
        } else {
            "at most 64 rows and 64 columns are possible"
        };
        Err(Unsupported::new("raster4d", pattern, reason))
    }

    fn prepare(&mut self, frame: &Frame) {
        let mesh: &Mesh = &frame.scene.mesh;
        let lights = &frame.scene.lights;
        self.stats = VisibilityStats::default();
        (0..mesh.triangle_count() as u32)
            .into_par_iter()
            .with_min_len(1024)
            .map(|index| Triangle::new(mesh, index))
            .collect_into_vec(&mut self.triangles);
        let (low, high) = mesh.bounds().unwrap_or_default();
        self.largest = low.abs().max(high.abs()).max_element();
        let span = self.config.coarser.then_some(SPAN);
        self.sides.resize_with(lights.len(), || [None, None]);
        for (light, sides) in lights.iter().zip(&mut self.sides) {
            for (side, back) in sides.iter_mut().zip([false, true]) {
                if back && !light.two_sided {
                    continue;
                }
                let cells = side.get_or_insert_with(|| Cells::new(self.config.framebuffer));
                cells.fill(mesh, frame.gbuffer, light, back, span);
                self.stats.entries += cells.entry_count() as u64;
            }
        }
    }

    fn masks(&mut self, frame: &Frame, batch: &mut MaskBatch) {
        let (pattern, words) = (batch.pattern(), batch.words());
        let number = batch.light();
        let light = *frame.light(number);
        if words == 0 || !Rows::fit(pattern) {
            return;
        }
        let (config, isa, triangles, largest) = (self.config, self.isa, &self.triangles[..], self.largest);
        let parts = batch.parts();
        // Without preparation there are no triangles.
        let Some(sides) = self.sides.get(number as usize) else {
            parts.visible.copy_from_slice(parts.wanted);
            return;
        };
        let wanted = parts.wanted.par_chunks(GROUP * words);
        let visible = parts.visible.par_chunks_mut(GROUP * words);
        let chunks = parts.queries.par_chunks(GROUP).zip(wanted).zip(visible);
        let chunk = |((queries, wanted), visible)| Chunk {
            config,
            triangles,
            largest,
            light: &light,
            sides,
            words,
            queries,
            wanted,
            visible,
        };
        self.stats += if config.rows {
            chunks.map(|part| answer(&self.rows, isa, pattern, chunk(part))).sum::<VisibilityStats>()
        } else {
            chunks.map(|part| answer(&self.points, isa, pattern, chunk(part))).sum::<VisibilityStats>()
        };
    }

    fn stats(&self) -> VisibilityStats {
        self.stats
    }

    fn bytes(&self) -> usize {
        self.triangles.capacity() * size_of::<Triangle>()
            + self.sides.iter().flatten().flatten().map(Cells::bytes).sum::<usize>()
    }
}

fn answer<M: Samples>(
    pool: &Pool<Worker<M>>,
    isa: Isa,
    pattern: Pattern,
    chunk: Chunk<'_>,
) -> VisibilityStats {
    let new = || Worker {
        samples: M::new(),
        shared: Shared::default(),
        kept: Shared::default(),
        part: Shared::default(),
        indices: Vec::new(),
    };
    pool.lend(new, |worker| {
        worker.samples.set(pattern, chunk.light);
        isa.run(Answer { chunk, worker })
    })
}

/// Neighbouring queries of a batch.
struct Chunk<'a> {
    config: Raster4dConfig,
    triangles: &'a [Triangle],
    largest: f32,
    light: &'a AreaLight,
    sides: &'a [Option<Cells>; 2],
    words: usize,
    queries: &'a [Query],
    wanted: &'a [u64],
    visible: &'a mut [u64],
}

struct Answer<'a, 'b, M> {
    chunk: Chunk<'a>,
    worker: &'b mut Worker<M>,
}

/// Working memory for one chunk after another.
struct Worker<M> {
    samples: M,
    /// What the cells of all receivers of a chunk hold, without what covers none of them.
    shared: Shared,
    /// Of these, what may hide something from them.
    kept: Shared,
    /// Of these, what may hide something from a quarter of them.
    part: Shared,
    indices: Vec<u32>,
}

/// Triangles that receivers share, with their rectangles.
#[derive(Default)]
struct Shared {
    entries: Entries,
    list: List,
}

impl Shared {
    /// Fills the list by the entries.
    fn fetch(&mut self, triangles: &[Triangle]) {
        self.list.clear();
        for &triangle in &self.entries.triangles {
            self.list.push(&triangles[triangle as usize]);
        }
    }

    /// Becomes what another has in a hull.
    #[inline(always)]
    fn keep<S: Simd>(&mut self, from: &Self, hull: &Hull, indices: &mut Vec<u32>) {
        self.list.keep_indexed::<S>(&from.list, hull, indices);
        self.entries.clear();
        for &slot in indices.iter() {
            self.entries.push(&from.entries, slot as usize);
        }
    }
}

/// Triangles on their way to a receiver, eight at a time.
struct Waiting {
    block: Block,
    count: usize,
}

impl Waiting {
    /// Adds a triangle; false once nothing is left for the receiver to see.
    #[inline(always)]
    fn push<S: Simd>(&mut self, triangle: &Triangle, samples: &mut impl Samples) -> bool {
        self.block.set_lane(self.count, triangle);
        self.count += 1;
        self.count < 8 || self.flush::<S>(samples)
    }

    #[inline(always)]
    fn flush<S: Simd>(&mut self, samples: &mut impl Samples) -> bool {
        self.block.truncate(self.count);
        self.count = 0;
        samples.occlude::<S>(&self.block).is_none() && samples.any()
    }
}

/// A receiver and where it is projected to.
#[derive(Clone, Copy)]
struct Placed {
    query: u8,
    rectangle: Rectangle,
    range: [u16; 4],
}

impl<M: Samples> Kernel for Answer<'_, '_, M> {
    type Output = VisibilityStats;

    #[inline(always)]
    fn run<S: Simd>(self) -> VisibilityStats {
        let Self { mut chunk, worker } = self;
        let mut stats = VisibilityStats::default();
        let mut waiting = Waiting { block: Block::EMPTY, count: 0 };
        let normal = chunk.light.edge_u.cross(chunk.light.edge_v);
        let mut placed = [Placed { query: 0, rectangle: Rectangle::EMPTY, range: [0; 4] }; GROUP];
        for (back, cells) in chunk.sides.iter().enumerate() {
            let mut count = 0;
            for index in 0..chunk.queries.len() {
                let query = chunk.queries[index];
                if usize::from(normal.dot(query.origin - chunk.light.corner) < 0.0) != back {
                    continue;
                }
                let slots = index * chunk.words..(index + 1) * chunk.words;
                if chunk.wanted[slots.clone()].iter().all(|&word| word == 0) {
                    chunk.visible[slots].fill(0);
                    continue;
                }
                let place =
                    cells.as_ref().and_then(|cells| cells.receiver(query.origin, !chunk.config.one_cell));
                if let Some((rectangle, range)) = place {
                    placed[count] = Placed { query: index as u8, rectangle, range };
                    count += 1;
                } else {
                    stats.unprojected += 1;
                    worker.samples.aim::<S>(&query, &chunk.wanted[slots.clone()]);
                    waiting.count = 0;
                    let triangles = chunk.triangles.iter();
                    let mut open = true;
                    for triangle in triangles {
                        open = waiting.push::<S>(triangle, &mut worker.samples);
                        if !open {
                            break;
                        }
                    }
                    if open && waiting.count > 0 {
                        waiting.flush::<S>(&mut worker.samples);
                    }
                    worker.samples.write(&mut chunk.visible[slots]);
                }
            }
            if let (Some(cells), true) = (cells, count > 0) {
                chunk.pair::<S, M>(cells, &placed[..count], worker, &mut waiting, &mut stats);
            }
        }
        stats
    }
}

/// What receivers that are answered together have besides.
struct Party<'a> {
    /// All of their chunk, in the order of their queries.
    placed: &'a [Placed],
    waiting: &'a mut Waiting,
    stats: &'a mut VisibilityStats,
}

/// The receiver of a query.
fn find(placed: &[Placed], query: u8) -> Option<&Placed> {
    placed.binary_search_by_key(&query, |one| one.query).ok().map(|at| &placed[at])
}

impl Chunk<'_> {
    /// Pairs receivers on one side of the light with triangles.
    #[inline(always)]
    fn pair<S: Simd, M: Samples>(
        &mut self,
        cells: &Cells,
        placed: &[Placed],
        worker: &mut Worker<M>,
        waiting: &mut Waiting,
        stats: &mut VisibilityStats,
    ) {
        if !(self.config.one_cell && self.config.rejection && self.config.shafts) {
            for one in placed {
                let rectangle = if self.config.rejection { one.rectangle } else { Rectangle::EMPTY };
                let lists = cells.lists(one.range).map(|(list, _)| list);
                if self.config.count_relevant {
                    let lists = cells.lists(one.range).map(|(list, _)| list);
                    stats.relevant +=
                        self.count_relevant::<S, M>(one, &cells.entries, lists, &mut worker.samples);
                }
                self.answer_one::<S, M>(
                    one,
                    rectangle,
                    &cells.entries,
                    lists,
                    &mut worker.samples,
                    waiting,
                    stats,
                );
            }
            return;
        }
        // Neighbours look into the same few cells. What is in none of their rectangles' way is left out once for all.
        let Worker { samples, shared, kept, part, indices } = worker;
        let mut range = placed[0].range;
        for one in placed {
            for axis in 0..2 {
                range[axis] = range[axis].min(one.range[axis]);
                range[axis + 2] = range[axis + 2].max(one.range[axis + 2]);
            }
        }
        let rectangle = Rectangle::within(placed.iter().map(|one| one.rectangle));
        shared.entries.clear();
        for (list, first) in cells.lists(range) {
            stats.pairs += list.len() as u64;
            S::call(Cover {
                entries: &cells.entries,
                list,
                rectangle,
                task: |slot| {
                    if cells.is_first(slot, first) {
                        shared.entries.push(&cells.entries, slot);
                    }
                    true
                },
            });
        }
        let mut members = [0; GROUP];
        for (member, one) in members.iter_mut().zip(placed) {
            *member = one.query;
        }
        let members = &mut members[..placed.len()];
        let count = shared.entries.triangles.len();
        let party = Party { placed, waiting, stats };
        if count <= MANY {
            let hull = self.hull(members);
            shared.fetch(self.triangles);
            kept.keep::<S>(shared, &hull, indices);
            if kept.list.len() <= SHORT {
                self.answer_all::<S, M>(members, &hull, &kept.list, samples, party);
                return;
            }
        }
        let Party { waiting, stats, .. } = party;
        let mut first = 0;
        for last in quarter(self.queries, members) {
            let members = &members[first..last];
            first = last;
            if members.is_empty() {
                continue;
            }
            let hull = self.hull(members);
            if count <= MANY {
                part.keep::<S>(kept, &hull, indices);
            } else {
                let rectangle = Rectangle::within(
                    members.iter().filter_map(|&member| find(placed, member)).map(|one| one.rectangle),
                );
                kept.entries.clear();
                let entries = &shared.entries;
                let task = |slot| {
                    kept.entries.push(entries, slot);
                    true
                };
                S::call(Cover { entries, list: 0..count, rectangle, task });
                stats.pairs += count as u64;
                if kept.entries.triangles.len() > MANY {
                    let party = Party { placed, waiting, stats };
                    self.answer_each::<S, M>(members, &kept.entries, samples, party);
                    continue;
                }
                kept.fetch(self.triangles);
                part.keep::<S>(kept, &hull, indices);
            }
            let party = Party { placed, waiting, stats };
            if part.list.len() <= SHORT {
                self.answer_all::<S, M>(members, &hull, &part.list, samples, party);
            } else {
                self.answer_each::<S, M>(members, &part.entries, samples, party);
            }
        }
    }

    fn hull(&self, members: &[u8]) -> Hull {
        let (low, high) = bounds(self.queries, members);
        Hull::new(low, high, self.light, self.largest)
    }

    /// Answers receivers from all of a list.
    #[inline(always)]
    fn answer_all<S: Simd, M: Samples>(
        &mut self,
        members: &[u8],
        hull: &Hull,
        list: &List,
        samples: &mut M,
        party: Party<'_>,
    ) {
        let pairs = (members.len() * list.len()) as u64;
        party.stats.pairs += pairs;
        party.stats.kept += pairs;
        S::call(Share {
            samples,
            list,
            hull,
            queries: self.queries,
            wanted: self.wanted,
            visible: self.visible,
            words: self.words,
            members,
            stats: party.stats,
        });
    }

    /// Answers receivers from the entries that cover each.
    #[inline(always)]
    fn answer_each<S: Simd, M: Samples>(
        &mut self,
        members: &[u8],
        entries: &Entries,
        samples: &mut M,
        party: Party<'_>,
    ) {
        for &member in members {
            let Some(one) = find(party.placed, member) else { continue };
            let list = std::iter::once(0..entries.triangles.len());
            self.answer_one::<S, M>(one, one.rectangle, entries, list, samples, party.waiting, party.stats);
        }
    }

    /// Pairs in which the triangle hides a sample that the receiver wants.
    fn count_relevant<S: Simd, M: Samples>(
        &mut self,
        one: &Placed,
        entries: &Entries,
        lists: impl Iterator<Item = Range<usize>>,
        samples: &mut M,
    ) -> u64 {
        let query = usize::from(one.query);
        let slots = query * self.words..(query + 1) * self.words;
        let (wanted, visible) = (&self.wanted[slots.clone()], &mut self.visible[slots]);
        let (mut block, mut count) = (Block::EMPTY, 0);
        for list in lists {
            let task = |slot: usize| {
                samples.aim::<S>(&self.queries[query], wanted);
                block.set_lane(0, &self.triangles[entries.triangles[slot] as usize]);
                samples.occlude::<S>(&block);
                samples.write(visible);
                count += u64::from(visible != wanted);
                true
            };
            S::call(Cover { entries, list, rectangle: one.rectangle, task });
        }
        count
    }

    /// Answers one receiver from entries whose rectangles cover its own.
    #[inline(always)]
    fn answer_one<S: Simd, M: Samples>(
        &mut self,
        one: &Placed,
        rectangle: Rectangle,
        entries: &Entries,
        lists: impl Iterator<Item = Range<usize>>,
        samples: &mut M,
        waiting: &mut Waiting,
        stats: &mut VisibilityStats,
    ) {
        let query = usize::from(one.query);
        let slots = query * self.words..(query + 1) * self.words;
        samples.aim::<S>(&self.queries[query], &self.wanted[slots.clone()]);
        waiting.count = 0;
        let mut open = true;
        for list in lists {
            stats.pairs += list.len() as u64;
            let task = |slot: usize| {
                stats.kept += 1;
                open = waiting.push::<S>(&self.triangles[entries.triangles[slot] as usize], samples);
                open
            };
            if !S::call(Cover { entries, list, rectangle, task }) {
                break;
            }
        }
        if open && waiting.count > 0 {
            waiting.flush::<S>(samples);
        }
        samples.write(&mut self.visible[slots]);
    }
}

/// Does something with every entry of a list whose rectangle covers another, until it returns false.
struct Cover<'a, F> {
    entries: &'a Entries,
    list: Range<usize>,
    rectangle: Rectangle,
    task: F,
}

impl<F: FnMut(usize) -> bool> Kernel for Cover<'_, F> {
    type Output = bool;

    #[inline(always)]
    fn run<S: Simd>(mut self) -> bool {
        let Rectangle { low, high } = self.rectangle;
        let (entries, width) = (self.entries, S::Wide::WIDTH);
        for at in self.list.clone().step_by(width) {
            let count = (self.list.end - at).min(width);
            let mut kept = (1u32 << count) - 1;
            if count == width {
                kept &= S::Wide::load(&entries.low[0][at..]).le(S::Wide::splat(low[0]));
                kept &= S::Wide::load(&entries.low[1][at..]).le(S::Wide::splat(low[1]));
                kept &= S::Wide::splat(high[0]).le(S::Wide::load(&entries.high[0][at..]));
                kept &= S::Wide::splat(high[1]).le(S::Wide::load(&entries.high[1][at..]));
            } else {
                for slot in 0..count {
                    let mut covers = true;
                    for axis in 0..2 {
                        covers &= entries.low[axis][at + slot] <= low[axis];
                        covers &= high[axis] <= entries.high[axis][at + slot];
                    }
                    kept &= !(u32::from(!covers) << slot);
                }
            }
            while kept != 0 {
                let slot = at + kept.trailing_zeros() as usize;
                kept &= kept - 1;
                if !(self.task)(slot) {
                    return false;
                }
            }
        }
        true
    }
}
