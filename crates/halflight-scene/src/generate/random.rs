//! Small pseudo-random sequence from an integer hash.

use std::f32::consts::TAU;

use glam::Vec3;

/// Generator of numbers: a 32-bit counter hashed with the finalizer of MurmurHash3.
pub(super) struct Random(u32);

impl Random {
    /// Independent sequence for every pair of numbers.
    pub(super) fn new(seed: u32, stream: u32) -> Self {
        Self(mix(seed ^ mix(stream.wrapping_add(0x9e37_79b9))))
    }

    /// Uniform number in 0 ≤ x < 1.
    pub(super) fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9);
        (mix(self.0) >> 8) as f32 / (1 << 24) as f32
    }

    /// Uniform number in `low ≤ x < high`.
    pub(super) fn between(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.unit()
    }

    /// Uniformly distributed direction.
    pub(super) fn direction(&mut self) -> Vec3 {
        let y = self.between(-1.0, 1.0);
        let (sin, cos) = (self.unit() * TAU).sin_cos();
        let out = (1.0 - y * y).max(0.0).sqrt();
        Vec3::new(out * cos, y, out * sin)
    }
}

fn mix(mut bits: u32) -> u32 {
    bits ^= bits >> 16;
    bits = bits.wrapping_mul(0x85eb_ca6b);
    bits ^= bits >> 13;
    bits = bits.wrapping_mul(0xc2b2_ae35);
    bits ^ (bits >> 16)
}
