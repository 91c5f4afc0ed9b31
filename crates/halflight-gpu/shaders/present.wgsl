// Writes the image to the caller's texture, per pixel: a triangle that covers the texture reads the image
// buffer.
//@ reads image

@vertex
fn cover(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4<f32> {
    return vec4(f32((vertex & 1u) * 4u) - 1.0, f32((vertex & 2u) * 2u) - 1.0, 0.0, 1.0);
}

@fragment
fn pixel(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    let place = min(vec2<u32>(at.xy), vec2(frame.width, frame.height) - 1u);
    return image[place.y * frame.width + place.x];
}
