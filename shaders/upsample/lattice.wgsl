// Bilinear between the corners of cells (halflight-cpu/src/upsample/lattice.rs).

@compute @workgroup_size(8, 8)
fn lattice(@builtin(global_invocation_id) at: vec3<u32>) {
    if at.x >= frame.width || at.y >= frame.height {
        return;
    }
    let pixel = at.y * frame.width + at.x;
    let level = owners[pixel];
    if level == NONE || !is_receiver(pixel) {
        plane[pixel] = 0.0;
    } else if level == 0u {
        plane[pixel] = max(samples[pixel].value, 0.0);
    } else {
        plane[pixel] = value_at(at.xy, corners_of(level, at.xy >> vec2(level)));
    }
}

fn value_at(at: vec2<u32>, corners: Corners) -> f32 {
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
        // Where no value exists the light is below the horizon, and so is all that is multiplied with it.
        return 0.0;
    }
    if same {
        // All on one triangle, which is most of what is not flat.
        let weights = corner_weights(corners, at);
        let sum = weights.x * values.x + weights.y * values.y;
        return clamp(sum + weights.z * values.z + weights.w * values.w, low, high);
    }
    let found = interpolated(corners, values, at);
    // Where the light is below the horizon of all corners on the pixel's surface there is next to none.
    return select(0.5 * (low + high), clamp(found.value, low, high), found.exists);
}
