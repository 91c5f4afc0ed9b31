//! A group of neighbouring receivers.

use glam::Vec3;
use halflight_core::stats::VisibilityStats;

use super::GROUP;
use super::shaft::{Candidates, Hull};
use crate::bvh::{Child, Chunk, STACK, Shaft, Tracer, push_near_last};
use crate::occluder::Samples;
use crate::simd::{Isa, Kernel, Simd};

/// Queries of one group and room for their answers.
pub(super) type Answers<'a> = Chunk<'a>;

/// Triangles on a list that receivers share. Eight cost a receiver about as much as one step of its own walk.
const LIST: usize = 64;

/// Receivers that share a list at least.
const FEWEST: usize = 8;

/// Blocks of triangles that a receiver looks at before it is left to rays.
const BLOCKS: usize = 16;

/// Working memory for one group after another.
pub(super) struct Groups<M> {
    samples: M,
    candidates: Candidates,
    tracer: Tracer,
    stack: [u32; STACK],
    rest: Vec<u64>,
}

impl<M: Samples> Groups<M> {
    pub(super) fn new() -> Self {
        Self {
            samples: M::new(),
            candidates: Candidates::new(),
            tracer: Tracer::new(),
            stack: [0; STACK],
            rest: Vec::new(),
        }
    }

    /// Answers all queries of a group.
    pub(super) fn answer(&mut self, isa: Isa, answers: Answers<'_>) -> VisibilityStats {
        self.samples.set(answers.pattern, answers.light);
        isa.run(Group { groups: self, answers, stats: VisibilityStats::default() })
    }
}

struct Group<'a, 'b, M> {
    groups: &'b mut Groups<M>,
    answers: Answers<'a>,
    stats: VisibilityStats,
}

impl<M: Samples> Kernel for Group<'_, '_, M> {
    type Output = VisibilityStats;

    #[inline(always)]
    fn run<S: Simd>(mut self) -> VisibilityStats {
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
        // Parts that wait, the next one last: the whole, or its quarters.
        let mut parts = [(0, count); 4];
        let mut waiting = usize::from(count > 0);
        while waiting > 0 {
            waiting -= 1;
            let (first, last) = parts[waiting];
            let part = &mut members[first..last];
            if self.by_list::<S>(part) {
                continue;
            }
            let size = last - first;
            if size == count && size >= 4 * FEWEST {
                let (a, b) = (size / 4, size / 2);
                split(part, self.answers.queries.iter().map(|query| query.origin), b);
                parts[waiting] = (first, first + a);
                parts[waiting + 1] = (first + a, first + b);
                parts[waiting + 2] = (first + b, first + b + a);
                parts[waiting + 3] = (first + b + a, last);
                waiting += 4;
            } else {
                self.one_by_one::<S>(first, last, &members);
            }
        }
        self.stats
    }
}

/// Orders members along the longest side of the box around them, the nearer half of it first.
fn split(members: &mut [u8], origins: impl Iterator<Item = Vec3> + Clone, middle: usize) {
    let mut places = [Vec3::ZERO; GROUP];
    for (place, origin) in places.iter_mut().zip(origins) {
        *place = origin;
    }
    for part in 0..3 {
        // The whole first, then each half.
        let half = match part {
            0 => &mut members[..],
            1 => &mut members[..middle],
            _ => &mut members[middle..],
        };
        let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for &member in half.iter() {
            (low, high) = (low.min(places[usize::from(member)]), high.max(places[usize::from(member)]));
        }
        let axis = (high - low).max_position();
        half.sort_unstable_by(|&a, &b| {
            let key = |member: u8| places[usize::from(member)][axis];
            key(a).total_cmp(&key(b)).then(a.cmp(&b))
        });
    }
}

impl<M: Samples> Group<'_, '_, M> {
    /// Answers from a list that all members share; false where it would be too long or they are too few.
    #[inline(always)]
    fn by_list<S: Simd>(&mut self, members: &[u8]) -> bool {
        if members.len() < FEWEST {
            return false;
        }
        let answers = &mut self.answers;
        let (mut low, mut high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for &member in members {
            let origin = answers.queries[usize::from(member)].origin;
            (low, high) = (low.min(origin), high.max(origin));
        }
        let hull = Hull::new(low, high, answers.light, answers.bvh.largest());
        if !self.groups.candidates.gather::<S>(answers.bvh, &hull, LIST) {
            return false;
        }
        let (words, samples) = (answers.words, &mut self.groups.samples);
        let blocks = self.groups.candidates.blocks();
        let mut proved = if blocks.is_empty() { Some(true) } else { None };
        for (number, &member) in members.iter().enumerate() {
            let query = usize::from(member);
            let slots = query * words..(query + 1) * words;
            let (wanted, visible) = (&answers.wanted[slots.clone()], &mut answers.visible[slots]);
            if let Some(lit) = proved {
                if lit {
                    visible.copy_from_slice(wanted);
                    self.stats.lit += 1;
                } else {
                    visible.fill(0);
                    self.stats.umbra += 1;
                }
                self.stats.spared += wanted.iter().map(|word| u64::from(word.count_ones())).sum::<u64>();
                continue;
            }
            samples.aim(&answers.queries[query], wanted);
            for block in blocks {
                if let Some(lane) = samples.occlude::<S>(block) {
                    // Seldom worth a try where the first member is not in full shadow.
                    if number == 0 && hull.is_covered::<S>(block, lane) {
                        proved = Some(false);
                    }
                    break;
                }
                if !samples.any() {
                    break;
                }
            }
            samples.write(visible);
            self.stats.listed += 1;
        }
        true
    }

    /// Answers each member by a walk of its own.
    #[inline(always)]
    fn one_by_one<S: Simd>(&mut self, first: usize, last: usize, members: &[u8; GROUP]) {
        // Where two in a row met too much, so would the rest.
        let mut dense = 0;
        for &member in &members[first..last] {
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
        samples.aim(&answers.queries[query], &answers.wanted[slots.clone()]);
        let corners = answers.light.corners().map(|corner| corner - origin);
        let low = corners.into_iter().fold(corners[0], Vec3::min);
        let high = corners.into_iter().fold(corners[0], Vec3::max);
        let shaft = Shaft::new(origin, low, high);
        let mut budget = BLOCKS;
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
