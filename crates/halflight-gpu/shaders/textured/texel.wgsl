// Texels of a light (halflight-core/src/light_texture.rs).
//@ reads emitted

// Factors of the light's radiance at a place in the unit square.
fn texel_at(place: vec2<f32>) -> vec3<f32> {
    let size = frame.texture_size.xy;
    let turned = select(place, place.yx, frame.texture_size.z == 1u);
    let at = min(vec2<u32>(turned * vec2<f32>(size)), size - 1u);
    return emitted[frame.texture.w - 1u + (size.y - 1u - at.y) * size.x + at.x].xyz;
}
