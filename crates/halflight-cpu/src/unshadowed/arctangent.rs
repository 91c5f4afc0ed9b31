//! Angles that edges of a light subtend, from sine and cosine.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

/// Coefficients of `atan(t)/t − 1` in powers of t².
const SERIES: [f64; 13] = {
    let mut series = [0.0; 13];
    let mut term = 0;
    while term < series.len() {
        let sign = if term % 2 == 0 { -1.0 } else { 1.0 };
        series[term] = sign / (2 * term + 3) as f64;
        term += 1;
    }
    series
};

/// `atan2(sine, cosine) / sine` for `sine ≥ 0`: the angle between two vectors over the length of their cross product.
///
/// The argument of the arctangent is brought to 0 … tan(π/8), where 14 terms of its series are good to 1e-12.
/// A receiver on an edge of the light (sine 0, cosine ≤ 0) has no limit: it gets 0 from the factor that multiplies this.
#[inline(always)]
pub(super) fn angle_over_sine(sine: f64, cosine: f64) -> f64 {
    const TAN_PI_8: f64 = 0.414_213_562_373_095_03;
    const TAN_3_PI_8: f64 = 2.414_213_562_373_095;
    let magnitude = cosine.abs();
    let low = sine <= TAN_PI_8 * magnitude;
    let high = sine >= TAN_3_PI_8 * magnitude;
    let numerator = if low {
        sine
    } else if high {
        -magnitude
    } else {
        sine - magnitude
    };
    let denominator = if low {
        magnitude
    } else if high {
        sine
    } else {
        sine + magnitude
    };
    let base = if low {
        0.0
    } else if high {
        FRAC_PI_2
    } else {
        FRAC_PI_4
    };
    let t = numerator / denominator.max(f64::MIN_POSITIVE);
    let z = t * t;
    let series = SERIES.iter().rev().fold(0.0, |sum, &coefficient| (sum + coefficient) * z);
    let atan = base + t * (1.0 + series);
    let angle = if cosine < 0.0 { PI - atan } else { atan };
    // For a tiny sine the quotient is computed from the series alone, without dividing 0 by 0.
    if low && cosine > 0.0 { (1.0 + series) / magnitude } else { angle / sine.max(f64::MIN_POSITIVE) }
}

/// Computes [`angle_over_sine`] in single precision. Eight terms of the series are good to 1e-8.
#[inline(always)]
pub(super) fn quick_angle_over_sine(sine: f32, cosine: f32) -> f32 {
    const TAN_PI_8: f32 = 0.414_213_57;
    const TAN_3_PI_8: f32 = 2.414_213_7;
    let magnitude = cosine.abs();
    let low = sine <= TAN_PI_8 * magnitude;
    let high = sine >= TAN_3_PI_8 * magnitude;
    let (numerator, denominator, base) = if low {
        (sine, magnitude, 0.0)
    } else if high {
        (-magnitude, sine, FRAC_PI_2 as f32)
    } else {
        (sine - magnitude, sine + magnitude, FRAC_PI_4 as f32)
    };
    let t = numerator / denominator.max(f32::MIN_POSITIVE);
    let z = t * t;
    let series = SERIES[..8].iter().rev().fold(0.0f32, |sum, &coefficient| (sum + coefficient as f32) * z);
    let atan = base + (t + t * series);
    let angle = if cosine < 0.0 { PI as f32 - atan } else { atan };
    if low && cosine > 0.0 { (1.0 + series) / magnitude } else { angle / sine.max(f32::MIN_POSITIVE) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_arctangent_is_good_to_twelve_digits() {
        for step in 0..=10_000 {
            let angle = PI * f64::from(step) / 10_000.0;
            let (sine, cosine) = (angle.sin(), angle.cos());
            if sine > 1e-9 {
                let expected = sine.atan2(cosine) / sine;
                assert!((angle_over_sine(sine, cosine) / expected - 1.0).abs() < 2e-12, "{angle}");
            }
        }
        assert_eq!(angle_over_sine(0.0, 4.0), 0.25);
    }
}
