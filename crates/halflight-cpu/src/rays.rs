//! The `bvh` visibility backend.

use std::ops::Range;
use std::sync::Arc;

use glam::Vec3;
use halflight_core::certificate::{Certificate, Region};
use halflight_core::frame::Frame;
use halflight_core::light::{AreaLight, LightFrame};
use halflight_core::mask::{MaskBatch, Query};
use halflight_core::pattern::Pattern;
use halflight_core::stages::{UnsupportedLight, Visibility};
use rayon::prelude::*;

use crate::bvh::{Bvh, Packet, RAYS, Stacks};
use crate::pool::TASK;
use crate::samples::{LANES, positions};
use crate::shaft::Certifier;
use crate::simd::{Isa, Kernel, Simd};

/// Queries that one task answers: as many as a packet has rays.
const CHUNK: usize = RAYS;

/// Distance of a light up to which rays may start from it, in diagonals of the mesh.
const NEAR: f32 = 4.0;

/// Exact visibility by ray tracing: rays that share a receiver or a light sample are traced as a packet.
#[derive(Clone, Debug)]
pub struct BvhRays {
    bvh: Arc<Bvh>,
    isa: Isa,
    together: bool,
    certifier: Arc<Certifier>,
}

impl BvhRays {
    /// Traces rays in packets, with the widest vectors that the CPU has.
    pub fn new(bvh: Arc<Bvh>) -> Self {
        Self { bvh, isa: Isa::best(), together: true, certifier: Arc::default() }
    }

    /// Traces one ray at a time; the masks are identical. For comparison.
    pub fn single_rays(bvh: Arc<Bvh>) -> Self {
        Self { together: false, ..Self::new(bvh) }
    }

    /// Selects another instruction set; the masks are identical. For comparison.
    #[must_use]
    pub fn with_isa(self, isa: Isa) -> Self {
        Self { isa, ..self }
    }
}

impl Visibility for BvhRays {
    fn supports_light(&self, _light: &AreaLight) -> Result<(), UnsupportedLight> {
        Ok(())
    }

    fn masks(&mut self, frame: &Frame, batch: &mut MaskBatch) {
        let (pattern, words) = (batch.pattern(), batch.words());
        let light = *frame.light(batch.light());
        let parts = batch.parts();
        if words == 0 {
            return;
        }
        if self.bvh.nodes.is_empty() {
            parts.visible.copy_from_slice(parts.wanted);
            return;
        }
        let wanted = parts.wanted.par_chunks(CHUNK * words);
        let visible = parts.visible.par_chunks_mut(CHUNK * words);
        let chunks = parts.queries.par_chunks(CHUNK).zip(wanted).zip(visible).with_max_len(TASK);
        chunks.for_each(|((queries, wanted), visible)| {
            let chunk = Chunk { bvh: &self.bvh, light: &light, pattern, words, queries, wanted, visible };
            if self.together {
                chunk.trace(self.isa);
            } else {
                self.isa.run(Single(chunk));
            }
        });
    }

    fn certify(
        &mut self,
        frame: &Frame,
        light: u32,
        regions: &[Region],
        certificates: &mut Vec<Certificate>,
    ) {
        self.certifier.certify(&self.bvh, frame.light(light), regions, certificates);
    }

    fn bytes(&self) -> usize {
        self.bvh.bytes()
    }
}

/// Consecutive queries of a batch.
pub(crate) struct Chunk<'a> {
    pub(crate) bvh: &'a Bvh,
    pub(crate) light: &'a AreaLight,
    pub(crate) pattern: Pattern,
    pub(crate) words: usize,
    pub(crate) queries: &'a [Query],
    pub(crate) wanted: &'a [u64],
    pub(crate) visible: &'a mut [u64],
}

