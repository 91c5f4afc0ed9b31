//! Primary rays: the nearest hits of a bundle.

use super::Bvh;
use super::bundle::{Bundle, RAYS};
use super::layout::Child;
use super::slab::Shaft;
use super::stack::{STACK, push_sorted};
use crate::occluder::{Block, Planes, Vector};
use crate::simd::{Lanes, Simd};

/// The nearest hit of every ray of a bundle.
pub(crate) struct Hits {
    /// Ray parameter; infinite for a miss.
    pub(crate) t: [f32; RAYS],
    /// Triangle; `u32::MAX` for a miss.
    pub(crate) triangle: [u32; RAYS],
}

impl Hits {
    pub(crate) fn new() -> Self {
        Self { t: [f32::INFINITY; RAYS], triangle: [u32::MAX; RAYS] }
    }
}

/// The largest of the first `count` numbers, none of them negative.
#[inline(always)]
fn farthest<L: Lanes>(t: &[f32; RAYS], count: usize) -> f32 {
    let mut most = L::splat(0.0);
    for at in (0..count).step_by(L::WIDTH) {
        most = most.max(L::load(&t[at..]));
    }
    let mut lanes = [0.0f32; 16];
    most.store(&mut lanes);
    let mut most = 0.0f32;
    for lane in lanes {
        most = most.max(lane);
    }
    most
}

impl Bvh {
    /// The nearest triangle that each ray of a finished bundle meets at t > 0; of several at the same t the one with
    /// the lowest index.
    #[inline(always)]
    pub(crate) fn nearest<S: Simd>(&self, bundle: &Bundle, stack: &mut [(u32, f32); STACK], hits: &mut Hits) {
        *hits = Hits::new();
        if self.nodes.is_empty() || bundle.count == 0 {
            return;
        }
        let shaft = Shaft::new(bundle.origin, bundle.low, bundle.high);
        let mut end = f32::INFINITY;
        stack[0] = (0, 0.0);
        let mut waiting = 1;
        while waiting > 0 {
            waiting -= 1;
            let (child, enter) = stack[waiting];
            if enter > end {
                continue;
            }
            match Child::decode(child) {
                Child::Node(index) => {
                    let node = &self.nodes[index as usize];
                    let (low, high) = node.bounds::<S::Eight>();
                    let (mask, enter) = shaft.enters(low, high, end);
                    waiting = push_sorted(node, mask & node.occupied(), enter, stack, waiting);
                }
                Child::Block(index) => {
                    if self.nearest_in_block::<S>(&self.blocks[index as usize], bundle, &shaft, hits) {
                        end = farthest::<S::Wide>(&hits.t, bundle.count);
                    }
                }
            }
        }
    }

    /// Whether any ray found a nearer hit in a block. Rays within rounding of an edge hit both its triangles, so that
    /// none passes between them.
    #[inline(always)]
    fn nearest_in_block<S: Simd>(
        &self,
        block: &Block,
        bundle: &Bundle,
        shaft: &Shaft,
        nearest: &mut Hits,
    ) -> bool {
        let mut planes = Planes::new();
        let mut within = shaft.within::<S>(block, false, &mut planes);
        let width = S::Wide::WIDTH;
        let mut found = false;
        while within != 0 {
            let lane = within.trailing_zeros() as usize;
            within &= within - 1;
            let facet = planes.facet::<S::Wide>(lane);
            for at in (0..bundle.count).step_by(width) {
                let best = S::Wide::load(&nearest.t[at..]);
                let (hits, t) = facet.nearest(Vector::load(&bundle.d, at), best);
                if hits == 0 {
                    continue;
                }
                found = true;
                let closer = hits & t.lt(best);
                best.select(closer, t).store(&mut nearest.t[at..]);
                let mut left = hits;
                while left != 0 {
                    let slot = left.trailing_zeros();
                    left &= left - 1;
                    let triangle = &mut nearest.triangle[at + slot as usize];
                    if closer >> slot & 1 == 1 || block.triangle(lane) < *triangle {
                        *triangle = block.triangle(lane);
                    }
                }
            }
        }
        found
    }
}
