// Adds the irradiance of one light to the image, per pixel: from interpolated values to linear RGB.
//@ needs shared/receiver shared/unshadowed
//@ reads plane
//@ writes image

// Quantity in `plane`: 0 irradiance per radiance, 1 the visible fraction.
override SHADING: u32 = 1u;

@compute @workgroup_size(8, 8)
fn compose(@builtin(global_invocation_id) at: vec3<u32>) {
    if at.x >= frame.width || at.y >= frame.height {
        return;
    }
    let pixel = at.y * frame.width + at.x;
    var value = plane[pixel];
    // In umbra the unshadowed irradiance is irrelevant.
    if SHADING == 1u && value != 0.0 {
        if is_receiver(pixel) {
            let receiver = receiver_at(pixel);
            value *= unshadowed(receiver.origin, receiver.normal);
        } else {
            value = 0.0;
        }
    }
    let before = select(image[pixel], vec4(0.0), frame.light == 0u);
    image[pixel] = vec4(before.xyz + frame.radiance * value, 1.0);
}
