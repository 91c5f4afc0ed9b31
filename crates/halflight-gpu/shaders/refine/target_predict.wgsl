// Estimates the squared error of one light's irradiance by luminance, per tile: from the masks at the corners
// of cells (halflight-cpu/src/refine/lattice/error_estimate.rs).
//@ needs shared/fractions shared/inside shared/tiles shared/unshadowed
//@ reads owners plane

// True if fractions are smoothed: `plane` then holds the noise that is left.
override SMOOTHED: bool = false;

// Mean squared errors of the visible fraction in cells whose corners agree, in cells whose corners differ
// (relative to the squared difference), and of both kinds across a depth discontinuity: `assumed` in
// halflight-cpu/src/refine/lattice/validate.rs. The GPU does not validate cells.
const AGREED: f32 = 2e-5;
const CURVATURE: f32 = 0.06;
const STEP_AGREED: f32 = 5e-4;
const STEP_MIXED: f32 = 2e-3;

@compute @workgroup_size(8, 8)
fn predict(here: Tile) {
    var share = 0.0;
    if here.at.x < frame.width && here.at.y < frame.height {
        let level = owners[pixel_of(here.at.xy)];
        // The first pixel of a cell represents it.
        if level != NONE && all(((here.at.xy >> vec2(level)) << vec2(level)) == here.at.xy) {
            share = expected(level, here.at.xy);
        }
    }
    let power = luminance(frame.mean_radiance.xyz);
    add_up(here, share * power * power);
}

fn expected(level: u32, first: vec2<u32>) -> f32 {
    let corners = corners_of(level, first >> vec2(level));
    var low = 1.0;
    var high = 0.0;
    var strongest = 0.0;
    for (var number = 0u; number < 4u; number++) {
        let pixel = pixel_of(corner_at(corners, number));
        if !is_receiver(pixel) {
            continue;
        }
        let receiver = receiver_at(pixel);
        strongest = max(strongest, unshadowed(receiver.origin, receiver.normal));
        let fraction = fraction_at(pixel);
        if fraction >= 0.0 {
            low = min(low, fraction);
            high = max(high, fraction);
        }
    }
    var error = 0.0;
    if level == 0u {
        var variance = variance_at(pixel_of(first));
        if SMOOTHED {
            variance = plane[pixel_of(first)];
        }
        error = select(0.0, variance, high >= low);
    } else {
        let difference = clamp(high - low, 0.0, frame.error);
        error = select(AGREED, CURVATURE * difference * difference, difference > 0.0);
        if discontinuities_inside(level, first >> vec2(level)) == STEP {
            error = select(STEP_AGREED, STEP_MIXED, difference > 0.0);
        }
    }
    let pixels = min(vec2(1u << level), vec2(frame.width, frame.height) - first);
    return error * strongest * strongest * f32(pixels.x * pixels.y);
}
