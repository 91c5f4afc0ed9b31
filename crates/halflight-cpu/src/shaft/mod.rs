//! Shaft of neighbouring receivers and the light, with a shared list of the triangles in it.
//!
//! An empty list is a certificate that all receivers see the whole light. A triangle across the whole shaft
//! is a certificate that they see nothing of it.

mod certify;
mod gather;
mod hull;
mod list;

use glam::Vec3;
use halflight_core::mask::Query;
use halflight_core::stats::VisibilityStats;

pub(crate) use certify::Certifier;
pub(crate) use gather::Gather;
pub(crate) use hull::Hull;
pub(crate) use list::List;

use crate::occluder::Samples;
use crate::simd::{Kernel, Simd};

/// Most receivers that share a list.
pub(crate) const GROUP: usize = 64;

/// Fewest receivers that share a list.
pub(crate) const FEWEST: usize = 8;

/// Kernel that computes receivers' masks from a shared list.
pub(crate) struct Share<'a, M> {
    pub(crate) samples: &'a mut M,
    pub(crate) list: &'a List,
    pub(crate) hull: &'a Hull,
    pub(crate) queries: &'a [Query],
    pub(crate) wanted: &'a [u64],
    pub(crate) visible: &'a mut [u64],
    /// Words of a mask.
    pub(crate) words: usize,
    /// Queries to answer: each has wanted samples.
    pub(crate) members: &'a [u8],
    pub(crate) stats: &'a mut VisibilityStats,
}

impl<M: Samples> Kernel for Share<'_, M> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self) {
        let Self { samples, list, hull, queries, wanted, visible, words, members, stats } = self;
        let blocks = list.blocks();
        let mut certified = if blocks.is_empty() { Some(true) } else { None };
        for (number, &member) in members.iter().enumerate() {
            let query = usize::from(member);
            let slots = query * words..(query + 1) * words;
            let (wanted, visible) = (&wanted[slots.clone()], &mut visible[slots]);
            if let Some(lit) = certified {
                if lit {
                    visible.copy_from_slice(wanted);
                    stats.lit += 1;
                } else {
                    visible.fill(0);
                    stats.umbra += 1;
                }
                stats.spared += wanted.iter().map(|word| u64::from(word.count_ones())).sum::<u64>();
                continue;
            }
            samples.aim::<S>(&queries[query], wanted);
            for block in blocks {
                if let Some(lane) = samples.occlude::<S>(block) {
                    // The test rarely succeeds where the first member is not in full shadow.
                    if number == 0 && hull.is_covered::<S>(block, lane) {
                        certified = Some(false);
                    }
                    break;
                }
                if !samples.any() {
                    break;
                }
            }
            samples.write(visible);
            stats.listed += 1;
        }
    }
}

/// Bounding box of the origins of some queries.
pub(crate) fn bounds(queries: &[Query], members: &[u8]) -> (Vec3, Vec3) {
    let mut bounds = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for &member in members {
        let origin = queries[usize::from(member)].origin;
        bounds = (bounds.0.min(origin), bounds.1.max(origin));
    }
    bounds
}

/// Divides members into four spatially coherent quarters, in sequence; returns the end of each.
pub(crate) fn quarter(queries: &[Query], members: &mut [u8]) -> [usize; 4] {
    let (first, middle, last) = (members.len() / 4, members.len() / 2, members.len());
    order(queries, members);
    order(queries, &mut members[..middle]);
    order(queries, &mut members[middle..]);
    [first, middle, middle + (last - middle) / 2, last]
}

/// Sorts members along the longest side of their bounding box.
fn order(queries: &[Query], members: &mut [u8]) {
    let (low, high) = bounds(queries, members);
    let axis = (high - low).max_position();
    members.sort_unstable_by(|&a, &b| {
        let key = |member: u8| queries[usize::from(member)].origin[axis];
        key(a).total_cmp(&key(b)).then(a.cmp(&b))
    });
}
