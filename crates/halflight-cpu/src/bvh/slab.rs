//! Ray–box tests, for one ray and for all rays whose directions lie between two bounds.
//!
//! A ray enters a box when its parameter intervals for the three slabs and 0 … end overlap. Differences,
//! directions, their reciprocals and products each have a relative rounding error, so that a parameter is
//! wrong by a few units in its own last place, however far away the box is. The parameter at which a box is
//! left is enlarged by [`LATE`], so that a ray that meets a triangle is found to enter every box around it.
//! Boxes are slightly larger than their contents, so that a ray that runs in one of their sides is inside.

use glam::Vec3;

use crate::simd::Lanes;
use crate::vector::Vector;

/// 1 + 2⁻²⁰: more than the rounding errors of both parameters, each of which has four roundings.
const LATE: f32 = 1.0 + 1.0 / 1_048_576.0;

/// Reciprocals of directions; large but finite for 0, so that no product is undefined.
#[inline(always)]
pub(super) fn inverse<L: Lanes>(d: L) -> L {
    L::splat(1.0).div(d).min(L::splat(1e30)).max(L::splat(-1e30))
}

/// Mask of the boxes that rays from `origin` with reciprocal directions `inverse` enter before `end`, and the
/// parameters at which they enter.
#[inline(always)]
pub(super) fn enters<L: Lanes>(
    low: Vector<L>,
    high: Vector<L>,
    origin: Vector<L>,
    inverse: Vector<L>,
    end: L,
) -> (u32, L) {
    let (a, b) = (low.sub(origin).mul(inverse), high.sub(origin).mul(inverse));
    let (near, far) = (a.min(b), a.max(b));
    let enter = near.x.max(near.y).max(near.z).max(L::splat(0.0));
    let leave = far.x.min(far.y).min(far.z).min(end).mul(L::splat(LATE));
    (enter.le(leave), enter)
}

/// Set of all rays from one origin whose directions lie between two bounds.
#[derive(Clone, Copy)]
pub(crate) struct Shaft {
    origin: Vec3,
    /// Least positive reciprocal direction, or 0.
    rising: [f32; 3],
    /// Greatest negative reciprocal direction, or 0.
    falling: [f32; 3],
    /// Reciprocal direction that leaves a slab last, or 0 where directions have both signs and may stay in it
    /// for ever.
    leaving: [f32; 3],
    /// Least parameter for leaving a slab: ∞ for directions of both signs, else less than any that matters.
    stay: [f32; 3],
    /// True for axes whose slabs are left through their lower side.
    downward: [bool; 3],
}

impl Shaft {
    #[inline(always)]
    pub(crate) fn new(origin: Vec3, low: Vec3, high: Vec3) -> Self {
        let mut shaft = Self {
            origin,
            rising: [0.0; 3],
            falling: [0.0; 3],
            leaving: [0.0; 3],
            stay: [-1.0; 3],
            downward: [false; 3],
        };
        for axis in 0..3 {
            let (low, high) = (low[axis], high[axis]);
            let (inverse_low, inverse_high) =
                ((1.0 / low).clamp(-1e30, 1e30), (1.0 / high).clamp(-1e30, 1e30));
            if low > 0.0 {
                (shaft.rising[axis], shaft.leaving[axis]) = (inverse_high, inverse_low);
            } else if high < 0.0 {
                (shaft.falling[axis], shaft.leaving[axis]) = (inverse_low, inverse_high);
                shaft.downward[axis] = true;
            } else {
                shaft.rising[axis] = if high > 0.0 { inverse_high } else { 0.0 };
                shaft.falling[axis] = if low < 0.0 { inverse_low } else { 0.0 };
                shaft.stay[axis] = f32::INFINITY;
            }
        }
        shaft
    }

    /// Mask of the boxes that any of the rays may enter before `end`, and lower bounds on the parameters at
    /// which they enter.
    #[inline(always)]
    pub(crate) fn enters<L: Lanes>(&self, low: Vector<L>, high: Vector<L>, end: f32) -> (u32, L) {
        let (enter_x, leave_x) = self.span(0, low.x, high.x);
        let (enter_y, leave_y) = self.span(1, low.y, high.y);
        let (enter_z, leave_z) = self.span(2, low.z, high.z);
        let enter = enter_x.max(enter_y).max(enter_z).max(L::splat(0.0));
        let leave = leave_x.min(leave_y).min(leave_z).min(L::splat(end)).mul(L::splat(LATE));
        (enter.le(leave), enter)
    }

    /// Bounds on the parameters at which any of the rays enters and leaves slabs.
    #[inline(always)]
    fn span<L: Lanes>(&self, axis: usize, low: L, high: L) -> (L, L) {
        let origin = L::splat(self.origin[axis]);
        let (low, high) = (low.sub(origin), high.sub(origin));
        let enter = low.mul(L::splat(self.rising[axis])).max(high.mul(L::splat(self.falling[axis])));
        let last = if self.downward[axis] { low } else { high };
        (enter, last.mul(L::splat(self.leaving[axis])).max(L::splat(self.stay[axis])))
    }
}
