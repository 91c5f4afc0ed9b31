//! A group of neighbouring receivers.

use glam::Vec3;
use halflight_core::pattern::Pattern;
use halflight_core::stats::VisibilityStats;

use crate::bvh::{Child, Chunk, RAYS, STACK, Shaft, Tracer, push_near_last};
use crate::occluder::Samples;
use crate::shaft::{FEWEST, GROUP, Gather, Hull, List, Share, bounds, quarter};
use crate::simd::{Isa, Kernel, Simd};

/// Queries of one group and room for their answers.
pub(super) type Answers<'a> = Chunk<'a>;

/// Triangles on a list that a group shares from which on a packet of rays for each receiver is quicker. Of 16, 24, 32, 48 and 80
/// the best or within 3 % of it in two halls, church, tower, toys and railing; more make the railing a quarter slower.
const RIVAL: usize = 32;

/// How much is looked at before another way is taken.
#[derive(Clone, Copy)]
struct Limits {
    /// Triangles on a list that all receivers of a group share. Eight cost a receiver about as much as one step of its
    /// own walk.
    short: usize,
    /// Triangles on a list that is shared out to quarters of a group.
    whole: usize,
    /// Triangles on the list of a quarter.
    long: usize,
    /// Blocks of triangles that a receiver looks at before it is left to rays.
    blocks: usize,
    /// Whether a group is left to rays as a whole where its list is not short.
    rays: bool,
}

impl Limits {
    /// Rays cost as much as there are samples, rows of masks as much as its square root.
    fn new(pattern: Pattern) -> Self {
        let samples = pattern.len();
        let (long, blocks) = (8 * samples.isqrt(), (samples / 8).clamp(8, 256));
        Self { short: 64, whole: 512, long, blocks, rays: false }
    }

    /// Where rays may answer too. Those of up to 64 samples travel as one packet, and cost less than a list of more than
    /// [`RIVAL`] triangles.
    fn or_rays(pattern: Pattern) -> Self {
        let beams = Self::new(pattern);
        if pattern.len() > RAYS {
            return beams;
        }
        Self { short: RIVAL, whole: RIVAL, rays: true, ..beams }
    }
}

/// Working memory for one group after another.
pub(super) struct Groups<M> {
    samples: M,
    list: List,
    part: List,
    waiting: Vec<u32>,
    tracer: Tracer,
    stack: [u32; STACK],
    rest: Vec<u64>,
}

impl<M: Samples> Groups<M> {
    pub(super) fn new() -> Self {
        Self {
            samples: M::new(),
            list: List::default(),
            part: List::default(),
            waiting: Vec::new(),
            tracer: Tracer::new(),
            stack: [0; STACK],
            rest: Vec::new(),
        }
    }

    /// Answers all queries of a group, those that share no short list by rays if `rays` says so.
    pub(super) fn answer(&mut self, isa: Isa, rays: bool, answers: Answers<'_>) -> VisibilityStats {
        self.samples.set(answers.pattern, answers.light);
        let limits = if rays { Limits::or_rays(answers.pattern) } else { Limits::new(answers.pattern) };
        let group = Group { groups: self, answers, limits, stats: VisibilityStats::default() };
        let (stats, left) = isa.run(group);
        if let Some(left) = left {
            left.trace(isa);
        }
        stats
    }
}

struct Group<'a, 'b, M> {
    groups: &'b mut Groups<M>,
    answers: Answers<'a>,
    limits: Limits,
    stats: VisibilityStats,
}

impl<'a, M: Samples> Kernel for Group<'a, '_, M> {
    /// And the group, where it is left to rays.
    type Output = (VisibilityStats, Option<Answers<'a>>);

    #[inline(always)]
    fn run<S: Simd>(mut self) -> Self::Output {
        let words = self.answers.words;
        let mut members = [0u8; GROUP];
        let mut count = 0;
        for query in 0..self.answers.queries.len() {
            let slots = query * words..(query + 1) * words;
            if self.answers.wanted[slots.clone()].iter().all(|&word| word == 0) {
                self.answers.visible[slots].fill(0);
            } else {
                members[count] = query as u8;
                count += 1;
            }
        }
        let members = &mut members[..count];
        if members.is_empty() {
            return (self.stats, None);
        }
        if members.len() < FEWEST && !self.limits.rays {
            self.one_by_one::<S>(members);
            return (self.stats, None);
        }
        let hull = self.hull(members);
        let Groups { list, waiting, .. } = &mut *self.groups;
        let bvh = self.answers.bvh;
        let known = S::call(Gather { list, waiting, bvh, hull: &hull, most: self.limits.whole });
        if known && list.len() <= self.limits.short {
            self.share::<S>(&hull, members, false);
            return (self.stats, None);
        }
        if self.limits.rays {
            self.stats.left_to_rays += members.len() as u64;
            return (self.stats, Some(self.answers));
        }
        if members.len() < 4 * FEWEST {
            if known && list.len() <= self.limits.long {
                self.share::<S>(&hull, members, false);
            } else {
                self.one_by_one::<S>(members);
            }
            return (self.stats, None);
        }
        let mut first = 0;
        for last in quarter(self.answers.queries, members) {
            let members = &members[first..last];
            first = last;
            let hull = self.hull(members);
            let Groups { list, part, waiting, .. } = &mut *self.groups;
            let listed = if known {
                part.keep::<S>(list, &hull);
                part.len() <= self.limits.long
            } else {
                S::call(Gather { list: part, waiting, bvh, hull: &hull, most: self.limits.long })
            };
            if listed {
                self.share::<S>(&hull, members, true);
            } else {
                self.one_by_one::<S>(members);
            }
        }
        (self.stats, None)
    }
}

