//! Packets of primary rays from one eye.

use glam::Vec3;
use halflight_core::gbuffer::NO_PRIMITIVE;
use halflight_core::scene::Mesh;

use super::surface::{Layers, Surface};
use crate::bvh::{Bvh, Hits, Packet, STACK};
use crate::simd::Simd;

/// Triangles that are remembered.
const SURFACES: usize = 64;

/// Traces packets of up to `N` rays, one after another, and remembers the triangles that they have hit: neighbours hit few, by turns.
pub(super) struct Rays<'a, const N: usize> {
    bvh: &'a Bvh,
    mesh: &'a Mesh,
    eye: Vec3,
    packet: Packet<N>,
    hits: Hits<N>,
    stack: [(u32, f32); STACK],
    surfaces: [Surface; SURFACES],
    /// Ray parameter up to which rays go.
    limit: f32,
}

impl<'a, const N: usize> Rays<'a, N> {
    #[inline(always)]
    pub(super) fn new(bvh: &'a Bvh, mesh: &'a Mesh, eye: Vec3) -> Self {
        Self {
            bvh,
            mesh,
            eye,
            packet: Packet::new(),
            hits: Hits::new(),
            stack: [(0, 0.0); STACK],
            surfaces: [Surface::NONE; SURFACES],
            limit: f32::INFINITY,
        }
    }

    /// Moves the eye, for rays up to a ray parameter.
    #[inline(always)]
    pub(super) fn leave(&mut self, eye: Vec3, limit: f32) {
        (self.eye, self.limit) = (eye, limit);
        self.surfaces.iter_mut().for_each(|surface| surface.triangle = NO_PRIMITIVE);
    }

    /// Traces up to `N` rays and writes what they hit: ray `i` goes along `direction(i)` and has entry `place(i)` of `out`. Returns the
    /// number of triangles that were not remembered.
    #[inline(always)]
    pub(super) fn trace<S: Simd>(
        &mut self,
        count: usize,
        direction: impl Fn(usize) -> Vec3,
        place: impl Fn(usize) -> usize,
        out: &mut Layers,
    ) -> usize {
        self.packet.clear(self.eye);
        for ray in 0..count {
            self.packet.push(direction(ray));
        }
        self.packet.finish::<S>();
        self.bvh.closest_hit_within::<S, N>(&self.packet, self.limit, &mut self.stack, &mut self.hits);
        self.bvh.closer_masked_hit::<S, N>(&self.packet, self.mesh, &mut self.stack, &mut self.hits);
        let mut triangles = 0;
        for ray in 0..count {
            let triangle = self.hits.triangle[ray];
            let seen = &mut self.surfaces[triangle as usize % SURFACES];
            if triangle != seen.triangle {
                let corners = self.bvh.hit_corners(self.mesh, &self.hits, ray);
                *seen = Surface::new(self.mesh, self.eye, triangle, corners);
                triangles += 1;
            }
            out.write(place(ray), self.mesh, self.eye, self.packet.direction(ray), seen);
        }
        triangles
    }
}
