//! What neighbouring receivers share: one shaft to the light, and a list of the triangles in it.
//!
//! An empty list proves that all of them see all of the light, and a triangle across the whole shaft that they see
//! nothing.

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

/// Receivers that may share a list at most.
pub(crate) const GROUP: usize = 64;

/// Receivers that share a list at least.
pub(crate) const FEWEST: usize = 8;

/// Gives receivers their masks from a list that they share.
pub(crate) struct Share<'a, M> {
    pub(crate) samples: &'a mut M,
    pub(crate) list: &'a List,
    pub(crate) hull: &'a Hull,
    pub(crate) queries: &'a [Query],
    pub(crate) wanted: &'a [u64],
    pub(crate) visible: &'a mut [u64],
    /// Words of a mask.
    pub(crate) words: usize,
    /// Which queries: each wants something.
    pub(crate) members: &'a [u8],
    pub(crate) stats: &'a mut VisibilityStats,
}

impl<M: Samples> Kernel for Share<'_, M> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self) {
        let Self { samples, list, hull, queries, wanted, visible, words, members, stats } = self;
        let blocks = list.blocks();
        let mut proved = if blocks.is_empty() { Some(true) } else { None };
        for (number, &member) in members.iter().enumerate() {
            let query = usize::from(member);
            let slots = query * words..(query + 1) * words;
            let (wanted, visible) = (&wanted[slots.clone()], &mut visible[slots]);
            if let Some(lit) = proved {
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
            stats.listed += 1;
        }
    }
}

/// The box around the origins of some queries.
pub(crate) fn bounds(queries: &[Query], members: &[u8]) -> (Vec3, Vec3) {
    let mut bounds = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    for &member in members {
        let origin = queries[usize::from(member)].origin;
        bounds = (bounds.0.min(origin), bounds.1.max(origin));
    }
    bounds
}

/// Parts members into quarters that lie closer together, each one after the one before: where each ends.
pub(crate) fn quarter(queries: &[Query], members: &mut [u8]) -> [usize; 4] {
    let (first, middle, last) = (members.len() / 4, members.len() / 2, members.len());
    order(queries, members);
    order(queries, &mut members[..middle]);
    order(queries, &mut members[middle..]);
    [first, middle, middle + (last - middle) / 2, last]
}

/// Orders members along the longest side of the box around them.
fn order(queries: &[Query], members: &mut [u8]) {
    let (low, high) = bounds(queries, members);
    let axis = (high - low).max_position();
    members.sort_unstable_by(|&a, &b| {
        let key = |member: u8| queries[usize::from(member)].origin[axis];
        key(a).total_cmp(&key(b)).then(a.cmp(&b))
    });
}
