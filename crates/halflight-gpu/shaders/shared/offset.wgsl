// Offsets of shadow rays from their surface: bounds on the rounding of points, as `receiver_origin` in
// halflight-core/src/gbuffer.rs.

// Half a unit in the last place of single precision at 1.
const UNIT: f32 = 5.9604644775390625e-8;

fn largest(v: vec3<f32>) -> f32 {
    let size = abs(v);
    return max(max(size.x, size.y), size.z);
}

// Offset of a point on a triangle with these largest extents along each axis. The second term covers the
// rounding of interpolation between its corners, which the CPU computes in double precision.
fn offset_on(point: vec3<f32>, up: vec3<f32>, extents: vec3<f32>) -> f32 {
    let size = largest(point) + largest(extents) * (1.0 / 4096.0);
    return UNIT * (12.0 * size + 4.0 * dot3(abs(up), extents));
}

// Offset of a point of which only the distance along the view direction is known.
fn offset_at(point: vec3<f32>, depth: f32) -> f32 {
    return UNIT * (12.0 * largest(point) + 8.0 * depth);
}

// Largest distance of points of one plane from that plane by rounding: 16 units of 2⁻²⁴.
fn rounding_at(point: vec3<f32>) -> f32 {
    return largest(point) * (16.0 * UNIT);
}
