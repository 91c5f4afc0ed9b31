// Ray–triangle test, per segment and triangle.
//@ reads triangles

// Relative error of a product of two vectors, with earlier rounding included: 2⁻²¹, as on the CPU.
const PRODUCT_ERROR: f32 = 4.76837158203125e-7;

// True if the open segment from `origin` along `d` to `end` meets a closed triangle. A triangle with an end
// of the segment in its plane, or within the rounding error of it, is not met.
//
// The signs of (P + Q) × (Q − P) · d over the edges PQ give the side on which the segment passes each.
// Neighbouring triangles have the shared edge in opposite directions, which flips the sign and changes no
// other bit: no segment passes between them.
fn meets(triangle: u32, origin: vec3<f32>, end: vec3<f32>, d: vec3<f32>) -> bool {
    let first = triangles[3u * triangle];
    let second = triangles[3u * triangle + 1u];
    let third = triangles[3u * triangle + 2u];
    let up = vec3(first.w, second.w, third.w);
    let a = first.xyz - origin;
    let start = dot3(up, a);
    let to = dot3(up, first.xyz - end);
    let from_error = dot3(abs(up), abs(a)) * PRODUCT_ERROR;
    let to_error = dot3(abs(up), abs(first.xyz - end)) * PRODUCT_ERROR;
    if !((start > from_error && to < -to_error) || (start < -from_error && to > to_error)) {
        return false;
    }
    let b = second.xyz - origin;
    let c = third.xyz - origin;
    let ab = dot3(cross3(a + b, second.xyz - first.xyz), d);
    let bc = dot3(cross3(b + c, third.xyz - second.xyz), d);
    let ca = dot3(cross3(c + a, first.xyz - third.xyz), d);
    return (ab >= 0.0 && bc >= 0.0 && ca >= 0.0) || (ab <= 0.0 && bc <= 0.0 && ca <= 0.0);
}
