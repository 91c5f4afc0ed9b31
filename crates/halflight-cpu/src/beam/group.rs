//! Visibility masks of a group of neighbouring receivers.

use glam::Vec3;
use halflight_core::pattern::Pattern;
use halflight_core::stats::VisibilityStats;

use crate::bvh::{Child, RAYS, STACK, Shaft, push_near_last};
use crate::occluder::Samples;
use crate::rays::{Chunk, Tracer};
use crate::shaft::{FEWEST, GROUP, Gather, Hull, List, Share, bounds, quarter};
use crate::simd::{Isa, Kernel, Simd};

/// Queries of one group and their masks.
pub(super) type Answers<'a> = Chunk<'a>;

/// Length of a group's shared triangle list from which on a packet of rays for each receiver is faster. Of
/// 16, 24, 32, 48 and 80, this is the fastest or within 3 % of it in two halls, church, tower, toys and
/// railing; larger values make the railing a quarter slower.
const RIVAL: usize = 32;

/// Amounts of work beyond which a group switches to another method.
#[derive(Clone, Copy)]
struct Limits {
    /// Most triangles on a list that all receivers of a group share. Eight triangles cost a receiver about as
    /// much as one step of its own traversal.
    short: usize,
    /// Most triangles on a list that is divided among quarters of a group.
    whole: usize,
    /// Most triangles on the list of a quarter.
    long: usize,
    /// Most blocks of triangles that a receiver's own traversal tests before rays take over.
    blocks: usize,
    /// True if a group is left to rays as a whole where its list is not short.
    rays: bool,
}

impl Limits {
    /// Limits of `beam`: the cost of rays is proportional to the number of samples, that of masks by rows to
    /// its square root.
    fn new(pattern: Pattern) -> Self {
        let samples = pattern.len();
        let (long, blocks) = (8 * samples.isqrt(), (samples / 8).clamp(8, 256));
        Self { short: 64, whole: 512, long, blocks, rays: false }
    }

    /// Limits of `auto`, which may use rays too. Rays to up to 64 samples form one packet, and cost less than
    /// a list of more than [`RIVAL`] triangles.
    fn or_rays(pattern: Pattern) -> Self {
        let beams = Self::new(pattern);
        if pattern.len() > RAYS {
            return beams;
        }
        Self { short: RIVAL, whole: RIVAL, rays: true, ..beams }
    }
}

/// Working memory that is reused from group to group.
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

    /// Answers all queries of a group; if `rays` is set, groups without a short shared list are answered by
    /// rays.
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
    /// Statistics, and the group if it is left to rays.
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
    /// Shaft from some members to the light.
    fn hull(&self, members: &[u8]) -> Hull {
        let (low, high) = bounds(self.answers.queries, members);
        Hull::new(low, high, self.answers.light, self.answers.bvh.largest())
    }

    /// Answers members from the list of the group or of a quarter of it.
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

    /// Answers each member by its own traversal of the BVH.
    #[inline(always)]
    fn one_by_one<S: Simd>(&mut self, members: &[u8]) {
        // After two consecutive receivers with too many triangles, the rest is assumed to have too many as
        // well.
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

    /// Tests all triangles in the frustum of a receiver and the light. Returns false, with the result so far,
    /// if there are too many.
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

    /// Traces rays to the samples of a mask that are still visible.
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

/// Kernel that traces the rays of one receiver in one word of its mask.
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
