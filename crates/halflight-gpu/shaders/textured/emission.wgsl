// Radiance of a textured light at a place in the unit square.
//@ needs textured/texel

fn emission_at(place: vec2<f32>) -> vec3<f32> {
    return frame.radiance * texel_at(place);
}
