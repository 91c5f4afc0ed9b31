//! Rays that leave one origin, and what they have in common.

use glam::Vec3;

use super::slab::inverse;
use crate::simd::{Lanes, Simd};

/// Rays of a bundle.
pub(crate) const RAYS: usize = 64;

/// Up to 64 rays from one origin.
#[derive(Clone)]
pub(crate) struct Bundle {
    pub(super) origin: Vec3,
    pub(super) count: usize,
    /// Where shadow rays end.
    ends: [[f32; RAYS]; 3],
    pub(super) d: [[f32; RAYS]; 3],
    pub(super) inverse: [[f32; RAYS]; 3],
    pub(super) low: Vec3,
    pub(super) high: Vec3,
}

impl Bundle {
    pub(crate) fn new() -> Self {
        Self {
            origin: Vec3::ZERO,
            count: 0,
            ends: [[0.0; RAYS]; 3],
            d: [[0.0; RAYS]; 3],
            inverse: [[0.0; RAYS]; 3],
            low: Vec3::ZERO,
            high: Vec3::ZERO,
        }
    }

    /// Starts anew with an origin and no rays.
    #[inline(always)]
    pub(crate) fn clear(&mut self, origin: Vec3) {
        (self.origin, self.count) = (origin, 0);
    }

    /// Number of rays.
    #[inline(always)]
    pub(crate) fn count(&self) -> usize {
        self.count
    }

    /// Adds a ray along `d` unless there are 64.
    #[inline(always)]
    pub(crate) fn push(&mut self, d: Vec3) {
        if self.count < RAYS {
            for axis in 0..3 {
                self.d[axis][self.count] = d[axis];
            }
            self.count += 1;
        }
    }

    /// Adds a shadow ray that stops at `end` unless there are 64.
    #[inline(always)]
    pub(super) fn push_end(&mut self, end: Vec3) {
        if self.count < RAYS {
            for axis in 0..3 {
                self.ends[axis][self.count] = end[axis];
            }
        }
        self.push(end - self.origin);
    }

    /// The direction of a ray.
    #[inline(always)]
    pub(crate) fn direction(&self, ray: usize) -> Vec3 {
        Vec3::new(self.d[0][ray], self.d[1][ray], self.d[2][ray])
    }

    /// The end of a shadow ray.
    #[inline(always)]
    pub(super) fn end(&self, ray: usize) -> Vec3 {
        Vec3::new(self.ends[0][ray], self.ends[1][ray], self.ends[2][ray])
    }

    /// Reciprocals and bounds, once all rays are there. Unused lanes repeat the first ray.
    #[inline(always)]
    pub(crate) fn finish<S: Simd>(&mut self) {
        let width = S::Wide::WIDTH;
        let filled = self.count.next_multiple_of(width);
        for axis in 0..3 {
            for ray in self.count..filled {
                self.d[axis][ray] = self.d[axis][0];
            }
            let first = S::Wide::splat(self.d[axis][0]);
            let (mut low, mut high) = (first, first);
            for at in (0..filled).step_by(width) {
                let d = S::Wide::load(&self.d[axis][at..]);
                (low, high) = (low.min(d), high.max(d));
                inverse(d).store(&mut self.inverse[axis][at..]);
            }
            let (mut lows, mut highs) = ([0.0f32; 16], [0.0f32; 16]);
            low.store(&mut lows);
            high.store(&mut highs);
            self.low[axis] = lows[..width].iter().fold(f32::INFINITY, |a, &b| a.min(b));
            self.high[axis] = highs[..width].iter().fold(f32::NEG_INFINITY, |a, &b| a.max(b));
        }
    }
}
