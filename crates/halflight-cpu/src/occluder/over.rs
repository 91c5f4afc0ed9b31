//! Tests of triangles against the whole of a light, for one receiver.

use glam::Vec3;
use halflight_core::light::LightFrame;

use super::block::Block;
use super::facet::Facets;
use crate::simd::Lanes;
use crate::vector::Vector;

/// Bound on products below which single precision may have underflowed.
const VANISHING: f32 = 1e-30;

/// Four planes that each of eight triangles has for a receiver (through the receiver and an edge, and the
/// triangle's own), as functions `a + bu · u + bv · v` of the position in the light's frame. A sample is hidden where
/// all four are positive.
pub(crate) struct OverLight<L> {
    pub(super) facets: Facets<L>,
    pub(super) a: [L; 4],
    pub(super) bu: [L; 4],
    pub(super) bv: [L; 4],
    /// Bounds on the rounding errors of the functions, including the rounding of the samples' positions.
    pub(super) error: [L; 4],
    /// Triangles that have the whole light on the inner side, per plane.
    pub(super) inside: [u32; 4],
    /// Triangles that may hide a sample.
    pub(super) may: u32,
    /// Triangles that hide all of the light.
    pub(crate) whole: u32,
    /// Triangles whose functions are too inaccurate to decide anything.
    pub(super) unsure: u32,
}

impl<L: Lanes> OverLight<L> {
    /// Compares triangles with all of a light's frame, as `origin` sees it.
    #[inline(always)]
    pub(crate) fn new(block: &Block, origin: Vec3, light: LightFrame) -> Self {
        let corner = light.origin - origin;
        let edges = light.u.abs() + light.v.abs();
        // `Facets` bounds the error of products with a direction. Twice the reach covers sums of three
        // products, and the rounding of sample positions to single precision.
        let reach = (corner.abs() + light.origin.abs() + edges * 2.0) * 2.0;
        let facets = Facets::<L>::new(block, origin, Vector::splat(reach));
        let (c, u, v) = (Vector::splat(corner), Vector::splat(light.u), Vector::splat(light.v));
        let [ab, bc, ca] = facets.edges;
        let face = facets.face;
        let a = [ab.dot(c), bc.dot(c), ca.dot(c), face.dot(c).sub(facets.distance)];
        let bu = [ab.dot(u), bc.dot(u), ca.dot(u), face.dot(u)];
        let bv = [ab.dot(v), bc.dot(v), ca.dot(v), face.dot(v)];
        let error = [facets.edge_error, facets.edge_error, facets.edge_error, facets.face_error];
        let zero = L::splat(0.0);
        let (mut may, mut whole, mut inside) = (facets.occupied, facets.occupied, [0; 4]);
        for plane in 0..4 {
            let most = a[plane].add(bu[plane].max(zero)).add(bv[plane].max(zero));
            let least = a[plane].add(bu[plane].min(zero)).add(bv[plane].min(zero));
            inside[plane] = error[plane].lt(least);
            may &= zero.le(most.add(error[plane]));
            whole &= inside[plane];
        }
        let (lost, endless) = (L::splat(VANISHING), L::splat(f32::INFINITY));
        let vague = (facets.face_error.lt(endless) & facets.edge_error.lt(endless)) ^ L::ALL
            | facets.face_error.lt(lost)
            | facets.edge_error.lt(lost);
        let unsure = vague & facets.occupied;
        Self { facets, a, bu, bv, error, inside, may: may | unsure, whole: whole & !unsure, unsure }
    }
}
