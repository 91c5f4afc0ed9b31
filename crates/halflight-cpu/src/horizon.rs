//! Takes samples below the receiver's or the light's horizon out of a batch before it is traced.

use halflight_core::light::AreaLight;
use halflight_core::mask::{MaskBatch, Query};
use halflight_core::pattern::Pattern;
use rayon::prelude::*;

use crate::dispatch::multiversion;
use crate::samples::{LANES, facing, geometry_terms, positions};

/// Rays of a batch after culling.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Culled {
    /// Samples left to trace.
    pub traced: u64,
    /// Samples taken out.
    pub skipped: u64,
}

/// Clears the wanted bits of samples that cannot add light.
pub fn cull(light: &AreaLight, batch: &mut MaskBatch) -> Culled {
    let pattern = batch.pattern();
    let words = batch.words();
    let (queries, wanted, _) = batch.slots_mut();
    queries
        .par_chunks(256)
        .zip(wanted.par_chunks_mut(256 * words))
        .map(|(queries, wanted)| cull_chunk(light, pattern, queries, wanted, words))
        .reduce(Culled::default, |a, b| Culled {
            traced: a.traced + b.traced,
            skipped: a.skipped + b.skipped,
        })
}

multiversion! {
    fn cull_chunk(light: &AreaLight, pattern: Pattern, queries: &[Query], wanted: &mut [u64], words: usize) -> Culled {
        let mut culled = Culled::default();
        let corners = light.corners();
        let light_normal = light.normal();
        for (query, wanted) in queries.iter().zip(wanted.chunks_mut(words)) {
            let asked: u32 = wanted.iter().map(|word| word.count_ones()).sum();
            let above = corners.iter().filter(|&&corner| query.normal.dot(corner - query.origin) > 0.0).count();
            match facing(light, light_normal, query.origin) {
                // Between the corners all of the light is above the horizon if they are, and below if they are.
                Some(_) if above == corners.len() => {}
                Some(facing) if above > 0 => clear_below(light, pattern, query, facing, wanted),
                _ => wanted.fill(0),
            }
            let traced: u32 = wanted.iter().map(|word| word.count_ones()).sum();
            culled.traced += u64::from(traced);
            culled.skipped += u64::from(asked - traced);
        }
        culled
    }
}

#[inline(always)]
fn clear_below(light: &AreaLight, pattern: Pattern, query: &Query, facing: glam::Vec3, wanted: &mut [u64]) {
    for (word, wanted) in wanted.iter_mut().enumerate() {
        for block in 0..64 / LANES {
            if (*wanted >> (block * LANES)) as u16 == 0 {
                continue;
            }
            let positions = positions(light, pattern, query.key, word * 64 + block * LANES);
            let terms = geometry_terms(&positions, query.origin, query.normal, facing);
            let mut lit = 0u64;
            for (lane, &term) in terms.iter().enumerate() {
                lit |= u64::from(term > 0.0) << lane;
            }
            *wanted &= !(0xffff << (block * LANES)) | lit << (block * LANES);
        }
    }
}