impl Chunk<'_> {
    /// Answers all queries by packets of rays.
    pub(crate) fn trace(self, isa: Isa) {
        isa.run(Together(self));
    }

    /// Queries from `first` on that share the positions of their light samples; a single query if rays should
    /// not start from the light.
    #[inline(always)]
    fn same_points(&self, first: usize) -> Range<usize> {
        let Query { key, origin, .. } = self.queries[first];
        // Receivers of a sphere light have samples of their own.
        if self.light.as_sphere().is_some() {
            return first..first + 1;
        }
        let LightFrame { origin: corner, u, v } = self.light.frame();
        // Boxes are padded for rays that start on or near the geometry, not for those from a distant light.
        let farthest = (corner - origin).abs() + u.abs() + v.abs();
        if farthest.max_element() > NEAR * self.bvh.diagonal() {
            return first..first + 1;
        }
        let any = self.pattern.ignores_key();
        let count = self.queries[first..].iter().take_while(|query| any || query.key == key).count();
        first..first + count
    }

    /// Fills `packet` with the rays of the wanted samples in one word of a mask, and `bits` with their bit
    /// positions in it. Samples that are close together on the light follow each other where the word holds a
    /// square of them.
    #[inline(always)]
    fn gather<S: Simd>(&self, packet: &mut Packet, bits: &mut [u8; 64], query: usize, word: usize) {
        let wanted = self.wanted[query * self.words + word];
        let Query { origin, key, .. } = self.queries[query];
        let square = self.pattern.columns == 8;
        let order = if square { &SQUARES } else { &IN_ORDER };
        let mut places = [[0.0f32; 64]; 3];
        let light = self.light.seen_from(origin);
        for group in 0..64 / LANES {
            if wanted >> (group * LANES) & ((1 << LANES) - 1) != 0 {
                let sixteen = positions::<S::Wide>(&light, self.pattern, key, word * 64 + group * LANES);
                for (to, from) in places.iter_mut().zip(&sixteen) {
                    to[group * LANES..(group + 1) * LANES].copy_from_slice(from);
                }
            }
        }
        if wanted == u64::MAX {
            *bits = *order;
            for (to, from) in packet.ends_mut().iter_mut().zip(&places) {
                for (to, &first) in to.as_chunks_mut::<4>().0.iter_mut().zip(order.iter().step_by(4)) {
                    to.copy_from_slice(&from[usize::from(first)..usize::from(first) + 4]);
                }
            }
            packet.set_ends::<S>(origin, 64);
            return;
        }
        let mut count = 0;
        for &bit in order {
            if wanted >> bit & 1 != 0 {
                bits[count] = bit;
                for (to, from) in packet.ends_mut().iter_mut().zip(&places) {
                    to[count] = from[usize::from(bit)];
                }
                count += 1;
            }
        }
        packet.set_ends::<S>(origin, count);
    }
}

/// Order of a word's samples: by bit.
const IN_ORDER: [u8; 64] = {
    let mut order = [0; 64];
    let mut at = 0;
    while at < 64 {
        order[at] = at as u8;
        at += 1;
    }
    order
};

/// Order of a word's samples where it holds eight rows and eight columns: blocks of four rows and four
/// columns.
const SQUARES: [u8; 64] = {
    let mut order = [0; 64];
    let mut at = 0;
    while at < 64 {
        let (square, row, column) = (at / 16, at / 4 % 4, at % 4);
        order[at] = (square / 2 * 32 + row * 8 + square % 2 * 4 + column) as u8;
        at += 1;
    }
    order
};

/// Task that traces a chunk in packets of rays that share an end point.
struct Together<'a>(Chunk<'a>);

impl Kernel for Together<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self) {
        let mut chunk = self.0;
        let mut tracer = Tracer::new();
        let mut first = 0;
        while first < chunk.queries.len() {
            let run = chunk.same_points(first);
            first = run.end;
            for word in 0..chunk.words {
                // The grouping that needs fewer packets is taken: 16 receivers that ask for the same 4
                // samples are 4 packets.
                let receivers = run.clone().filter(|query| chunk.wanted[query * chunk.words + word] != 0);
                let (count, samples) = receivers
                    .fold((0, 0), |(n, all), query| (n + 1, all | chunk.wanted[query * chunk.words + word]));
                if samples.count_ones() < count {
                    tracer.trace_points::<S>(&mut chunk, run.clone(), word, samples);
                } else {
                    for query in run.clone() {
                        tracer.trace_receiver::<S>(&mut chunk, query, word);
                    }
                }
            }
        }
    }
}

