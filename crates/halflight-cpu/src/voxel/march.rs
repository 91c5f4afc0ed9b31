//! Traversal of the grid by sixteen rays in parallel.
//!
//! A ray is straight in the image, so it is followed from texel to texel there, and its depth range in each
//! texel is tested against the slices at once. 1 / depth is linear along the image, so the depth at every
//! border is known exactly: together the tested slices are exactly the voxels that the ray passes.

use glam::Vec3;
use halflight_core::light::AreaLight;

use super::Traversal;
use super::frustum::Frustum;
use super::run::Run;
use crate::samples::LANES;
use crate::simd::Lanes;

/// One number per ray.
type Lane = [f32; LANES];

/// Dimensions of the grid in the precision of rays.
#[derive(Clone, Copy, Debug)]
pub(super) struct Measures {
    pub(super) side: f32,
    pub(super) slices: f32,
    pub(super) near: f32,
    pub(super) far: f32,
    /// Slices per metre.
    pub(super) density: f32,
}

impl Measures {
    pub(super) fn new(frustum: &Frustum) -> Self {
        Self {
            side: frustum.side as f32,
            slices: frustum.bits as f32,
            near: frustum.near,
            far: frustum.far,
            density: frustum.slices() as f32,
        }
    }
}

/// Rays from one origin to sixteen ends, all in homogeneous coordinates.
pub(super) struct Rays<'a> {
    pub(super) origin: Vec3,
    pub(super) ends: &'a [Lane; 3],
}

/// Light in homogeneous coordinates. The transformation is linear, so points on it correspond to those of the
/// light in the world.
pub fn turned(frustum: &Frustum, light: &AreaLight) -> AreaLight {
    light.transformed(|point| frustum.place(point).as_vec3(), |v| frustum.turn(v.as_dvec3()).as_vec3())
}

/// Mask of the `active` rays for which `meets` returns true somewhere in a run. Its arguments are a ray, a
/// texel that the ray passes, and the first and last slice to test there.
#[inline(always)]
pub(super) fn march<L: Lanes>(
    traversal: Traversal,
    thickness: u32,
    measures: &Measures,
    rays: &Rays,
    run: Run,
    active: u32,
    mut meets: impl FnMut(usize, usize, usize, usize) -> bool,
) -> u32 {
    let mut met = 0;
    for first in (0..LANES).step_by(L::WIDTH) {
        let active = active >> first & L::ALL;
        if active == 0 {
            continue;
        }
        let ends = [0, 1, 2].map(|axis| L::load(&rays.ends[axis][first..]));
        let part = Part { measures, origin: rays.origin.to_array().map(L::splat), ends, run };
        let ask = |lane: usize, texel: usize, from: usize, to: usize| meets(first + lane, texel, from, to);
        met |= match traversal {
            Traversal::Dda => part.walk(active, ask),
            Traversal::Steps { count } => part.step(count, thickness, active, ask),
        } << first;
    }
    met
}

/// As many rays as fit a vector, and the part of them to traverse.
struct Part<'a, L> {
    measures: &'a Measures,
    origin: [L; 3],
    ends: [L; 3],
    run: Run,
}

/// Traversal state of rays along one axis of the image, in texels.
#[derive(Clone, Copy)]
struct Axis<L> {
    /// Start of each ray.
    start: L,
    /// Reciprocal of the ray's extent along the axis.
    inverse: L,
    /// Next border.
    border: L,
    /// Number of borders left.
    left: L,
    /// Step from one border to the next: 1 or -1.
    ahead: L,
    /// Step from one texel's index to the next one's.
    stride: L,
}

