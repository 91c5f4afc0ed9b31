// Adds the irradiance of one textured light to the image, per pixel: from interpolated visible fractions of red, green
// and blue to linear RGB.
//@ needs shared/receiver shared/unshadowed textured/seen
//@ reads planes
//@ writes image

// Quantity in `planes`: 0 irradiance per radiance, 1 the visible fraction.
override SHADING: u32 = 1u;

@compute @workgroup_size(8, 8)
fn compose(@builtin(global_invocation_id) at: vec3<u32>) {
    if at.x >= frame.width || at.y >= frame.height {
        return;
    }
    let pixel = at.y * frame.width + at.x;
    let pixels = frame.width * frame.height;
    var value = vec3(planes[pixel], planes[pixels + pixel], planes[2u * pixels + pixel]);
    // In umbra the unshadowed irradiance is irrelevant.
    if SHADING == 1u && any(value != vec3(0.0)) {
        if is_receiver(pixel) {
            let receiver = receiver_at(pixel);
            value *= unshadowed(receiver.origin, receiver.normal) * seen(receiver.origin, receiver.normal);
        } else {
            value = vec3(0.0);
        }
    }
    let before = select(image[pixel], vec4(0.0), frame.light == 0u);
    image[pixel] = vec4(before.xyz + frame.radiance * value, 1.0);
}
