// Specularly reflected radiance of pixels.
//@ reads specular

fn reflected_at(pixel: u32) -> vec3<f32> {
    return specular[pixel].xyz;
}