impl<L: Lanes> Axis<L> {
    /// State for rays from `start` to `end`, and the texels in which they start.
    #[inline(always)]
    fn new(start: L, end: L, side: f32, pitch: f32) -> (Self, L) {
        let (zero, one, last) = (L::splat(0.0), L::splat(1.0), L::splat(side - 1.0));
        let first = floor(start.max(zero).min(last));
        let target = floor(end.max(zero).min(last));
        let up = first.lt(target);
        let axis = Self {
            start,
            inverse: one.div(end.sub(start)),
            border: first.add(zero.select(up, one)),
            left: target.sub(first).abs(),
            ahead: L::splat(-1.0).select(up, one),
            stride: L::splat(-pitch).select(up, L::splat(pitch)),
        };
        (axis, first.mul(L::splat(pitch)))
    }

    /// Ray parameter at which a ray crosses its next border; infinite if there is none.
    #[inline(always)]
    fn next(&self) -> L {
        let more = L::splat(0.0).lt(self.left);
        L::splat(f32::INFINITY).select(more, self.border.sub(self.start).mul(self.inverse))
    }

    /// Advances to the next texel in the lanes of `mask`.
    #[inline(always)]
    fn advance(&mut self, mask: u32, texel: &mut L) {
        let zero = L::splat(0.0);
        self.border = self.border.add(zero.select(mask, self.ahead));
        self.left = self.left.sub(zero.select(mask, L::splat(1.0)));
        *texel = texel.add(zero.select(mask, self.stride));
    }
}

/// Number that, added to an integer from 0 to below 2^23, leaves that integer in the lowest bits: vectors
/// have no conversion.
pub(super) const NUMBER: f32 = 8_388_608.0;

/// Integer that [`NUMBER`] was added to.
#[inline(always)]
pub(super) fn whole(sum: f32) -> usize {
    (sum.to_bits() & 0x7f_ffff) as usize
}

/// Largest integer that is not above `x`, for 0 <= x < 2^22.
#[inline(always)]
pub(super) fn floor<L: Lanes>(x: L) -> L {
    let number = L::splat(NUMBER);
    let rounded = x.add(number).sub(number);
    rounded.sub(L::splat(0.0).select(x.lt(rounded), L::splat(1.0)))
}

