//! Floating-point filter for [`super::exact::meets`] with a small setup per triangle, for few rays from an
//! origin.
//!
//! With T the first corner relative to the origin, E and F the edges that leave it and R = T × d, a ray along
//! d meets the triangle's plane with the corner weights R · F, −R · E and N · d minus these two (Möller and
//! Trumbore 1997). Every product has a bound on its error.

use glam::Vec3;

use super::block::Block;
use super::facet::decide_sides;
use crate::simd::Lanes;
use crate::vector::Vector;

/// Eight triangles relative to an origin.
#[derive(Clone, Copy)]
pub(crate) struct Spokes<L> {
    corner: Vector<L>,
    edges: [Vector<L>; 2],
    normal: Vector<L>,
    /// Distance of the triangle's plane from the origin, times the normal's length; its sign is the side on
    /// which the origin is.
    distance: L,
    edge_error: L,
    face_error: L,
    /// Triangles that have a non-zero area and whose plane does not contain the origin: others are never met.
    occupied: u32,
}

impl<L: Lanes> Spokes<L> {
    /// Prepares a block of triangles. `reach` bounds the components of the rays' directions.
    ///
    /// With u = 2⁻²⁴, A the largest component of a corner relative to the origin, B that of an edge and D =
    /// Σ|dₖ|: R · E is wrong by at most 16u A B D, the rounding of T, E and d included. N · d is wrong by 5u
    /// Σ|dₖNₖ|, and Σ|dₖNₖ| is at most 2 B² D, where B is no more than 2 A. The difference is wrong by 52u A
    /// B D; 64u is taken.
    #[inline(always)]
    pub(crate) fn new(block: &Block, origin: Vec3, reach: Vector<L>) -> Self {
        let corners = block.corners();
        let from = Vector::<L>::splat(origin);
        let corner = corners[0].sub(from);
        let edges = [corners[1].sub(corners[0]), corners[2].sub(corners[0])];
        let normal = block.normals();
        let parts = normal.mul(corner);
        let mut distance = parts.sum();
        let small = L::splat(2f32.powi(-21));
        let distance_error = parts.abs().sum().mul(small);
        let mut occupied = block.occupied();
        let open = distance.abs().le(distance_error) & occupied;
        if open != 0 {
            let mut distances = [0.0; 8];
            distance.store(&mut distances);
            occupied &= !decide_sides(block, origin, open, &mut distances);
            distance = L::load(&distances);
        }
        let longest = block.longest();
        let farthest = corner.abs().largest().add(longest);
        Self {
            corner,
            edges,
            normal,
            distance,
            edge_error: farthest.mul(longest).mul(reach.sum()).mul(L::splat(2f32.powi(-18))),
            face_error: normal.abs().dot(reach).mul(small).add(distance_error),
            occupied,
        }
    }

    /// Mask of the triangles that a ray along `d` may meet at t < 1, and of those that it certainly meets.
    #[inline(always)]
    pub(crate) fn any_hit(&self, d: Vector<L>) -> (u32, u32) {
        let turned = self.corner.cross(d);
        let along = self.normal.dot(d).flip(self.distance);
        let first = turned.dot(self.edges[1]).flip(self.distance);
        let second = turned.dot(self.edges[0]).flip(self.distance);
        let zero = L::splat(0.0);
        let second = zero.sub(second);
        let least = first.min(second).min(along.sub(first).sub(second));
        let beyond = along.sub(self.distance.abs());
        let (edge, face) = (self.edge_error, self.face_error);
        let may = zero.le(least.add(edge)) & zero.le(beyond.add(face)) & self.occupied;
        (may, may & edge.lt(least) & face.lt(beyond))
    }
}
