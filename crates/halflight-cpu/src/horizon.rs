//! Takes samples below the receiver's or the light's horizon, and those beside a light that is no parallelogram, out of a batch before it is
//! traced.

use glam::Vec3;
use halflight_core::light::{AreaLight, Extent};
use halflight_core::mask::{MaskBatch, Query};
use halflight_core::pattern::Pattern;
use rayon::prelude::*;

use crate::samples::{LANES, facing, geometry_terms, points};
use crate::simd::{Isa, Kernel, Lanes, Simd};
use crate::vector::Vector;

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
    let isa = Isa::best();
    let (queries, wanted, _) = batch.slots_mut();
    queries
        .par_chunks(256)
        .zip(wanted.par_chunks_mut(256 * words))
        .map(|(queries, wanted)| isa.run(Cull { light, pattern, queries, wanted, words }))
        .reduce(Culled::default, |a, b| Culled {
            traced: a.traced + b.traced,
            skipped: a.skipped + b.skipped,
        })
}

/// Culls some of a batch's queries.
struct Cull<'a> {
    light: &'a AreaLight,
    pattern: Pattern,
    queries: &'a [Query],
    wanted: &'a mut [u64],
    words: usize,
}

impl Kernel for Cull<'_> {
    type Output = Culled;

    #[inline(always)]
    fn run<S: Simd>(self) -> Culled {
        let Self { light, pattern, queries, wanted, words } = self;
        let mut culled = Culled::default();
        let (corners, extent) = (light.corners(), light.extent());
        let light_normal = light.normal();
        for (query, wanted) in queries.iter().zip(wanted.chunks_mut(words)) {
            let asked: u32 = wanted.iter().map(|word| word.count_ones()).sum();
            // Of a sphere every receiver sees another disk; flat lights are as they are.
            let seen = light.seen_from(query.origin);
            let (corners, light_normal) = match light.as_sphere() {
                None => (corners, light_normal),
                Some(_) => (seen.corners(), seen.normal()),
            };
            let light = &*seen;
            let above =
                corners.iter().filter(|&&corner| query.normal.dot(corner - query.origin) > 0.0).count();
            if extent != Extent::Whole {
                clear_beside(&extent, pattern, query, wanted);
            }
            match facing(light, light_normal, query.origin) {
                // Between the corners all of the light is above the horizon if they are, and below if they are.
                Some(_) if above == corners.len() => {}
                Some(facing) if above > 0 => clear_below::<S::Wide>(light, pattern, query, facing, wanted),
                _ => wanted.fill(0),
            }
            let traced: u32 = wanted.iter().map(|word| word.count_ones()).sum();
            culled.traced += u64::from(traced);
            culled.skipped += u64::from(asked - traced);
        }
        culled
    }
}

/// Clears the bits of samples that the light does not contain.
fn clear_beside(extent: &Extent, pattern: Pattern, query: &Query, wanted: &mut [u64]) {
    for (word, wanted) in wanted.iter_mut().enumerate() {
        let mut left = *wanted;
        while left != 0 {
            let bit = left.trailing_zeros() as usize;
            left &= left - 1;
            if !extent.contains(pattern.position(word * 64 + bit, query.key)) {
                *wanted &= !(1 << bit);
            }
        }
    }
}

#[inline(always)]
fn clear_below<L: Lanes>(
    light: &AreaLight,
    pattern: Pattern,
    query: &Query,
    facing: Vec3,
    wanted: &mut [u64],
) {
    let (zero, origin) = (L::splat(0.0), Vector::splat(query.origin));
    for (word, wanted) in wanted.iter_mut().enumerate() {
        for shift in (0..64).step_by(LANES) {
            if (*wanted >> shift) as u16 == 0 {
                continue;
            }
            let mut lit = 0u64;
            for at in (0..LANES).step_by(L::WIDTH) {
                let d = points::<L>(light, pattern, query.key, word * 64 + shift + at).sub(origin);
                lit |= u64::from(zero.lt(geometry_terms(d, query.normal, facing))) << at;
            }
            *wanted &= !(0xffff << shift) | lit << shift;
        }
    }
}
