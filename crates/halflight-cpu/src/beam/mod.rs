//! The `beam` visibility backend. One traversal of the BVH finds the triangles that may hide the light for
//! many samples, and for many receivers where they are close together.
//!
//! Receivers form groups of up to 64 neighbours. The shaft of a group and the light (`shaft`) gathers the
//! triangles that may hide the light from any of its receivers; each receiver then computes its mask from
//! these. A group with too many triangles is divided. Its remaining parts traverse the BVH receiver by
//! receiver, with the frustum of the receiver and the light. Where even that contains too many triangles, as
//! in foliage, rays are faster and trace the remaining samples. An empty shaft is a certificate that all
//! receivers are fully lit. A triangle across the whole shaft is a certificate that all are in umbra.
//!
//! `auto` leaves groups whose shaft holds too many triangles to rays as a whole, at the cost of one traversal
//! per group. With up to 64 samples, which form one packet of rays, rays are faster from some ten triangles
//! per row of samples on.

mod group;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use glam::Vec3;
use halflight_core::certificate::{Certificate, Region};
use halflight_core::frame::Frame;
use halflight_core::light::AreaLight;
use halflight_core::mask::{MaskBatch, Query};
use halflight_core::stages::{UnsupportedLight, Visibility};
use halflight_core::stats::VisibilityStats;
use rayon::prelude::*;

use crate::bvh::Bvh;
use crate::occluder::{Points, Rows, Samples};
use crate::pool::{Pool, TASK};
use crate::shaft::{Certifier, GROUP};
use crate::simd::Isa;
use group::{Answers, Groups};

/// Number of queries whose order one task checks.
const SORTED: usize = 4096;

/// Exact visibility by shafts and frusta.
#[derive(Debug)]
pub struct Beam {
    bvh: Arc<Bvh>,
    isa: Isa,
    /// True if groups with many triangles are left to rays.
    rays: bool,
    order: Vec<u64>,
    queries: Vec<Query>,
    wanted: Vec<u64>,
    visible: Vec<u64>,
    stats: VisibilityStats,
    rows: Pool<Groups<Rows>>,
    points: Pool<Groups<Points>>,
    certifier: Certifier,
}

impl Beam {
    /// Creates the `beam` backend over a BVH, with the widest vectors that the CPU has.
    pub fn new(bvh: Arc<Bvh>) -> Self {
        Self {
            bvh,
            isa: Isa::best(),
            rays: false,
            order: Vec::new(),
            queries: Vec::new(),
            wanted: Vec::new(),
            visible: Vec::new(),
            stats: VisibilityStats::default(),
            rows: Pool::default(),
            points: Pool::default(),
            certifier: Certifier::default(),
        }
    }

    /// Creates the `auto` backend: beams or rays, whichever is faster for the number of samples and of
    /// triangles between receivers and light. Both are exact: the masks are identical.
    pub fn or_rays(bvh: Arc<Bvh>) -> Self {
        Self { rays: true, ..Self::new(bvh) }
    }

    /// Selects another instruction set; the masks are identical. For comparison.
    #[must_use]
    pub fn with_isa(self, isa: Isa) -> Self {
        Self { isa, ..self }
    }

    /// Sorts queries so that neighbours in the image follow each other; returns false if they are in order
    /// already.
    fn sort(&mut self, width: u32, batch: &MaskBatch) -> bool {
        let width = width.max(1);
        let queries = batch.queries();
        // Each part includes the first query of the next.
        let parts = (0..queries.len()).into_par_iter().step_by(SORTED);
        if parts.all(|first| follow_tiles(width, &queries[first..(first + SORTED + 1).min(queries.len())])) {
            return false;
        }
        let place = |(index, query): (usize, &Query)| {
            let (x, y) = (query.pixel % width, query.pixel / width);
            (u64::from(spread(x) | spread(y) << 1)) << 32 | index as u64
        };
        self.order.clear();
        self.order.extend(batch.queries().iter().enumerate().map(place));
        self.order.par_sort_unstable();
        true
    }