/// Packet and the traversal stacks to trace it.
pub(crate) struct Tracer {
    packet: Packet,
    /// Sample, or query of a run, that each ray belongs to.
    bits: [u8; 64],
    stacks: Stacks,
}

impl Tracer {
    pub(crate) fn new() -> Self {
        Self { packet: Packet::new(), bits: [0; 64], stacks: Stacks::new() }
    }

    /// Traces all rays of a receiver in one word of its mask.
    #[inline(always)]
    pub(crate) fn trace_receiver<S: Simd>(&mut self, chunk: &mut Chunk<'_>, query: usize, word: usize) {
        let slot = query * chunk.words + word;
        let mut visible = chunk.wanted[slot];
        if visible != 0 {
            chunk.gather::<S>(&mut self.packet, &mut self.bits, query, word);
            let mut occluded = chunk.bvh.occluded::<S>(&self.packet, &mut self.stacks);
            while occluded != 0 {
                visible &= !(1 << self.bits[occluded.trailing_zeros() as usize]);
                occluded &= occluded - 1;
            }
        }
        chunk.visible[slot] = visible;
    }

    /// Traces all rays of a run of receivers that share the positions of `samples`, one sample at a time. A
    /// segment meets the same triangles from either end.
    #[inline(always)]
    fn trace_points<S: Simd>(&mut self, chunk: &mut Chunk<'_>, run: Range<usize>, word: usize, samples: u64) {
        let key = chunk.queries[run.start].key;
        for query in run.clone() {
            let slot = query * chunk.words + word;
            chunk.visible[slot] = chunk.wanted[slot];
        }
        for group in 0..64 / LANES {
            let mut left = samples >> (group * LANES) & ((1 << LANES) - 1);
            if left == 0 {
                continue;
            }
            let places = positions::<S::Wide>(chunk.light, chunk.pattern, key, word * 64 + group * LANES);
            while left != 0 {
                let lane = left.trailing_zeros() as usize;
                left &= left - 1;
                let sample = 1 << (group * LANES + lane);
                let mut count = 0;
                for query in run.clone() {
                    if chunk.wanted[query * chunk.words + word] & sample != 0 {
                        self.bits[count] = (query - run.start) as u8;
                        for (axis, ends) in self.packet.ends_mut().iter_mut().enumerate() {
                            ends[count] = chunk.queries[query].origin[axis];
                        }
                        count += 1;
                    }
                }
                self.packet
                    .set_ends::<S>(Vec3::new(places[0][lane], places[1][lane], places[2][lane]), count);
                let mut occluded = chunk.bvh.occluded::<S>(&self.packet, &mut self.stacks);
                while occluded != 0 {
                    let query = run.start + usize::from(self.bits[occluded.trailing_zeros() as usize]);
                    chunk.visible[query * chunk.words + word] &= !sample;
                    occluded &= occluded - 1;
                }
            }
        }
    }
}

/// Task that traces every ray of a chunk alone.
struct Single<'a>(Chunk<'a>);

impl Kernel for Single<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self) {
        let chunk = self.0;
        let mut packet = Packet::new();
        let mut bits = [0u8; 64];
        let mut stacks = Stacks::new();
        for query in 0..chunk.queries.len() {
            for word in 0..chunk.words {
                let slot = query * chunk.words + word;
                chunk.gather::<S>(&mut packet, &mut bits, query, word);
                let mut visible = chunk.wanted[slot];
                let mut occluded = chunk.bvh.occluded_singly::<S>(&packet, &mut stacks);
                while occluded != 0 {
                    visible &= !(1 << bits[occluded.trailing_zeros() as usize]);
                    occluded &= occluded - 1;
                }
                chunk.visible[slot] = visible;
            }
        }
    }
}