impl<M: Samples> Group<'_, '_, M> {
    /// The shaft from members to the light.
    fn hull(&self, members: &[u8]) -> Hull {
        let (low, high) = bounds(self.answers.queries, members);
        Hull::new(low, high, self.answers.light, self.answers.bvh.largest())
    }

    /// Answers members from the list of the group or of a part of it.
    #[inline(always)]
    fn share<S: Simd>(&mut self, hull: &Hull, members: &[u8], part: bool) {
        let Groups { samples, list: whole, part: some, .. } = &mut *self.groups;
        let Chunk { queries, wanted, visible, words, .. } = &mut self.answers;
        S::call(Share {
            samples,
            list: if part { some } else { whole },
            hull,
            queries,
            wanted,
            visible,
            words: *words,
            members,
            stats: &mut self.stats,
        });
    }

    /// Answers each member by a walk of its own.
    #[inline(always)]
    fn one_by_one<S: Simd>(&mut self, members: &[u8]) {
        // Where two in a row met too much, so would the rest.
        let mut dense = 0;
        for &member in members {
            let query = usize::from(member);
            if dense < 2 && self.walk::<S>(query) {
                self.stats.walked += 1;
                dense = 0;
                continue;
            }
            if dense >= 2 {
                let words = self.answers.words;
                let slots = query * words..(query + 1) * words;
                self.answers.visible[slots.clone()].copy_from_slice(&self.answers.wanted[slots]);
            }
            dense += 1;
            self.stats.left_to_rays += 1;
            self.trace_rest::<S>(query);
        }
    }

    /// Looks at all triangles in the pyramid from a receiver to the light; false, with what it found so far, where they
    /// are too many.
    #[inline(always)]
    fn walk<S: Simd>(&mut self, query: usize) -> bool {
        let answers = &mut self.answers;
        let Groups { samples, stack, .. } = &mut *self.groups;
        let (words, origin) = (answers.words, answers.queries[query].origin);
        let slots = query * words..(query + 1) * words;
        samples.aim::<S>(&answers.queries[query], &answers.wanted[slots.clone()]);
        let corners = answers.light.corners().map(|corner| corner - origin);
        let low = corners.into_iter().fold(corners[0], Vec3::min);
        let high = corners.into_iter().fold(corners[0], Vec3::max);
        let shaft = Shaft::new(origin, low, high);
        let mut budget = self.limits.blocks;
        stack[0] = 0;
        let mut waiting = usize::from(!answers.bvh.nodes.is_empty());
        while waiting > 0 {
            waiting -= 1;
            match Child::decode(stack[waiting]) {
                Child::Node(index) => {
                    let node = &answers.bvh.nodes[index as usize];
                    let (low, high) = node.bounds::<S::Eight>();
                    let (mask, enter) = shaft.enters(low, high, 1.0);
                    waiting = push_near_last(node, mask & node.occupied(), enter, stack, waiting);
                }
                Child::Block(index) => {
                    if budget == 0 {
                        samples.write(&mut answers.visible[slots]);
                        return false;
                    }
                    budget -= 1;
                    let all = samples.occlude::<S>(&answers.bvh.blocks[index as usize]).is_some();
                    if all || !samples.any() {
                        break;
                    }
                }
            }
        }
        samples.write(&mut answers.visible[slots]);
        true
    }

    /// Traces what is left visible of a mask.
    #[inline(always)]
    fn trace_rest<S: Simd>(&mut self, query: usize) {
        let Groups { tracer, rest, .. } = &mut *self.groups;
        let answers = &mut self.answers;
        let slots = query * answers.words..(query + 1) * answers.words;
        rest.clear();
        rest.extend_from_slice(&answers.visible[slots.clone()]);
        let mut chunk = Chunk {
            queries: &answers.queries[query..=query],
            wanted: rest,
            visible: &mut answers.visible[slots],
            ..*answers
        };
        for word in 0..chunk.words {
            S::call(Trace { tracer: &mut *tracer, chunk: &mut chunk, word });
        }
    }
}

/// The rays of one receiver in one word of its mask.
struct Trace<'a, 'b> {
    tracer: &'a mut Tracer,
    chunk: &'a mut Chunk<'b>,
    word: usize,
}

impl Kernel for Trace<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self) {
        self.tracer.trace_receiver::<S>(self.chunk, 0, self.word);
    }
}
