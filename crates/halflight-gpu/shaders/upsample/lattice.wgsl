// Lattice upsampling, per pixel: bilinear between the corners of the pixel's cell
// (halflight-cpu/src/upsample/lattice.rs).
//@ needs shared/corners upsample/pixels

fn value_at(at: vec2<u32>, owner: Owner) -> f32 {
    let corners = corners_of(owner.level, owner.cell);
    var values = vec4(-1.0);
    var low = 3e38;
    var high = -3e38;
    var same = true;
    let triangle = triangle_at(pixel_of(at));
    for (var number = 0u; number < 4u; number++) {
        let corner = pixel_of(corner_at(corners, number));
        same &= triangle_at(corner) == triangle;
        if is_receiver(corner) {
            values[number] = samples[corner].value;
        }
        same &= values[number] >= 0.0;
        if values[number] >= 0.0 {
            low = min(low, values[number]);
            high = max(high, values[number]);
        }
    }
    if low == high {
        return low;
    }
    if low > high {
        // All values are undefined: the light is below the horizon, and the pixel is 0.
        return 0.0;
    }
    if same {
        // All on one triangle: the most common case of values that vary.
        let weights = bilinear_weights(corners, at);
        let sum = weights.x * values.x + weights.y * values.y;
        return clamp(sum + weights.z * values.z + weights.w * values.w, low, high);
    }
    let found = interpolated(corners, values, at);
    // If all corners on the pixel's surface are undefined, the light is below their horizons and the pixel
    // gets almost none.
    return select(0.5 * (low + high), clamp(found.value, low, high), found.exists);
}
