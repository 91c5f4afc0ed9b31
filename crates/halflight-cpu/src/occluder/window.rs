//! Range of light samples that triangles may hide: the bounding box of each triangle's projection from the
//! receiver onto the light.
//!
//! A point P relative to the receiver projects onto the light's point `C + u U + v V` with u = P · (V × C) /
//! P · (U × V) and v = P · (C × U) / P · (U × V). Most small triangles fall between samples, and most others
//! hide samples of a few rows only.

use glam::Vec3;
use halflight_core::light::{AreaLight, LightFrame};
use halflight_core::pattern::{Pattern, PatternKind};

use super::block::Block;
use crate::simd::Lanes;
use crate::vector::Vector;

/// Margin of a window in samples: more than rounding moves samples in their strata.
const SLACK: f32 = 1.0 / 1024.0;

/// Light relative to one receiver.
#[derive(Clone, Copy)]
pub(super) struct Window {
    origin: Vec3,
    /// Normal of the light, towards the receiver's side.
    normal: Vec3,
    across: [Vec3; 2],
    /// Magnitudes of the factors of `normal` and `across`, for bounds on the products' errors.
    size: f32,
    sizes: [f32; 2],
    /// Bound on the displacement of samples by rounding, in edges of the light; infinite where no bound is
    /// known.
    misplaced: f32,
}

/// First and last column and row of the samples that each of eight triangles may hide.
pub(super) struct Span {
    pub(super) first: [[f32; 8]; 2],
    pub(super) last: [[f32; 8]; 2],
    /// Triangles that may hide any sample.
    pub(super) some: u32,
}

impl Window {
    pub(super) const NONE: Self = Self {
        origin: Vec3::ZERO,
        normal: Vec3::ZERO,
        across: [Vec3::ZERO; 2],
        size: 0.0,
        sizes: [0.0; 2],
        misplaced: f32::INFINITY,
    };

    #[inline(always)]
    pub(super) fn new(origin: Vec3, light: &AreaLight) -> Self {
        let LightFrame { origin: corner, u, v } = light.frame();
        let c = corner - origin;
        let (normal, across) = (u.cross(v), [v.cross(c), c.cross(u)]);
        let height = normal.dot(c);
        let turn = if height < 0.0 { -1.0 } else { 1.0 };
        let (far, u, v) = (c.abs().max_element(), u.abs().max_element(), v.abs().max_element());
        // Displacement of samples by rounding, and the resulting displacement of their projections.
        let moved = (corner.abs().max_element() + u + v) * 2f32.powi(-21);
        let sum = |v: Vec3| v.abs().element_sum();
        let most = sum(across[0]).max(sum(across[1])) + sum(normal);
        // With u = 2⁻²⁴, the height is wrong by at most 48u times the magnitudes of its factors.
        let sure = height.abs() > far * u * v * 2f32.powi(-12) && height.abs() > f32::MIN_POSITIVE * 1e9;
        let misplaced = moved * most / height.abs();
        Self {
            origin,
            normal: normal * turn,
            across: across.map(|across| across * turn),
            size: u * v,
            sizes: [v * far, far * u],
            misplaced: if sure && misplaced < 0.25 { misplaced } else { f32::INFINITY },
        }
    }

    /// Range of the pattern's samples that triangles may hide.
    ///
    /// Products of corners relative to the receiver with the three vectors are wrong by at most 48u times the
    /// largest component of a corner and the vectors' magnitudes. Projected positions are therefore wrong by
    /// as much, and by their own size times as much, over the least product with the normal. 64u is taken. No
    /// bound is computed where that product is so small that its error matters.
    #[inline(always)]
    pub(super) fn span<L: Lanes>(&self, block: &Block, pattern: Pattern) -> Span {
        let [a, b, c] = block.corners::<L>();
        let origin = Vector::splat(self.origin);
        let corners = [a.sub(origin), b.sub(origin), c.sub(origin)];
        let (normal, one) = (Vector::splat(self.normal), L::splat(1.0));
        let heights = [corners[0].dot(normal), corners[1].dot(normal), corners[2].dot(normal)];
        let far = corners[0].abs().max(corners[1].abs()).max(corners[2].abs()).largest();
        let lowest = heights[0].min(heights[1]).min(heights[2]);
        let tiny = L::splat(f32::MIN_POSITIVE * 1e9);
        let sure = far.mul(L::splat(self.size * 2f32.powi(-12))).max(tiny).lt(lowest);
        let open = if self.misplaced < 1.0 { !sure } else { !0 };
        let inverse = [one.div(heights[0]), one.div(heights[1]), one.div(heights[2])];
        let error = far.mul(L::splat(2f32.powi(-18))).mul(one.div(lowest));
        let (least, most) = match pattern.kind {
            PatternKind::Grid => (0.5, 0.5),
            PatternKind::ShiftedRows | PatternKind::Jittered => (0.0, 1.0),
        };
        let mut span = Span { first: [[0.0; 8]; 2], last: [[0.0; 8]; 2], some: L::ALL };
        for (axis, count) in [pattern.columns, pattern.rows].into_iter().enumerate() {
            let across = Vector::splat(self.across[axis]);
            let at = [
                corners[0].dot(across).mul(inverse[0]),
                corners[1].dot(across).mul(inverse[1]),
                corners[2].dot(across).mul(inverse[2]),
            ];
            let (low, high) = (at[0].min(at[1]).min(at[2]), at[0].max(at[1]).max(at[2]));
            let size = low.abs().max(high.abs());
            let margin = size
                .mul(L::splat(self.size))
                .add(L::splat(self.sizes[axis]))
                .mul(error)
                .add(size.add(one).mul(L::splat(self.misplaced)));
            let count = f32::from(count);
            let (zero, end, above) = (L::splat(0.0), L::splat(count), L::splat(count + 1.0));
            let from = low.sub(margin).mul(end).sub(L::splat(most + SLACK)).max(zero).min(end);
            let to = high.add(margin).mul(end).add(L::splat(1.0 - least + SLACK)).max(zero).min(end);
            let first = above.sub(above.sub(from).truncate()).select(open, zero);
            let last = to.truncate().sub(one).select(open, end.sub(one));
            span.some &= first.le(last);
            first.store(&mut span.first[axis]);
            last.store(&mut span.last[axis]);
        }
        span
    }
}