    /// Answers queries about a sphere, whose disk is another one for every receiver: each by its own frustum, or by rays where these are allowed.
    fn answer_each(&self, light: &AreaLight, batch: &mut MaskBatch) -> VisibilityStats {
        let (bvh, isa, pattern, words) = (&*self.bvh, self.isa, batch.pattern(), batch.words());
        let parts = batch.parts();
        let together = if self.rays { GROUP } else { 1 };
        let masks =
            parts.wanted.par_chunks(together * words).zip(parts.visible.par_chunks_mut(together * words));
        let groups = parts.queries.par_chunks(together).zip(masks).with_max_len(TASK);
        let one = |(queries, (wanted, visible)): (&[Query], (&[u64], &mut [u64]))| {
            let answers = Answers { bvh, light, pattern, words, queries, wanted, visible };
            if self.rays {
                let left_to_rays =
                    wanted.chunks(words).filter(|wanted| wanted.iter().any(|&word| word != 0)).count() as u64;
                answers.trace(isa);
                let mut stats = VisibilityStats::default();
                stats.left_to_rays = left_to_rays;
                return stats;
            }
            let seen = light.seen_from(queries.first().map_or(Vec3::ZERO, |query| query.origin));
            let answers = Answers { light: &seen, ..answers };
            if Rows::fit(pattern) {
                self.rows.lend(Groups::new, |groups| groups.answer(isa, false, answers))
            } else {
                self.points.lend(Groups::new, |groups| groups.answer(isa, false, answers))
            }
        };
        groups.map(one).sum()
    }
}

/// Answers all queries, a group at a time.
fn answer<M: Samples + Send>(
    pool: &Pool<Groups<M>>,
    rays: bool,
    isa: Isa,
    all: Answers<'_>,
) -> VisibilityStats {
    let Answers { bvh, light, pattern, words, queries, wanted, visible } = all;
    let parts = wanted.par_chunks(GROUP * words).zip(visible.par_chunks_mut(GROUP * words));
    let groups = queries.par_chunks(GROUP).zip(parts);
    let one = |(queries, (wanted, visible))| {
        let answers = Answers { bvh, light, pattern, words, queries, wanted, visible };
        pool.lend(Groups::new, |groups| groups.answer(isa, rays, answers))
    };
    groups.with_max_len(TASK).map(one).sum()
}

/// True if queries are ordered tile by tile.
fn follow_tiles(width: u32, queries: &[Query]) -> bool {
    let (mut row, mut start) = (0, 0);
    queries.is_sorted_by_key(|query| {
        // Most pixels lie in the row of the previous one.
        if query.pixel.wrapping_sub(start) >= width {
            row = query.pixel / width;
            start = row * width;
        }
        (row / 8, (query.pixel - start) / 8)
    })
}

/// Spreads the lower 16 bits to every other bit of the result.
fn spread(bits: u32) -> u32 {
    let mut bits = bits & 0xffff;
    for (shift, mask) in [(8, 0x00ff_00ff), (4, 0x0f0f_0f0f), (2, 0x3333_3333), (1, 0x5555_5555)] {
        bits = (bits | bits << shift) & mask;
    }
    bits
}

impl Visibility for Beam {
    fn prepare(&mut self, _frame: &Frame) {
        self.stats = VisibilityStats::default();
    }

    fn masks(&mut self, frame: &Frame, batch: &mut MaskBatch) {
        let words = batch.words();
        if words == 0 {
            return;
        }
        let (pattern, light) = (batch.pattern(), *frame.light(batch.light()));
        if light.as_sphere().is_some() {
            self.stats += self.answer_each(&light, batch);
            return;
        }
        let sorted = self.sort(frame.gbuffer.width, batch);
        let parts = batch.parts();
        if sorted {
            self.queries.clear();
            self.wanted.clear();
            for &at in &self.order {
                let at = at as u32 as usize;
                self.queries.push(parts.queries[at]);
                self.wanted.extend_from_slice(&parts.wanted[at * words..(at + 1) * words]);
            }
            self.visible.clear();
            self.visible.resize(self.wanted.len(), 0);
        }
        let (queries, wanted) =
            if sorted { (&self.queries[..], &self.wanted[..]) } else { (parts.queries, parts.wanted) };
        let visible: &mut [u64] = if sorted { &mut self.visible } else { parts.visible };
        let answers = Answers { bvh: &self.bvh, light: &light, pattern, words, queries, wanted, visible };
        self.stats += if Rows::fit(pattern) {
            answer(&self.rows, self.rays, self.isa, answers)
        } else {
            answer(&self.points, self.rays, self.isa, answers)
        };
        if sorted {
            for (&at, visible) in self.order.iter().zip(self.visible.chunks(words)) {
                let at = at as u32 as usize;
                parts.visible[at * words..(at + 1) * words].copy_from_slice(visible);
            }
        }
    }

    fn supports_light(&self, _light: &AreaLight) -> Result<(), UnsupportedLight> {
        Ok(())
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

    fn stats(&self) -> VisibilityStats {
        self.stats
    }

    fn bytes(&self) -> usize {
        self.bvh.bytes()
            + self.order.capacity() * 8
            + self.queries.capacity() * size_of::<Query>()
            + (self.wanted.capacity() + self.visible.capacity()) * 8
    }
}
