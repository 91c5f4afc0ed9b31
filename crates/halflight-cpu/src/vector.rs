//! Points and directions, one per lane.

use glam::Vec3;

use crate::simd::Lanes;

/// `WIDTH` vectors of three numbers.
#[derive(Clone, Copy)]
pub(crate) struct Vector<L> {
    pub(crate) x: L,
    pub(crate) y: L,
    pub(crate) z: L,
}

impl<L: Lanes> Vector<L> {
    #[inline(always)]
    pub(crate) fn splat(v: Vec3) -> Self {
        Self { x: L::splat(v.x), y: L::splat(v.y), z: L::splat(v.z) }
    }

    #[inline(always)]
    pub(crate) fn load<const N: usize>(from: &[[f32; N]], at: usize) -> Self {
        Self { x: L::load(&from[0][at..]), y: L::load(&from[1][at..]), z: L::load(&from[2][at..]) }
    }

    /// One vector of an array of vectors, broadcast to all lanes.
    #[inline(always)]
    pub(crate) fn broadcast<const N: usize>(from: &[[f32; N]], at: usize) -> Self {
        Self { x: L::splat(from[0][at]), y: L::splat(from[1][at]), z: L::splat(from[2][at]) }
    }

    #[inline(always)]
    pub(crate) fn store<const N: usize>(self, to: &mut [[f32; N]], at: usize) {
        self.x.store(&mut to[0][at..]);
        self.y.store(&mut to[1][at..]);
        self.z.store(&mut to[2][at..]);
    }

    #[inline(always)]
    pub(crate) fn add(self, o: Self) -> Self {
        Self { x: self.x.add(o.x), y: self.y.add(o.y), z: self.z.add(o.z) }
    }

    #[inline(always)]
    pub(crate) fn sub(self, o: Self) -> Self {
        Self { x: self.x.sub(o.x), y: self.y.sub(o.y), z: self.z.sub(o.z) }
    }

    #[inline(always)]
    pub(crate) fn mul(self, o: Self) -> Self {
        Self { x: self.x.mul(o.x), y: self.y.mul(o.y), z: self.z.mul(o.z) }
    }

    #[inline(always)]
    pub(crate) fn min(self, o: Self) -> Self {
        Self { x: self.x.min(o.x), y: self.y.min(o.y), z: self.z.min(o.z) }
    }

    #[inline(always)]
    pub(crate) fn max(self, o: Self) -> Self {
        Self { x: self.x.max(o.x), y: self.y.max(o.y), z: self.z.max(o.z) }
    }

    #[inline(always)]
    pub(crate) fn abs(self) -> Self {
        Self { x: self.x.abs(), y: self.y.abs(), z: self.z.abs() }
    }

    /// The largest component.
    #[inline(always)]
    pub(crate) fn largest(self) -> L {
        self.x.max(self.y).max(self.z)
    }

    #[inline(always)]
    pub(crate) fn flip(self, signs: L) -> Self {
        Self { x: self.x.flip(signs), y: self.y.flip(signs), z: self.z.flip(signs) }
    }

    /// `x + y + z`, in this order: sums of larger terms are never smaller.
    #[inline(always)]
    pub(crate) fn sum(self) -> L {
        self.x.add(self.y).add(self.z)
    }

    #[inline(always)]
    pub(crate) fn dot(self, o: Self) -> L {
        self.mul(o).sum()
    }

    /// Upper bound on the dot product with any vector between `low` and `high`, rounding included.
    #[inline(always)]
    pub(crate) fn greatest_dot(self, low: Self, high: Self) -> L {
        self.mul(low).max(self.mul(high)).sum()
    }

    #[inline(always)]
    pub(crate) fn cross(self, o: Self) -> Self {
        Self {
            x: self.y.mul(o.z).sub(self.z.mul(o.y)),
            y: self.z.mul(o.x).sub(self.x.mul(o.z)),
            z: self.x.mul(o.y).sub(self.y.mul(o.x)),
        }
    }
}
