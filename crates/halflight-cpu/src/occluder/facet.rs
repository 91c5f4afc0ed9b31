//! Floating-point filter for [`super::exact::meets`]: planes of triangles relative to one origin, with bounds
//! on their rounding errors.
//!
//! With P and Q the ends of an edge relative to the origin, a ray along d passes the edge on the side given
//! by the sign of `d · (P + Q) × (Q − P)`, twice the volume that d, P and Q span. Sums and differences of the
//! ends instead of `P × Q` keep the error small for small distant triangles. All but the last product depends
//! on the origin alone and serves all rays that leave it. Every sum has a bound on its error, and a ray
//! within the bound is decided exactly.

use glam::Vec3;

use super::block::Block;
use super::exact;
use crate::simd::Lanes;
use crate::vector::Vector;

/// Eight triangles relative to an origin; signs are flipped so that a ray that meets a triangle has positive
/// products.
#[derive(Clone, Copy)]
pub(crate) struct Facets<L> {
    /// Normals of the planes through the origin and each edge.
    pub(crate) edges: [Vector<L>; 3],
    /// Normal of the triangle, away from the origin.
    pub(crate) face: Vector<L>,
    /// Distance of the triangle's plane from the origin, times the normal's length.
    pub(crate) distance: L,
    /// Bound on the error of the products with the edges' planes.
    pub(crate) edge_error: L,
    /// Bound on the error of the product with the face, minus the distance.
    pub(crate) face_error: L,
    /// Triangles that have a non-zero area and whose plane does not contain the origin: others are never met.
    pub(crate) occupied: u32,
}

/// Bounds on the errors of the two parts of a ray's parameter.
#[derive(Clone, Copy)]
pub(crate) struct ParameterErrors<L> {
    /// Of the distance.
    pub(crate) distance: L,
    /// Of the product of direction and face.
    pub(crate) along: L,
}

impl<L: Lanes> Facets<L> {
    /// Prepares a block of triangles. `reach` bounds the components of the rays' directions.
    ///
    /// With u = 2⁻²⁴, A the largest component of a corner seen from the origin, E that of an edge and D =
    /// Σ|dₖ|: sums of corners are wrong by at most 4uA in each component, edges by uE, the planes' normals by
    /// 20uAE and the products, d's own rounding included, by 36uDAE; 64u covers what was rounded on the way.
    /// The stored face normals N are wrong by u relative to each component, and products of them with corners
    /// and directions by 5u(Σ|aₖNₖ| + Σ|dₖNₖ|); 8u is taken.
    #[inline(always)]
    pub(crate) fn new(block: &Block, origin: Vec3, reach: Vector<L>) -> Self {
        Self::with_errors(block, origin, reach).0
    }

    /// Prepares a block; returns also bounds on the errors of the parameters of rays that meet its triangles.
    #[inline(always)]
    pub(crate) fn with_errors(block: &Block, origin: Vec3, reach: Vector<L>) -> (Self, ParameterErrors<L>) {
        let (corners, origin_point) = (block.corners(), origin);
        let origin = Vector::<L>::splat(origin);
        let (a, b, c) = (corners[0].sub(origin), corners[1].sub(origin), corners[2].sub(origin));
        let ab = corners[1].sub(corners[0]);
        let bc = corners[2].sub(corners[1]);
        let ca = corners[0].sub(corners[2]);
        let normal = block.normals();
        let parts = normal.mul(a);
        let mut distance = parts.sum();
        let distance_error = parts.abs().sum().mul(L::splat(2f32.powi(-21)));
        let along_error = normal.abs().dot(reach).mul(L::splat(2f32.powi(-21)));
        let mut occupied = block.occupied();
        let open = distance.abs().le(distance_error) & occupied;
        if open != 0 {
            let mut distances = [0.0; 8];
            distance.store(&mut distances);
            occupied &= !decide_sides(block, origin_point, open, &mut distances);
            distance = L::load(&distances);
        }
        let farthest = a.abs().max(b.abs()).max(c.abs()).largest();
        let facets = Self {
            edges: [
                a.add(b).cross(ab).flip(distance),
                b.add(c).cross(bc).flip(distance),
                c.add(a).cross(ca).flip(distance),
            ],
            face: normal.flip(distance),
            distance: distance.abs(),
            edge_error: farthest.mul(block.longest()).mul(reach.sum()).mul(L::splat(2f32.powi(-18))),
            face_error: along_error.add(distance_error),
            occupied,
        };
        (facets, ParameterErrors { distance: distance_error, along: along_error })
    }

    /// Mask of the triangles that a ray along `d` may meet at t < 1, and of those that it certainly meets.
    #[inline(always)]
    pub(crate) fn any_hit(&self, d: Vector<L>) -> (u32, u32) {
        let beyond = self.face.dot(d).sub(self.distance);
        let least = self.least_side(d);
        let (edge, face) = (self.edge_error, self.face_error);
        let zero = L::splat(0.0);
        let may = zero.le(least.add(edge)) & zero.le(beyond.add(face));
        (may, edge.lt(least) & face.lt(beyond))
    }

