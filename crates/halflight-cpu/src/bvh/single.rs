//! One ray at a time: eight boxes or eight triangles against it.

use glam::Vec3;

use super::facet::Facets;
use super::layout::{Child, boxes};
use super::slab::{enters, inverse};
use super::vector::Vector;
use super::{Bvh, STACK, push_near_last};
use crate::simd::{Lanes, Simd};

impl Bvh {
    /// Whether the open segment from `origin` to `origin + d` meets a triangle under the child `root`.
    #[inline(always)]
    pub(super) fn occludes<S: Simd>(&self, root: u32, origin: Vec3, d: Vec3, stack: &mut [u32; STACK]) -> bool {
        let (from, along) = (Vector::<S::Eight>::splat(origin), Vector::<S::Eight>::splat(d));
        let reciprocal = Vector { x: inverse(along.x), y: inverse(along.y), z: inverse(along.z) };
        let end = S::Eight::splat(1.0);
        stack[0] = root;
        let mut waiting = 1;
        while waiting > 0 {
            waiting -= 1;
            match Child::decode(stack[waiting]) {
                Child::Node(index) => {
                    let node = &self.nodes[index as usize];
                    let (low, high) = node.bounds();
                    let (mask, enter) = enters(low, high, from, reciprocal, end);
                    waiting = push_near_last(node, mask & node.occupied(), enter, stack, waiting);
                }
                Child::Block(index) => {
                    let corners = self.blocks[index as usize].corners();
                    let hits = Facets::new(&corners, from).shadow(along);
                    if hits != 0 {
                        let (low, high) = boxes(&corners, self.padding);
                        if hits & enters(low, high, from, reciprocal, end).0 != 0 {
                            return true;
                        }
                    }
                }
            }
        }
        false
    }
}
