// Specularly reflected radiance of pixels in scenes without glossy surfaces.

fn reflected_at(pixel: u32) -> vec3<f32> {
    return vec3(0.0);
}
