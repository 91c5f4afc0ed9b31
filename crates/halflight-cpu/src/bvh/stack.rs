//! Traversal stacks.

use super::layout::Node;
use crate::simd::Lanes;

/// Capacity of a traversal stack. Each of the at most 51 levels (40 split by boxes, then 2³² triangles split
/// eightfold) leaves seven siblings on it.
pub(crate) const STACK: usize = 512;

/// Stacks of packet and single-ray traversal.
pub(crate) struct Stacks {
    /// Nodes with the mask of the packet's rays that may enter them.
    pub(crate) split: [(u32, u64); STACK],
    /// Nodes and blocks for one ray.
    pub(crate) single: [u32; STACK],
}

impl Stacks {
    pub(crate) fn new() -> Self {
        Self { split: [(0, 0); STACK], single: [0; STACK] }
    }
}

/// Pushes the children in `mask`, the nearest last, and returns the new height.
#[inline(always)]
pub(crate) fn push_near_last<L: Lanes>(
    node: &Node,
    mask: u32,
    enter: L,
    stack: &mut [u32; STACK],
    height: usize,
) -> usize {
    let mut height = height;
    let mut left = mask;
    if left == 0 {
        return height;
    }
    if left & (left - 1) == 0 {
        stack[height] = node.child(left.trailing_zeros() as usize);
        return height + 1;
    }
    let mut distances = [0.0f32; 8];
    enter.store(&mut distances);
    let (mut nearest, mut least) = (0, f32::INFINITY);
    while left != 0 {
        let child = left.trailing_zeros() as usize;
        left &= left - 1;
        stack[height] = node.child(child);
        if distances[child] < least {
            (nearest, least) = (height, distances[child]);
        }
        height += 1;
    }
    if least < f32::INFINITY {
        stack.swap(nearest, height - 1);
    }
    height
}

/// Pushes the children in `mask` with the distance of each, nearest last, and returns the new height.
#[inline(always)]
pub(crate) fn push_sorted<L: Lanes>(
    node: &Node,
    mask: u32,
    enter: L,
    stack: &mut [(u32, f32); STACK],
    height: usize,
) -> usize {
    let mut distances = [0.0f32; 8];
    enter.store(&mut distances);
    let mut top = height;
    let mut left = mask;
    while left != 0 {
        let child = left.trailing_zeros() as usize;
        left &= left - 1;
        let entry = (node.child(child), distances[child]);
        let mut slot = top;
        while slot > height && stack[slot - 1].1 < entry.1 {
            stack[slot] = stack[slot - 1];
            slot -= 1;
        }
        stack[slot] = entry;
        top += 1;
    }
    top
}
