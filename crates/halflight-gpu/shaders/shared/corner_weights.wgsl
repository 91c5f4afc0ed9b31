// Barycentric weights of the points where rays from the eye meet triangles.

// Weights of the second and third corner where the ray along `d` meets a triangle.
fn corner_weights(a: vec3<f32>, b: vec3<f32>, c: vec3<f32>, d: vec3<f32>) -> vec2<f32> {
    let p = a - frame.eye;
    let q = b - frame.eye;
    let r = c - frame.eye;
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