    /// Least product of a direction with the edges' planes.
    #[inline(always)]
    pub(crate) fn least_side(&self, d: Vector<L>) -> L {
        self.edges[0].dot(d).min(self.edges[1].dot(d)).min(self.edges[2].dot(d))
    }

    /// Triangles that any ray between `low` and `high` may meet at t < 1. Rounding is monotone, so bounds on
    /// a product hold for every ray.
    #[inline(always)]
    pub(crate) fn reachable(&self, low: Vector<L>, high: Vector<L>) -> u32 {
        let beyond = self.face.greatest_dot(low, high).sub(self.distance);
        self.in_reach(low, high) & L::splat(0.0).le(beyond.add(self.face_error))
    }

    /// Triangles for which some ray between `low` and `high` may pass all edges on the inner side.
    #[inline(always)]
    pub(super) fn in_reach(&self, low: Vector<L>, high: Vector<L>) -> u32 {
        let sides = [
            self.edges[0].greatest_dot(low, high),
            self.edges[1].greatest_dot(low, high),
            self.edges[2].greatest_dot(low, high),
        ];
        let least = sides[0].min(sides[1]).min(sides[2]);
        L::splat(0.0).le(least.add(self.edge_error)) & self.occupied
    }
}

/// Corrects the distances of open triangles, whose sign may be wrong by rounding: their signs become those of
/// exact arithmetic. Returns the triangles whose plane contains the origin.
#[cold]
#[inline(never)]
pub(super) fn decide_sides(block: &Block, origin: Vec3, mut open: u32, distances: &mut [f32; 8]) -> u32 {
    let mut flat = 0;
    while open != 0 {
        let lane = open.trailing_zeros() as usize;
        open &= open - 1;
        let side = exact::side_of_plane(block.triangle_corners(lane), origin);
        distances[lane] = distances[lane].abs().copysign(side as f32);
        flat |= u32::from(side == 0.0) << lane;
    }
    flat
}

/// [`Facets`] in memory, from which single triangles are broadcast.
pub(crate) struct Planes {
    edges: [[[f32; 8]; 3]; 3],
    face: [[f32; 8]; 3],
    distance: [f32; 8],
    edge_error: [f32; 8],
    face_error: [f32; 8],
}

impl Planes {
    pub(crate) fn new() -> Self {
        Self {
            edges: [[[0.0; 8]; 3]; 3],
            face: [[0.0; 8]; 3],
            distance: [0.0; 8],
            edge_error: [0.0; 8],
            face_error: [0.0; 8],
        }
    }

    #[inline(always)]
    pub(crate) fn set<L: Lanes>(&mut self, facets: &Facets<L>) {
        facets.edges[0].store(&mut self.edges[0], 0);
        facets.edges[1].store(&mut self.edges[1], 0);
        facets.edges[2].store(&mut self.edges[2], 0);
        facets.face.store(&mut self.face, 0);
        facets.distance.store(&mut self.distance);
        facets.edge_error.store(&mut self.edge_error);
        facets.face_error.store(&mut self.face_error);
    }

    /// One triangle, broadcast to all lanes.
    #[inline(always)]
    pub(crate) fn facet<L: Lanes>(&self, lane: usize) -> Facets<L> {
        Facets {
            edges: [
                Vector::broadcast(&self.edges[0], lane),
                Vector::broadcast(&self.edges[1], lane),
                Vector::broadcast(&self.edges[2], lane),
            ],
            face: Vector::broadcast(&self.face, lane),
            distance: L::splat(self.distance[lane]),
            edge_error: L::splat(self.edge_error[lane]),
            face_error: L::splat(self.face_error[lane]),
            occupied: L::ALL,
        }
    }
}

/// Vectors that weight the corners of a triangle along rays from one origin. A ray's product with each
/// vector, over the sum of the three, is the barycentric weight of that corner at the hit.
pub(crate) fn corner_weights(corners: [Vec3; 3], origin: Vec3) -> [Vec3; 3] {
    let [a, b, c] = corners.map(|corner| corner - origin);
    let side = |p: Vec3, q: Vec3, edge: Vec3| (p + q).cross(edge);
    [
        side(b, c, corners[2] - corners[1]),
        side(c, a, corners[0] - corners[2]),
        side(a, b, corners[1] - corners[0]),
    ]
}

/// Barycentric weights of the second and third corner at the point where the ray along `d` meets a triangle;
/// the ray is known to meet it.
#[inline(always)]
pub(crate) fn barycentric(weights: &[Vec3; 3], d: Vec3) -> (f32, f32) {
    let [first, second, third] = [d.dot(weights[0]), d.dot(weights[1]), d.dot(weights[2])];
    let sum = first + second + third;
    let (second, third) = if sum == 0.0 { (1.0 / 3.0, 1.0 / 3.0) } else { (second / sum, third / sum) };
    // Rays within rounding of an edge count as hits.
    let second = second.clamp(0.0, 1.0);
    (second, third.clamp(0.0, 1.0 - second))
}
