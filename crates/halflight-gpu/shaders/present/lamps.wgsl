// Radiance of the light that a pixel sees, and its distance; the distance is 0 where it sees none.
//@ reads emission

fn lamp_at(pixel: u32) -> vec4<f32> {
    return emission[pixel];
}
