//! Packet of rays that leave one origin, and bounds on their directions.

use glam::Vec3;

use super::slab::inverse;
use crate::simd::{Lanes, Simd};

/// Most rays of a packet of shadow rays.
pub(crate) const RAYS: usize = 64;

/// Most rays of a packet.
const MOST: usize = 256;

/// Rays of a group: consecutive rays of a packet whose directions are bounded together.
pub(crate) const GROUP: usize = 16;

/// Up to `N` rays from one origin, [`MOST`] at most.
#[derive(Clone)]
pub(crate) struct Packet<const N: usize = RAYS> {
    pub(crate) origin: Vec3,
    pub(crate) count: usize,
    /// End points of shadow rays.
    ends: [[f32; N]; 3],
    pub(crate) d: [[f32; N]; 3],
    pub(crate) inverse: [[f32; N]; 3],
    pub(crate) low: Vec3,
    pub(crate) high: Vec3,
    /// Bounds on the directions of each group.
    pub(crate) lows: [Vec3; MOST / GROUP],
    pub(crate) highs: [Vec3; MOST / GROUP],
}

impl<const N: usize> Packet<N> {
    pub(crate) fn new() -> Self {
        const { assert!(N <= MOST && N.is_multiple_of(GROUP)) }
        Self {
            origin: Vec3::ZERO,
            count: 0,
            ends: [[0.0; N]; 3],
            d: [[0.0; N]; 3],
            inverse: [[0.0; N]; 3],
            low: Vec3::ZERO,
            high: Vec3::ZERO,
            lows: [Vec3::ZERO; MOST / GROUP],
            highs: [Vec3::ZERO; MOST / GROUP],
        }
    }

    /// Removes all rays and sets the origin.
    #[inline(always)]
    pub(crate) fn clear(&mut self, origin: Vec3) {
        (self.origin, self.count) = (origin, 0);
    }

    /// Adds a ray along `d`; does nothing if the packet is full.
    #[inline(always)]
    pub(crate) fn push(&mut self, d: Vec3) {
        if self.count < N {
            for axis in 0..3 {
                self.d[axis][self.count] = d[axis];
            }
            self.count += 1;
        }
    }

    /// Resets the packet to shadow rays towards the first `count` end points, which were written through
    /// [`Packet::ends_mut`].
    #[inline(always)]
    pub(crate) fn set_ends<S: Simd>(&mut self, origin: Vec3, count: usize) {
        (self.origin, self.count) = (origin, count.min(N));
        for axis in 0..3 {
            let origin = S::Wide::splat(origin[axis]);
            for at in (0..self.count).step_by(S::Wide::WIDTH) {
                S::Wide::load(&self.ends[axis][at..]).sub(origin).store(&mut self.d[axis][at..]);
            }
        }
        self.bound::<S, true>();
    }

    /// End points of shadow rays, one array per axis.
    #[inline(always)]
    pub(crate) fn ends_mut(&mut self) -> &mut [[f32; N]; 3] {
        &mut self.ends
    }

    /// Direction of a ray.
    #[inline(always)]
    pub(crate) fn direction(&self, ray: usize) -> Vec3 {
        Vec3::new(self.d[0][ray], self.d[1][ray], self.d[2][ray])
    }

    /// End point of a shadow ray.
    #[inline(always)]
    pub(crate) fn end(&self, ray: usize) -> Vec3 {
        Vec3::new(self.ends[0][ray], self.ends[1][ray], self.ends[2][ray])
    }

    /// Computes the bounds that closest-hit traversal needs, after all rays were added.
    #[inline(always)]
    pub(crate) fn finish<S: Simd>(&mut self) {
        self.bound::<S, false>();
    }

    /// Computes the bounds of all groups, and reciprocals of directions where single rays are traced. Unused
    /// lanes of the last group repeat its first ray.
    #[inline(always)]
    fn bound<S: Simd, const SINGLE: bool>(&mut self) {
        let width = S::Wide::WIDTH;
        let filled = self.count.next_multiple_of(GROUP);
        (self.low, self.high) = (Vec3::INFINITY, Vec3::NEG_INFINITY);
        for first in (0..filled).step_by(GROUP) {
            let (mut least, mut most) = (Vec3::ZERO, Vec3::ZERO);
            for axis in 0..3 {
                let d = &mut self.d[axis];
                for ray in self.count.max(first)..first + GROUP {
                    d[ray] = d[first];
                }
                let start = S::Wide::splat(d[first]);
                let (mut low, mut high) = (start, start);
                for at in (first..first + GROUP).step_by(width) {
                    let d = S::Wide::load(&d[at..]);
                    (low, high) = (low.min(d), high.max(d));
                    if SINGLE {
                        inverse(d).store(&mut self.inverse[axis][at..]);
                    }
                }
                (least[axis], most[axis]) = (low.least(), high.greatest());
            }
            (self.lows[first / GROUP], self.highs[first / GROUP]) = (least, most);
            (self.low, self.high) = (self.low.min(least), self.high.max(most));
        }
    }
}
