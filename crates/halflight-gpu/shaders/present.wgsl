// Writes the radiance that leaves each pixel to the caller's texture: a triangle that covers the texture reads the buffers of the
// frame. `reflected_at` and `lamp_at` are those of scenes with or without glossy surfaces and visible lights.
//@ reads image albedo

// True where the albedo of the surfaces is not known: they are white.
override WHITE: bool = false;

// True if the texture keeps sRGB values that nothing else encodes.
override ENCODE: bool = false;

@vertex
fn cover(@builtin(vertex_index) vertex: u32) -> @builtin(position) vec4<f32> {
    return vec4(f32((vertex & 1u) * 4u) - 1.0, f32((vertex & 2u) * 2u) - 1.0, 0.0, 1.0);
}

@fragment
fn pixel(@builtin(position) at: vec4<f32>) -> @location(0) vec4<f32> {
    let place = min(vec2<u32>(at.xy), vec2(frame.width, frame.height) - 1u);
    let pixel = place.y * frame.width + place.x;
    let diffuse = image[pixel].xyz * select(albedo[pixel].xyz, vec3(1.0), WHITE) * 0.318309886;
    let lamp = lamp_at(pixel);
    let radiance = select(diffuse + reflected_at(pixel), lamp.xyz, lamp.w != 0.0);
    return vec4(select(radiance, encoded(radiance), ENCODE), 1.0);
}

// sRGB values of linear ones (IEC 61966-2-1), from 0 to 1.
fn encoded(linear: vec3<f32>) -> vec3<f32> {
    let clamped = clamp(linear, vec3(0.0), vec3(1.0));
    let curve = 1.055 * pow(clamped, vec3(1.0 / 2.4)) - 0.055;
    return select(curve, 12.92 * clamped, clamped <= vec3(0.0031308));
}
