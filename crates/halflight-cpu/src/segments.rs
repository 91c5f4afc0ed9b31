//! Shadow rays to ends of the caller's choice, through all triangles of a mesh.

use glam::Vec3;
use halflight_core::scene::Mesh;

use crate::bvh::{Bvh, Packet, STACK, Stacks};
use crate::simd::{Isa, Kernel, Simd};

/// Geometry that hides light: a BVH, and the mesh that it is over.
#[derive(Clone, Copy)]
pub(crate) struct Occluders<'a> {
    pub(crate) bvh: &'a Bvh,
    pub(crate) mesh: &'a Mesh,
}

/// Shadow rays of one receiver, and the working memory to trace them.
pub(crate) struct Segments {
    packet: Packet,
    stacks: Stacks,
}

impl Default for Segments {
    fn default() -> Self {
        Self { packet: Packet::new(), stacks: Stacks::new() }
    }
}

impl Segments {
    /// Sets the end of the ray with this number, below [`RAYS`](crate::bvh::RAYS).
    #[inline]
    pub(crate) fn set_end(&mut self, ray: usize, end: Vec3) {
        for (axis, ends) in self.packet.ends_mut().iter_mut().enumerate() {
            ends[ray] = end[axis];
        }
    }

    /// Traces the first `count` rays from `origin` to their ends. Returns those that are hidden, a bit each.
    pub(crate) fn hidden(&mut self, occluders: Occluders, origin: Vec3, count: usize) -> u64 {
        let Self { packet, stacks } = self;
        Isa::best().run(Trace { occluders, packet, stacks, origin, count })
    }
}

struct Trace<'a> {
    occluders: Occluders<'a>,
    packet: &'a mut Packet,
    stacks: &'a mut Stacks,
    origin: Vec3,
    count: usize,
}

impl Kernel for Trace<'_> {
    type Output = u64;

    #[inline(always)]
    fn run<S: Simd>(self) -> u64 {
        let Self { occluders: Occluders { bvh, mesh }, packet, stacks, origin, count } = self;
        packet.set_ends::<S>(origin, count);
        let mut hidden = bvh.occluded::<S>(packet, stacks);
        if let Some(masked) = bvh.masked() {
            let mut stack = [0; STACK];
            for ray in 0..count {
                if hidden >> ray & 1 != 0 {
                    continue;
                }
                let solid = masked.occludes_solidly::<S>(mesh, origin, packet.end(ray), &mut stack);
                hidden |= u64::from(solid) << ray;
            }
        }
        hidden
    }
}
