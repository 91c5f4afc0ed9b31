//! The predicate: whether a ray meets a triangle.
//!
//! With P, Q the ends of an edge seen from the ray's origin, the ray's side of the edge is the sign of
//! `d · (P + Q) × (Q − P)`, twice the volume that d, P and Q span. The two triangles at an edge compute the same number
//! with opposite signs, bit for bit, so no ray slips between them; sums and differences of the ends instead of `P × Q`
//! keep the error of small distant triangles at the size of rounding. All of it but the last product depends on the
//! origin alone and serves every ray that leaves it.
//!
//! A hit must also pass the box test of the triangle's own box. Nodes are boxes around those boxes, so that skipping a
//! node never changes an answer, not even where a triangle is seen edge-on and the signs are noise.

use glam::Vec3;

use super::vector::Vector;
use crate::simd::Lanes;

/// Triangles seen from one origin: planes through it, with the signs that make a ray inside positive.
#[derive(Clone, Copy)]
pub(super) struct Facets<L> {
    /// Normals of the planes through the origin and each edge.
    pub(super) edges: [Vector<L>; 3],
    /// Normal of the triangle, away from the origin.
    pub(super) face: Vector<L>,
    /// Distance of the triangle's plane from the origin, times the normal's length; infinite for a plane through it.
    pub(super) distance: L,
}

impl<L: Lanes> Facets<L> {
    #[inline(always)]
    pub(super) fn new(corners: &[Vector<L>; 3], origin: Vector<L>) -> Self {
        let [a, b, c] = [corners[0].sub(origin), corners[1].sub(origin), corners[2].sub(origin)];
        let [ab, bc, ca] =
            [corners[1].sub(corners[0]), corners[2].sub(corners[1]), corners[0].sub(corners[2])];
        let face = ca.cross(ab);
        let distance = face.dot(a);
        let zero = L::splat(0.0);
        let through = zero.le(distance) & distance.le(zero);
        Self {
            edges: [
                a.add(b).cross(ab).flip(distance),
                b.add(c).cross(bc).flip(distance),
                c.add(a).cross(ca).flip(distance),
            ],
            face: face.flip(distance),
            distance: distance.flip(distance).select(through, L::splat(f32::INFINITY)),
        }
    }

    /// Which of the triangles the ray with direction `d` meets at 0 < t < 1, boxes aside.
    #[inline(always)]
    pub(super) fn shadow(&self, d: Vector<L>) -> u32 {
        let zero = L::splat(0.0);
        let beyond = self.distance.lt(self.face.dot(d));
        beyond & zero.le(self.edges[0].dot(d)) & zero.le(self.edges[1].dot(d)) & zero.le(self.edges[2].dot(d))
    }

    /// Which of the triangles any ray with a direction between `low` and `high` can meet, where the product of its
    /// direction and the triangle's normal must exceed `least`. Rounding is monotone, so nothing is lost that a test of
    /// the ray itself would find.
    #[inline(always)]
    pub(super) fn reachable(&self, low: Vector<L>, high: Vector<L>, least: L) -> u32 {
        let zero = L::splat(0.0);
        let [first, second, third] = &self.edges;
        least.lt(self.face.greatest_dot(low, high))
            & zero.le(first.greatest_dot(low, high))
            & zero.le(second.greatest_dot(low, high))
            & zero.le(third.greatest_dot(low, high))
    }
}

/// Weights of the second and third corner at the point where the ray from `origin` along `d` meets a triangle that it
/// was found to meet.
pub(crate) fn barycentric(corners: [Vec3; 3], origin: Vec3, d: Vec3) -> (f32, f32) {
    let [a, b, c] = corners.map(|corner| corner - origin);
    let side = |p: Vec3, q: Vec3, edge: Vec3| d.dot((p + q).cross(edge));
    let first = side(b, c, corners[2] - corners[1]);
    let second = side(c, a, corners[0] - corners[2]);
    let third = side(a, b, corners[1] - corners[0]);
    let sum = first + second + third;
    if sum == 0.0 { (1.0 / 3.0, 1.0 / 3.0) } else { (second / sum, third / sum) }
}
