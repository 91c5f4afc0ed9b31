//! Convex hull of a box of receivers and a light: contains all segments between the two, and with them all
//! occluders.

use glam::{DVec3, Vec3};
use halflight_core::light::{AreaLight, LightFrame};

use crate::occluder::{Block, OverLight, Vector};
use crate::simd::{Kernel, Lanes, Simd};

/// Plane parallel to one axis: all of the shaft has `x · first + y · second ≤ limit`, x and y along the other
/// axes.
#[derive(Clone, Copy)]
struct Side {
    first: f32,
    second: f32,
    limit: f32,
}

/// Convex hull of two boxes, one around receivers and one around a light: a box and, parallel to each axis,
/// the planes that touch both boxes.
pub(crate) struct Hull {
    low: Vec3,
    high: Vec3,
    /// Planes parallel to x, y and z; at most four each.
    sides: [[Side; 4]; 3],
    counts: [usize; 3],
    receivers: (Vec3, Vec3),
    light: LightFrame,
    /// Bound on the rounding errors of positions and of their products with unit vectors.
    slack: f32,
}

/// Indices of the other two axes.
const OTHERS: [(usize, usize); 3] = [(1, 2), (2, 0), (0, 1)];

impl Hull {
    /// Hull of the box `low` … `high` and a light. `largest` bounds all coordinates of the scene.
    pub(crate) fn new(low: Vec3, high: Vec3, light: &AreaLight, largest: f32) -> Self {
        let (light_low, light_high) = light.bounds();
        let size =
            light_high.abs().max(light_low.abs()).max(low.abs()).max(high.abs()).max_element().max(largest);
        let slack = size * 2f32.powi(-20);
        let mut hull = Self {
            // Receivers' positions are exact; samples of the light are rounded.
            low: low.min(light_low - slack),
            high: high.max(light_high + slack),
            sides: [[Side { first: 0.0, second: 0.0, limit: 0.0 }; 4]; 3],
            counts: [0; 3],
            receivers: (low, high),
            light: light.frame(),
            slack,
        };
        for (axis, (i, j)) in OTHERS.into_iter().enumerate() {
            for (upper_i, upper_j) in [(false, false), (false, true), (true, false), (true, true)] {
                let pick = |low: Vec3, high: Vec3| {
                    (if upper_i { high[i] } else { low[i] }, if upper_j { high[j] } else { low[j] })
                };
                let (a, b) = (pick(low, high), pick(light_low, light_high));
                // The line through two corresponding corners supports both boxes if its normal points away
                // from both.
                let (across, along) = (b.1 - a.1, a.0 - b.0);
                let outward =
                    |x: f32, y: f32| (x > 0.0) == upper_i && (y > 0.0) == upper_j && x != 0.0 && y != 0.0;
                let length = (across * across + along * along).sqrt();
                for sign in [1.0, -1.0] {
                    let (first, second) = (sign * across / length, sign * along / length);
                    if length > 0.0 && outward(first, second) {
                        // Rounding may have tilted the line slightly: it is moved out until both corners are
                        // behind it.
                        let limit =
                            (first * a.0 + second * a.1).max(first * b.0 + second * b.1) + 4.0 * slack;
                        hull.sides[axis][hull.counts[axis]] = Side { first, second, limit };
                        hull.counts[axis] += 1;
                    }
                }
            }
        }
        hull
    }

    /// Mask of the boxes, out of eight, that overlap the hull.
    #[inline(always)]
    pub(crate) fn reaches<L: Lanes>(&self, low: Vector<L>, high: Vector<L>) -> u32 {
        let (from, to) = (Vector::<L>::splat(self.low), Vector::<L>::splat(self.high));
        let mut inside = low.x.le(to.x) & low.y.le(to.y) & low.z.le(to.z);
        inside &= from.x.le(high.x) & from.y.le(high.y) & from.z.le(high.z);
        let (low, high) = ([low.x, low.y, low.z], [high.x, high.y, high.z]);
        for (axis, (i, j)) in OTHERS.into_iter().enumerate() {
            for side in &self.sides[axis][..self.counts[axis]] {
                let x = if side.first > 0.0 { low[i] } else { high[i] };
                let y = if side.second > 0.0 { low[j] } else { high[j] };
                let nearest = x.mul(L::splat(side.first)).add(y.mul(L::splat(side.second)));
                inside &= nearest.le(L::splat(side.limit));
            }
        }
        inside
    }

