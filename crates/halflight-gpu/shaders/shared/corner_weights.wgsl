// Barycentric weights of the points where lines meet triangles.

// Weights of the second and third corner where the ray from the eye along `d` meets a triangle.
fn corner_weights(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>, d: vec3<f32>) -> vec2<f32> {
    return weights_along(a, b, c, frame.eye, d);
}

// Weights of the second and third corner where the line from `origin` along `d` meets a triangle.
fn weights_along(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>, origin: vec3<f32>, d: vec3<f32>) -> vec2<f32> {
    let p = a - origin;
    let q = b - origin;
    let r = c - origin;
    let first = dot3(d, cross3(q + r, c - b));
    let second = dot3(d, cross3(r + p, a - c));
    let third = dot3(d, cross3(p + q, b - a));
    let sum = first + second + third;
    if sum == 0.0 {
        return vec2(1.0 / 3.0);
    }
    // Rays within the rounding error of an edge count as hits.
    let x = clamp(second / sum, 0.0, 1.0);
    return vec2(x, clamp(third / sum, 0.0, 1.0 - x));
}
