//! The one source of randomness: a 32-bit integer hash, since shading languages have no 64-bit integers to rely on.

/// A bijective 32-bit mix with low bias (Wellons' "lowbias32" constants).
#[inline]
pub const fn mix(value: u32) -> u32 {
    let mut x = value;
    x ^= x >> 16;
    x = x.wrapping_mul(0x21f0_aaad);
    x ^= x >> 15;
    x = x.wrapping_mul(0xd35a_2d97);
    x ^ (x >> 15)
}

/// Folds `value` into `state`; a chain of folds makes a key out of several numbers.
#[inline]
pub const fn fold(state: u32, value: u32) -> u32 {
    mix(state ^ mix(value.wrapping_add(0x9e37_79b9)))
}

/// The key of a light-sample pattern: all that randomness may depend on, besides the sample's index.
///
/// `place` is the pixel for a pattern of its own, or whatever the receivers that share one have in common.
#[inline]
pub const fn pattern_key(place: u32, light: u32, frame: u32, seed: u32) -> u32 {
    fold(fold(fold(mix(seed), frame), light), place)
}

/// The random bits of sample `index` in the pattern with this key.
#[inline]
pub const fn sample_bits(key: u32, index: u32) -> u32 {
    mix(key.wrapping_add(index.wrapping_mul(0x9e37_79b9)))
}

/// The two halves of 32 random bits as numbers strictly inside 0 … 1.
#[inline]
pub fn unit_pair(bits: u32) -> (f32, f32) {
    const SCALE: f32 = 1.0 / 65536.0;
    (((bits >> 16) as f32 + 0.5) * SCALE, ((bits & 0xffff) as f32 + 0.5) * SCALE)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_argument_changes_the_key() {
        let base = pattern_key(1, 2, 3, 4);
        for other in [
            pattern_key(2, 2, 3, 4),
            pattern_key(1, 3, 3, 4),
            pattern_key(1, 2, 4, 4),
            pattern_key(1, 2, 3, 5),
        ] {
            assert_ne!(base, other);
        }
    }

    #[test]
    fn unit_pairs_are_uniform_and_inside() {
        let count = 1 << 16;
        let (mut sum, mut low, mut high) = (0.0f64, 1.0f32, 0.0f32);
        for index in 0..count {
            let (u, v) = unit_pair(sample_bits(7, index));
            sum += f64::from(u) + f64::from(v);
            low = low.min(u).min(v);
            high = high.max(u).max(v);
        }
        assert!(low > 0.0 && high < 1.0);
        // Standard error of the mean of 2^17 uniform numbers is 0.0008; five of them.
        assert!((sum / f64::from(2 * count) - 0.5).abs() < 0.004);
    }
}