    /// Mask of the triangles that may hide the light: those that overlap the hull and whose plane separates
    /// some receivers from some of the light.
    #[inline(always)]
    pub(crate) fn meets<L: Lanes>(&self, block: &Block) -> u32 {
        let corners = block.corners::<L>();
        let low = corners[0].min(corners[1]).min(corners[2]);
        let high = corners[0].max(corners[1]).max(corners[2]);
        let (from, to) = (Vector::<L>::splat(self.low), Vector::<L>::splat(self.high));
        let mut inside = block.occupied();
        inside &= low.x.le(to.x) & low.y.le(to.y) & low.z.le(to.z);
        inside &= from.x.le(high.x) & from.y.le(high.y) & from.z.le(high.z);
        if inside == 0 {
            return 0;
        }
        let [a, b, c] = corners;
        let parts = [[a.x, a.y, a.z], [b.x, b.y, b.z], [c.x, c.y, c.z]];
        for (axis, (i, j)) in OTHERS.into_iter().enumerate() {
            for side in &self.sides[axis][..self.counts[axis]] {
                let (first, second) = (L::splat(side.first), L::splat(side.second));
                let at = [
                    parts[0][i].mul(first).add(parts[0][j].mul(second)),
                    parts[1][i].mul(first).add(parts[1][j].mul(second)),
                    parts[2][i].mul(first).add(parts[2][j].mul(second)),
                ];
                inside &= at[0].min(at[1]).min(at[2]).le(L::splat(side.limit));
            }
        }
        if inside == 0 {
            return 0;
        }
        // Signed distances, times the normal's length, of the receivers' box and of the light from the
        // triangle's plane.
        let normal = block.normals::<L>();
        let near = normal.mul(Vector::splat(self.receivers.0).sub(corners[0]));
        let far = normal.mul(Vector::splat(self.receivers.1).sub(corners[0]));
        let (receivers, others) = (near.min(far).sum(), near.max(far).sum());
        // Error of differences, products and sums; normals are exact up to one rounding. The receivers' own
        // surface, which lies a few units in the last place behind them, must not count as an occluder.
        let doubt =
            near.abs().max(far.abs()).sum().mul(L::splat(2f32.powi(-21))).add(L::splat(f32::MIN_POSITIVE));
        let corner = normal.dot(Vector::splat(self.light.origin).sub(corners[0]));
        let (u, v) = (normal.dot(Vector::splat(self.light.u)), normal.dot(Vector::splat(self.light.v)));
        let zero = L::splat(0.0);
        let least = corner.add(u.min(zero)).add(v.min(zero));
        let most = corner.add(u.max(zero)).add(v.max(zero));
        let error = normal.abs().sum().mul(L::splat(8.0 * self.slack));
        let before = doubt.lt(receivers) & error.lt(least);
        let behind = others.add(doubt).lt(zero) & most.add(error).lt(zero);
        inside & !(before | behind)
    }

    /// Part of a segment that lies in the hull, if any.
    pub(crate) fn clip(&self, from: DVec3, to: DVec3) -> Option<(DVec3, DVec3)> {
        let (mut start, mut end) = (0.0f64, 1.0f64);
        let along = to - from;
        // `value` at the start, plus its growth up to the end, must not exceed `limit`.
        let mut cut = |value: f64, growth: f64, limit: f64| {
            let left = limit - value;
            if growth > 0.0 {
                end = end.min(left / growth);
            } else if growth < 0.0 {
                start = start.max(left / growth);
            } else if left < 0.0 {
                end = -1.0;
            }
        };
        for (axis, (i, j)) in OTHERS.into_iter().enumerate() {
            cut(from[axis], along[axis], f64::from(self.high[axis]));
            cut(-from[axis], -along[axis], -f64::from(self.low[axis]));
            for side in &self.sides[axis][..self.counts[axis]] {
                let (first, second) = (f64::from(side.first), f64::from(side.second));
                let value = |point: DVec3| point[i] * first + point[j] * second;
                cut(value(from), value(along), f64::from(side.limit));
            }
        }
        (start <= end).then(|| (from + along * start, from + along * end))
    }

    /// True if one triangle hides all of the light from the whole box of receivers. Testing the box's corners
    /// suffices: the set of points from which a triangle hides the light is convex on both of its sides.
    pub(crate) fn is_covered<S: Simd>(&self, block: &Block, lane: usize) -> bool {
        let (low, high) = self.receivers;
        (0..8).all(|corner| {
            let pick = |axis: usize| if corner >> axis & 1 == 0 { low[axis] } else { high[axis] };
            let corner = Vec3::new(pick(0), pick(1), pick(2));
            S::call(Covers { block, origin: corner, light: self.light }) >> lane & 1 != 0
        })
    }
}

/// Kernel that returns the triangles that hide all of a light from a point.
struct Covers<'a> {
    block: &'a Block,
    origin: Vec3,
    light: LightFrame,
}

impl Kernel for Covers<'_> {
    type Output = u32;

    #[inline(always)]
    fn run<S: Simd>(self) -> u32 {
        OverLight::<S::Eight>::new(self.block, self.origin, self.light).whole
    }
}
