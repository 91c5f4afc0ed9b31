//! Light samples that alpha-masked triangles hide, of those that a visibility backend has left visible.
//!
//! Backends answer for the other triangles ([`Bvh`] keeps the two apart), so that they know nothing of masks and
//! agree bit for bit.

#[cfg(test)]
mod tests;

use glam::Vec3;
use halflight_core::certificate::{Certificate, Region};
use halflight_core::frame::Frame;
use halflight_core::light::AreaLight;
use halflight_core::mask::{MaskBatch, Query};
use halflight_core::pattern::Pattern;
use halflight_core::scene::Mesh;
use rayon::prelude::*;

use crate::bvh::{Bvh, STACK};
use crate::pool::{Pool, TASK};
use crate::samples::{LANES, positions};
use crate::shaft::{GROUP, Gather, Hull, List, bounds};
use crate::simd::{Isa, Kernel, Simd};

/// Most triangles that are collected to find out whether there are any in a shaft.
const MOST: usize = 16;

/// Removes visible samples that alpha-masked triangles hide. `masked` is the BVH over these.
pub(crate) fn hide(masked: &Bvh, frame: &Frame, batch: &mut MaskBatch) {
    let (pattern, words) = (batch.pattern(), batch.words());
    if words == 0 {
        return;
    }
    let (light, mesh) = (frame.light(batch.light()), &frame.scene.mesh);
    // Receivers share a shaft to a light of which all see the same.
    let group = if light.as_sphere().is_some() { 1 } else { GROUP };
    let parts = batch.parts();
    let wanted = parts.wanted.par_chunks(group * words);
    let visible = parts.visible.par_chunks_mut(group * words);
    let groups = parts.queries.par_chunks(group).zip(wanted).zip(visible).with_max_len(TASK);
    let (isa, pool) = (Isa::best(), Pool::default());
    groups.for_each(|((queries, wanted), visible)| {
        let light = &*light.seen_from(queries.first().map_or(Vec3::ZERO, |query| query.origin));
        pool.lend(Work::default, |work| {
            isa.run(Group { work, masked, mesh, light, pattern, words, queries, wanted, visible });
        });
    });
}

/// Withdraws certificates of regions that an alpha-masked triangle may hide part of the light from.
pub(crate) fn withdraw(
    masked: &Bvh,
    light: &AreaLight,
    regions: &[Region],
    certificates: &mut [Certificate],
) {
    let (isa, pool) = (Isa::best(), Pool::default());
    let pairs = regions.par_iter().zip(certificates).with_min_len(16);
    pairs.filter(|(_, certificate)| !matches!(certificate, Certificate::Umbra | Certificate::Open)).for_each(
        |(region, certificate)| {
            let finite = region.low.is_finite() && region.high.is_finite();
            let clear = finite
                && pool.lend(Work::default, |work| {
                    let hull = Hull::new(region.low, region.high, light, masked.largest());
                    isa.run(Clear { work, masked, hull: &hull })
                });
            if !clear {
                *certificate = Certificate::Open;
            }
        },
    );
}

/// Working memory that is reused from task to task.
#[derive(Default)]
struct Work {
    list: List,
    waiting: Vec<u32>,
    members: Vec<u8>,
}

/// Test that no alpha-masked triangle lies in a shaft.
struct Clear<'a> {
    work: &'a mut Work,
    masked: &'a Bvh,
    hull: &'a Hull,
}

impl Kernel for Clear<'_> {
    type Output = bool;

    #[inline(always)]
    fn run<S: Simd>(self) -> bool {
        let Self { work: Work { list, waiting, .. }, masked, hull } = self;
        S::call(Gather { list, waiting, bvh: masked, hull, most: MOST }) && list.len() == 0
    }
}

/// Neighbouring queries of a batch.
struct Group<'a> {
    work: &'a mut Work,
    masked: &'a Bvh,
    mesh: &'a Mesh,
    light: &'a AreaLight,
    pattern: Pattern,
    words: usize,
    queries: &'a [Query],
    wanted: &'a [u64],
    visible: &'a mut [u64],
}

impl Kernel for Group<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self) {
        let Self { work, masked, mesh, light, pattern, words, queries, wanted, visible } = self;
        let slots = |query: usize| query * words..(query + 1) * words;
        work.members.clear();
        work.members.extend((0..queries.len() as u8).filter(|&query| {
            let slots = slots(usize::from(query));
            wanted[slots.clone()].iter().zip(&visible[slots]).any(|(wanted, visible)| wanted & visible != 0)
        }));
        if work.members.is_empty() {
            return;
        }
        let (low, high) = bounds(queries, &work.members);
        let hull = Hull::new(low, high, light, masked.largest());
        if S::call(Clear { work, masked, hull: &hull }) {
            return;
        }
        let mut stack = [0; STACK];
        for &query in &work.members {
            let (query, slots) = (&queries[usize::from(query)], slots(usize::from(query)));
            for (word, visible) in visible[slots.clone()].iter_mut().enumerate() {
                let left = *visible & wanted[slots.start + word];
                for first in (0..64).step_by(LANES) {
                    let mut left = left >> first & ((1 << LANES) - 1);
                    if left == 0 {
                        continue;
                    }
                    let ends = positions::<S::Wide>(light, pattern, query.key, word * 64 + first);
                    while left != 0 {
                        let lane = left.trailing_zeros() as usize;
                        left &= left - 1;
                        let end = Vec3::from_array(ends.map(|axis| axis[lane]));
                        if masked.occludes_solidly::<S>(mesh, query.origin, end, &mut stack) {
                            *visible &= !(1 << (first + lane));
                        }
                    }
                }
            }
        }
    }
}
