// Surfaces of the G-buffer: `normal` holds the bits of unit normals and the triangle's index (NONE for the
// background), of all pixels; in scenes with smooth surfaces, shading normals of all pixels follow.
//@ reads normal

fn triangle_at(pixel: u32) -> u32 {
    return normal[pixel].w;
}

fn is_receiver(pixel: u32) -> bool {
    return triangle_at(pixel) != NONE;
}

fn normal_at(pixel: u32) -> vec3<f32> {
    return bitcast<vec3<f32>>(normal[pixel].xyz);
}

// Normal by which light is weighted.
fn shading_at(pixel: u32) -> vec3<f32> {
    return bitcast<vec3<f32>>(normal[pixel + frame.shading].xyz);
}
