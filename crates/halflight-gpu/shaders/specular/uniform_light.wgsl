// A uniform light, as lobes see it: its texture is 1 everywhere.

fn factors_at(uv: vec2<f32>) -> vec3<f32> {
    return vec3(1.0);
}

fn factors_around(uv: vec2<f32>, side: f32) -> vec3<f32> {
    return vec3(1.0);
}

fn share_of(reflected: vec3<f32>) -> f32 {
    return reflected.x;
}
