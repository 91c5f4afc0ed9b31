//! Floating-point filter for closest hits: the triangles that rays from one origin meet, and bounds on the
//! ray parameters.
//!
//! Edges and faces are those of [`Facets`]. Undecided cases are left to exact arithmetic (`exact::Ray`): a
//! ray within the rounding error of an edge, or two triangles whose parameters differ by less than their
//! errors.

use glam::Vec3;

use super::block::Block;
use super::facet::{Facets, Planes};
use crate::simd::Lanes;
use crate::vector::Vector;

/// Eight triangles prepared for closest-hit rays from one origin, in memory.
pub(crate) struct Targets {
    planes: Planes,
    distance_error: [f32; 8],
    along_error: [f32; 8],
}

/// One triangle, broadcast to all lanes.
#[derive(Clone, Copy)]
pub(crate) struct Target<L> {
    facet: Facets<L>,
    /// Bound on the relative error of the distance.
    distance_error: L,
    /// Bound on the error of products of directions with the normal.
    along_error: L,
}

/// Result of testing a vector of rays against a triangle.
#[derive(Clone, Copy)]
pub(crate) struct Found<L> {
    /// Rays for which the triangle may be the closest so far.
    pub(crate) may: u32,
    /// Rays for which the triangle certainly is the closest so far.
    pub(crate) surely: u32,
    /// Ray parameters, and bounds on them.
    pub(crate) t: L,
    pub(crate) least: L,
    pub(crate) most: L,
}

impl Targets {
    pub(crate) fn new() -> Self {
        Self { planes: Planes::new(), distance_error: [0.0; 8], along_error: [0.0; 8] }
    }

    /// Prepares a block and returns the triangles in it that any ray between `low` and `high` may meet.
    #[inline(always)]
    pub(crate) fn set<L: Lanes>(&mut self, block: &Block, origin: Vec3, low: Vec3, high: Vec3) -> u32 {
        let reach = Vector::splat(low.abs().max(high.abs()));
        let (facets, errors) = Facets::<L>::with_errors(block, origin, reach);
        let (low, high) = (Vector::splat(low), Vector::splat(high));
        let ahead = facets.face.greatest_dot(low, high).add(errors.along);
        let within = facets.in_reach(low, high) & L::splat(0.0).le(ahead);
        if within != 0 {
            self.planes.set(&facets);
            errors.distance.div(facets.distance).store(&mut self.distance_error);
            errors.along.store(&mut self.along_error);
        }
        within
    }

    #[inline(always)]
    pub(crate) fn target<L: Lanes>(&self, lane: usize) -> Target<L> {
        Target {
            facet: self.planes.facet(lane),
            distance_error: L::splat(self.distance_error[lane]),
            along_error: L::splat(self.along_error[lane]),
        }
    }
}

impl<L: Lanes> Target<L> {
    /// Compares a triangle with the closest hits so far, whose parameters lie between `least` and `most`.
    ///
    /// With a and b the relative errors of distance and product, both below a quarter, a parameter is wrong
    /// by a factor of at most (1 + a) / (1 − b) ≤ 1 + 4/3 (a + b).
    #[inline(always)]
    pub(crate) fn find(&self, d: Vector<L>, least: L, most: L) -> Found<L> {
        let zero = L::splat(0.0);
        let side = self.facet.least_side(d);
        let along = self.facet.face.dot(d);
        let edge = self.facet.edge_error;
        let inside = zero.le(side.add(edge)) & zero.le(along.add(self.along_error));
        if inside == 0 {
            return Found { may: 0, surely: 0, t: zero, least: zero, most: zero };
        }
        let inverse = L::splat(1.0).div(along);
        let t = self.facet.distance.mul(inverse);
        let error = self.distance_error.add(self.along_error.mul(inverse));
        let spread = t.mul(error.mul(L::splat(1.5)).add(L::splat(2f32.powi(-21))));
        let clear = self.distance_error.lt(L::splat(0.25)) & self.along_error.mul(L::splat(4.0)).lt(along);
        let (low, high) = (t.sub(spread), t.add(spread));
        Found {
            may: inside & (low.le(most) | !clear),
            surely: inside & clear & edge.lt(side) & high.lt(least),
            t,
            least: low,
            most: high,
        }
    }
}