impl<L: Lanes> Part<'_, L> {
    /// Points of the rays at a parameter.
    #[inline(always)]
    fn at(&self, t: f32) -> [L; 3] {
        [0, 1, 2].map(|axis| {
            let from = self.origin[axis];
            from.add(self.ends[axis].sub(from).mul(L::splat(t)))
        })
    }

    /// Slice at a depth, with its fraction, clamped to the grid.
    #[inline(always)]
    fn slice(&self, depth: L) -> L {
        let Measures { near, density, slices, .. } = *self.measures;
        let slice = depth.sub(L::splat(near)).mul(L::splat(density));
        slice.max(L::splat(0.0)).min(L::splat(slices - 1.0))
    }

    /// Exact traversal: tests every voxel that a ray passes.
    #[inline(always)]
    fn walk(&self, mut active: u32, mut meets: impl FnMut(usize, usize, usize, usize) -> bool) -> u32 {
        let (mut a, mut b) = (self.at(self.run.from), self.at(self.run.to));
        if !self.run.inside {
            active &= self.clip(&mut a, &mut b);
        }
        let (zero, one, side) = (L::splat(0.0), L::splat(1.0), self.measures.side);
        let inverse = [one.div(a[2]), one.div(b[2])];
        let change = inverse[1].sub(inverse[0]);
        let (mut x, column) = Axis::new(a[0].mul(inverse[0]), b[0].mul(inverse[1]), side, 1.0);
        let (mut y, row) = Axis::new(a[1].mul(inverse[0]), b[1].mul(inverse[1]), side, side);
        let (mut texel, mut slice) = (row.add(column), floor(self.slice(a[2])));

        let mut met = 0;
        let (mut texels, mut enter, mut leave) = ([0.0f32; LANES], [0.0f32; LANES], [0.0f32; LANES]);
        let number = L::splat(NUMBER);
        while active != 0 {
            let (next_x, next_y) = (x.next(), y.next());
            let along = next_x.min(next_y).min(one);
            let depth = one.div(inverse[0].add(along.mul(change)));
            texel.add(number).store(&mut texels);
            slice.add(number).store(&mut enter);
            slice = floor(self.slice(depth));
            slice.add(number).store(&mut leave);
            let last = x.left.add(y.left).le(zero);
            let across = next_x.le(next_y);
            x.advance(across, &mut texel);
            y.advance(!across & L::ALL, &mut texel);
            let mut asked = active;
            while asked != 0 {
                let lane = asked.trailing_zeros() as usize % LANES;
                asked &= asked - 1;
                let hit = meets(lane, whole(texels[lane]), whole(enter[lane]), whole(leave[lane]));
                met |= u32::from(hit) << lane;
            }
            active &= !(met | last);
        }
        met
    }

    /// Clips segments to the grid and returns the mask of those that are not empty.
    #[inline(always)]
    fn clip(&self, a: &mut [L; 3], b: &mut [L; 3]) -> u32 {
        let Measures { side, near, far, .. } = *self.measures;
        let (zero, side) = (L::splat(0.0), L::splat(side));
        let distances = |p: &[L; 3]| {
            let widest = p[2].mul(side);
            let depth = [p[2].sub(L::splat(near)), L::splat(far).sub(p[2])];
            [depth[0], depth[1], p[0], widest.sub(p[0]), p[1], widest.sub(p[1])]
        };
        let (first, second) = (distances(a), distances(b));
        let (mut enter, mut leave) = (zero, L::splat(1.0));
        let mut gone = 0;
        for (first, second) in first.into_iter().zip(second) {
            let (starts_out, ends_out) = (first.lt(zero), second.lt(zero));
            let at = first.div(first.sub(second));
            enter = enter.select(starts_out, enter.max(at));
            leave = leave.select(ends_out, leave.min(at));
            gone |= starts_out & ends_out;
        }
        for axis in 0..3 {
            let (from, d) = (a[axis], b[axis].sub(a[axis]));
            a[axis] = from.add(d.mul(enter));
            b[axis] = from.add(d.mul(leave));
        }
        enter.le(leave) & !gone
    }

    /// Tests samples at equal distances from the origin to the end; the first is half a distance from the
    /// origin.
    #[inline(always)]
    fn step(
        &self,
        count: u32,
        thickness: u32,
        mut active: u32,
        mut meets: impl FnMut(usize, usize, usize, usize) -> bool,
    ) -> u32 {
        let Measures { side, near, far, slices, .. } = *self.measures;
        let (zero, one, last) = (L::splat(0.0), L::splat(1.0), L::splat(side - 1.0));
        let mut met = 0;
        let (mut texels, mut middles) = ([0.0f32; LANES], [0.0f32; LANES]);
        let number = L::splat(NUMBER);
        let first = (self.run.from * count as f32 - 1.0).max(0.0) as u32;
        for sample in first..count {
            let t = (sample as f32 + 0.5) / count as f32;
            if t < self.run.from {
                continue;
            }
            if t > self.run.to || active == 0 {
                break;
            }
            let point = self.at(t);
            let inverse = one.div(point[2]);
            let (column, row) = (point[0].mul(inverse), point[1].mul(inverse));
            let mut inside = L::splat(near).le(point[2]) & point[2].le(L::splat(far));
            inside &= zero.le(column) & column.le(L::splat(side)) & zero.le(row) & row.le(L::splat(side));
            let texel = floor(row.max(zero).min(last)).mul(L::splat(side));
            texel.add(floor(column.max(zero).min(last))).add(number).store(&mut texels);
            floor(self.slice(point[2])).add(number).store(&mut middles);
            let mut asked = active & inside;
            while asked != 0 {
                let lane = asked.trailing_zeros() as usize % LANES;
                asked &= asked - 1;
                let middle = whole(middles[lane]);
                let low = middle.saturating_sub(thickness as usize);
                let high = (middle + thickness as usize).min(slices as usize - 1);
                let hit = meets(lane, whole(texels[lane]), low, high);
                met |= u32::from(hit) << lane;
            }
            active &= !met;
        }
        met
    }
}
