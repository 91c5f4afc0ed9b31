// Adds the irradiance of one light to the image, per pixel: from interpolated values to linear RGB. `values_at` and `seen_at`
// are those of a uniform or of a textured light.
//@ needs shared/receiver shared/unshadowed
//@ writes image

// Interpolated quantity: 0 irradiance per radiance, 1 the visible fraction.
override SHADING: u32 = 1u;

@compute @workgroup_size(8, 8)
fn compose(@builtin(global_invocation_id) at: vec3<u32>) {
    if at.x >= frame.width || at.y >= frame.height {
        return;
    }
    let pixel = at.y * frame.width + at.x;
    var value = values_at(pixel);
    // In umbra the unshadowed irradiance is irrelevant.
    if SHADING == 1u && any(value != vec3(0.0)) {
        if is_receiver(pixel) {
            let receiver = receiver_at(pixel);
            value *= unshadowed(receiver.origin, receiver.normal) * seen_at(receiver);
        } else {
            value = vec3(0.0);
        }
    }
    let before = select(image[pixel], vec4(0.0), frame.light == 0u);
    image[pixel] = vec4(before.xyz + frame.radiance * value, 1.0);
}
