//! Pairing of neighbouring receivers with the triangles of their cells, and the receivers' masks (STEPs 3 and
//! 5).

use std::ops::Range;

use halflight_core::light::AreaLight;
use halflight_core::mask::Query;
use halflight_core::pattern::Pattern;
use halflight_core::stats::VisibilityStats;

use super::Raster4dConfig;
use super::cells::{Cells, Entries};
use super::cover::Cover;
use super::project::Rectangle;
use crate::occluder::{Block, Samples, Triangle};
use crate::pool::Pool;
use crate::shaft::{GROUP, Hull, List, Share, bounds, quarter};
use crate::simd::{Isa, Kernel, Simd};

/// Most triangles that receivers share without comparing each one's rectangle.
const SHORT: usize = 64;

/// Most triangles that are tested against a shaft. Longer lists are first reduced by the rectangles of fewer
/// receivers.
const MANY: usize = 1024;

/// Answers neighbouring queries.
pub(super) fn answer<M: Samples>(
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
pub(super) struct Chunk<'a> {
    pub(super) config: Raster4dConfig,
    pub(super) triangles: &'a [Triangle],
    pub(super) largest: f32,
    pub(super) light: &'a AreaLight,
    pub(super) sides: &'a [Option<Cells>; 2],
    pub(super) words: usize,
    pub(super) queries: &'a [Query],
    pub(super) wanted: &'a [u64],
    pub(super) visible: &'a mut [u64],
}

struct Answer<'a, 'b, M> {
    chunk: Chunk<'a>,
    worker: &'b mut Worker<M>,
}

/// Working memory that is reused from chunk to chunk.
pub(super) struct Worker<M> {
    samples: M,
    /// Triangles in the cells of all receivers of a chunk, without those whose rectangles cover none of the
    /// receivers.
    shared: Shared,
    /// Triangles of `shared` that may hide samples from the receivers.
    kept: Shared,
    /// Triangles of `kept` that may hide samples from a quarter of the receivers.
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
    /// Fills the list from the entries.
    fn fetch(&mut self, triangles: &[Triangle]) {
        self.list.clear();
        for &triangle in &self.entries.triangles {
            self.list.push(&triangles[triangle as usize]);
        }
    }

    /// Becomes the part of another list that lies in a hull.
    #[inline(always)]
    fn keep<S: Simd>(&mut self, from: &Self, hull: &Hull, indices: &mut Vec<u32>) {
        self.list.keep_indexed::<S>(&from.list, hull, indices);
        self.entries.clear();
        for &slot in indices.iter() {
            self.entries.push(&from.entries, slot as usize);
        }
    }
}

/// Buffer of up to eight triangles to be tested against a receiver.
struct Waiting {
    block: Block,
    count: usize,
}

impl Waiting {
    /// Adds a triangle; returns false once no sample of the receiver is left.
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

/// Receiver and its projection.
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
        let mut placed = [Placed { query: 0, rectangle: Rectangle::EMPTY, range: [0; 4] }; GROUP];
        for (back, cells) in chunk.sides.iter().enumerate() {
            let mut count = 0;
            for index in 0..chunk.queries.len() {
                let query = chunk.queries[index];
                if usize::from(chunk.light.side(query.origin) < 0.0) != back {
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

/// State that receivers of one chunk share.
struct Party<'a> {
    /// All receivers of the chunk, in the order of their queries.
    placed: &'a [Placed],
    waiting: &'a mut Waiting,
    stats: &'a mut VisibilityStats,
}

/// Receiver of a query.
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
        // Neighbours share the same few cells. Triangles whose rectangles cover none of the receivers are
        // dropped once for all.
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

    /// Answers receivers from all triangles of a list.
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

    /// Answers each receiver from the entries that cover it.
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

    /// Counts the pairs in which the triangle hides a sample that the receiver wants.
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

    /// Answers one receiver from the entries whose rectangles cover its own.
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
