//! Collection of the triangles in a shaft.

use super::{Hull, List};
use crate::bvh::{Bvh, Child};
use crate::simd::{Kernel, Simd};

/// Kernel that gathers all triangles in a hull that may hide the light; returns false if there are more than
/// `most`.
pub(crate) struct Gather<'a> {
    pub(crate) list: &'a mut List,
    pub(crate) waiting: &'a mut Vec<u32>,
    pub(crate) bvh: &'a Bvh,
    pub(crate) hull: &'a Hull,
    pub(crate) most: usize,
}

impl Kernel for Gather<'_> {
    type Output = bool;

    #[inline(always)]
    fn run<S: Simd>(self) -> bool {
        let Self { list, waiting, bvh, hull, most } = self;
        list.clear();
        waiting.clear();
        if !bvh.nodes.is_empty() {
            waiting.push(0);
        }
        // Traversal is also given up when it visits many more boxes than the list may have triangles.
        let mut visits = 4 * most;
        while let Some(child) = waiting.pop() {
            match Child::decode(child) {
                Child::Node(index) => {
                    visits -= 1;
                    if visits == 0 {
                        return false;
                    }
                    let node = &bvh.nodes[index as usize];
                    let (low, high) = node.bounds::<S::Eight>();
                    let mut reached = hull.reaches(low, high) & node.occupied();
                    while reached != 0 {
                        waiting.push(node.child(reached.trailing_zeros() as usize));
                        reached &= reached - 1;
                    }
                }
                Child::Block(index) => {
                    let block = &bvh.blocks[index as usize];
                    let met = hull.meets::<S::Eight>(block);
                    if list.len() + met.count_ones() as usize > most {
                        return false;
                    }
                    list.push_lanes(block, met);
                }
            }
        }
        true
    }
}
