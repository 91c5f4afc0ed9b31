//! Any-hit traversal by a single ray: eight boxes or eight triangles at a time.

use glam::Vec3;
use halflight_core::scene::Mesh;

use super::Bvh;
use super::layout::Child;
use super::slab::{enters, inverse};
use super::stack::{STACK, push_near_last};
use crate::occluder::{Facets, Vector, exact, is_solid};
use crate::simd::{Kernel, Lanes, Simd};

impl Bvh {
    /// True if the open segment from `origin` to `end` meets a triangle under the child `root`.
    #[inline(always)]
    pub(crate) fn occludes<S: Simd>(
        &self,
        root: u32,
        origin: Vec3,
        end: Vec3,
        stack: &mut [u32; STACK],
    ) -> bool {
        S::call(Segment { bvh: self, root, origin, end, stack, solid: |_| true })
    }

    /// True if the open segment from `origin` to `end` meets a triangle in a point that is solid by the mesh's
    /// alpha masks. The BVH must have nodes.
    #[inline(always)]
    pub(crate) fn occludes_solidly<S: Simd>(
        &self,
        mesh: &Mesh,
        origin: Vec3,
        end: Vec3,
        stack: &mut [u32; STACK],
    ) -> bool {
        let d = end.as_dvec3() - origin.as_dvec3();
        let solid = |triangle| is_solid(mesh, triangle, origin, d);
        S::call(Segment { bvh: self, root: 0, origin, end, stack, solid })
    }
}

/// Traversal of a child's subtree by one ray. Only hits of triangles that are `solid` where they are met count.
struct Segment<'a, F> {
    bvh: &'a Bvh,
    root: u32,
    origin: Vec3,
    end: Vec3,
    stack: &'a mut [u32; STACK],
    solid: F,
}

impl<F: Fn(u32) -> bool> Kernel for Segment<'_, F> {
    type Output = bool;

    #[inline(always)]
    fn run<S: Simd>(self) -> bool {
        let Self { bvh, root, origin, end, stack, solid } = self;
        let d = end - origin;
        let (from, along) = (Vector::<S::Eight>::splat(origin), Vector::<S::Eight>::splat(d));
        let reciprocal = Vector { x: inverse(along.x), y: inverse(along.y), z: inverse(along.z) };
        stack[0] = root;
        let mut waiting = 1;
        while waiting > 0 {
            waiting -= 1;
            match Child::decode(stack[waiting]) {
                Child::Node(index) => {
                    let node = &bvh.nodes[index as usize];
                    let (low, high) = node.bounds();
                    let (mask, enter) = enters(low, high, from, reciprocal, S::Eight::splat(1.0));
                    waiting = push_near_last(node, mask & node.occupied(), enter, stack, waiting);
                }
                Child::Block(index) => {
                    let block = &bvh.blocks[index as usize];
                    let facets = Facets::new(block, origin, along.abs());
                    let (may, surely) = facets.any_hit(along);
                    let mut may = may & facets.occupied;
                    let mut met = may & surely;
                    may &= !surely;
                    while met != 0 {
                        let lane = met.trailing_zeros() as usize;
                        met &= met - 1;
                        if solid(block.triangle(lane)) {
                            return true;
                        }
                    }
                    while may != 0 {
                        let lane = may.trailing_zeros() as usize;
                        may &= may - 1;
                        if exact::meets(origin, end, block.triangle_corners(lane))
                            && solid(block.triangle(lane))
                        {
                            return true;
                        }
                    }
                }
            }
        }
        false
    }
}
