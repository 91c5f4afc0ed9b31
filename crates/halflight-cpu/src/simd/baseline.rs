//! Vectors as plain arrays, without explicit instructions. The compiler vectorises most of the operations.

use halflight_core::hash;

use super::{Kernel, Lanes, Simd};

pub(super) struct Baseline;

impl Simd for Baseline {
    type Wide = Array;
    type Eight = Array;

    #[inline(never)]
    fn call<K: Kernel>(kernel: K) -> K::Output {
        kernel.run::<Self>()
    }

    fn deposit(bits: u64, mut mask: u64) -> u64 {
        let (mut put, mut bits) = (0, bits);
        while mask != 0 {
            put |= (mask & mask.wrapping_neg()) * (bits & 1);
            mask &= mask - 1;
            bits >>= 1;
        }
        put
    }
}

#[derive(Clone, Copy)]
pub(crate) struct Array([f32; 8]);

impl Array {
    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(f32, f32) -> f32) -> Self {
        let mut out = self.0;
        for (a, b) in out.iter_mut().zip(other.0) {
            *a = f(*a, b);
        }
        Self(out)
    }

    #[inline(always)]
    fn bits(self, other: Self, f: impl Fn(f32, f32) -> bool) -> u32 {
        let mut bits = 0;
        for lane in 0..8 {
            bits |= u32::from(f(self.0[lane], other.0[lane])) << lane;
        }
        bits
    }
}

impl Lanes for Array {
    const WIDTH: usize = 8;

    #[inline(always)]
    fn splat(value: f32) -> Self {
        Self([value; 8])
    }
    #[inline(always)]
    fn load(from: &[f32]) -> Self {
        let mut out = [0.0; 8];
        out.copy_from_slice(&from[..8]);
        Self(out)
    }
    #[inline(always)]
    fn store(self, to: &mut [f32]) {
        to[..8].copy_from_slice(&self.0);
    }
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.zip(other, |a, b| a + b)
    }
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.zip(other, |a, b| a - b)
    }
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.zip(other, |a, b| a * b)
    }
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        self.zip(other, |a, b| a / b)
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.zip(other, |a, b| if a < b { a } else { b })
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.zip(other, |a, b| if a > b { a } else { b })
    }
    #[inline(always)]
    fn abs(self) -> Self {
        self.zip(self, |a, _| a.abs())
    }
    #[inline(always)]
    fn flip(self, signs: Self) -> Self {
        self.zip(signs, |a, s| f32::from_bits(a.to_bits() ^ (s.to_bits() & 0x8000_0000)))
    }
    #[inline(always)]
    fn select(self, mask: u32, other: Self) -> Self {
        let mut out = self.0;
        for (lane, (a, b)) in out.iter_mut().zip(other.0).enumerate() {
            *a = if mask >> lane & 1 == 1 { b } else { *a };
        }
        Self(out)
    }
    #[inline(always)]
    fn truncate(self) -> Self {
        self.zip(self, |a, _| (a as i32) as f32)
    }
    #[inline(always)]
    fn run_of_bits(first: Self, end: Self, to: &mut [u32; 16]) {
        let from = |count: f32| u32::MAX.checked_shl(count as u32).unwrap_or(0);
        for ((to, first), end) in to.iter_mut().zip(first.0).zip(end.0) {
            *to = from(first) & !from(end);
        }
    }
    #[inline(always)]
    fn jitter(key: u32, index: Self) -> (Self, Self) {
        let (mut u, mut v) = ([0.0; 8], [0.0; 8]);
        for ((u, v), index) in u.iter_mut().zip(&mut v).zip(index.0) {
            (*u, *v) = hash::unit_pair(hash::sample_bits(key, index as u32));
        }
        (Self(u), Self(v))
    }
    #[inline(always)]
    fn least(self) -> f32 {
        self.0.into_iter().fold(f32::INFINITY, |a, b| if a < b { a } else { b })
    }

    #[inline(always)]
    fn greatest(self) -> f32 {
        self.0.into_iter().fold(f32::NEG_INFINITY, |a, b| if a > b { a } else { b })
    }

    #[inline(always)]
    fn lt(self, other: Self) -> u32 {
        self.bits(other, |a, b| a < b)
    }
    #[inline(always)]
    fn le(self, other: Self) -> u32 {
        self.bits(other, |a, b| a <= b)
    }
}
