//! The `bvh` visibility backend.

use std::sync::Arc;

use glam::Vec3;
use halflight_core::frame::Frame;
use halflight_core::light::AreaLight;
use halflight_core::mask::{MaskBatch, Query};
use halflight_core::pattern::Pattern;
use halflight_core::stages::Visibility;
use rayon::prelude::*;

use super::Bvh;
use super::bundle::Bundle;
use super::stack::Stacks;
use crate::samples::{LANES, positions};
use crate::simd::{Isa, Kernel, Simd};

/// Queries that one task answers.
const CHUNK: usize = 64;

/// Exact visibility by ray tracing: all rays of a receiver travel together.
#[derive(Clone, Debug)]
pub struct BvhRays {
    bvh: Arc<Bvh>,
    isa: Isa,
    together: bool,
}

impl BvhRays {
    /// Rays in bundles, with the widest vectors that the processor has.
    pub fn new(bvh: Arc<Bvh>) -> Self {
        Self { bvh, isa: Isa::best(), together: true }
    }

    /// One ray at a time: the same answers, for comparison.
    pub fn single_rays(bvh: Arc<Bvh>) -> Self {
        Self { together: false, ..Self::new(bvh) }
    }

    /// The same backend with another instruction set: the same answers, for comparison.
    #[must_use]
    pub fn with_isa(self, isa: Isa) -> Self {
        Self { isa, ..self }
    }
}

impl Visibility for BvhRays {
    fn masks(&mut self, frame: &Frame, batch: &mut MaskBatch) {
        let (pattern, words) = (batch.pattern(), batch.words());
        let light = *frame.light(batch.light());
        let parts = batch.parts();
        if words == 0 {
            return;
        }
        if self.bvh.triangle_count() == 0 {
            parts.visible.copy_from_slice(parts.wanted);
            return;
        }
        let wanted = parts.wanted.par_chunks(CHUNK * words);
        let visible = parts.visible.par_chunks_mut(CHUNK * words);
        parts.queries.par_chunks(CHUNK).zip(wanted).zip(visible).for_each(|((queries, wanted), visible)| {
            let chunk = Chunk { bvh: &self.bvh, light: &light, pattern, words, queries, wanted, visible };
            if self.together {
                self.isa.run(Together(chunk));
            } else {
                self.isa.run(Single(chunk));
            }
        });
    }

    fn bytes(&self) -> usize {
        self.bvh.bytes()
    }
}

/// Neighbouring queries of a batch.
struct Chunk<'a> {
    bvh: &'a Bvh,
    light: &'a AreaLight,
    pattern: Pattern,
    words: usize,
    queries: &'a [Query],
    wanted: &'a [u64],
    visible: &'a mut [u64],
}

impl Chunk<'_> {
    /// Fills `bundle` with the rays of the wanted samples in one word of a mask, and `bits` with their places in it.
    #[inline(always)]
    fn gather<S: Simd>(&self, bundle: &mut Bundle, bits: &mut [u8; 64], query: usize, word: usize) {
        let wanted = self.wanted[query * self.words + word];
        let Query { origin, key, .. } = self.queries[query];
        bundle.clear(origin);
        for group in 0..64 / LANES {
            let mut left = wanted >> (group * LANES) & ((1 << LANES) - 1);
            if left == 0 {
                continue;
            }
            let places = positions(self.light, self.pattern, key, word * 64 + group * LANES);
            while left != 0 {
                let lane = left.trailing_zeros() as usize;
                left &= left - 1;
                bits[bundle.count()] = (group * LANES + lane) as u8;
                bundle.push_end(Vec3::new(places[0][lane], places[1][lane], places[2][lane]));
            }
        }
        bundle.finish::<S>();
    }
}

/// A chunk with all rays of a receiver in bundles of 64.
struct Together<'a>(Chunk<'a>);

impl Kernel for Together<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self) {
        let chunk = self.0;
        let mut bundle = Bundle::new();
        let mut bits = [0u8; 64];
        let mut stacks = Stacks::new();
        for query in 0..chunk.queries.len() {
            for word in 0..chunk.words {
                let slot = query * chunk.words + word;
                let wanted = chunk.wanted[slot];
                if wanted == 0 {
                    chunk.visible[slot] = 0;
                    continue;
                }
                chunk.gather::<S>(&mut bundle, &mut bits, query, word);
                let mut occluded = chunk.bvh.occluded::<S>(&bundle, &mut stacks);
                let mut visible = wanted;
                while occluded != 0 {
                    visible &= !(1 << bits[occluded.trailing_zeros() as usize]);
                    occluded &= occluded - 1;
                }
                chunk.visible[slot] = visible;
            }
        }
    }
}

/// A chunk with every ray by itself.
struct Single<'a>(Chunk<'a>);

impl Kernel for Single<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self) {
        let chunk = self.0;
        let mut bundle = Bundle::new();
        let mut bits = [0u8; 64];
        let mut stacks = Stacks::new();
        for query in 0..chunk.queries.len() {
            for word in 0..chunk.words {
                let slot = query * chunk.words + word;
                chunk.gather::<S>(&mut bundle, &mut bits, query, word);
                let mut visible = chunk.wanted[slot];
                for (ray, &bit) in bits[..bundle.count()].iter().enumerate() {
                    if chunk.bvh.occludes::<S>(0, bundle.origin(), bundle.end(ray), &mut stacks.single) {
                        visible &= !(1 << bit);
                    }
                }
                chunk.visible[slot] = visible;
            }
        }
    }
}
