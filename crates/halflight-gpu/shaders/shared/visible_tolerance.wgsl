// Interpolation tolerance between corners: that of the sampling plan, bounded by visible errors where these are bounded
// (halflight-cpu/src/refine/lattice/split_test.rs).
//@ needs shared/fractions

// Bound on visible errors relative to the irradiance around them, or 0 for none.
override VISIBLE_ERROR: f32 = 0.0;

// Interpolation tolerance relative to the bound, and its least value in standard deviations of the corners' noise.
const TOLERANCE_IN_VISIBLE_ERROR: f32 = 2.0;
const LEAST_DEVIATIONS: f32 = 2.5;

// Visible fraction that is added to the local brightness. The CPU takes the same part of the root mean square of the irradiance.
const FLOOR: f32 = 0.06;

fn tolerance_between(corners: Corners, found: vec4<f32>) -> f32 {
    if VISIBLE_ERROR <= 0.0 {
        return frame.error;
    }
    var sum = 0.0;
    var noise = 0.0;
    var count = 0.0;
    for (var number = 0u; number < 4u; number++) {
        if found[number] >= 0.0 {
            sum += found[number];
            count += 1.0;
        }
        if found[number] > 0.0 && found[number] < 1.0 {
            noise += variance_at(pixel_of(corner_at(corners, number)));
        }
    }
    count = max(count, 1.0);
    let visible = VISIBLE_ERROR * TOLERANCE_IN_VISIBLE_ERROR * (sum / count + FLOOR);
    return min(frame.error, max(visible, LEAST_DEVIATIONS * sqrt(noise / count)));
}
